//! The program as its users call it.

mod bad_input;
#[path = "../common/mod.rs"]
mod common;
mod conditions;
#[cfg(target_os = "linux")]
mod outputs;
mod pictures;
mod plausible;
mod result_files;
mod verbs;
