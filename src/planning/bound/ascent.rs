//! Finds good prices: a deflected subgradient method.
//!
//! `1 - (how often item j is taken)` is a subgradient of L (Held, Wolfe and Crowder 1974, DOI
//! 10.1007/BF01580223). Each direction is mixed with the previous ones (Camerini, Fratta and
//! Maffioli 1975, DOI 10.1007/BFb0120697). Step lengths follow Polyak's rule for a level a
//! little below the best value, and become shorter if the best value has not fallen for a
//! while. The method stops by count, never by time.

use super::dual::{Dual, DualEvaluation, Schedules};
use super::profile::{BoundProfile, Leaving};

/// Share of the previous direction in the next one.
const MEMORY: f64 = 0.7;
/// The target level, as a share of the best value.
const LEVEL: f64 = 0.95;
/// Number of steps without a better value before steps become shorter.
const PATIENCE: usize = 5;
/// Factor by which they become shorter.
const SHORTER: f64 = 0.6;
/// Minimum relative improvement of a better value.
const BETTER: f64 = 1e-8;
/// Steps shorter than this share of the first have no effect any longer.
const SHORTEST: f64 = 1e-5;

/// The state of the search for prices.
#[derive(Debug, Clone)]
pub(super) struct Ascent {
    /// The current prices, as shares of the items' weights in units.
    at: Vec<f64>,
    direction: Vec<f64>,
    /// The best prices so far, in units.
    pub best_prices: Vec<i64>,
    /// The value of the best prices, in units.
    pub best: i64,
}

/// How far one call of [`Ascent::run`] may go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    /// Maximum number of steps.
    pub most: usize,
    /// Relative length of the first.
    pub length: f64,
}

impl Ascent {
    /// Starts from `prices` in units, within the limits for its schedules; `best` is a value
    /// known to be valid.
    pub(super) fn new(prices: Vec<i64>, best: i64) -> Self {
        Self {
            at: prices.iter().map(|&p| p as f64).collect(),
            direction: vec![0.0; prices.len()],
            best_prices: prices,
            best,
        }
    }

    /// The current prices, in units.
    pub(super) fn last_prices(&self) -> Vec<i64> {
        self.at.iter().map(|&at| at as i64).collect()
    }

    /// Makes `steps` for `schedules`. Every step is entered in `profile`. `done` gets the best value after every step and may end
    /// the search.
    pub(super) fn run(
        &mut self,
        dual: &Dual,
        schedules: Schedules,
        steps: Steps,
        profile: &mut BoundProfile,
        belt: &Leaving,
        mut done: impl FnMut(i64) -> bool,
    ) {
        let (mut length, shortest) = (steps.length, steps.length * SHORTEST);
        let mut without = 0;
        let mut evaluation = DualEvaluation::default();
        self.direction.fill(0.0);
        for _ in 0..steps.most {
            let prices = self.last_prices();
            dual.evaluate(&prices, schedules.horizon, &mut evaluation);
            profile.enter(belt, &prices, &evaluation);
            without += 1;
            if is_better(evaluation.value, self.best) {
                without = 0;
            }
            if evaluation.value < self.best {
                self.best = evaluation.value;
                self.best_prices = prices;
            }
            if done(self.best) {
                return;
            }
            if without >= PATIENCE {
                length *= SHORTER;
                without = 0;
            }
            if length < shortest || !self.step(dual, schedules, length, &evaluation) {
                return;
            }
        }
    }

    /// Makes one step; false if no direction is left, which proves the prices optimal.
    fn step(
        &mut self,
        dual: &Dual,
        schedules: Schedules,
        length: f64,
        at: &DualEvaluation,
    ) -> bool {
        let box_of = |item: usize| -> (f64, f64) {
            let must = item >= schedules.must_from;
            let least = if must { -dual.most_negative } else { 0 };
            (least as f64, dual.weights[item] as f64)
        };
        let mut norm = 0.0;
        for (item, direction) in self.direction.iter_mut().enumerate() {
            let counts = dual.earliest[item].is_some_and(|slot| slot <= schedules.horizon);
            let slope = if counts {
                1.0 - f64::from(at.taken[item])
            } else {
                0.0
            };
            // A price at a limit must not move beyond it.
            let (least, most) = box_of(item);
            let outwards =
                (slope > 0.0 && self.at[item] <= least) || (slope < 0.0 && self.at[item] >= most);
            let slope = if outwards { 0.0 } else { slope };
            *direction = slope + MEMORY * *direction;
            norm += *direction * *direction;
        }
        if norm == 0.0 {
            return false;
        }
        let above = (at.value as f64 - LEVEL * self.best as f64).max(1.0);
        let step = length * above / norm;
        for (item, (at, direction)) in self.at.iter_mut().zip(&self.direction).enumerate() {
            let (least, most) = box_of(item);
            *at = (*at - step * direction).clamp(least, most);
        }
        true
    }
}

