//! The Lagrangian dual: a price for every item, a longest path for every robot.
//!
//! With a price `p_j >= 0` on taking item j, the robots no longer compete, and
//!
//! ```text
//! L(p) = sum_j p_j + sum_robots (longest path under rewards w_j - p_j)
//! ```
//!
//! is at least what any schedule earns, whatever the prices (weak duality). All of it
//! is computed in whole numbers, so no rounding can lower it.

use super::Objective;
use super::network::{Network, Slots, earliest_release};
use crate::sim::Scene;

/// Items, weights and networks of one scene, in whole units.
#[derive(Debug)]
pub(super) struct Dual {
    /// Length of the slots.
    pub slots: Slots,
    /// One network a robot, upstream first.
    pub networks: Vec<Network>,
    /// What each item is worth, in units, rounded up; 0 for unreachable ones.
    pub weights: Vec<i64>,
    /// Earliest release of each item by any robot, as a slot; none when unreachable.
    pub earliest: Vec<Option<u64>>,
    /// Units in a weight of 1, a power of two.
    pub units: f64,
    /// How far below 0 prices of items that must be picked may go, in units.
    pub most_negative: i64,
    /// What is counted.
    objective: Objective,
}

/// What one set of prices gives.
#[derive(Debug, Default, Clone)]
pub(super) struct Evaluation {
    /// L(p) in units.
    pub value: i64,
    /// How often each item lies on a longest path.
    pub taken: Vec<u32>,
    /// Per robot, the value of the best path up to each node.
    pub values: Vec<Vec<i64>>,
}

/// Prices of items that must be picked may be as low as minus so many of the largest
/// weights.
const LEAST_PRICE: i64 = 16;
/// Sums of rewards, at most `1 + LEAST_PRICE` an item, stay below this power of two.
const BITS: i32 = 56;
/// No more binary digits than this behind the largest weight.
const DIGITS: i32 = 40;

impl Dual {
    /// The dual of `scene`.
    pub fn new(scene: &Scene, objective: Objective, slots: Slots) -> Self {
        let items = scene.pattern().len();
        let robots = 0..scene.station().robots().len();
        let network = |r: usize| Network::new(scene.station(), r, scene.queue(r), slots);
        let networks: Vec<Network> = robots.clone().map(network).collect();
        let mut worth = vec![0.0f64; items];
        let mut earliest: Vec<Option<u64>> = vec![None; items];
        for robot in robots {
            for candidate in scene.queue(robot) {
                let item = candidate.item as usize;
                worth[item] = match objective {
                    Objective::Picks => 1.0,
                    Objective::Weight => candidate.weight,
                };
                let free = earliest_release(scene.station(), robot, candidate);
                let slot = slots.of(free);
                earliest[item] = Some(earliest[item].map_or(slot, |other| other.min(slot)));
            }
        }
        let most = worth.iter().copied().fold(0.0, f64::max);
        let digits = DIGITS.min(BITS - (items as f64).log2().ceil() as i32 - 1);
        let exponent = if most > 0.0 {
            most.log2().ceil() as i32
        } else {
            0
        };
        let units = 2f64.powi(digits - exponent);
        Self {
            slots,
            networks,
            weights: worth.iter().map(|w| (w * units).ceil() as i64).collect(),
            earliest,
            units,
            most_negative: LEAST_PRICE << digits,
            objective,
        }
    }

    /// L(`prices`) for schedules whose last release lies in slot `horizon` or before, into
    /// `into`. Items that nobody can have released by then cost nothing.
    pub fn evaluate(&self, prices: &[i64], horizon: u64, into: &mut Evaluation) {
        let rewards: Vec<i64> = self
            .weights
            .iter()
            .zip(prices)
            .map(|(w, p)| w - p)
            .collect();
        into.value = self.price_sum(prices, horizon);
        into.taken.clear();
        into.taken.resize(prices.len(), 0);
        into.values.resize(self.networks.len(), Vec::new());
        for (network, values) in self.networks.iter().zip(&mut into.values) {
            network.longest_path(&rewards, values);
            let nodes = network.nodes_up_to(horizon);
            into.value += values[nodes];
            let taken = &mut into.taken;
            network.follow(&rewards, values, nodes, |item| taken[item as usize] += 1);
        }
    }

    fn price_sum(&self, prices: &[i64], horizon: u64) -> i64 {
        let counts = |slot: &Option<u64>| slot.is_some_and(|slot| slot <= horizon);
        let pairs = prices.iter().zip(&self.earliest);
        pairs.filter(|(_, slot)| counts(slot)).map(|(p, _)| p).sum()
    }

    /// The most that a schedule can earn of `units`: picks come in whole numbers.
    pub fn whole(&self, units: i64) -> i64 {
        match self.objective {
            Objective::Picks => {
                let pick = self.units as i64;
                units.div_euclid(pick) * pick
            }
            Objective::Weight => units,
        }
    }

    /// `units` as a weight, rounded up.
    pub fn weight(&self, units: i64) -> f64 {
        let value = units as f64 / self.units;
        if (value * self.units) as i64 >= units {
            value
        } else {
            value.next_up()
        }
    }
}
