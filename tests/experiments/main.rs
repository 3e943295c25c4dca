//! Comparisons, sweeps and the committed results.

#[path = "../common/mod.rs"]
mod common;
mod compare;
#[cfg(unix)]
#[path = "../common/programs.rs"]
mod programs;
mod results;
mod sweep;
