//! Small networks by hand: matrix products, two architectures, Adam.
//!
//! At this size the deep-learning crates spend their time elsewhere: plain products
//! from `matrixmultiply` train several times faster and build in seconds. All in f32,
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

pub use activation::{Activation, tanh};
pub use adam::{Adam, clip_gradient};
pub use linear::Linear;
pub use mlp::Mlp;
pub use network::{Architecture, Batch, Network, Shape, Workspace};
pub use scorer::{Head, Scorer};
pub use set_encoder::SetEncoder;

#[cfg(test)]
mod gradient_test;
