//! One interface to both architectures: policy logits and value of observations.

use super::activation::Activation;
use super::adam::Adam;
use super::mlp::{self, Mlp};
use super::scorer::{self, Scorer};
use crate::error::{Error, Result};
use rand::Rng;
use serde::{Deserialize, Serialize};

/// What goes in and comes out of one decision. An observation is `globals` numbers
/// followed by `slots` times `slot_features`; actions are the slots and, with `wait`,
/// one more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shape {
    /// Numbers that do not belong to a slot.
    pub globals: usize,
    /// Slots, K.
    pub slots: usize,
    /// Numbers a slot.
    pub slot_features: usize,
    /// Whether waiting is an action.
    pub wait: bool,
}

impl Shape {
    /// Numbers in an observation.
    pub fn observation(&self) -> usize {
        self.globals + self.slots * self.slot_features
    }

    /// Number of actions.
    pub fn actions(&self) -> usize {
        self.slots + usize::from(self.wait)
    }
}

/// Which network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub enum Architecture {
    /// Two towers of dense layers over the flat observation, as in Stable-Baselines3.
    Mlp {
        /// Widths of the hidden layers.
        hidden: Vec<usize>,
        /// Between the layers.
        activation: Activation,
    },
    /// One small network applied to every slot, with pooled context.
    Scorer {
        /// Width of its layers.
        width: usize,
        /// Between the layers.
        activation: Activation,
    },
}

impl Architecture {
    /// Checks that it is one.
    ///
    /// # Errors
    /// Layers without width, or so wide or many that they do not fit into memory.
    pub fn check(&self) -> Result<()> {
        let (widths, most) = match self {
            Self::Mlp { hidden, .. } => (hidden.as_slice(), 16),
            Self::Scorer { width, .. } => (std::slice::from_ref(width), 1),
        };
        if widths.len() <= most && widths.iter().all(|width| (1..=4096).contains(width)) {
            return Ok(());
        }
        Err(Error::input(
            "the network",
            format!("layers of {widths:?}"),
            format!("give at most {most} layers of 1 to 4096"),
        ))
    }
}

/// A batch of observations.
#[derive(Clone, Copy)]
pub struct Batch<'a> {
    /// [rows, observation].
    pub observations: &'a [f32],
    /// Which actions are allowed, [rows, actions].
    pub masks: &'a [bool],
    /// How many.
    pub rows: usize,
}

/// Results and everything in between, reused from batch to batch.
#[derive(Debug, Default)]
pub struct Workspace {
    /// [rows, actions]; those of forbidden actions mean nothing.
    pub logits: Vec<f32>,
    /// [rows].
    pub values: Vec<f32>,
    pub(super) mlp: mlp::Buffers,
    pub(super) scorer: scorer::Buffers,
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

    /// How many parameters it takes.
    pub fn parameters(&self) -> usize {
        match self {
            Self::Mlp(net) => net.parameters(),
            Self::Scorer(net) => net.parameters(),
        }
    }

    /// Fresh parameters: orthogonal, the output layers small (0.01) and 1 as in
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

    /// Fills the workspace's logits and values.
    pub fn forward(&self, parameters: &[f32], batch: Batch, work: &mut Workspace) {
        match self {
            Self::Mlp(net) => net.forward(parameters, batch, work),
            Self::Scorer(net) => net.forward(parameters, batch, work),
        }
    }

    /// Adds to `gradient` the gradient of a loss whose derivatives by logits [rows,
    /// actions] and values [rows] are given, after [`Network::forward`] of the same
    /// batch. Derivatives by forbidden logits must be 0.
    pub fn backward(
        &self,
        parameters: &[f32],
        batch: Batch,
        (logits, values): (&[f32], &[f32]),
        work: &mut Workspace,
        gradient: &mut [f32],
    ) {
        match self {
            Self::Mlp(net) => net.backward(parameters, batch, (logits, values), work, gradient),
            Self::Scorer(net) => net.backward(parameters, batch, (logits, values), work, gradient),
        }
    }
}

/// Makes `buffer` at least `length` long; it keeps its memory from batch to batch.
pub(super) fn reserve(buffer: &mut Vec<f32>, length: usize) {
    if buffer.len() < length {
        buffer.resize(length, 0.0);
    }
}
