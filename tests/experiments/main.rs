//! Comparisons, sweeps and the committed results.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

#[path = "../common/mod.rs"]
mod common;
mod benchmark;
mod class_columns;
mod compare;
mod compare_columns;
mod complete;
mod error_kinds;
mod examples;
mod pages;
mod pairing;
#[cfg(unix)]
#[path = "../common/programs.rs"]
mod programs;
mod purity_columns;
mod ranking_columns;
mod results;
mod robots_down_columns;
mod run_columns;
mod support;
mod studies;
mod study_options;
mod sweep;
mod sweep_columns;
mod training_seeds;
mod tutorial;
