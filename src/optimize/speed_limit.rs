//! The highest belt speed up to which everything is picked.
//!
//! Completeness is not monotonic in speed: a line may miss an item at one speed and pick
//! everything at a higher one. Therefore the limit is found by an upward scan that verifies
//! every step, not by bisection.

use crate::decision::Figures;
use crate::error::{Error, Result, shown_number};
use crate::pattern::Pattern;
use crate::sim::{AssignmentTree, Conditions, Scene};
use crate::station::Station;

/// The speeds that are tried: `step`, `2 step`, ... [m/s], up to below the slowest arm's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedScan {
    /// Resolution of the limit [m/s].
    step: f64,
}

impl Default for SpeedScan {
    fn default() -> Self {
        Self { step: 0.001 }
    }
}

/// Lowest belt speed [m/s].
const FINEST: f64 = 1e-6;
/// Maximum number of speeds in one scan; more are treated as a typing mistake.
const MOST_STEPS: f64 = 1e5;

impl SpeedScan {
    /// A scan with this resolution [m/s] that fits `station`.
    ///
    /// # Errors
    /// A step that leaves no speed below the slowest arm's, or far too many.
    pub fn new(step: f64, station: &Station) -> Result<Self> {
        let fastest = station.slowest_arm();
        let steps = fastest / step;
        if step >= FINEST && station.is_faster_than(step) && steps <= MOST_STEPS {
            return Ok(Self { step });
        }
        Err(Error::usage(
            "'scan'",
            format!(
                "{} m/s is not a valid step up to the slowest arm's {fastest} m/s",
                shown_number(step)
            ),
            format!(
                "give a step in m/s, from {} to below {fastest}",
                (fastest / MOST_STEPS).max(FINEST)
            ),
        ))
    }

    /// Approximate number of speeds that a limit takes on `station`. A line designed for its
    /// belt speed misses something not far above it.
    pub(super) fn expected_steps(&self, station: &Station) -> f64 {
        let most = station.slowest_arm().min(1.5 * station.belt().speed);
        (most / self.step).max(1.0)
    }

    /// The `k`-th speed [m/s], as the decimal number that a user would write.
    fn speed(&self, k: u32) -> f64 {
        (f64::from(k) * self.step * 1e9).round() / 1e9
    }

    /// For each assignment of `tree`, in its order: the highest speed of the scan up to which
    /// all items of `pattern` are picked at every speed; 0 if the lowest speed already misses
    /// one. Also returns the number of runs.
    ///
    /// # Errors
    /// A pattern that does not fit on the belt.
    pub fn limits(
        &self,
        station: &Station,
        pattern: &Pattern,
        tree: &AssignmentTree,
        conditions: &Conditions,
    ) -> Result<(Vec<f64>, u64)> {
        let (limits, runs) = self.limits_within(station, pattern, tree, conditions, u64::MAX)?;
        Ok((limits.unwrap_or_default(), runs))
    }

    /// The same in at most `most` runs; `None` if these do not suffice.
    pub(super) fn limits_within(
        &self,
        station: &Station,
        pattern: &Pattern,
        tree: &AssignmentTree,
        conditions: &Conditions,
        most: u64,
    ) -> Result<(Option<Vec<f64>>, u64)> {
        let mut limits = vec![0.0; tree.assignments().len()];
        let mut runs = 0;
        // Those that have missed nothing yet, as indices into `limits`.
        let mut alive: Vec<usize> = (0..limits.len()).collect();
        let mut tree = tree.clone();
        for k in 1.. {
            let speed = self.speed(k);
            if alive.is_empty() || !station.is_faster_than(speed) {
                break;
            }
            if runs + alive.len() as u64 > most {
                return Ok((None, runs));
            }
            let station = station.with_belt_speed(speed)?;
            let scene = Scene::under(&station, pattern, conditions.clone())?;
            // Indices in the tree.
            let mut still: Vec<usize> = Vec::with_capacity(alive.len());
            tree.evaluate(&scene, |place, figures| {
                if figures.complete() {
                    limits[alive[place]] = speed;
                    still.push(place);
                }
            })?;
            runs += alive.len() as u64;
            if still.len() < alive.len() {
                let survivors = still.iter().map(|&place| &tree.assignments()[place]);
                tree = AssignmentTree::new(survivors.cloned().collect());
                alive = still.iter().map(|&place| alive[place]).collect();
            }
        }
        Ok((Some(limits), runs))
    }

