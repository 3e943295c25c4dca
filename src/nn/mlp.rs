//! Dense layers over the flat observation, with one tower for the policy and one for the value:
//! the `MlpPolicy` of Stable-Baselines3.

use super::activation::Activation;
use super::init::orthogonal;
use super::linear::Linear;
use super::matrix::reserve;
use super::shape::{ObservationBatch, Shape};
use rand::Rng;

/// The `MlpPolicy` network; see the module.
#[derive(Debug, Clone)]
pub struct Mlp {
    shape: Shape,
    activation: Activation,
    policy: Vec<Linear>,
    value: Vec<Linear>,
    parameters: usize,
}

/// For each tower: outputs of every layer but the last, and the gradient during
/// back-propagation.
#[derive(Debug, Default)]
pub(crate) struct MlpBuffers {
    policy: Tower,
    value: Tower,
}

#[derive(Debug, Default)]
struct Tower {
    hidden: Vec<Vec<f32>>,
    gradients: [Vec<f32>; 2],
}

impl Mlp {
    /// A network with hidden layers of these widths in both towers.
    pub fn new(shape: Shape, hidden: &[usize], activation: Activation) -> Self {
        let mut parameters = 0;
        let mut tower = |outputs: usize| {
            let mut widths = vec![shape.observation()];
            widths.extend(hidden);
            widths.push(outputs);
            let layer = |pair: &[usize]| Linear::new(pair[0], pair[1], true, &mut parameters);
            widths.windows(2).map(layer).collect::<Vec<_>>()
        };
        let policy = tower(shape.actions());
        let value = tower(1);
        Self {
            shape,
            activation,
            policy,
            value,
            parameters,
        }
    }

    /// Number of parameters of all layers.
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// The policy's layers, from the observation to the logits.
    pub fn policy(&self) -> &[Linear] {
        &self.policy
    }

    /// The value's layers, from the observation to the value.
    pub fn value(&self) -> &[Linear] {
        &self.value
    }

    /// The activation between the layers.
    pub fn activation(&self) -> Activation {
        self.activation
    }

    /// Sets orthogonal weights and zero biases.
    pub(crate) fn initialise(&self, parameters: &mut [f32], rng: &mut impl Rng) {
        for (tower, last) in [(&self.policy, 0.01), (&self.value, 1.0)] {
            for (i, layer) in tower.iter().enumerate() {
                let gain = if i + 1 == tower.len() {
                    last
                } else {
                    2f32.sqrt()
                };
                orthogonal(layer, gain, parameters, rng);
            }
        }
    }

    /// Computes `logits` [rows, actions] and `values` [rows] of the batch.
    pub(crate) fn forward(
        &self,
        parameters: &[f32],
        batch: ObservationBatch,
        buffers: &mut MlpBuffers,
        (logits, values): (&mut Vec<f32>, &mut Vec<f32>),
    ) {
        self.decide(parameters, batch, buffers, logits);
        self.climb(parameters, batch, &self.value, &mut buffers.value, values);
    }

    /// Computes `logits` [rows, actions] of the batch.
    pub(crate) fn decide(
        &self,
        parameters: &[f32],
        batch: ObservationBatch,
        buffers: &mut MlpBuffers,
        logits: &mut Vec<f32>,
    ) {
        self.climb(parameters, batch, &self.policy, &mut buffers.policy, logits);
    }

    /// Computes the `output` of one tower's `layers`.
    fn climb(
        &self,
        parameters: &[f32],
        batch: ObservationBatch,
        layers: &[Linear],
        tower: &mut Tower,
        output: &mut Vec<f32>,
    ) {
        tower.hidden.resize_with(layers.len() - 1, Vec::new);
        for (i, layer) in layers.iter().enumerate() {
            let (before, rest) = tower.hidden.split_at_mut(i);
            let x = before.last().map_or(batch.observations, |h| h.as_slice());
            let size = batch.rows * layer.outputs;
            match rest.first_mut() {
                Some(hidden) => {
                    reserve(hidden, size);
                    layer.forward(parameters, x, layer.inputs, batch.rows, hidden);
                    self.activation.apply(&mut hidden[..size]);
                }
                None => {
                    reserve(output, size);
                    layer.forward(parameters, x, layer.inputs, batch.rows, output);
                }
            }
        }
    }

    /// Adds the gradient; see `Network::backward`.
    pub(crate) fn backward(
        &self,
        parameters: &[f32],
        batch: ObservationBatch,
        (logits, values): (&[f32], &[f32]),
        buffers: &mut MlpBuffers,
        gradient: &mut [f32],
    ) {
        for (layers, tower, output) in [
            (&self.policy, &mut buffers.policy, logits),
            (&self.value, &mut buffers.value, values),
        ] {
            let [now, next] = &mut tower.gradients;
            for (i, layer) in layers.iter().enumerate().rev() {
                let dy = if i + 1 == layers.len() {
                    output
                } else {
                    now.as_slice()
                };
                let Some(below) = i.checked_sub(1) else {
                    let stride = self.shape.observation();
                    layer.backward(batch.observations, stride, batch.rows, dy, gradient);
                    break;
                };
                let x = &tower.hidden[below];
                let size = batch.rows * layer.inputs;
                layer.backward(x, layer.inputs, batch.rows, dy, gradient);
                reserve(next, size);
                layer.backward_input(parameters, dy, batch.rows, 0.0, next);
                self.activation.backward(&x[..size], &mut next[..size]);
                std::mem::swap(now, next);
            }
        }
    }
}
