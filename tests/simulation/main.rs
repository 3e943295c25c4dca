//! The simulated line: both engines, the checker, disturbances, what a line makes.

mod checker;
mod clearance;
#[path = "../common/mod.rs"]
mod common;
mod disturbed;
mod engines;
mod failures;
mod flow;
mod run;
mod throughput;
