//! Orthogonal initialisation.
//!
//! Saxe, McClelland, Ganguli, "Exact solutions to the nonlinear dynamics of learning in
//! deep linear neural networks", arXiv 1312.6120; Stable-Baselines3's default for PPO.

use super::linear::Linear;
use rand::Rng;
use rand_distr::{Distribution as _, StandardNormal};

/// Fills the layer's weights with an orthogonal matrix times `gain`; biases stay 0. The vectors
/// along the longer side are orthogonalised one after the other.
pub(super) fn orthogonal(layer: &Linear, gain: f32, parameters: &mut [f32], rng: &mut impl Rng) {
    let (rows, columns) = (layer.inputs, layer.outputs);
    // `count` orthonormal vectors of dimension `size`.
    let (count, size) = (rows.min(columns), rows.max(columns));
    let mut vectors: Vec<Vec<f64>> = Vec::with_capacity(count);
    while vectors.len() < count {
        let mut vector: Vec<f64> = (0..size).map(|_| StandardNormal.sample(rng)).collect();
        // Twice, because one pass leaves rounding errors.
        for _ in 0..2 {
            for other in &vectors {
                let dot: f64 = vector.iter().zip(other).map(|(a, b)| a * b).sum();
                vector
                    .iter_mut()
                    .zip(other)
                    .for_each(|(a, b)| *a -= dot * b);
            }
        }
        let norm = vector.iter().map(|a| a * a).sum::<f64>().sqrt();
        // A draw within the span of the others is practically impossible.
        if norm > 1e-6 {
            vector.iter_mut().for_each(|a| *a /= norm);
            vectors.push(vector);
        }
    }
    let weight = layer.weight_mut(parameters);
    for i in 0..rows {
        for j in 0..columns {
            let value = if rows <= columns {
                vectors[i][j]
            } else {
                vectors[j][i]
            };
            weight[i * columns + j] = gain * value as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::random_stream;

    #[test]
    fn columns_or_rows_are_orthonormal_times_the_gain() {
        for (inputs, outputs) in [(3, 7), (7, 3), (5, 5)] {
            let layer = Linear::new(inputs, outputs, true, &mut 0);
            let mut parameters = vec![0.0; inputs * outputs + outputs];
            orthogonal(&layer, 2.0, &mut parameters, &mut random_stream(1, 0));
            let w = layer.weight(&parameters);
            let count = inputs.min(outputs);
            for a in 0..count {
                for b in 0..count {
                    let dot: f32 = if inputs <= outputs {
                        (0..outputs)
                            .map(|j| w[a * outputs + j] * w[b * outputs + j])
                            .sum()
                    } else {
                        (0..inputs)
                            .map(|i| w[i * outputs + a] * w[i * outputs + b])
                            .sum()
                    };
                    let expected = if a == b { 4.0 } else { 0.0 };
                    assert!((dot - expected).abs() < 1e-5, "{dot}");
                }
            }
        }
    }
}
