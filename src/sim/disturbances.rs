//! What can go wrong with single attempts, drawn from a seed.

use crate::pattern::{Item, random_stream};
use crate::setters::setters;
use rand::RngExt;
use rand_distr::{Distribution as _, StandardNormal};

/// Constants that derive the seeds of grasps and positions from the master seed, so that neither
/// repeats the random numbers of a pattern with the same seed.
const GRASPS: u64 = 0x6772_6173_7073_0001;
const POSITIONS: u64 = 0x706f_7369_7469_6f6e;

/// What can go wrong; nothing by default. The draws depend only on seed, item and attempt, so that
/// all strategies face the same random events (`docs/model.md`, disturbances).
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Disturbances {
    /// Whether grasps may fail. Each grasp succeeds with the item's `p_grasp`.
    pub grasp_failures: bool,
    /// `p_grasp` of items that do not define it.
    pub default_p_grasp: f64,
    /// Standard deviation of the error of reported positions, along and across the belt [m].
    pub position_noise: f64,
    /// Whether detections may be wrong. Each item is what it is reported as with its `p_detection`,
    /// and [`Item::true_class`] says so for recorded ones.
    pub misdetections: bool,
    /// Seed of the random draws; the pattern with index i of a set uses this seed plus i.
    pub seed: u64,
}

impl Default for Disturbances {
    fn default() -> Self {
        Self {
            grasp_failures: false,
            default_p_grasp: 1.0,
            position_noise: 0.0,
            misdetections: false,
            seed: 0,
        }
    }
}

setters!(Disturbances {
    /// With grasps that may fail, or not.
    fn with_grasp_failures(grasp_failures: bool);
    /// With this probability that a grasp succeeds for items that do not define it.
    fn with_default_p_grasp(default_p_grasp: f64);
    /// With this standard deviation of the error of reported positions [m].
    fn with_position_noise(position_noise: f64);
    /// With detections that may be wrong, or not.
    fn with_misdetections(misdetections: bool);
    /// With this seed.
    fn with_seed(seed: u64);
});

impl Disturbances {
    /// Whether an attempt may fail, so that its item is given back. Misdetections do not change a
    /// run, only what its picks are worth.
    pub fn may_fail(&self) -> bool {
        self.grasp_failures || self.position_noise > 0.0
    }

    /// The probability that a grasp of `item` succeeds.
    pub fn p_grasp(&self, item: &Item) -> f64 {
        if self.grasp_failures {
            item.p_grasp.unwrap_or(self.default_p_grasp)
        } else {
            1.0
        }
    }

    /// Whether grasp failures are enabled but can never happen: neither for any of `items` nor for
    /// an item without its own probability.
    pub fn never_fails(&self, items: &[Item]) -> bool {
        let sure = |item: &Item| self.p_grasp(item) == 1.0;
        let all_sure = if items.is_empty() {
            self.default_p_grasp == 1.0
        } else {
            items.iter().all(sure)
        };
        self.grasp_failures && all_sure
    }

    /// Whether the grasp in attempt number `attempt` (from 0) at item `index` succeeds.
    pub fn grasp_succeeds(&self, index: u32, item: &Item, attempt: u32) -> bool {
        if !self.grasp_failures {
            return true;
        }
        let stream = u64::from(index) << 32 | u64::from(attempt);
        let mut rng = random_stream(self.seed ^ GRASPS, stream);
        rng.random::<f64>() < self.p_grasp(item)
    }

