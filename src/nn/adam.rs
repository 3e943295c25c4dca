//! Adam as torch computes it.
//!
//! Kingma, Ba, "Adam: a method for stochastic optimization", arXiv 1412.6980, with epsilon
//! where torch puts it: outside the root, after the bias correction.

/// Moments smaller than this become 0. They are far too small to move a weight, and numbers
/// below 1e-38 (denormals) would make every later step many times slower.
const SMALLEST_FIRST: f32 = 1e-20;
/// The same for second moments, which are squares.
const SMALLEST_SECOND: f32 = 1e-35;

/// The moments of all parameters, and the settings of Adam.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Adam {
    /// Decay of the first moments.
    pub beta1: f32,
    /// Decay of the second moments.
    pub beta2: f32,
    /// Prevents division by zero.
    pub epsilon: f32,
    steps: u64,
    first: Vec<f32>,
    second: Vec<f32>,
}

impl Adam {
    /// An optimiser with torch's decays; `epsilon` 1e-5 is Stable-Baselines3's value for PPO.
    pub fn new(parameters: usize, epsilon: f32) -> Self {
        Self {
            beta1: 0.9,
            beta2: 0.999,
            epsilon,
            steps: 0,
            first: vec![0.0; parameters],
            second: vec![0.0; parameters],
        }
    }

    /// Number of parameters that it updates.
    pub fn parameters(&self) -> usize {
        self.first.len()
    }

    /// Updates `parameters` by one step against `gradient`.
    pub fn step(&mut self, learning_rate: f32, gradient: &[f32], parameters: &mut [f32]) {
        self.steps += 1;
        let correction = |beta: f32| 1.0 - f64::from(beta).powf(self.steps as f64);
        let rate = (f64::from(learning_rate) / correction(self.beta1)) as f32;
        let root = correction(self.beta2).sqrt() as f32;
        let (beta1, beta2, epsilon) = (self.beta1, self.beta2, self.epsilon);
        let moments = self.first.iter_mut().zip(&mut self.second);
        for (((m, v), g), p) in moments.zip(gradient).zip(parameters) {
            let first = beta1 * *m + (1.0 - beta1) * g;
            let second = beta2 * *v + (1.0 - beta2) * g * g;
            *m = if first.abs() < SMALLEST_FIRST {
                0.0
            } else {
                first
            };
            *v = if second < SMALLEST_SECOND {
                0.0
            } else {
                second
            };
            *p -= rate * *m / (v.sqrt() / root + epsilon);
        }
    }
}

/// Scales `gradient` to a norm of at most `most`, as torch's `clip_grad_norm_` does, and
/// returns the norm before that.
pub(crate) fn clip_gradient(gradient: &mut [f32], most: f32) -> f32 {
    // Eight sums in parallel: a single f64 sum would wait for every addition.
    let mut sums = [0.0f64; 8];
    let chunks = gradient.chunks_exact(8);
    for (sum, g) in sums.iter_mut().zip(chunks.remainder()) {
        *sum += f64::from(g * g);
    }
    for chunk in chunks {
        for (sum, g) in sums.iter_mut().zip(chunk) {
            *sum += f64::from(g * g);
        }
    }
    let norm = sums.iter().sum::<f64>().sqrt() as f32;
    let scale = most / (norm + 1e-6);
    if scale < 1.0 {
        gradient.iter_mut().for_each(|g| *g *= scale);
    }
    norm
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_step_is_the_learning_rate() {
        let mut adam = Adam::new(2, 1e-8);
        let mut parameters = [1.0, 1.0];
        adam.step(0.1, &[3.0, -0.02], &mut parameters);
        assert!((parameters[0] - 0.9).abs() < 1e-6 && (parameters[1] - 1.1).abs() < 1e-6);
    }

    #[test]
    fn moments_never_become_denormal() {
        let mut adam = Adam::new(1, 1e-8);
        let mut parameters = [0.0];
        adam.step(0.1, &[1e-3], &mut parameters);
        for _ in 0..100_000 {
            adam.step(0.1, &[0.0], &mut parameters);
            let denormal = |v: f32| v != 0.0 && !v.is_normal();
            assert!(!denormal(adam.first[0]) && !denormal(adam.second[0]));
        }
        assert_eq!(adam.first[0], 0.0);
    }

    #[test]
    fn clipping_keeps_the_direction() {
        let mut gradient = [3.0, 4.0];
        assert_eq!(clip_gradient(&mut gradient, 10.0), 5.0);
        assert_eq!(gradient, [3.0, 4.0]);
        clip_gradient(&mut gradient, 0.5);
        assert!((gradient[0] - 0.3).abs() < 1e-6 && (gradient[1] - 0.4).abs() < 1e-6);
    }
}
