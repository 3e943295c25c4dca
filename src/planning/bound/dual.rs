//! The Lagrangian dual: a price for every item, a longest path for every robot.
//!
//! With a price `p_j >= 0` on taking item j, the robots no longer compete, and
//!
//! ```text
//! L(p) = sum_j p_j + sum_robots (longest path under rewards w_j - p_j)
//! ```
//!
//! is an upper bound on what any schedule earns, for any prices (weak duality). Everything is
//! computed in whole numbers, so no rounding can lower the bound.

use super::BoundObjective;
use super::network::best_two::BestTwo;
use super::network::{SlotNetwork, Slots, earliest_release, picks};
use crate::sim::Scene;

/// Items, weights and networks of one scene, in whole units.
#[derive(Debug)]
pub(super) struct Dual {
    /// The time slots.
    pub slots: Slots,
    /// One network per robot, upstream first.
    pub networks: Vec<SlotNetwork>,
    /// Weight of each item in units, rounded up; 0 for unreachable items.
    pub weights: Vec<i64>,
    /// Slot of the earliest release of each item by any robot; `None` if unreachable.
    pub earliest: Vec<Option<u64>>,
    /// Units per weight of 1, a power of two.
    pub units: f64,
    /// How far below 0 the prices of items that must be picked may be, in units.
    pub most_negative: i64,
    /// The quantity to bound.
    objective: BoundObjective,
}

/// The schedules for which prices are sought.
#[derive(Debug, Clone, Copy)]
pub(super) struct Schedules {
    /// Every release is in this slot or before.
    pub horizon: u64,
    /// The items from this one on must be picked, so their prices may be negative.
    pub must_from: usize,
}

impl Schedules {
    /// All schedules: no limit on the last release, and no item that must be picked.
    pub(super) const ANY: Self = Self {
        horizon: u64::MAX,
        must_from: usize::MAX,
    };
}

/// The evaluation of one set of prices.
#[derive(Debug, Default, Clone)]
pub(super) struct DualEvaluation {
    /// L(p) in units.
    pub value: i64,
    /// How many longest paths contain each item.
    pub taken: Vec<u32>,
    /// For each robot, the value of the best path up to each node.
    pub values: Vec<Vec<i64>>,
    /// For each robot, the best paths that end in each node and place.
    pub endings: Vec<Vec<BestTwo>>,
}

/// Prices of items that must be picked may be as low as minus this many times the largest
/// weight.
const LEAST_PRICE: i64 = 16;
/// The largest weights of all items together stay below this power of two.
const BITS: i32 = 56;
/// Maximum number of binary digits after the largest weight.
const DIGITS: i32 = 40;

/// Number of binary digits after the largest of `items` weights.
fn digits(items: usize) -> i32 {
    DIGITS.min(BITS - (items as f64).log2().ceil() as i32 - 1)
}

