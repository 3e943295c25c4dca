//! The program as its users call it.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

mod bad_input;
#[path = "../common/mod.rs"]
mod common;
mod conditions;
mod options;
#[cfg(target_os = "linux")]
mod outputs;
mod pictures;
mod plausible;
#[path = "../common/programs.rs"]
mod programs;
mod result_files;
mod shards;
#[cfg(all(
    feature = "dashboard",
    feature = "mcap",
    feature = "onnx",
    feature = "tls",
    not(feature = "mqtt"),
    not(feature = "ros2")
))]
mod snapshots;
#[cfg(target_os = "linux")]
#[path = "../common/terminal.rs"]
mod terminal;
mod verbs;
mod verification;
