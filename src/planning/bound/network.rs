//! One robot's day as a network over time slots.
//!
//! Slot `s` is the time from `s d` to `(s + 1) d`. Leaving within slot `s` for an item with
//! window `[open, close]` means leaving at `max(open, s d)` at the earliest. As
//! `C(t) = t + P(t)` increases strictly, the robot is free again at `C(max(open, s d))` at the
//! earliest; the arc leads to the slot of that time. So every schedule that the model allows is
//! a path: only arrival times are rounded, down to the beginning of their slots.

use crate::decision::{Candidate, Moment};
use crate::station::Station;
use std::ops::Range;

/// Departures and releases may be early by this much, relative to `1 + t`, and still be covered
/// by the relaxation: the times of a run are sums of rounded numbers, and the checker allows
/// the same tolerance.
const SLACK: f64 = 2e-9;

/// Maximum number of slots without an arrival that one item's nodes may span; it limits the
/// number of nodes per arc.
const GAP: u64 = 8;

/// Allowance for rounding at time `time` [s].
fn slack(time: f64) -> f64 {
    SLACK * (1.0 + time.abs())
}

/// Time slots of equal length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Slots {
    /// Length d [s].
    pub length: f64,
}

impl Slots {
    /// Start of slot `slot` [s].
    pub(super) fn start(self, slot: u64) -> f64 {
        slot as f64 * self.length
    }

    /// The last slot that begins at `time` [s] or before; 0 for times before 0.
    pub(super) fn of(self, time: f64) -> u64 {
        let mut slot = (time / self.length) as u64;
        // The quotient may be rounded across the boundary defined by the product.
        while slot > 0 && self.start(slot) > time {
            slot -= 1;
        }
        while self.start(slot + 1) <= time {
            slot += 1;
        }
        slot
    }
}

/// A pick that ends in the slot of the node that it leads to.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    /// The item's place in the pattern.
    pub item: u32,
    /// Number of nodes up to and including the slot of the departure: the index into
    /// [`SlotNetwork::longest_path`]'s values at which the arc starts.
    pub from: u32,
}

/// One robot's picks. The nodes are the slots in which it may become free; waiting leads from
/// each node to the next. Paths begin before the first node.
#[derive(Debug, Clone)]
pub(super) struct SlotNetwork {
    slots: Vec<u64>,
    /// Arcs into node `i` are `arcs[first[i]..first[i + 1]]`.
    first: Vec<u32>,
    arcs: Vec<Arc>,
    /// Largest number of places that an arc spans.
    longest_arc: usize,
    /// Picks that end in the slot in which they begin, by node. Any number of them fits into
    /// one slot, but each item only once.
    loops: Vec<(u32, u32)>,
}

/// A pick whose node is not yet known.
struct Raw {
    arrival: u64,
    departure: u64,
    item: u32,
}

/// The picks of robot `robot` in slots, item by item, and the spans of slots in which they arrive.
fn picks_in_slots(
    station: &Station,
    robot: usize,
    queue: &[Candidate],
    slots: Slots,
) -> (Vec<Raw>, Vec<(u64, u64)>) {
    let mut raw: Vec<Raw> = Vec::new();
    let mut spans: Vec<(u64, u64)> = Vec::with_capacity(queue.len());
    for candidate in queue {
        let (begin, first_span) = (raw.len(), spans.len());
        let open = (candidate.open - slack(candidate.open)).max(0.0);
        let last = slots.of(candidate.close + slack(candidate.close));
        for departure in slots.of(open)..=last {
            let time = slots.start(departure).max(open);
            let free = time + Moment::new(station, robot, time).processing_time(candidate);
            let arrival = slots.of((free - slack(free)).max(0.0)).max(departure);
            match raw[begin..].last_mut() {
                // Of several departures with the same arrival, the last is as good as any.
                Some(before) if before.arrival >= arrival => before.departure = departure,
                _ => raw.push(Raw {
                    arrival,
                    departure,
                    item: candidate.item,
                }),
            }
        }
        // If the arm is only slightly faster than the belt, arrivals are far apart.
        for pick in &raw[begin..] {
            match spans[first_span..].last_mut() {
                Some((_, last)) if pick.arrival <= *last + GAP => *last = pick.arrival,
                _ => spans.push((pick.arrival, pick.arrival)),
            }
        }
    }
    (raw, spans)
}

