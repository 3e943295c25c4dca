//! Lines and cameras that the tests of live control share.

pub mod line;
#[cfg(unix)]
pub mod pipe;
pub mod rates;
pub mod table;
pub mod three;
pub mod tracker;
