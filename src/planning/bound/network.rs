//! One robot's day as a network over time slots.
//!
//! Slot `s` is the time from `s d` to `(s + 1) d`. Leaving within slot `s` for an item with
//! window `[open, close]` means leaving at `max(open, s d)` at the earliest. As
//! `C(t) = t + P(t)` increases strictly, the robot is free again at `C(max(open, s d))` at the
//! earliest; the arc leads to the slot of that time. So every schedule that the model allows is
//! a path: only arrival times are rounded, down to the beginning of their slots.
//!
//! For a robot that leaves from several places a node is a slot and a place: an arc leads from the
//! place where the pick begins to its bin, and waiting from each slot to the next at the same place.
//! Picks that begin and end in one slot are relaxed: after them the robot may be anywhere. Where picks can
//! fail, it may be anywhere at any time: a failed attempt takes the arm to another bin and leaves the item.

pub(super) mod best_two;
mod paths;
mod to_come;

use crate::decision::{Candidate, Moment};
use crate::sim::Scene;
use crate::station::{Robot, Station};

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
    /// Where the picks begin and end, for a robot with several places.
    places: Option<ArcPlaces>,
}

/// The places of the arcs of a network.
#[derive(Debug, Clone)]
struct ArcPlaces {
    /// Number of places.
    count: usize,
    /// Where the robot is at the beginning.
    start: usize,
    /// Whether waiting may take it to any other place.
    anywhere: bool,
    /// For each arc, where it begins.
    from: Vec<u16>,
    /// For each item, the bin where its picks end.
    bins: Vec<u16>,
}

/// A pick whose node is not yet known.
struct Raw {
    arrival: u64,
    departure: u64,
    item: u32,
    place: u16,
}

/// Picks in slots.
struct RawPicks {
    /// The picks, item by item.
    raw: Vec<Raw>,
    /// The spans of slots in which they arrive.
    spans: Vec<(u64, u64)>,
    /// The bin of each item.
    bins: Vec<(u32, u16)>,
}