impl SlotNetwork {
    /// The picks of robot `robot` of `station`, which has the windows `queue`.
    pub(super) fn new(station: &Station, robot: usize, queue: &[Candidate], slots: Slots) -> Self {
        let (raw, spans) = picks_in_slots(station, robot, queue, slots);
        let nodes = Nodes::new(spans);
        let mut network = Self {
            slots: nodes.slots(),
            first: vec![0; nodes.count + 1],
            arcs: Vec::new(),
            longest_arc: 0,
            loops: Vec::new(),
        };
        // A counting sort by node keeps the order of the items within a node.
        let is_loop = |pick: &Raw| pick.departure == pick.arrival;
        for pick in raw.iter().filter(|pick| !is_loop(pick)) {
            network.first[nodes.up_to(pick.arrival)] += 1;
        }
        for node in 0..nodes.count {
            network.first[node + 1] += network.first[node];
        }
        let total = network.first[nodes.count] as usize;
        network.arcs = vec![Arc { item: 0, from: 0 }; total];
        let mut next = network.first.clone();
        for pick in &raw {
            let node = nodes.up_to(pick.arrival) - 1;
            if is_loop(pick) {
                network.loops.push((node as u32, pick.item));
                continue;
            }
            let from = nodes.up_to(pick.departure);
            network.longest_arc = network.longest_arc.max(node + 1 - from);
            network.arcs[next[node] as usize] = Arc {
                item: pick.item,
                from: from as u32,
            };
            next[node] += 1;
        }
        network.loops.sort_unstable();
        network
    }

    /// Upper bound on the number of arcs of a network.
    pub(super) fn size(queue: &[Candidate], slots: Slots) -> f64 {
        let arcs = |c: &Candidate| (c.close - c.open) / slots.length + 2.0;
        queue.iter().map(arcs).sum()
    }

    /// The slots of the nodes, in ascending order.
    pub(super) fn slots(&self) -> &[u64] {
        &self.slots
    }

    /// Number of arcs.
    pub(super) fn arcs(&self) -> usize {
        self.arcs.len() + self.loops.len()
    }

    /// Computes the best value of any path up to each node with `rewards` per item, into
    /// `values`: `values[i]` uses the first `i` nodes, so `values[0]` is 0.
    pub(super) fn longest_path(&self, rewards: &[i64], values: &mut Vec<i64>) {
        values.clear();
        values.push(0);
        let mut loops = self.loops.iter().peekable();
        let mut begin = 0;
        for (node, &end) in self.first[1..].iter().enumerate() {
            let mut best = values[node];
            for arc in &self.arcs[begin..end as usize] {
                let value = values[arc.from as usize] + rewards[arc.item as usize];
                best = best.max(value);
            }
            begin = end as usize;
            while let Some((_, item)) = loops.next_if(|(at, _)| *at as usize == node) {
                best += rewards[*item as usize].max(0);
            }
            values.push(best);
        }
    }

    /// Calls `visit` with the items on the longest path over the first `nodes` nodes; `values`
    /// must come from [`Self::longest_path`] with the same `rewards`.
    pub(super) fn follow(
        &self,
        rewards: &[i64],
        values: &[i64],
        nodes: usize,
        mut visit: impl FnMut(u32),
    ) {
        let mut at = nodes;
        let mut loops = self
            .loops
            .partition_point(|(node, _)| (*node as usize) < at);
        while at > 0 {
            if values[at] == values[at - 1] {
                at -= 1;
                continue;
            }
            let node = at - 1;
            let mut value = values[at];
            while loops > 0 && self.loops[loops - 1].0 as usize > node {
                loops -= 1;
            }
            while loops > 0 && self.loops[loops - 1].0 as usize == node {
                loops -= 1;
                let (_, item) = self.loops[loops];
                if rewards[item as usize] > 0 {
                    value -= rewards[item as usize];
                    visit(item);
                }
            }
            if value == values[node] {
                at = node;
                continue;
            }
            let arcs = &self.arcs[self.first[node] as usize..self.first[at] as usize];
            let leads_here =
                |arc: &&Arc| values[arc.from as usize] + rewards[arc.item as usize] == value;
            match arcs.iter().find(leads_here) {
                Some(arc) => {
                    visit(arc.item);
                    at = arc.from as usize;
                }
                // Impossible: the value came from one of them.
                None => at = node,
            }
        }
    }

