//! Finding good prices: a deflected subgradient method.
//!
//! `1 - (how often item j is taken)` is a subgradient of L (Held, Wolfe and Crowder
//! 1974, DOI 10.1007/BF01580223). Steps go along a mixture with the steps before
//! (Camerini, Fratta and Maffioli 1975, DOI 10.1007/BFb0120697), are as long as Polyak's
//! rule says for a level a little below the best value, and become shorter when the
//! best has not fallen for a while. It stops by count, never by time.

use super::dual::{Dual, Evaluation};
use super::profile::{Leaving, Profile};

/// Share of the last direction in the next one.
const MEMORY: f64 = 0.7;
/// The level aimed at, as a share of the best value.
const LEVEL: f64 = 0.95;
/// Steps without a better value before steps become shorter.
const PATIENCE: usize = 5;
/// By how much they do.
const SHORTER: f64 = 0.6;
/// A value counts as better when it is by this share.
const BETTER: f64 = 1e-8;
/// Steps shorter than this share of the first no longer change anything.
const SHORTEST: f64 = 1e-5;

/// The schedules that prices are sought for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedules {
    /// Every release lies in this slot or before.
    pub horizon: u64,
    /// The items from this one on must be picked, so that their prices may be negative.
    pub must_from: usize,
}

/// Prices on their way.
#[derive(Debug, Clone)]
pub(super) struct Ascent {
    /// Where it stands, as shares of the items' weights in units.
    at: Vec<f64>,
    direction: Vec<f64>,
    /// The best prices so far, in units.
    pub best_prices: Vec<i64>,
    /// Their value, in units.
    pub best: i64,
}

impl Ascent {
    /// Starts from `prices` in units, in the box of the schedules that it is for; `best`
    /// is a value known to hold.
    pub fn new(prices: Vec<i64>, best: i64) -> Self {
        Self {
            at: prices.iter().map(|&p| p as f64).collect(),
            direction: vec![0.0; prices.len()],
            best_prices: prices,
            best,
        }
    }

    /// Where it stands, in units.
    pub fn last_prices(&self) -> Vec<i64> {
        self.at.iter().map(|&at| at as i64).collect()
    }

    /// Goes up to `steps` steps for `schedules`, the first of relative length `length`;
    /// every step is entered in `profile`. `done` is told the best value after every
    /// step and may end it.
    pub fn run(
        &mut self,
        dual: &Dual,
        schedules: Schedules,
        (steps, length): (usize, f64),
        (profile, belt): (&mut Profile, &Leaving),
        mut done: impl FnMut(i64) -> bool,
    ) {
        let (mut length, shortest) = (length, length * SHORTEST);
        let mut without = 0;
        let mut evaluation = Evaluation::default();
        self.direction.fill(0.0);
        for _ in 0..steps {
            let prices = self.last_prices();
            dual.evaluate(&prices, schedules.horizon, &mut evaluation);
            profile.enter(belt, &prices, &evaluation);
            without += 1;
            if (evaluation.value as f64) < self.best as f64 * (1.0 - BETTER) {
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

    /// One step; false when there is nowhere to go, which proves the prices optimal.
    fn step(&mut self, dual: &Dual, schedules: Schedules, length: f64, at: &Evaluation) -> bool {
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
            // No further out of the box than its face.
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
