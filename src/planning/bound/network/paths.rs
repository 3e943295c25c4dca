//! The longest paths of a network: up to each node, and from each node on.

use super::{Arc, ArcPlaces, SlotNetwork};
use std::ops::Range;

/// The value of a node that no path leads to, far from the limits of the number type.
const UNREACHED: i64 = i64::MIN / 4;

impl SlotNetwork {
    /// Computes the best value of any path up to each node with `rewards` per item, into
    /// `values`: `values[i]` uses the first `i` nodes, so `values[0]` is 0. For a robot with several
    /// places `by_place` then has the same for each place in which a path may end.
    pub(in super::super) fn longest_path(
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
    pub(in super::super) fn follow(
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
    pub(in super::super) fn longest_path_from(
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
}
