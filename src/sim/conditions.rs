//! The conditions under which a pattern is picked: the camera and disturbances.

use crate::error::{Error, Result, shown_number};
use crate::pattern::{Item, random_stream};
use crate::setters::setters;
use rand::RngExt;
use rand_distr::{Distribution as _, StandardNormal};

/// Camera positions beyond this [m] are rejected.
const FURTHEST: f64 = 1e6;
/// Larger position noise [m] is treated as a wrong unit.
const MOST_NOISE: f64 = 10.0;
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

/// The conditions under which a pattern is picked. The default is the plain model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Conditions {
    /// Decisions are only made at multiples of `1 / update_hz` seconds; 0 means at any time [Hz].
    pub update_hz: f64,
    /// Position of the camera [m]: only items that have passed it are known. Without a camera, an
    /// item is in view from the start of the belt, and its windows are those of the model.
    pub camera_x: Option<f64>,
    /// Items with a lower `p_detection` are left on the belt; 0 picks all. An item without one
    /// counts as certain.
    pub min_detection: f64,
    /// What can go wrong while items are picked.
    pub disturbances: Disturbances,
}

setters!(Conditions {
    /// With decisions only at multiples of `1 / update_hz` seconds; 0 for any time [Hz].
    fn with_update_hz(update_hz: f64);
    /// With a camera at this position [m], or without one.
    fn with_camera_x(camera_x: impl Into<Option<f64>>);
    /// With items of a lower `p_detection` left on the belt.
    fn with_min_detection(min_detection: f64);
    /// With these disturbances.
    fn with_disturbances(disturbances: Disturbances);
});

impl Conditions {
    /// The plain model with decisions only at multiples of `1 / hz` seconds.
    pub fn at_update_hz(hz: f64) -> Self {
        Self {
            update_hz: hz,
            ..Self::default()
        }
    }

    /// The same conditions for the pattern with index `place` in a set; its seed is this seed plus
    /// `place`.
    pub fn of_place(self, place: usize) -> Self {
        self.with_seed(self.disturbances.seed.wrapping_add(place as u64))
    }

