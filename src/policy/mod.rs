//! Trained networks as strategies: ONNX files, run by tract.
//!
//! Files of this program carry metadata that says how to encode what they see. Files of
//! other programs (Stable-Baselines3 through torch's exporters) are taken when the size
//! of their input and output fits a known observation.

#[cfg(feature = "onnx")]
mod check;
#[cfg(feature = "onnx")]
mod external;
#[cfg(feature = "onnx")]
mod graph;
mod metadata;
#[cfg(feature = "onnx")]
mod model;
#[cfg(feature = "onnx")]
mod seal;
#[cfg(feature = "onnx")]
mod strategy;
mod trained;

#[cfg(feature = "onnx")]
pub use external::weight_files;
#[cfg(feature = "onnx")]
pub use graph::{Attribute, GraphBuilder, INPUT, MASK, OUTPUT};
pub use metadata::Metadata;
#[cfg(feature = "onnx")]
pub use model::{Policy, PolicyState};
#[cfg(feature = "onnx")]
pub use strategy::PolicyStrategy;
pub use trained::{Extent, Outside, Trained};
