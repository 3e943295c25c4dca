//! Smooth weighted round robin: turns in proportion to weights, spread as evenly as they go.

/// The turns given so far.
///
/// Each turn adds every weight to its robot's credit, goes to the robot with the most, and takes the
/// sum of the weights from it: "smooth weighted round-robin balancing" of nginx
/// (`ngx_http_upstream_round_robin.c`). Weights 5, 1, 1 give 1, 1, 2, 1, 3, 1, 1. After k turns of
/// which none was refused, a robot with share p has had fewer than kp + 1, and after a whole cycle of
/// whole weights exactly kp.
#[derive(Debug, Clone, Default)]
pub(super) struct RoundRobin {
    /// What each robot is owed, as a multiple of a turn times the sum of the weights.
    credit: Vec<f64>,
}

impl RoundRobin {
    /// The robot whose turn it is among those that `may` take one; the others keep their credit. `None`
    /// if none of them has a weight. Of equal credits, the first counts.
    pub(super) fn next(&mut self, weights: &[f64], may: impl Fn(usize) -> bool) -> Option<usize> {
        self.credit.resize(weights.len(), 0.0);
        let mut best: Option<usize> = None;
        let mut total = 0.0;
        for (robot, weight) in weights.iter().enumerate() {
            if *weight <= 0.0 || !may(robot) {
                continue;
            }
            total += weight;
            self.credit[robot] += weight;
            if best.is_none_or(|best| self.credit[robot] > self.credit[best]) {
                best = Some(robot);
            }
        }
        self.credit[best?] -= total;
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn turns(weights: &[f64], count: usize) -> Vec<usize> {
        let mut turns = RoundRobin::default();
        (0..count)
            .map(|_| turns.next(weights, |_| true).unwrap())
            .collect()
    }

    #[test]
    fn turns_are_spread_evenly() {
        assert_eq!(turns(&[5.0, 1.0, 1.0], 7), [0, 0, 1, 0, 2, 0, 0]);
        assert_eq!(turns(&[1.0, 1.0, 1.0], 6), [0, 1, 2, 0, 1, 2]);
        assert_eq!(turns(&[0.0, 2.0, 2.0], 4), [1, 2, 1, 2]);
    }

    #[test]
    fn nobody_gets_a_turn_without_weight() {
        let mut turns = RoundRobin::default();
        assert_eq!(turns.next(&[1.0, 0.0], |robot| robot == 1), None);
        assert_eq!(turns.next(&[1.0, 1.0], |_| false), None);
        // Who may not take a turn is not paid for it.
        for _ in 0..5 {
            assert_eq!(turns.next(&[1.0, 1.0], |robot| robot == 1), Some(1));
        }
        assert_eq!(turns.next(&[1.0, 1.0], |_| true), Some(0));
        assert_eq!(turns.next(&[1.0, 1.0], |_| true), Some(1));
    }

    proptest! {
        /// What the documentation promises, for all beginnings and a whole cycle.
        #[test]
        fn shares_are_kept(weights in prop::collection::vec(0_u32..60, 1..6)) {
            let total: u32 = weights.iter().sum();
            prop_assume!(total > 0);
            let exact: Vec<f64> = weights.iter().copied().map(f64::from).collect();
            let mut had = vec![0_u32; weights.len()];
            for (turn, robot) in turns(&exact, total as usize).into_iter().enumerate() {
                had[robot] += 1;
                let due = (turn as f64 + 1.0) * exact[robot] / f64::from(total);
                prop_assert!(f64::from(had[robot]) < due + 1.0);
            }
            prop_assert_eq!(had, weights);
        }
    }
}
