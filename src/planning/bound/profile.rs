//! What can be earned by when: one set of prices gives a bound for every end of a run.
//!
//! The values of the longest paths up to a slot belong to schedules that end in it. So a single
//! pass over the networks bounds, for every T at once, what any schedule with its last release
//! by T earns: `B(T)`, the minimum over all prices tried. An item that leaves the belt after T
//! must have been picked by T; otherwise the run would end later. That gives the smallest T,
//! and `60 B(T) / T` bounds the rate of every run that ends at T.

use super::dual::{Dual, DualEvaluation, Schedules};
use super::network::{SlotNetwork, earliest_release, picks};
use crate::sim::Scene;

/// The smallest known B(T), a step function of T.
#[derive(Debug, Clone)]
pub(super) struct BoundProfile {
    /// Slots at which it may rise, in ascending order.
    slots: Vec<u64>,
    /// Starts of these slots [s], then infinity.
    begins: Vec<f64>,
    /// Its value from each slot to the next, in units.
    best: Vec<i64>,
    /// The same for schedules that pick everything.
    all: Vec<i64>,
    /// How many items of [`Self::by_release`] can have been released by the end of each slot.
    released: Vec<u32>,
    /// Reachable items, ordered by their earliest release.
    by_release: Vec<u32>,
    /// For each robot, the number of nodes up to each slot.
    nodes: Vec<Vec<u32>>,
}

impl BoundProfile {
    /// A profile that only knows that no item earns twice.
    pub(super) fn new(dual: &Dual) -> Self {
        let mut slots: Vec<u64> = Vec::new();
        for network in &dual.networks {
            slots.extend(network.slots());
        }
        slots.sort_unstable();
        slots.dedup();
        let mut by_release: Vec<(u64, u32)> = (0u32..)
            .zip(&dual.earliest)
            .filter_map(|(item, slot)| slot.map(|slot| (slot, item)))
            .collect();
        by_release.sort_unstable();
        let (mut worth, mut count) = (0, 0);
        let mut best = Vec::with_capacity(slots.len());
        let mut released = Vec::with_capacity(slots.len());
        for &slot in &slots {
            while let Some(&(_, item)) = by_release.get(count).filter(|(at, _)| *at <= slot) {
                worth += dual.weights[item as usize];
                count += 1;
            }
            best.push(worth);
            released.push(count as u32);
        }
        let places = |network: &SlotNetwork| {
            let place = |&slot| network.nodes_up_to(slot) as u32;
            slots.iter().map(place).collect()
        };
        Self {
            nodes: dual.networks.iter().map(places).collect(),
            by_release: by_release.into_iter().map(|(_, item)| item).collect(),
            begins: slots
                .iter()
                .map(|&slot| dual.slots.start(slot))
                .chain([f64::INFINITY])
                .collect(),
            slots,
            all: best.clone(),
            best,
            released,
        }
    }

    /// Lowers the profile by what `prices` give; `at` is their evaluation. Negative prices are
    /// valid only while their items must be picked because they have not left `belt` yet.
    pub(super) fn enter(&mut self, belt: &Leaving, prices: &[i64], at: &DualEvaluation) {
        let negative = prices.iter().position(|&price| price < 0);
        let until = negative.map_or(f64::INFINITY, |item| belt.leaves[item]);
        let (mut sum, mut counted) = (0, 0);
        for (place, (best, all)) in self.best.iter_mut().zip(&mut self.all).enumerate() {
            let released = self.released[place] as usize;
            for &item in &self.by_release[counted..released] {
                sum += prices[item as usize];
            }
            counted = released;
            let paths = self.nodes.iter().zip(&at.values);
            let paths: i64 = paths
                .map(|(nodes, values)| values[nodes[place] as usize])
                .sum();
            *all = (*all).min(sum + paths);
            if self.begins[place + 1] <= until {
                *best = (*best).min(sum + paths);
            }
        }
    }

    /// The schedules of step `step`; all their runs end before the next step.
    pub(super) fn schedules(&self, step: usize, belt: &Leaving) -> Schedules {
        Schedules {
            horizon: self.slots[step],
            must_from: belt
                .leaves
                .partition_point(|&leaves| leaves < self.begins[step + 1]),
        }
    }

    /// The schedules of step `step` that pick everything.
    pub(super) fn complete_schedules(&self, step: usize) -> Schedules {
        Schedules {
            horizon: self.slots[step],
            must_from: 0,
        }
    }