/// The picks of robot `robot` in slots.
fn picks_in_slots(
    station: &Station,
    robot: usize,
    picks: impl Iterator<Item = (Candidate, usize)>,
    slots: Slots,
) -> RawPicks {
    let mut raw: Vec<Raw> = Vec::new();
    let mut spans: Vec<(u64, u64)> = Vec::new();
    let mut bins: Vec<(u32, u16)> = Vec::new();
    for (candidate, place) in picks {
        bins.push((candidate.item, candidate.bin));
        let (begin, first_span) = (raw.len(), spans.len());
        let open = (candidate.open - slack(candidate.open)).max(0.0);
        let last = slots.of(candidate.close + slack(candidate.close));
        for departure in slots.of(open)..=last {
            let time = slots.start(departure).max(open);
            let moment = Moment::new(station, robot, place, time);
            let free = time + moment.processing_time(&candidate);
            let arrival = slots.of((free - slack(free)).max(0.0)).max(departure);
            match raw[begin..].last_mut() {
                // Of several departures with the same arrival, the last is as good as any.
                Some(before) if before.arrival >= arrival => before.departure = departure,
                _ => raw.push(Raw {
                    arrival,
                    departure,
                    item: candidate.item,
                    // A robot has at most 100 bins and its rest.
                    place: place as u16,
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
    RawPicks { raw, spans, bins }
}

impl SlotNetwork {
    /// The picks of robot `robot` of `station`, with their windows and the places from which they
    /// begin.
    pub(super) fn new(
        station: &Station,
        robot: usize,
        picks: impl Iterator<Item = (Candidate, usize)>,
        slots: Slots,
    ) -> Self {
        let RawPicks { raw, spans, bins } = picks_in_slots(station, robot, picks, slots);
        let nodes = Nodes::new(spans);
        let mut network = Self {
            slots: nodes.slots(),
            first: vec![0; nodes.count + 1],
            arcs: Vec::new(),
            longest_arc: 0,
            loops: Vec::new(),
            places: ArcPlaces::of(&station.robots()[robot], &bins),
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
        if let Some(places) = &mut network.places {
            places.from = vec![0; total];
        }
        let mut next = network.first.clone();
        for pick in &raw {
            let node = nodes.up_to(pick.arrival) - 1;
            if is_loop(pick) {
                network.loops.push((node as u32, pick.item));
                continue;
            }
            let from = nodes.up_to(pick.departure);
            network.longest_arc = network.longest_arc.max(node + 1 - from);
            let arc = next[node] as usize;
            network.arcs[arc] = Arc {
                item: pick.item,
                from: from as u32,
            };
            if let Some(places) = &mut network.places {
                places.from[arc] = pick.place;
            }
            next[node] += 1;
        }
        network.loops.sort_unstable();
        network.loops.dedup();
        network
    }

    /// The same for picks that may fail: attempts that did are left out, and take the arm where they did.
    pub(super) fn with_failures(mut self) -> Self {
        if let Some(places) = &mut self.places {
            places.anywhere = true;
        }
        self
    }

    /// Upper bound on the number of arcs of a network.
    pub(super) fn size(picks: impl Iterator<Item = (Candidate, usize)>, slots: Slots) -> f64 {
        let arcs = |(c, _): (Candidate, usize)| (c.close - c.open) / slots.length + 2.0;
        picks.map(arcs).sum()
    }

    /// The slots of the nodes, in ascending order.
    pub(super) fn slots(&self) -> &[u64] {
        &self.slots
    }

    /// Number of arcs.
    pub(super) fn arcs(&self) -> usize {
        self.arcs.len() + self.loops.len()
    }

    /// Number of values that [`Self::longest_path_from`] fills.
    pub(super) fn positions(&self) -> usize {
        self.position(self.slots.len() + 1, 0)
    }

    /// Where [`Self::longest_path_from`] has the value of a robot that is free after the first
    /// `nodes` nodes, at place `place`.
    pub(super) fn position(&self, nodes: usize, place: u16) -> usize {
        match &self.places {
            None => nodes,
            Some(places) => nodes * places.count + usize::from(place),
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

impl ArcPlaces {
    /// For a robot with several places; `bins` has the bin of each item with a window.
    fn of(robot: &Robot, bins: &[(u32, u16)]) -> Option<Self> {
        let count = robot.places();
        let items = bins.iter().map(|(item, _)| *item as usize + 1).max();
        let mut of_items = vec![0; items.unwrap_or(0)];
        for (item, bin) in bins {
            of_items[*item as usize] = *bin;
        }
        (count > 1).then(|| Self {
            count,
            start: robot.start(),
            anywhere: false,
            from: Vec::new(),
            bins: of_items,
        })
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

/// Each item that robot `robot` has a window for, with each place from which it has one; the
/// candidate has the window from there.
pub(super) fn picks(scene: &Scene, robot: usize) -> impl Iterator<Item = (Candidate, usize)> {
    let places = scene.station().robots()[robot].places();
    scene.queue(robot).iter().flat_map(move |candidate| {
        (0..places).filter_map(move |place| {
            let (open, close) = scene.window(robot, candidate, place)?;
            let candidate = Candidate {
                open,
                close,
                ..*candidate
            };
            Some((candidate, place))
        })
    })
}

/// The earliest time at which `robot` can have released `candidate` when it leaves from `place` [s],
/// with a tolerance for rounding.
pub(super) fn earliest_release(
    station: &Station,
    robot: usize,
    (candidate, place): (&Candidate, usize),
) -> f64 {
    let open = (candidate.open - slack(candidate.open)).max(0.0);
    let free = open + Moment::new(station, robot, place, open).processing_time(candidate);
    (free - slack(free)).max(0.0)
}

/// The approximate latest time at which `robot` can have released `candidate` when it leaves from
/// `place` [s].
pub(super) fn latest_release(
    station: &Station,
    robot: usize,
    (candidate, place): (&Candidate, usize),
) -> f64 {
    let moment = Moment::new(station, robot, place, candidate.close);
    candidate.close + moment.processing_time(candidate)
}

#[cfg(test)]
mod tests;
