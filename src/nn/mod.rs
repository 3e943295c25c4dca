//! Small hand-written networks: matrix products, two architectures, Adam.
//!
//! At this size, deep-learning crates spend their time on overhead: plain products from
//! `matrixmultiply` train several times faster and compile in seconds. Everything is f32 and
//! row-major; a network's parameters are one flat vector.

mod activation;
mod adam;
mod init;
mod linear;
mod matrix;
mod mlp;
mod network;
mod scorer;
mod set_encoder;
mod shape;

pub use activation::Activation;
pub use adam::Adam;
pub(crate) use adam::clip_gradient;
pub use linear::Linear;
pub use mlp::Mlp;
pub use network::{Architecture, Network, Workspace};
#[cfg(feature = "onnx")]
pub(crate) use scorer::Head;
pub use scorer::Scorer;
#[cfg(feature = "onnx")]
pub(crate) use set_encoder::SetEncoder;
pub use shape::{ObservationBatch, Shape};

#[cfg(test)]
mod gradient_test;