    /// Whether nothing can be released in any slot.
    pub(super) fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// B of step `step`, in units.
    pub(super) fn value(&self, step: usize) -> i64 {
        self.best[step]
    }

    /// Bounds on the ends of runs on `belt`.
    pub(super) fn ends(&self, dual: &Dual, belt: &Leaving) -> Ends {
        // Nothing is earned before the first release.
        let idle = belt.least_end(0);
        let mut found = Ends {
            end: (idle < self.begins[0]).then_some((idle, 0)),
            ..Ends::default()
        };
        let (best, all) = (rising(&self.best), rising(&self.all));
        for (step, (&value, &all)) in best.iter().zip(&all).enumerate() {
            let value = dual.whole(value);
            let begin = self.begins[step];
            let end = begin.max(belt.least_end(value));
            if end < self.begins[step + 1] {
                found.end.get_or_insert((end, step));
                let rate = 60.0 * dual.weight(value) / end;
                if found.rate.is_none_or(|(other, _)| rate > other) {
                    found.rate = Some((rate, step));
                }
            }
            if dual.whole(all) >= belt.total && found.all.is_none() {
                let end = begin.max(belt.last_release);
                found.all = end.is_finite().then_some((end, step));
            }
        }
        found
    }
}

/// The same bound, lowered where a later step is lower: a valid schedule by T is also valid by
/// any later time.
fn rising(bound: &[i64]) -> Vec<i64> {
    let mut bound = bound.to_vec();
    for step in (1..bound.len()).rev() {
        bound[step - 1] = bound[step - 1].min(bound[step]);
    }
    bound
}

/// Bounds on the end of a run, each with the step of the profile on which it depends.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ends {
    /// The earliest end of any run [s].
    pub end: Option<(f64, usize)>,
    /// The earliest end of a run that picks everything [s]; `None` if there is no such run.
    pub all: Option<(f64, usize)>,
    /// The highest rate [1/min].
    pub rate: Option<(f64, usize)>,
}

/// When items leave the belt and when they can be in a bin.
#[derive(Debug)]
pub(super) struct Leaving {
    /// When each item leaves the belt [s], in ascending order because patterns are sorted.
    leaves: Vec<f64>,
    /// Total weight of the items from each one on, in units; 0 at the end.
    worth_from: Vec<i64>,
    /// Total weight of all items, in units.
    total: i64,
    /// The earliest end of a run according to the items' earliest releases alone [s].
    least_end: f64,
    /// The latest of the items' earliest releases [s]; infinite if an item is unreachable.
    last_release: f64,
}

impl Leaving {
    /// The items of `scene`.
    pub(super) fn new(scene: &Scene, dual: &Dual) -> Self {
        let items = scene.pattern().len();
        let mut release = vec![f64::INFINITY; items];
        for robot in 0..dual.networks.len() {
            for (candidate, place) in picks(scene, robot) {
                let free = earliest_release(scene.station(), robot, (&candidate, place));
                let release = &mut release[candidate.item as usize];
                *release = release.min(free);
            }
        }
        let leaves: Vec<f64> = (0..items).map(|item| scene.leaves_belt(item)).collect();
        let mut worth_from = vec![0; items + 1];
        // Items that are left on purpose do not hold up the end of the run.
        for left in scene.left() {
            release[left.item as usize] = 0.0;
        }
        let mut left = scene
            .left()
            .iter()
            .rev()
            .map(|left| left.item as usize)
            .peekable();
        let (mut latest, mut least_end) = (0.0f64, f64::INFINITY);
        for item in (0..items).rev() {
            worth_from[item] = worth_from[item + 1] + dual.weights[item];
            if left.next_if_eq(&item).is_some() {
                continue;
            }
            // If this is the last item left, all items after it are picked.
            least_end = least_end.min(latest.max(leaves[item]));
            latest = latest.max(release[item]);
        }
        Self {
            leaves,
            total: worth_from[0],
            worth_from,
            least_end: least_end.min(latest),
            last_release: latest,
        }
    }

    /// The earliest end [s] of a run that earns at most `value` units: all items that are still
    /// on the belt at the end must be among those picked.
    fn least_end(&self, value: i64) -> f64 {
        // Negative prices can prove that no schedule has everything it must have.
        if value < 0 {
            return f64::INFINITY;
        }
        // The last item that may be left is the one before the first item from which all can be
        // earned.
        let first = self.worth_from.partition_point(|&worth| worth > value);
        let left = first.checked_sub(1).map_or(0.0, |item| self.leaves[item]);
        left.max(self.least_end)
    }
}

#[cfg(test)]
mod tests;
