//! Lines and cameras that the tests of live control share.

pub mod line;
pub mod three;
pub mod tracker;
