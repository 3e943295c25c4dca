//! Generalised advantage estimation.
//!
//! Schulman et al., "High-dimensional continuous control using generalized advantage
//! estimation", arXiv 1506.02438; computed as in Stable-Baselines3's rollout buffer.

/// Advantages of the steps of one environment, in order of time.
///
/// `rewards`, `values` and `ended` [steps]: the reward of a step, the value of the observation
/// before it, and whether the episode ended with it. `after` is the value of the observation
/// after the last step.
pub fn advantages(
    (rewards, values, ended): (&[f32], &[f32], &[bool]),
    after: f32,
    (gamma, lambda): (f32, f32),
    to: &mut [f32],
) {
    let (mut next, mut sum) = (after, 0.0);
    for t in (0..to.len()).rev() {
        let goes_on = if ended[t] { 0.0 } else { 1.0 };
        let delta = rewards[t] + gamma * next * goes_on - values[t];
        sum = delta + gamma * lambda * goes_on * sum;
        to[t] = sum;
        next = values[t];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lambda_one_is_the_return_and_zero_the_one_step_error() {
        let (rewards, values) = ([1.0, 2.0, 4.0], [0.5, 0.25, 0.125]);
        let ended = [false, true, false];
        let mut got = [0.0; 3];
        advantages((&rewards, &values, &ended), 8.0, (0.5, 1.0), &mut got);
        assert_eq!(
            got,
            [1.0 + 0.5 * 2.0 - 0.5, 2.0 - 0.25, 4.0 + 0.5 * 8.0 - 0.125]
        );
        advantages((&rewards, &values, &ended), 8.0, (0.5, 0.0), &mut got);
        assert_eq!(got[0], 1.0 + 0.5 * 0.25 - 0.5);
    }
}
