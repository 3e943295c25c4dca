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
//! Picks that begin and end in one slot are relaxed: after them the robot may be anywhere.

use crate::decision::{Candidate, Moment};
use crate::sim::Scene;
use crate::station::{Robot, Station};
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
    /// For each arc, where it begins.
    from: Vec<u16>,
    /// For each item, the bin where its picks end.
    bins: Vec<u16>,
}

/// The value of a node that no path leads to, far from the limits of the number type.
const UNREACHED: i64 = i64::MIN / 4;

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

    /// Computes the best value of any path up to each node with `rewards` per item, into
    /// `values`: `values[i]` uses the first `i` nodes, so `values[0]` is 0. For a robot with several
    /// places `by_place` then has the same for each place in which a path may end.
    pub(super) fn longest_path(
        &self,
        rewards: &[i64],
        values: &mut Vec<i64>,
        by_place: &mut Vec<i64>,
    ) {
        if let Some(places) = &self.places {
            return self.longest_path_by_place(places, rewards, values, by_place);
        }
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

    fn longest_path_by_place(
        &self,
        places: &ArcPlaces,
        rewards: &[i64],
        values: &mut Vec<i64>,
        by_place: &mut Vec<i64>,
    ) {
        let count = places.count;
        by_place.clear();
        by_place.resize(count, UNREACHED);
        by_place[places.start] = 0;
        values.clear();
        values.push(0);
        let mut loops = self.loops.iter().peekable();
        let mut begin = 0;
        for (node, &end) in self.first[1..].iter().enumerate() {
            let here = by_place.len();
            by_place.extend_from_within(here - count..);
            let arcs = begin..end as usize;
            for (arc, &from) in self.arcs[arcs.clone()].iter().zip(&places.from[arcs]) {
                let before = by_place[arc.from as usize * count + usize::from(from)];
                let value = before + rewards[arc.item as usize];
                let to = here + usize::from(places.bins[arc.item as usize]);
                by_place[to] = by_place[to].max(value);
            }
            begin = end as usize;
            let mut gain = None;
            while let Some((_, item)) = loops.next_if(|(at, _)| *at as usize == node) {
                *gain.get_or_insert(0) += rewards[*item as usize].max(0);
            }
            let mut best = by_place[here..].iter().copied().fold(UNREACHED, i64::max);
            if let Some(gain) = gain {
                best += gain;
                by_place[here..].fill(best);
            }
            values.push(best);
        }
    }

    /// Calls `visit` with the items on the longest path over the first `nodes` nodes; `values` and
    /// `by_place` must come from [`Self::longest_path`] with the same `rewards`.
    pub(super) fn follow(
        &self,
        rewards: &[i64],
        (values, by_place): (&[i64], &[i64]),
        nodes: usize,
        mut visit: impl FnMut(u32),
    ) {
        if let Some(places) = &self.places {
            return self.follow_by_place(places, rewards, by_place, nodes, visit);
        }
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

    fn follow_by_place(
        &self,
        places: &ArcPlaces,
        rewards: &[i64],
        by_place: &[i64],
        nodes: usize,
        mut visit: impl FnMut(u32),
    ) {
        let count = places.count;
        let value_of = |at: usize, place: usize| by_place[at * count + place];
        let mut at = nodes;
        let mut place = (0..count)
            .rev()
            .max_by_key(|&p| value_of(at, p))
            .unwrap_or(0);
        while at > 0 {
            let mut value = value_of(at, place);
            if value == value_of(at - 1, place) {
                at -= 1;
                continue;
            }
            let node = at - 1;
            let begin = self.loops.partition_point(|(n, _)| (*n as usize) < node);
            let end = self.loops.partition_point(|(n, _)| (*n as usize) <= node);
            for (_, item) in &self.loops[begin..end] {
                let reward = rewards[*item as usize];
                if reward > 0 {
                    value -= reward;
                    visit(*item);
                }
            }
            // Before loops the robot may have been anywhere.
            let may_be = |p: usize| begin < end || p == place;
            let waited = (0..count).find(|&p| may_be(p) && value_of(node, p) == value);
            if let Some(before) = waited {
                (at, place) = (node, before);
                continue;
            }
            let arcs = self.first[node] as usize..self.first[at] as usize;
            let leads_here = |arc: &usize| {
                let Arc { item, from } = self.arcs[*arc];
                let before = value_of(from as usize, usize::from(places.from[*arc]));
                may_be(usize::from(places.bins[item as usize]))
                    && before + rewards[item as usize] == value
            };
            match arcs.into_iter().find(leads_here) {
                Some(arc) => {
                    visit(self.arcs[arc].item);
                    at = self.arcs[arc].from as usize;
                    place = usize::from(places.from[arc]);
                }
                // Impossible: the value came from one of them.
                None => at = node,
            }
        }
    }

    /// The best value of any path from each position of [`Self::longest_path`] on: what a robot
    /// that is free after the first `i` nodes can still get, in `values[i]`; for a robot with several
    /// places, at [`Self::position`] of each. Recomputes the positions of `places` and assumes that
    /// later values are up to date.
    pub(super) fn longest_path_from(
        &self,
        rewards: &[i64],
        values: &mut [i64],
        places: Range<usize>,
    ) {
        if let Some(own) = &self.places {
            return self.longest_path_from_places(own, rewards, values, places);
        }
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

    fn longest_path_from_places(
        &self,
        own: &ArcPlaces,
        rewards: &[i64],
        values: &mut [i64],
        span: Range<usize>,
    ) {
        let count = own.count;
        values[span.start * count..span.end * count].fill(0);
        // An arc into a later node begins after `span`.
        let end = (span.end + self.longest_arc).min(self.slots.len());
        let begin = |node: u32| (node as usize) < end;
        let mut loops = self.loops.partition_point(|(node, _)| begin(*node));
        let mut here = vec![0; count];
        for node in (span.start..end).rev() {
            here.copy_from_slice(&values[(node + 1) * count..(node + 2) * count]);
            let mut gain = None;
            while loops > 0 && self.loops[loops - 1].0 as usize == node {
                loops -= 1;
                *gain.get_or_insert(0) += rewards[self.loops[loops].1 as usize].max(0);
            }
            if let Some(gain) = gain {
                let best = here.iter().copied().fold(0, i64::max) + gain;
                here.fill(best);
            }
            if node < span.end {
                for (value, here) in values[node * count..].iter_mut().zip(&here) {
                    *value = (*value).max(*here);
                }
            }
            for arc in self.first[node] as usize..self.first[node + 1] as usize {
                let Arc { item, from } = self.arcs[arc];
                if span.contains(&(from as usize)) {
                    let to = here[usize::from(own.bins[item as usize])];
                    let value = &mut values[from as usize * count + usize::from(own.from[arc])];
                    *value = (*value).max(to + rewards[item as usize]);
                }
            }
        }
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
