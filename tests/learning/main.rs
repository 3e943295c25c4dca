//! Policies: training, files, what runs them.

// Nothing uses a test from outside.
#![allow(unreachable_pub)]

#[path = "../common/mod.rs"]
mod common;
mod imitation;
#[cfg(feature = "onnx")]
mod masks;
mod observation;
mod observation_bounds;
mod observation_real;
mod observation_tables;
#[cfg(feature = "onnx")]
mod policy;
#[cfg(feature = "onnx")]
mod policy_forms;
#[cfg(feature = "onnx")]
mod policy_logits;
#[cfg(all(unix, feature = "onnx"))]
#[path = "../common/programs.rs"]
mod programs;
mod rl;
mod sb3;
#[cfg(feature = "onnx")]
mod train_options;
#[cfg(feature = "onnx")]
mod train_verb;
mod training;
