//! Comparisons, sweeps and the committed results.

#[path = "../common/mod.rs"]
mod common;
mod compare;
mod results;
mod sweep;
