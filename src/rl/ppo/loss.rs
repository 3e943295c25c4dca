//! The clipped surrogate loss and its derivatives with respect to logits and values.

use super::masked::log_softmax;
use super::settings::PpoSettings;
use std::ops::AddAssign;

/// What was recorded about a sample when it was collected.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Index of the action that was taken.
    pub action: usize,
    /// Its log-probability when it was collected.
    pub log_probability: f32,
    /// Its advantage, normalised if the settings say so.
    pub advantage: f32,
    /// Target of the value: advantage plus the value when it was collected.
    pub target: f32,
}

/// The terms of the loss, summed over samples.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Terms {
    /// Clipped surrogate loss of the policy.
    pub policy: f64,
    /// Squared error of the value.
    pub value: f64,
    /// Entropy of the policy.
    pub entropy: f64,
    /// Approximate divergence from the policy that collected the samples
    /// (Schulman, <http://joschu.net/blog/kl-approx.html>).
    pub divergence: f64,
    /// Number of samples whose ratio was clipped.
    pub clipped: f64,
    /// Number of samples whose action the policy prefers to all others; counted when learning
    /// from an expert, otherwise 0.
    pub agreement: f64,
}

impl AddAssign for Terms {
    fn add_assign(&mut self, other: Self) {
        self.policy += other.policy;
        self.value += other.value;
        self.entropy += other.entropy;
        self.divergence += other.divergence;
        self.clipped += other.clipped;
        self.agreement += other.agreement;
    }
}

impl Terms {
    /// The means over `samples` samples.
    pub fn mean(self, samples: usize) -> Self {
        let share = 1.0 / samples.max(1) as f64;
        Self {
            policy: self.policy * share,
            value: self.value * share,
            entropy: self.entropy * share,
            divergence: self.divergence * share,
            clipped: self.clipped * share,
            agreement: self.agreement * share,
        }
    }

    /// The total loss, if the terms are means.
    pub fn loss(&self, settings: &PpoSettings) -> f64 {
        self.policy + f64::from(settings.vf_coef) * self.value
            - f64::from(settings.ent_coef) * self.entropy
    }
}

/// The terms of one sample. `logits` [actions] become the derivatives of the mean loss over
/// `count` samples with respect to the logits, `value` the one with respect to the value.
pub(crate) fn sample_loss(
    sample: &Sample,
    mask: &[bool],
    (logits, value): (&mut [f32], &mut f32),
    settings: &PpoSettings,
    count: usize,
) -> Terms {
    log_softmax(logits, mask);
    let share = 1.0 / count as f32;
    let log_ratio = logits[sample.action] - sample.log_probability;
    let ratio = log_ratio.exp();
    let clip = settings.clip_range;
    let free = sample.advantage * ratio;
    let clipped = sample.advantage * ratio.clamp(1.0 - clip, 1.0 + clip);
    // torch's min passes the gradient to the smaller one. If both are equal, the ratio is
    // within the range and both have the same gradient.
    let slope = if free <= clipped { -free * share } else { 0.0 };
    let entropy: f32 = logits
        .iter()
        .filter(|log| **log > f32::NEG_INFINITY)
        .map(|log| -log * log.exp())
        .sum();
    let error = *value - sample.target;
    for (action, log) in logits.iter_mut().enumerate() {
        let probability = log.exp();
        let taken = if action == sample.action { 1.0 } else { 0.0 };
        let mut derivative = slope * (taken - probability);
        if settings.ent_coef != 0.0 && probability > 0.0 {
            derivative += settings.ent_coef * share * probability * (*log + entropy);
        }
        *log = derivative;
    }
    *value = settings.vf_coef * 2.0 * error * share;
    Terms {
        policy: -f64::from(free.min(clipped)),
        value: f64::from(error * error),
        entropy: f64::from(entropy),
        divergence: f64::from(ratio - 1.0 - log_ratio),
        clipped: f64::from(u8::from((ratio - 1.0).abs() > clip)),
        agreement: 0.0,
    }
}