    /// The best value of any path from each place of [`Self::longest_path`] on: what a robot
    /// that is free after the first `i` nodes can still get. Recomputes `values[places]` and
    /// assumes that later values are up to date.
    pub(super) fn longest_path_from(
        &self,
        rewards: &[i64],
        values: &mut [i64],
        places: Range<usize>,
    ) {
        values[places.clone()].fill(0);
        // An arc into a later node begins after `places`.
        let end = (places.end + self.longest_arc).min(self.slots.len());
        let begin = |node: u32| (node as usize) < end;
        let mut loops = self.loops.partition_point(|(node, _)| begin(*node));
        for node in (places.start..end).rev() {
            let mut here = values[node + 1];
            while loops > 0 && self.loops[loops - 1].0 as usize == node {
                loops -= 1;
                here += rewards[self.loops[loops].1 as usize].max(0);
            }
            if node < places.end {
                values[node] = values[node].max(here);
            }
            for arc in &self.arcs[self.first[node] as usize..self.first[node + 1] as usize] {
                let from = arc.from as usize;
                if places.contains(&from) {
                    values[from] = values[from].max(here + rewards[arc.item as usize]);
                }
            }
        }
    }

    /// For each of `items` items, one more than the last place from which a pick of it begins;
    /// 0 if there is none.
    pub(super) fn last_places(&self, items: usize) -> Vec<u32> {
        let mut last = vec![0; items];
        let loops = self.loops.iter().map(|(node, item)| (*item, *node));
        let arcs = self.arcs.iter().map(|arc| (arc.item, arc.from));
        for (item, place) in arcs.chain(loops) {
            let last = &mut last[item as usize];
            *last = (*last).max(place + 1);
        }
        last
    }

    /// The slot of the last node before `place`; 0 before the first node.
    pub(super) fn slot_of_place(&self, place: usize) -> u64 {
        place.checked_sub(1).map_or(0, |node| self.slots[node])
    }

    /// Number of nodes up to and including slot `slot`.
    pub(super) fn nodes_up_to(&self, slot: u64) -> usize {
        self.slots.partition_point(|&s| s <= slot)
    }
}

/// Runs of consecutive slots, numbered one after the other.
struct Nodes {
    /// First and last slot of each run, and the number of nodes before it.
    runs: Vec<(u64, u64, usize)>,
    count: usize,
}

impl Nodes {
    fn new(mut spans: Vec<(u64, u64)>) -> Self {
        spans.sort_unstable();
        let mut runs: Vec<(u64, u64, usize)> = Vec::new();
        for (first, last) in spans {
            match runs.last_mut() {
                Some(run) if first <= run.1 + 1 => run.1 = run.1.max(last),
                _ => runs.push((first, last, 0)),
            }
        }
        let mut count = 0;
        for run in &mut runs {
            run.2 = count;
            count += (run.1 - run.0 + 1) as usize;
        }
        Self { runs, count }
    }

    fn slots(&self) -> Vec<u64> {
        self.runs.iter().flat_map(|run| run.0..=run.1).collect()
    }

    /// Number of nodes up to and including slot `slot`.
    fn up_to(&self, slot: u64) -> usize {
        match self.runs.partition_point(|run| run.0 <= slot) {
            0 => 0,
            place => {
                let (first, last, before) = self.runs[place - 1];
                before + (slot.min(last) - first + 1) as usize
            }
        }
    }
}

/// The earliest time at which `robot` can have released `candidate` [s], with a tolerance for
/// rounding.
pub(super) fn earliest_release(station: &Station, robot: usize, candidate: &Candidate) -> f64 {
    let open = (candidate.open - slack(candidate.open)).max(0.0);
    let free = open + Moment::new(station, robot, open).processing_time(candidate);
    (free - slack(free)).max(0.0)
}

/// The approximate latest time at which `robot` can have released `candidate` [s].
pub(super) fn latest_release(station: &Station, robot: usize, candidate: &Candidate) -> f64 {
    candidate.close + Moment::new(station, robot, candidate.close).processing_time(candidate)
}

#[cfg(test)]
mod tests;