/// Whether steps that find `value` after `best` are worth their length.
fn is_better(value: i64, best: i64) -> bool {
    (value as f64) < best as f64 * (1.0 - BETTER)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Item, Pattern};
    use crate::planning::bound::BoundObjective;
    use crate::planning::bound::network::Slots;
    use crate::sim::Scene;
    use crate::station::{Robot, Station, built_in};

    /// Two robots that have time for one pick each, and `items` items within reach of both.
    fn contest(items: usize) -> (Dual, Leaving) {
        let plain = built_in("paper").unwrap().station(Some(2)).unwrap();
        let slow = |robot: &Robot| Robot {
            grasp_time: 60.0,
            ..robot.clone()
        };
        let robots = plain.robots().iter().map(slow).collect();
        let station = Station::new(*plain.belt(), robots).unwrap();
        let item = |i: usize| Item::at(i.to_string(), -0.1 * i as f64, 0.0);
        let pattern = Pattern::new((0..items).map(item).collect()).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let dual = Dual::new(&scene, BoundObjective::Picks, Slots { length: 0.5 });
        let belt = Leaving::new(&scene, &dual);
        (dual, belt)
    }

    fn evaluation(value: i64, taken: &[u32]) -> DualEvaluation {
        DualEvaluation {
            value,
            taken: taken.to_vec(),
            ..DualEvaluation::default()
        }
    }

    fn steps(most: usize) -> Steps {
        Steps { most, length: 2.0 }
    }

    /// The prices in picks, within rounding.
    fn assert_at(ascent: &Ascent, dual: &Dual, expected: &[f64]) {
        let found: Vec<f64> = ascent.at.iter().map(|at| at / dual.units).collect();
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9;
        assert!(
            found.iter().zip(expected).all(near),
            "{found:?}, not {expected:?}"
        );
    }

    #[test]
    fn a_value_is_better_by_more_than_a_hundred_millionth() {
        let best = 5_000_000_000;
        assert!(is_better(best - 51, best));
        for value in [best - 49, best, best + 51] {
            assert!(!is_better(value, best), "{value}");
        }
    }

    /// Down where an item lies on no path, up where it lies on several; 0.7 of the last
    /// direction goes into the next one, and the step is Polyak's for 0.95 of the best value.
    #[test]
    fn a_step_goes_as_far_as_polyak_says() {
        let (dual, _) = contest(3);
        let unit = dual.units as i64;
        let mut ascent = Ascent::new(vec![unit / 2; 3], 2 * unit);
        // (3 - 0.95 * 2) of 2 over a norm of 2.
        let at = evaluation(3 * unit, &[0, 2, 1]);
        assert!(ascent.step(&dual, Schedules::ANY, 0.2, &at));
        let far = 0.2 * 1.1 / 2.0;
        assert_at(&ascent, &dual, &[0.5 - far, 0.5 + far, 0.5]);
        // The norm of (1 + 0.7, -1 - 0.7, 0).
        assert!(ascent.step(&dual, Schedules::ANY, 0.2, &at));
        let further = far + 1.7 * 0.2 * 1.1 / (2.0 * 1.7 * 1.7);
        assert_at(&ascent, &dual, &[0.5 - further, 0.5 + further, 0.5]);
        // Taken three times: a slope of -2.
        let mut ascent = Ascent::new(vec![unit / 4; 3], 2 * unit);
        assert!(ascent.step(
            &dual,
            Schedules::ANY,
            0.2,
            &evaluation(3 * unit, &[1, 1, 3])
        ));
        assert_at(&ascent, &dual, &[0.25, 0.25, 0.25 + 2.0 * 0.2 * 1.1 / 4.0]);
    }

    /// A value below the target level still moves the prices, by one unit.
    #[test]
    fn there_is_always_a_step() {
        let (dual, _) = contest(2);
        let unit = dual.units as i64;
        let mut ascent = Ascent::new(vec![unit / 2; 2], 2 * unit);
        assert!(ascent.step(&dual, Schedules::ANY, 2.0, &evaluation(unit, &[0, 2])));
        assert_eq!(ascent.last_prices(), [unit / 2 - 1, unit / 2 + 1]);
    }

    /// From 0 to the weight, or from far below 0 for items that must be picked. Prices at a
    /// limit do not move beyond it, and such a move is not a direction.
    #[test]
    fn prices_stay_in_their_box() {
        let (dual, _) = contest(3);
        let unit = dual.units as i64;
        let at = evaluation(3 * unit, &[0, 0, 2]);
        let faces = vec![0, 0, unit];
        let mut ascent = Ascent::new(faces.clone(), 2 * unit);
        assert!(
            !ascent.step(&dual, Schedules::ANY, 2.0, &at),
            "nowhere to go"
        );
        assert_eq!(ascent.last_prices(), faces);
        let must = Schedules {
            must_from: 1,
            ..Schedules::ANY
        };
        assert!(ascent.step(&dual, must, 0.5, &at));
        assert_at(&ascent, &dual, &[0.0, -0.5 * 1.1, 1.0]);
        assert!(ascent.step(&dual, must, 1e3, &at));
        assert_at(&ascent, &dual, &[0.0, -16.0, 1.0]);
        let mut ascent = Ascent::new(vec![unit / 2; 3], 2 * unit);
        assert!(ascent.step(&dual, Schedules::ANY, 1e3, &at));
        assert_at(&ascent, &dual, &[0.0, 0.0, 1.0]);
        // Back from both limits.
        assert!(ascent.step(
            &dual,
            Schedules::ANY,
            1e-3,
            &evaluation(3 * unit, &[2, 2, 0])
        ));
        assert!(
            ascent.at[0] > 0.0 && ascent.at[2] < dual.units,
            "{:?}",
            ascent.at
        );
    }

    /// Items that nobody can have released by the horizon have no slope.
    #[test]
    fn items_past_the_horizon_keep_their_prices() {
        let (dual, _) = contest(2);
        let unit = dual.units as i64;
        let [Some(first), Some(second)] = dual.earliest[..] else {
            panic!("both are in reach");
        };
        assert!(first < second);
        for (horizon, expected) in [(first - 1, [0.5, 0.5]), (first, [0.25, 0.5])] {
            let schedules = Schedules {
                horizon,
                ..Schedules::ANY
            };
            let mut ascent = Ascent::new(vec![unit / 2; 2], unit);
            let moved = ascent.step(&dual, schedules, 0.25, &evaluation(unit * 39 / 20, &[0, 0]));
            assert_eq!(moved, horizon == first);
            assert_at(&ascent, &dual, &expected);
        }
    }

    /// Steps become shorter by a factor of 0.6 after five without a better value, and the
    /// search ends when they are 1e-5 of the first: after 23 times five.
    #[test]
    fn steps_without_improvement_become_short_and_end() {
        let (dual, belt) = contest(5);
        let mut profile = BoundProfile::new(&dual);
        let mut ascent = Ascent::new(vec![dual.units as i64 / 2; 5], 0);
        let mut told = Vec::new();
        let step = |best| {
            told.push(best);
            false
        };
        ascent.run(
            &dual,
            Schedules::ANY,
            steps(1000),
            &mut profile,
            &belt,
            step,
        );
        assert_eq!(told, [0; 115]);
        assert_eq!(ascent.best_prices, [dual.units as i64 / 2; 5]);
    }

    /// From five items, of which two robots take one each, down to two picks. Every step is
    /// entered in the profile, and the best prices are those of the best value.
    #[test]
    fn the_best_value_of_all_steps_is_kept() {
        let (dual, belt) = contest(5);
        let unit = dual.units as i64;
        let mut profile = BoundProfile::new(&dual);
        let mut ascent = Ascent::new(vec![unit / 2; 5], 5 * unit);
        let mut told = Vec::new();
        let step = |best| {
            told.push(best);
            told.len() == 60
        };
        ascent.run(&dual, Schedules::ANY, steps(200), &mut profile, &belt, step);
        assert!(
            told.len() <= 60 && told.is_sorted_by(|a, b| a >= b),
            "{told:?}"
        );
        assert_eq!(told.last(), Some(&ascent.best));
        assert!(
            (2 * unit..2 * unit + unit / 1000).contains(&ascent.best),
            "{told:?}"
        );
        let mut again = DualEvaluation::default();
        dual.evaluate(&ascent.best_prices, u64::MAX, &mut again);
        assert_eq!(again.value, ascent.best);
        // The profile's last step has the best value of all steps of the search.
        let mut slots: Vec<u64> = dual
            .networks
            .iter()
            .flat_map(|n| n.slots().to_vec())
            .collect();
        slots.sort_unstable();
        slots.dedup();
        assert_eq!(profile.value(slots.len() - 1), ascent.best);
        // Exactly as many steps as requested are made.
        let mut made = 0;
        let count = |_| {
            made += 1;
            false
        };
        let mut ascent = Ascent::new(vec![unit / 2; 5], 5 * unit);
        ascent.run(&dual, Schedules::ANY, steps(7), &mut profile, &belt, count);
        assert_eq!(made, 7);
    }
}