    /// The same conditions with another seed.
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.disturbances.seed = seed;
        self
    }

    /// Whether `item` is left on the belt because its detection is too uncertain.
    pub fn is_too_uncertain(&self, item: &Item) -> bool {
        item.p_detection.is_some_and(|p| p < self.min_detection)
    }

    /// Checks the values.
    ///
    /// # Errors
    /// If a frequency, position, probability or standard deviation is not valid.
    pub fn check(&self) -> Result<()> {
        let hz = self.update_hz;
        if !(hz == 0.0 || (1e-6..=1e6).contains(&hz)) {
            return Err(Error::usage(
                "'update_hz'",
                format!("{} is not a valid update frequency", shown_number(hz)),
                "give Hz, from 1e-6 to 1e6, or 0 for exact decisions",
            ));
        }
        let on_belt = -FURTHEST..=FURTHEST;
        if let Some(x) = self.camera_x.filter(|x| !on_belt.contains(x)) {
            return Err(Error::usage(
                "'camera_x'",
                format!("{} is not a valid position along the belt", shown_number(x)),
                "give metres from the start of the belt, negative upstream of it",
            ));
        }
        let p = self.disturbances.default_p_grasp;
        if !(0.0..=1.0).contains(&p) {
            return Err(Error::usage(
                "'default_p_grasp'",
                format!("{} is not a probability", shown_number(p)),
                "give the probability that a grasp succeeds, from 0 to 1, or omit the number",
            ));
        }
        let least = self.min_detection;
        if !(0.0..=1.0).contains(&least) {
            return Err(Error::usage(
                "'min_detection'",
                format!("{} is not a probability", shown_number(least)),
                "give the lowest p_detection of items that are picked, from 0 to 1",
            ));
        }
        let noise = self.disturbances.position_noise;
        if !(0.0..=MOST_NOISE).contains(&noise) {
            return Err(Error::usage(
                "'position_noise'",
                format!("{} is not a valid standard deviation", shown_number(noise)),
                format!("give metres, from 0 to {MOST_NOISE}"),
            ));
        }
        Ok(())
    }

    /// The camera and the disturbances in words, one text per fact.
    pub fn describe(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(x) = self.camera_x {
            lines.push(format!(
                "only items past x = {} m are known",
                shown_number(x)
            ));
        }
        if self.min_detection > 0.0 {
            lines.push(format!(
                "items with a p_detection below {} are left on the belt",
                shown_number(self.min_detection)
            ));
        }
        let Disturbances {
            grasp_failures,
            default_p_grasp,
            position_noise,
            misdetections,
            ..
        } = self.disturbances;
        if grasp_failures {
            let p = shown_number(default_p_grasp);
            lines.push(format!("grasps succeed with p_grasp, {p} where not given"));
        }
        if position_noise > 0.0 {
            let sd = shown_number(position_noise);
            lines.push(format!(
                "reported positions are off by {sd} m (SD, x and y)"
            ));
        }
        if misdetections {
            lines.push("detections are right with p_detection, or as recorded".to_owned());
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_conditions_are_refused_by_name() {
        let plain = Conditions::default();
        plain.check().unwrap();
        let disturbed = |default_p_grasp, position_noise| Conditions {
            disturbances: Disturbances {
                grasp_failures: true,
                default_p_grasp,
                position_noise,
                ..Disturbances::default()
            },
            ..plain
        };
        disturbed(0.0, 0.0).check().unwrap();
        let camera = |x| Conditions {
            camera_x: Some(x),
            ..plain
        };
        camera(-3.0).check().unwrap();
        for (bad, flag) in [
            (Conditions::at_update_hz(-1.0), "'update_hz'"),
            (camera(f64::NAN), "'camera_x'"),
            (camera(f64::NEG_INFINITY), "'camera_x'"),
            (disturbed(1.01, 0.0), "'default_p_grasp'"),
            (disturbed(f64::NAN, 0.0), "'default_p_grasp'"),
            (plain.with_min_detection(-0.1), "'min_detection'"),
            (plain.with_min_detection(f64::NAN), "'min_detection'"),
            (disturbed(1.0, -1e-9), "'position_noise'"),
            (disturbed(1.0, f64::NAN), "'position_noise'"),
            (disturbed(1.0, 11.0), "'position_noise'"),
        ] {
            let message = bad.check().unwrap_err().to_string();
            assert!(message.contains(flag), "{message}");
        }
    }

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
    fn the_limits_of_each_condition_are_conditions() {
        let plain = Conditions::default();
        let failing = |p: f64| Conditions {
            disturbances: failing(p),
            ..plain
        };
        let noisy = |position_noise: f64| Conditions {
            disturbances: Disturbances {
                position_noise,
                ..Disturbances::default()
            },
            ..plain
        };
        let camera = |x: f64| Conditions {
            camera_x: Some(x),
            ..plain
        };
        for (good, bad) in [
            (
                Conditions::at_update_hz(1e-6),
                Conditions::at_update_hz(9e-7),
            ),
            (
                Conditions::at_update_hz(1e6),
                Conditions::at_update_hz(1.1e6),
            ),
            (camera(-1e6), camera(-1.1e6)),
            (camera(1e6), camera(1.1e6)),
            (failing(0.0), failing(-1e-9)),
            (failing(1.0), failing(1.0 + 1e-9)),
            (
                plain.with_min_detection(0.0),
                plain.with_min_detection(-1e-9),
            ),
            (
                plain.with_min_detection(1.0),
                plain.with_min_detection(1.0 + 1e-9),
            ),
            (noisy(0.0), noisy(-1e-9)),
            (noisy(10.0), noisy(10.1)),
        ] {
            good.check().unwrap();
            assert!(bad.check().is_err(), "{bad:?}");
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
    fn places_of_a_set_have_the_seeds_after_that_of_the_first() {
        let conditions = Conditions {
            update_hz: 10.0,
            camera_x: Some(0.5),
            min_detection: 0.5,
            disturbances: failing(0.5),
        };
        let seeded = conditions.with_seed(7);
        assert_eq!(seeded.disturbances.seed, 7);
        assert_eq!(seeded.of_place(0), seeded);
        assert_eq!(seeded.of_place(3), conditions.with_seed(10));
        let last = conditions.with_seed(u64::MAX);
        assert_eq!(last.of_place(2), conditions.with_seed(1));
        // Everything else stays the same.
        assert_eq!(seeded.with_seed(conditions.disturbances.seed), conditions);
    }

    #[test]
    fn conditions_are_described_one_by_one() {
        let none: [&str; 0] = [];
        assert_eq!(Conditions::default().describe(), none);
        assert_eq!(Conditions::at_update_hz(10.0).describe(), none);
        let all = Conditions {
            update_hz: 0.0,
            camera_x: Some(-0.5),
            min_detection: 0.8,
            disturbances: Disturbances {
                position_noise: 0.01,
                misdetections: true,
                ..failing(0.9)
            },
        };
        let camera = "only items past x = -0.5 m are known";
        let grasps = "grasps succeed with p_grasp, 0.9 where not given";
        let noise = "reported positions are off by 0.01 m (SD, x and y)";
        let threshold = "items with a p_detection below 0.8 are left on the belt";
        let wrong = "detections are right with p_detection, or as recorded";
        assert_eq!(all.describe(), [camera, threshold, grasps, noise, wrong]);
        let mut some = all;
        some.camera_x = None;
        assert_eq!(some.describe(), [threshold, grasps, noise, wrong]);
        some.min_detection = 0.0;
        assert_eq!(some.describe(), [grasps, noise, wrong]);
        some.disturbances.grasp_failures = false;
        assert_eq!(some.describe(), [noise, wrong]);
        some.disturbances.position_noise = 0.0;
        assert_eq!(some.describe(), [wrong]);
        some.disturbances.misdetections = false;
        assert_eq!(some.describe(), none);
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
