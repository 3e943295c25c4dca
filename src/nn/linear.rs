//! A layer `y = x W + b` whose parameters are part of the network's flat vector.

use super::matrix::{MatrixView, multiply, multiply_nt, multiply_tn};
use std::ops::Range;

/// Positions of a layer's weights [inputs, outputs] and biases [outputs].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linear {
    /// Number of values in an input row.
    pub inputs: usize,
    /// Number of values in an output row.
    pub outputs: usize,
    start: usize,
    has_bias: bool,
}

impl Linear {
    /// The layer whose parameters begin at `*next`, which is advanced past them.
    pub fn new(inputs: usize, outputs: usize, has_bias: bool, next: &mut usize) -> Self {
        let layer = Self {
            inputs,
            outputs,
            start: *next,
            has_bias,
        };
        *next += inputs * outputs + if has_bias { outputs } else { 0 };
        layer
    }

    /// Where the weights are among all parameters.
    pub(crate) fn weights(&self) -> Range<usize> {
        self.start..self.start + self.inputs * self.outputs
    }

    /// Where the biases are; empty without a bias.
    pub(crate) fn biases(&self) -> Range<usize> {
        let start = self.weights().end;
        start..start + if self.has_bias { self.outputs } else { 0 }
    }

    /// The weights, as a part of all parameters.
    pub fn weight<'p>(&self, parameters: &'p [f32]) -> &'p [f32] {
        &parameters[self.weights()]
    }

    /// The weights, mutable.
    pub(crate) fn weight_mut<'p>(&self, parameters: &'p mut [f32]) -> &'p mut [f32] {
        &mut parameters[self.weights()]
    }

    /// The biases, as a part of all parameters; empty without a bias.
    pub fn bias<'p>(&self, parameters: &'p [f32]) -> &'p [f32] {
        &parameters[self.biases()]
    }

    fn view<'p>(&self, parameters: &'p [f32]) -> MatrixView<'p> {
        MatrixView::new(self.weight(parameters), self.inputs, self.outputs)
    }

    /// `y = x W + b` for `rows` rows; `x` [rows, inputs] in rows of `stride`, `y` dense.
    pub fn forward(
        &self,
        parameters: &[f32],
        x: &[f32],
        stride: usize,
        rows: usize,
        y: &mut [f32],
    ) {
        let x = MatrixView::strided(x, rows, self.inputs, stride);
        let y = &mut y[..rows * self.outputs];
        let bias = self.bias(parameters);
        if bias.is_empty() {
            multiply(x, self.view(parameters), 0.0, y);
        } else {
            y.chunks_exact_mut(self.outputs)
                .for_each(|row| row.copy_from_slice(bias));
            multiply(x, self.view(parameters), 1.0, y);
        }
    }

    /// `y += x W` for `rows` dense rows, without the bias.
    pub(crate) fn forward_add(&self, parameters: &[f32], x: &[f32], rows: usize, y: &mut [f32]) {
        multiply(
            MatrixView::new(x, rows, self.inputs),
            self.view(parameters),
            1.0,
            y,
        );
    }

    /// Adds the gradients of weights and biases, given `dy` [rows, outputs].
    pub(crate) fn backward(
        &self,
        x: &[f32],
        stride: usize,
        rows: usize,
        dy: &[f32],
        gradient: &mut [f32],
    ) {
        let dy_view = MatrixView::new(dy, rows, self.outputs);
        let x = MatrixView::strided(x, rows, self.inputs, stride);
        multiply_tn(x, dy_view, 1.0, self.weight_mut(gradient));
        if self.has_bias {
            let bias = &mut gradient[self.biases()];
            for row in dy[..rows * self.outputs].chunks_exact(self.outputs) {
                bias.iter_mut().zip(row).for_each(|(b, d)| *b += d);
            }
        }
    }

    /// The gradient of the inputs, `dx = dy W' + beta dx`, dense.
    pub(crate) fn backward_input(
        &self,
        parameters: &[f32],
        dy: &[f32],
        rows: usize,
        beta: f32,
        dx: &mut [f32],
    ) {
        multiply_nt(
            MatrixView::new(dy, rows, self.outputs),
            self.view(parameters),
            beta,
            dx,
        );
    }
}
