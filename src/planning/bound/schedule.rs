//! A schedule to compare with the bound: what the prices tell each robot to do.

use super::dual::Dual;
use super::network::best_two::BestTwo;
use crate::decision::{Action, Outcome, Snapshot, Strategy};
use crate::error::Result;
use crate::sim::{Scene, simulate};

/// Value of a claimed item: lower than any path can compensate, and far enough from the limits
/// of the number type for additions.
const CLAIMED: i64 = i64::MIN / 4;

/// Chooses, among all candidates and waiting for the next slot, the option with the highest sum
/// of rewards until the end of the robot's day, over the items that nobody has claimed.
struct PriceStrategy<'a> {
    dual: &'a Dual,
    rewards: Vec<i64>,
    /// For each robot, what it can still get from each place of its network on.
    to_come: Vec<Vec<BestTwo>>,
    /// For each robot, the place up to which `to_come` is out of date.
    stale: Vec<usize>,
    /// For each robot and item, the last place from which a pick of the item begins.
    last_place: Vec<Vec<u32>>,
}

impl PriceStrategy<'_> {
    fn claim(&mut self, item: usize) {
        self.rewards[item] = CLAIMED;
        for (stale, last) in self.stale.iter_mut().zip(&self.last_place) {
            *stale = (*stale).max(last[item] as usize);
        }
    }
}

impl Strategy for PriceStrategy<'_> {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        let robot = snapshot.robot;
        let network = &self.dual.networks[robot];
        let slots = self.dual.slots;
        let now = network.nodes_up_to(slots.of(snapshot.time));
        let to_come = &mut self.to_come[robot];
        let stale = std::mem::take(&mut self.stale[robot]);
        if now < stale {
            network.longest_path_from(&self.rewards, to_come, now..stale);
        }
        let next = slots.of(snapshot.time) + 1;
        let here = snapshot.places[robot];
        let after = |slot: u64, place: u16| network.position(network.nodes_up_to(slot), place);
        let mut best = to_come[after(next, here)].best;
        let mut choice = None;
        let moment = snapshot.moment();
        for (place, candidate) in snapshot.candidates.iter().enumerate() {
            let free = slots.of(snapshot.time + moment.processing_time(candidate));
            let later = &to_come[after(free, candidate.bin)];
            let value = self.rewards[candidate.item as usize] + later.beside(candidate.item);
            // Rather now than later; among several items, the one furthest downstream.
            if value > best || (value == best && choice.is_none()) {
                best = value;
                choice = Some((place, candidate.item as usize));
            }
        }
        match choice {
            Some((place, item)) => {
                self.claim(item);
                Action::Pick(place)
            }
            None => {
                // Until the last slot from which the same value can still be reached.
                let first = network.nodes_up_to(next);
                let all = network.slots().len() + 1;
                // What is to come never increases with time.
                let same = partition(all - first, |later| {
                    to_come[network.position(first + later, here)].best == best
                });
                let slot = network.slot_of_place(first + same - 1);
                Action::WaitUntil(slots.start(slot.max(next)))
            }
        }
    }

    fn name(&self) -> String {
        "prices".into()
    }

    fn needs_view(&self) -> bool {
        false
    }
}

/// How many of `0..count` satisfy `holds`, which only the first ones do.
fn partition(count: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count);
    while low < high {
        let middle = usize::midpoint(low, high);
        if holds(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// What the line does if every robot follows `share` of `prices`. At the full prices nothing is
/// worth more than anything else; slightly lower prices make items worth picking.
///
/// # Errors
/// Never, because it acts legally; a `Result` avoids a panic.
pub(super) fn schedule(scene: &Scene, dual: &Dual, prices: &[i64], share: f64) -> Result<Outcome> {
    let rewards: Vec<i64> = dual
        .weights
        .iter()
        .zip(prices)
        .map(|(weight, price)| weight - (*price as f64 * share) as i64)
        .collect();
    let mut to_come = Vec::with_capacity(dual.networks.len());
    for network in &dual.networks {
        let places = network.slots().len() + 1;
        let mut values = vec![BestTwo::free(0); network.positions()];
        network.longest_path_from(&rewards, &mut values, 0..places);
        to_come.push(values);
    }
    let items = rewards.len();
    let mut strategy = PriceStrategy {
        dual,
        rewards,
        to_come,
        stale: vec![0; dual.networks.len()],
        last_place: dual.networks.iter().map(|n| n.last_places(items)).collect(),
    };
    simulate(scene, &mut strategy)
}
