//! The conditions under which a pattern is picked: the camera and disturbances.

use super::disturbances::Disturbances;
use super::outages::{Outage, RandomOutages};
use crate::error::{Error, Result, shown_number};
use crate::pattern::Item;
use crate::setters::setters;
use crate::station::Station;

/// Camera positions beyond this [m] are rejected.
const FURTHEST: f64 = 1e6;
/// Larger position noise [m] is treated as a wrong unit.
const MOST_NOISE: f64 = 10.0;

/// The conditions under which a pattern is picked. The default is the plain model.
#[derive(Debug, Clone, PartialEq, Default)]
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
    /// Times in which robots are down. Where they overlap or touch, they are one.
    pub given_outages: Vec<Outage>,
    /// Random outages of every robot, drawn from the seed of the disturbances.
    pub random_outages: Option<RandomOutages>,
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

    /// With this outage, in addition to others.
    #[must_use]
    pub fn with_outage(mut self, outage: Outage) -> Self {
        self.given_outages.push(outage);
        self
    }

    /// With random outages of every robot, or without.
    #[must_use]
    pub fn with_outages(mut self, outages: impl Into<Option<RandomOutages>>) -> Self {
        self.random_outages = outages.into();
        self
    }

    /// Whether a robot may be down.
    pub fn has_outages(&self) -> bool {
        !self.given_outages.is_empty() || self.random_outages.is_some()
    }

    /// Whether anything can go wrong.
    pub fn can_go_wrong(&self) -> bool {
        self.disturbances.may_fail() || self.has_outages()
    }

    /// Whether a run depends on the seed.
    pub fn is_random(&self) -> bool {
        self.disturbances.may_fail() || self.random_outages.is_some()
    }

    /// The same conditions for the pattern with index `place` in a set; its seed is this seed plus
    /// `place`.
    #[must_use]
    pub fn of_place(&self, place: usize) -> Self {
        self.with_seed(self.disturbances.seed.wrapping_add(place as u64))
    }

    /// The same conditions with another seed.
    #[must_use]
    pub fn with_seed(&self, seed: u64) -> Self {
        let mut seeded = self.clone();
        seeded.disturbances.seed = seed;
        seeded
    }

    /// Whether `item` is left on the belt because its detection is too uncertain.
    pub fn is_too_uncertain(&self, item: &Item) -> bool {
        item.p_detection.is_some_and(|p| p < self.min_detection)
    }

    /// Checks the values.
    ///
    /// # Errors
    /// If a frequency, position, probability, standard deviation or time is not valid.
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
        self.given_outages.iter().try_for_each(Outage::check)?;
        self.random_outages
            .iter()
            .try_for_each(RandomOutages::check)
    }

    /// Like [`Conditions::check`], and checks that `station` has the robots that are down.
    ///
    /// # Errors
    /// As for [`Conditions::check`], and an outage of a robot that the station does not have.
    pub fn check_on(&self, station: &Station) -> Result<()> {
        self.check()?;
        let mut outages = self.given_outages.iter();
        outages.try_for_each(|outage| outage.robot_on(station).map(drop))
    }

    /// The camera, the disturbances and the outages in words, one text per fact.
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
        lines.extend(self.given_outages.iter().map(Outage::describe));
        lines.extend(self.random_outages.iter().map(RandomOutages::describe));
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
            ..plain.clone()
        };
        disturbed(0.0, 0.0).check().unwrap();
        let camera = |x| Conditions {
            camera_x: Some(x),
            ..plain.clone()
        };
        camera(-3.0).check().unwrap();
        for (bad, flag) in [
            (Conditions::at_update_hz(-1.0), "'update_hz'"),
            (camera(f64::NAN), "'camera_x'"),
            (camera(f64::NEG_INFINITY), "'camera_x'"),
            (disturbed(1.01, 0.0), "'default_p_grasp'"),
            (disturbed(f64::NAN, 0.0), "'default_p_grasp'"),
            (plain.clone().with_min_detection(-0.1), "'min_detection'"),
            (
                plain.clone().with_min_detection(f64::NAN),
                "'min_detection'",
            ),
            (disturbed(1.0, -1e-9), "'position_noise'"),
            (disturbed(1.0, f64::NAN), "'position_noise'"),
            (disturbed(1.0, 11.0), "'position_noise'"),
        ] {
            let message = bad.check().unwrap_err().to_string();
            assert!(message.contains(flag), "{message}");
        }
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
            ..plain.clone()
        };
        let noisy = |position_noise: f64| Conditions {
            disturbances: Disturbances {
                position_noise,
                ..Disturbances::default()
            },
            ..plain.clone()
        };
        let camera = |x: f64| Conditions {
            camera_x: Some(x),
            ..plain.clone()
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
                plain.clone().with_min_detection(0.0),
                plain.clone().with_min_detection(-1e-9),
            ),
            (
                plain.clone().with_min_detection(1.0),
                plain.clone().with_min_detection(1.0 + 1e-9),
            ),
            (noisy(0.0), noisy(-1e-9)),
            (noisy(10.0), noisy(10.1)),
        ] {
            good.check().unwrap();
            assert!(bad.check().is_err(), "{bad:?}");
        }
    }

    #[test]
    fn places_of_a_set_have_the_seeds_after_that_of_the_first() {
        let conditions = Conditions {
            update_hz: 10.0,
            camera_x: Some(0.5),
            min_detection: 0.5,
            disturbances: failing(0.5),
            given_outages: vec![Outage::new("r1", 3.0, 4.0)],
            random_outages: None,
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
            given_outages: vec![Outage::new("r1", 3.0, 4.0)],
            random_outages: Some(RandomOutages::new(300.0, 20.0)),
        };
        let camera = "only items past x = -0.5 m are known";
        let grasps = "grasps succeed with p_grasp, 0.9 where not given";
        let noise = "reported positions are off by 0.01 m (SD, x and y)";
        let threshold = "items with a p_detection below 0.8 are left on the belt";
        let wrong = "detections are right with p_detection, or as recorded";
        let outage = "robot r1 is down from 3 s to 4 s";
        let outages = "robots fail after 300 s and are repaired in 20 s (means, exponential)";
        let facts = [camera, threshold, grasps, noise, wrong, outage, outages];
        assert_eq!(all.describe(), facts);
        let mut some = all;
        some.given_outages.clear();
        some.random_outages = None;
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
}