impl Dual {
    /// The dual of `scene`.
    pub(super) fn new(scene: &Scene, objective: BoundObjective, slots: Slots) -> Self {
        let items = scene.pattern().len();
        let robots = 0..scene.station().robots().len();
        let network = |r: usize| SlotNetwork::new(scene.station(), r, picks(scene, r), slots);
        let networks: Vec<SlotNetwork> = robots.clone().map(network).collect();
        let mut worth = vec![0.0f64; items];
        let mut earliest: Vec<Option<u64>> = vec![None; items];
        for robot in robots {
            for (candidate, place) in picks(scene, robot) {
                let item = candidate.item as usize;
                worth[item] = match objective {
                    BoundObjective::Picks => 1.0,
                    BoundObjective::Weight => candidate.weight,
                };
                let free = earliest_release(scene.station(), robot, (&candidate, place));
                let slot = slots.of(free);
                earliest[item] = Some(earliest[item].map_or(slot, |other| other.min(slot)));
            }
        }
        let most = worth.iter().copied().fold(0.0, f64::max);
        let digits = digits(items);
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

    /// The same dual for picks that may fail.
    pub(super) fn with_failures(mut self) -> Self {
        let networks = self.networks.into_iter();
        self.networks = networks.map(SlotNetwork::with_failures).collect();
        self
    }

    /// The same dual if only the items that `counted` marks are worth anything. The others still
    /// take a robot its time and change its place, so this bounds what any schedule earns with
    /// the marked items.
    pub(super) fn counting(mut self, counted: &[bool]) -> Self {
        for (weight, counts) in self.weights.iter_mut().zip(counted) {
            if !counts {
                *weight = 0;
            }
        }
        self
    }

    /// Evaluates L(`prices`) for schedules whose last release is in slot `horizon` or before,
    /// into `into`. Items that nobody can have released by then cost nothing.
    pub(super) fn evaluate(&self, prices: &[i64], horizon: u64, into: &mut DualEvaluation) {
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
        into.endings.resize(self.networks.len(), Vec::new());
        let buffers = into.values.iter_mut().zip(&mut into.endings);
        for (network, (values, endings)) in self.networks.iter().zip(buffers) {
            network.longest_path(&rewards, values, endings);
            let nodes = network.nodes_up_to(horizon);
            into.value += values[nodes];
            let taken = &mut into.taken;
            network.follow(&rewards, endings, nodes, |item| {
                taken[item as usize] += 1;
            });
        }
    }

    fn price_sum(&self, prices: &[i64], horizon: u64) -> i64 {
        let counts = |slot: &Option<u64>| slot.is_some_and(|slot| slot <= horizon);
        let pairs = prices.iter().zip(&self.earliest);
        pairs.filter(|(_, slot)| counts(slot)).map(|(p, _)| p).sum()
    }

    /// The most that a schedule can earn, given a bound of `units`: picks come in whole
    /// numbers.
    pub(super) fn whole(&self, units: i64) -> i64 {
        match self.objective {
            BoundObjective::Picks => {
                let pick = self.units as i64;
                units.div_euclid(pick) * pick
            }
            BoundObjective::Weight => units,
        }
    }

    /// `units` as a weight, rounded up.
    pub(super) fn weight(&self, units: i64) -> f64 {
        let value = units as f64 / self.units;
        if (value * self.units) as i64 >= units {
            value
        } else {
            value.next_up()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Item, Pattern};
    use crate::station::{Station, built_in};

    fn station() -> Station {
        built_in("paper").unwrap().station(Some(2)).unwrap()
    }

    /// Items of these weights in the middle of the belt, within reach of both robots.
    fn weighing(weights: &[f64]) -> Pattern {
        let items = weights.iter().enumerate().map(|(i, &weight)| Item {
            weight: Some(weight),
            ..Item::at(i.to_string(), -0.3 * i as f64, 0.0)
        });
        Pattern::new(items.collect()).unwrap()
    }

    fn dual(pattern: &Pattern, objective: BoundObjective) -> Dual {
        let station = station();
        let scene = Scene::new(&station, pattern).unwrap();
        Dual::new(&scene, objective, Slots { length: 0.5 })
    }

    /// `value` in units, exactly, because units are a power of two.
    fn in_units(dual: &Dual, value: f64) -> f64 {
        assert_eq!(dual.units.log2().fract(), 0.0);
        value * dual.units
    }

    #[test]
    fn weights_are_rounded_up_to_the_next_unit() {
        let weights = [0.1, 1.0 / 3.0, 2.7, 0.0, 1e-13, 0.7];
        let dual = dual(&weighing(&weights), BoundObjective::Weight);
        assert_eq!(dual.units, 2f64.powi(40 - 2));
        for (&units, weight) in dual.weights.iter().zip(weights) {
            let exact = in_units(&dual, weight);
            assert!(
                exact <= units as f64 && units as f64 - 1.0 < exact,
                "{weight}"
            );
        }
    }

    #[test]
    fn the_largest_weight_says_how_large_a_unit_is() {
        for (most, exponent) in [(1.0, 0), (1.5, 1), (2.0, 1), (0.3, -1), (1e6, 20)] {
            let dual = dual(&weighing(&[0.1, most]), BoundObjective::Weight);
            assert_eq!(dual.units, 2f64.powi(40 - exponent), "{most}");
            assert_eq!(dual.most_negative, 16 << 40);
        }
        let nothing = dual(&weighing(&[0.0, 0.0]), BoundObjective::Weight);
        assert_eq!(
            (nothing.units, &nothing.weights[..]),
            (2f64.powi(40), &[0, 0][..])
        );
        let picks = dual(&weighing(&[0.0, 5.0]), BoundObjective::Picks);
        assert_eq!(
            (picks.units, &picks.weights[..]),
            (2f64.powi(40), &[1 << 40, 1 << 40][..])
        );
    }

    #[test]
    fn the_weights_of_many_items_have_fewer_digits() {
        for (items, expected) in [
            (1, 40),
            (2, 40),
            (1 << 15, 40),
            ((1 << 15) + 1, 39),
            (1 << 16, 39),
            (10_000_000, 31),
        ] {
            assert_eq!(digits(items), expected, "{items}");
            // No sum of weights, or of prices at their lowest, comes near the limits of the
            // number type.
            let all = (items as f64) * f64::from(expected).exp2();
            assert!(all <= 55f64.exp2() && (1 + LEAST_PRICE) as f64 * all < 60f64.exp2());
        }
    }

    /// The price of an item counts as soon as the item can have been released in the last slot.
    #[test]
    fn prices_count_up_to_the_horizon() {
        let dual = dual(&weighing(&[1.0, 1.0]), BoundObjective::Picks);
        let [Some(first), Some(second)] = dual.earliest[..] else {
            panic!("both are in reach");
        };
        assert!(first < second);
        let unit = dual.units as i64;
        let prices = [3 * unit, 4 * unit];
        let value = |horizon| {
            let mut evaluation = DualEvaluation::default();
            dual.evaluate(&prices, horizon, &mut evaluation);
            assert_eq!(evaluation.taken, [0, 0], "nothing is worth its price");
            evaluation.value / unit
        };
        assert_eq!(value(first - 1), 0);
        assert_eq!((value(first), value(second - 1)), (3, 3));
        assert_eq!((value(second), value(u64::MAX)), (7, 7));
    }

    /// Each robot may take what it can get by the horizon, with the price subtracted from the
    /// reward.
    #[test]
    fn every_robot_takes_what_it_can_by_the_horizon() {
        let dual = dual(&weighing(&[1.0]), BoundObjective::Picks);
        let unit = dual.units as i64;
        let first = dual.earliest[0].unwrap();
        let mut evaluation = DualEvaluation::default();
        let mut at = |price: i64, horizon: u64| {
            dual.evaluate(&[price], horizon, &mut evaluation);
            (evaluation.value, evaluation.taken[0])
        };
        assert_eq!(at(0, first - 1), (0, 0));
        assert_eq!(at(0, first), (unit, 1));
        assert_eq!(at(unit / 4, first), (unit, 1));
        // Two robots, each of which can take it more than once, because only the price prevents
        // that.
        let (value, taken) = at(unit / 4, u64::MAX);
        assert!(taken >= 2);
        assert_eq!(value, unit / 4 + i64::from(taken) * (unit - unit / 4));
    }

    #[test]
    fn picks_are_whole_and_weights_are_not() {
        let picks = dual(&weighing(&[1.0]), BoundObjective::Picks);
        let unit = picks.units as i64;
        for (units, whole) in [
            (0, 0),
            (unit - 1, 0),
            (unit, 1),
            (3 * unit - 1, 2),
            (-1, -1),
        ] {
            assert_eq!(picks.whole(units), whole * unit, "{units}");
        }
        let weight = dual(&weighing(&[1.0]), BoundObjective::Weight);
        assert_eq!(weight.whole(unit - 1), unit - 1);
    }

    /// The smallest double that is not lower.
    #[test]
    fn units_become_a_weight_that_is_rounded_up() {
        let dual = dual(&weighing(&[1.0]), BoundObjective::Weight);
        for units in [
            0,
            1,
            1 << 40,
            (1 << 53) + 1,
            (1 << 54) + 1,
            (1 << 54) + 2,
            (1 << 54) + 3,
            (1 << 54) + 6,
            (1 << 55) - 1,
            (1 << 60) + 129,
        ] {
            let exact = |weight: f64| in_units(&dual, weight) as i128;
            let weight = dual.weight(units);
            assert!(exact(weight) >= i128::from(units), "{units}");
            assert!(
                units == 0 || exact(weight.next_down()) < i128::from(units),
                "{units}"
            );
        }
    }
}
