//! The station: a belt and the robots along it.
//!
//! A [`Station`] can only be had validated; nothing downstream re-checks it.

mod builtin;
mod file;
mod geometry;
mod line;
mod plausible;

pub use builtin::{BUILT_INS, BuiltIn, built_in};
pub use file::{Overrides, commented_example, load, parse, to_toml};
pub use geometry::{Belt, Robot, Station};
pub use line::Line;
