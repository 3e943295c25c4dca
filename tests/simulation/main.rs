//! The simulated line: both engines, the checker, disturbances, what a line makes.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

mod checker;
mod clearance;
#[path = "../common/mod.rs"]
mod common;
mod disturbed;
mod disturbed_transcription;
mod engines;
mod events;
mod failures;
mod flow;
mod rules;
mod run;
mod scenes;
mod station_files;
mod station_warnings;
mod stations;
mod throughput;
