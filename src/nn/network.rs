//! A common interface to both architectures: policy logits and value of observations.

use super::activation::Activation;
use super::adam::Adam;
use super::mlp::{self, Mlp};
use super::scorer::{self, Scorer};
use super::shape::{ObservationBatch, Shape};
use crate::error::{Error, Result};
use rand::Rng;
use serde::{Deserialize, Serialize};

/// Kind and size of a network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Architecture {
    /// Two towers of dense layers over the flat observation, as in Stable-Baselines3.
    Mlp {
        /// Widths of the hidden layers.
        hidden: Vec<usize>,
        /// Activation between the layers.
        activation: Activation,
    },
    /// One small network applied to every slot, with pooled context.
    Scorer {
        /// Width of all layers.
        width: usize,
        /// Activation between the layers.
        activation: Activation,
    },
}

impl Architecture {
    /// Checks that the architecture is valid.
    ///
    /// # Errors
    /// Layers of zero width, or so wide or so many that they do not fit into memory.
    pub fn check(&self) -> Result<()> {
        let (widths, most) = match self {
            Self::Mlp { hidden, .. } => (hidden.as_slice(), 16),
            Self::Scorer { width, .. } => (std::slice::from_ref(width), 1),
        };
        if widths.len() <= most && widths.iter().all(|width| (1..=4096).contains(width)) {
            return Ok(());
        }
        Err(Error::usage(
            "the network",
            format!("layers of {widths:?}"),
            format!("give at most {most} layers of width 1 to 4096"),
        ))
    }
}

/// Results and intermediate values; the buffers are reused for the next batch.
#[derive(Debug, Default)]
pub struct Workspace {
    /// Logits [rows, actions]; those of forbidden actions are meaningless.
    pub logits: Vec<f32>,
    /// Estimated return of every observation [rows].
    pub values: Vec<f32>,
    mlp: mlp::MlpBuffers,
    scorer: scorer::ScorerBuffers,
}

/// An actor-critic network without its parameters.
#[derive(Debug, Clone)]
pub enum Network {
    /// See [`Architecture::Mlp`].
    Mlp(Box<Mlp>),
    /// See [`Architecture::Scorer`].
    Scorer(Box<Scorer>),
}

impl Network {
    /// The network of this architecture and shape.
    pub fn new(architecture: &Architecture, shape: Shape) -> Self {
        match architecture {
            Architecture::Mlp { hidden, activation } => {
                Self::Mlp(Box::new(Mlp::new(shape, hidden, *activation)))
            }
            Architecture::Scorer { width, activation } => {
                Self::Scorer(Box::new(Scorer::new(shape, *width, *activation)))
            }
        }
    }

    /// Number of parameters of all layers.
    pub fn parameters(&self) -> usize {
        match self {
            Self::Mlp(net) => net.parameters(),
            Self::Scorer(net) => net.parameters(),
        }
    }

    /// Initial parameters: orthogonal; the output layers have gains 0.01 and 1, as in
    /// Stable-Baselines3.
    pub fn initial(&self, rng: &mut impl Rng) -> Vec<f32> {
        let mut parameters = vec![0.0; self.parameters()];
        match self {
            Self::Mlp(net) => net.initialise(&mut parameters, rng),
            Self::Scorer(net) => net.initialise(&mut parameters, rng),
        }
        parameters
    }

    /// An optimiser for its parameters.
    pub fn adam(&self, epsilon: f32) -> Adam {
        Adam::new(self.parameters(), epsilon)
    }

    /// Computes the workspace's logits and values.
    pub fn forward(&self, parameters: &[f32], batch: ObservationBatch, work: &mut Workspace) {
        let outputs = (&mut work.logits, &mut work.values);
        match self {
            Self::Mlp(net) => net.forward(parameters, batch, &mut work.mlp, outputs),
            Self::Scorer(net) => net.forward(parameters, batch, &mut work.scorer, outputs),
        }
    }

    /// Computes the workspace's logits only, which is what a decision needs.
    pub fn decide(&self, parameters: &[f32], batch: ObservationBatch, work: &mut Workspace) {
        match self {
            Self::Mlp(net) => net.decide(parameters, batch, &mut work.mlp, &mut work.logits),
            Self::Scorer(net) => {
                net.decide(parameters, batch, &mut work.scorer, &mut work.logits);
            }
        }
    }

    /// Adds the gradient of a loss to `gradient`, given its derivatives with respect to logits
    /// [rows, actions] and values [rows], after [`Network::forward`] on the same batch.
    /// Derivatives of forbidden logits must be 0.
    pub(crate) fn backward(
        &self,
        parameters: &[f32],
        batch: ObservationBatch,
        (logits, values): (&[f32], &[f32]),
        work: &mut Workspace,
        gradient: &mut [f32],
    ) {
        match self {
            Self::Mlp(net) => {
                net.backward(parameters, batch, (logits, values), &mut work.mlp, gradient);
            }
            Self::Scorer(net) => {
                net.backward(
                    parameters,
                    batch,
                    (logits, values),
                    &mut work.scorer,
                    gradient,
                );
            }
        }
    }
}