    /// The same for what `run` does with a scene.
    ///
    /// # Errors
    /// As for [`SpeedScan::limits`], and the errors of `run`.
    pub fn limit(
        &self,
        station: &Station,
        pattern: &Pattern,
        conditions: &Conditions,
        run: impl Fn(&Scene) -> Result<Figures>,
    ) -> Result<f64> {
        let mut limit = 0.0;
        for speed in (1..).map(|k| self.speed(k)) {
            if !station.is_faster_than(speed) {
                break;
            }
            let station = station.with_belt_speed(speed)?;
            let scene = Scene::under(&station, pattern, conditions.clone())?;
            if !run(&scene)?.complete() {
                break;
            }
            limit = speed;
        }
        Ok(limit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::grid;
    use crate::sim::simulate_rules;
    use crate::station::built_in;

    #[test]
    fn the_papers_grid_first_misses_at_the_speed_of_the_model_page() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let pattern = grid(1.05, 0.15, 50).unwrap();
        let tree = AssignmentTree::new(vec!["SPT,FIFO".parse().unwrap()]);
        let plain = Conditions::default();
        let (limits, _) = SpeedScan::default()
            .limits(&station, &pattern, &tree, &plain)
            .unwrap();
        assert_eq!(limits, [0.043]);
    }

    #[test]
    fn all_assignments_at_once_have_the_limits_of_a_plain_scan() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let pattern = grid(1.05, 0.22, 40).unwrap();
        let tree = AssignmentTree::all(2);
        let scan = SpeedScan::new(0.004, &station).unwrap();
        let plain = Conditions::default();
        let (limits, _) = scan.limits(&station, &pattern, &tree, &plain).unwrap();
        for (assignment, limit) in tree.assignments().iter().zip(limits) {
            let mut highest = 0.0;
            for k in 1..125 {
                let speed = f64::from(k) * 4.0 / 1000.0;
                let station = station.with_belt_speed(speed).unwrap();
                let scene = Scene::new(&station, &pattern).unwrap();
                if !simulate_rules(&scene, assignment)
                    .unwrap()
                    .figures
                    .complete()
                {
                    break;
                }
                highest = speed;
            }
            assert_eq!(limit, highest, "{assignment}");
            let run = |scene: &Scene| Ok(simulate_rules(scene, assignment)?.figures);
            let one = scan.limit(&station, &pattern, &plain, run).unwrap();
            assert_eq!(limit, one, "{assignment}");
        }
    }

    /// A limit takes one run at every speed up to it, and one at the next. If the runs do not
    /// suffice, there are no limits and the number of runs is not exceeded.
    #[test]
    fn a_scan_counts_its_runs() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let pattern = grid(1.05, 0.22, 40).unwrap();
        let (tree, plain) = (AssignmentTree::all(2), Conditions::default());
        let scan = SpeedScan::new(0.01, &station).unwrap();
        let (limits, runs) = scan.limits(&station, &pattern, &tree, &plain).unwrap();
        let steps = limits.iter().map(|limit| (limit / 0.01).round() as u64 + 1);
        assert_eq!(runs, steps.sum::<u64>());
        let within = |most| {
            let found = scan.limits_within(&station, &pattern, &tree, &plain, most);
            found.unwrap()
        };
        for most in (0..runs).step_by(5).chain([runs - 1]) {
            let (found, took) = within(most);
            assert!(found.is_none() && took <= most, "{took} of {most}");
        }
        assert_eq!(within(runs), (Some(limits.clone()), runs));
        assert_eq!(within(runs + 1), (Some(limits), runs));
    }

    /// A line that misses nothing at any speed gets the highest allowed belt speed.
    #[test]
    fn no_scan_goes_past_the_slowest_arm() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let pattern = grid(1.05, 0.5, 1).unwrap();
        let tree = AssignmentTree::new(vec!["SPT,FIFO".parse().unwrap()]);
        let scan = SpeedScan::new(0.05, &station).unwrap();
        let plain = Conditions::default();
        let (limits, runs) = scan.limits(&station, &pattern, &tree, &plain).unwrap();
        // The arm moves at 0.5 m/s.
        assert_eq!((limits, runs), (vec![0.45], 9));
    }

    /// Up to 1.5 times the belt speed, at least one step.
    #[test]
    fn a_limit_is_expected_near_the_belts_speed() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        let steps = |step: f64| SpeedScan { step }.expected_steps(&station);
        assert!((steps(0.001) - 75.0).abs() < 1e-9 && steps(0.1) == 1.0);
        let fast = station.with_belt_speed(0.4).unwrap();
        let steps = SpeedScan { step: 0.01 }.expected_steps(&fast);
        assert!((steps - 50.0).abs() < 1e-9, "{steps}");
    }

    #[test]
    fn steps_that_make_no_scan_are_refused() {
        let station = built_in("paper").unwrap().station(None).unwrap();
        for step in [0.0, -0.1, f64::NAN, 0.5, 1e-9] {
            assert!(SpeedScan::new(step, &station).is_err(), "{step}");
        }
    }
}