    /// The reported position of item `index` on a belt of `width` [m]: x at time 0 and y [m].
    pub fn reported(&self, index: u32, item: &Item, width: f64) -> (f64, f64) {
        if self.position_noise == 0.0 {
            return (item.x0, item.y);
        }
        let mut rng = random_stream(self.seed ^ POSITIONS, u64::from(index));
        let mut error = || -> f64 {
            let normal: f64 = StandardNormal.sample(&mut rng);
            self.position_noise * normal
        };
        let (x0, y) = (item.x0 + error(), item.y + error());
        (x0, y.clamp(-0.5 * width, 0.5 * width))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An item with its own probability and one without.
    fn two_items(own: f64) -> [Item; 2] {
        let own = Item {
            p_grasp: Some(own),
            ..Item::at("own", 0.0, 0.0)
        };
        [own, Item::at("plain", -1.0, 0.0)]
    }

    fn failing(default_p_grasp: f64) -> Disturbances {
        Disturbances {
            grasp_failures: true,
            default_p_grasp,
            ..Disturbances::default()
        }
    }

    #[test]
    fn grasps_succeed_with_the_items_own_probability_first() {
        let [own, plain] = two_items(0.3);
        assert_eq!(failing(0.8).p_grasp(&own), 0.3);
        assert_eq!(failing(0.8).p_grasp(&plain), 0.8);
        let sure = Disturbances {
            grasp_failures: false,
            ..failing(0.8)
        };
        assert_eq!((sure.p_grasp(&own), sure.p_grasp(&plain)), (1.0, 1.0));
        assert!((0..100).all(|attempt| sure.grasp_succeeds(0, &own, attempt)));
        assert!(!sure.may_fail() && failing(1.0).may_fail());
        assert!(!sure.with_misdetections(true).may_fail());
    }

    #[test]
    fn nothing_ever_fails_where_all_probabilities_are_1() {
        for (default, own, never) in [
            (1.0, 1.0, true),
            (1.0, 0.9, false),
            (0.9, 1.0, false),
            (0.9, 0.9, false),
        ] {
            let found = failing(default).never_fails(&two_items(own));
            assert_eq!(found, never, "{default} {own}");
        }
        // An item's own probability is enough, and so is the default if there are no items.
        assert!(failing(0.9).never_fails(&two_items(1.0)[..1]));
        assert!(failing(1.0).never_fails(&[]) && !failing(0.9).never_fails(&[]));
        // If grasp failures are not enabled, there is nothing to report.
        assert!(!Disturbances::default().never_fails(&two_items(1.0)));
    }

    #[test]
    fn random_events_depend_on_seed_item_and_attempt_and_not_on_positions() {
        let item = Item::at("a", 0.0, 0.0);
        let draws = |draw: &dyn Fn(u32) -> bool| (0..64).map(draw).collect::<Vec<bool>>();
        let seeded = |seed: u64| Disturbances {
            seed,
            position_noise: 0.1,
            ..failing(0.5)
        };
        let luck = seeded(1);
        let by_item = draws(&|i| luck.grasp_succeeds(i, &item, 0));
        let by_attempt = draws(&|i| luck.grasp_succeeds(0, &item, i));
        let by_seed = draws(&|i| seeded(u64::from(i)).grasp_succeeds(0, &item, 0));
        for some in [&by_item, &by_attempt, &by_seed] {
            let good = some.iter().filter(|good| **good).count();
            assert!((16..=48).contains(&good), "{good} of 64");
        }
        assert!(by_item != by_attempt && by_attempt != by_seed && by_item != by_seed);
        assert_ne!(luck.reported(0, &item, 1.0), luck.reported(1, &item, 1.0));
        let other = seeded(2).reported(0, &item, 1.0);
        assert_ne!(luck.reported(0, &item, 1.0), other);
    }

    #[test]
    fn errors_have_the_stated_deviation_and_stay_on_the_belt() {
        let noisy = Disturbances {
            position_noise: 0.01,
            seed: 3,
            ..Disturbances::default()
        };
        let item = Item::at("a", -1.0, 0.0);
        let errors: Vec<f64> = (0..4000)
            .flat_map(|i| {
                let (x0, y) = noisy.reported(i, &item, 1.0);
                [x0 + 1.0, y]
            })
            .collect();
        let mean = crate::stats::mean(&errors);
        let variance = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        assert!(mean.abs() < 5e-4, "{mean}");
        assert!((variance.sqrt() - 0.01).abs() < 3e-4, "{variance}");
        // On a belt of 0.4 m, 1 mm from its edges.
        for edge in [-0.2f64, 0.2] {
            let item = Item::at("b", 0.0, 0.995 * edge);
            let ys: Vec<f64> = (0..100).map(|i| noisy.reported(i, &item, 0.4).1).collect();
            assert!(ys.iter().all(|y| y.abs() <= 0.2) && ys.contains(&edge));
        }
        // Without noise, an item is reported exactly where it is, even if rounding puts it beside
        // the belt.
        let beside = Item::at("c", -0.3, 0.2 + 5e-10);
        let plain = Disturbances::default().reported(0, &beside, 0.4);
        assert_eq!(plain, (beside.x0, beside.y));
    }
}
