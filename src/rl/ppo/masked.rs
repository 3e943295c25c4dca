//! The categorical distribution over the allowed actions.
//!
//! Huang, Ontanon, "A closer look at invalid action masking in policy gradient
//! algorithms", arXiv 2006.14171: forbidden actions have probability 0 and no gradient.

use rand::{Rng, RngExt};

/// Turns the logits of the allowed actions into log-probabilities, in place; those of the other
/// actions become negative infinity.
pub(crate) fn log_softmax(logits: &mut [f32], mask: &[bool]) {
    let mut largest = f32::NEG_INFINITY;
    for (logit, allowed) in logits.iter_mut().zip(mask) {
        if *allowed {
            largest = largest.max(*logit);
        } else {
            *logit = f32::NEG_INFINITY;
        }
    }
    let sum: f32 = logits.iter().map(|logit| (logit - largest).exp()).sum();
    let shift = largest + sum.ln();
    logits.iter_mut().for_each(|logit| *logit -= shift);
}

/// Draws an action from log-probabilities; never one with probability 0.
pub(crate) fn sample(log_probabilities: &[f32], rng: &mut impl Rng) -> usize {
    let mut left: f32 = rng.random();
    let mut last = 0;
    for (action, log) in log_probabilities.iter().enumerate() {
        if *log > f32::NEG_INFINITY {
            last = action;
            left -= log.exp();
            if left < 0.0 {
                break;
            }
        }
    }
    // Rounding may leave a small rest of the sum; the last allowed action gets it.
    last
}

/// The most likely allowed action, the first of ties.
pub(crate) fn likeliest(logits: &[f32], mask: &[bool]) -> usize {
    let mut best: Option<usize> = None;
    for action in (0..logits.len()).filter(|action| mask[*action]) {
        if best.is_none_or(|best| logits[action] > logits[best]) {
            best = Some(action);
        }
    }
    best.unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::random_stream;

    #[test]
    fn forbidden_actions_are_never_drawn() {
        let mask = [true, false, true, false];
        let mut logits = [0.0, 50.0, 1.0, f32::NAN];
        log_softmax(&mut logits, &mask);
        let sum: f32 = logits.iter().map(|l| l.exp()).sum();
        assert!((sum - 1.0).abs() < 1e-6);
        let mut rng = random_stream(1, 0);
        let mut counts = [0; 4];
        for _ in 0..100_000 {
            counts[sample(&logits, &mut rng)] += 1;
        }
        assert_eq!((counts[1], counts[3]), (0, 0));
        let share = f64::from(counts[2]) / 1e5;
        assert!((share - 1.0f64.exp() / (1.0 + 1.0f64.exp())).abs() < 0.01);
        assert_eq!(likeliest(&[0.0, 50.0, 1.0, 1.0], &mask), 2);
    }
}
