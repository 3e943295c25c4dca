//! Trained networks as strategies: ONNX files. Networks of this program run as they do in training, all
//! others in tract.
//!
//! Files of this program have metadata that describes how to encode the observation. Files of
//! other programs (Stable-Baselines3 with torch's exporters) are accepted if the sizes of their
//! input and output match a known observation.

#[cfg(feature = "onnx")]
mod check;
#[cfg(feature = "onnx")]
mod export;
#[cfg(feature = "onnx")]
mod external;
#[cfg(feature = "onnx")]
mod graph;
#[cfg_attr(
    not(feature = "onnx"),
    allow(dead_code, reason = "only networks write and read it")
)]
mod metadata;
#[cfg(feature = "onnx")]
mod model;
#[cfg(feature = "onnx")]
mod native;
#[cfg(feature = "onnx")]
mod ports;
#[cfg(feature = "onnx")]
mod seal;
#[cfg(feature = "onnx")]
mod strategy;
#[cfg_attr(
    not(feature = "onnx"),
    allow(dead_code, reason = "only networks write and read it")
)]
mod trained;

#[cfg(feature = "onnx")]
pub use export::export;
#[cfg(feature = "onnx")]
pub(crate) use external::weight_files;
pub use metadata::Metadata;
#[cfg(feature = "onnx")]
pub use model::{Policy, PolicyState};
#[cfg(feature = "onnx")]
pub use strategy::PolicyStrategy;
pub(crate) use trained::{Outside, Trained};
