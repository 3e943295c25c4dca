//! The simulated line: both engines, the checker, disturbances, what a line makes.

mod checker;
mod clearance;
#[path = "../common/mod.rs"]
mod common;
mod disturbed;
mod disturbed_book;
mod engines;
mod events;
mod failures;
mod flow;
mod queueing;
mod real_lines;
mod real_station_files;
mod rules;
mod run;
mod scenes;
mod station_files;
mod station_warnings;
mod stations;
mod throughput;
