//! The longest paths up to each node of a network, on which no item follows itself.

use super::best_two::{BestTwo, NONE, UNREACHED};
use super::{Arc, SlotNetwork};

impl SlotNetwork {
    /// Computes the best value of any path up to each node with `rewards` per item, into
    /// `values`: `values[i]` uses the first `i` nodes, so `values[0]` is 0. `endings` then has the
    /// paths of each node and place.
    pub(in super::super) fn longest_path(
        &self,
        rewards: &[i64],
        values: &mut Vec<i64>,
        endings: &mut Vec<BestTwo>,
    ) {
        values.clear();
        endings.clear();
        if self.places.is_some() {
            return self.longest_path_by_place(rewards, values, endings);
        }
        let mut here = BestTwo::free(0);
        values.push(0);
        endings.push(here);
        let mut loops = self.loops.iter().peekable();
        let mut begin = 0;
        for (node, &end) in self.first[1..].iter().enumerate() {
            for arc in &self.arcs[begin..end as usize] {
                let reward = rewards[arc.item as usize];
                // Hardly any path is among the best two, so the last item is rarely looked at.
                if values[arc.from as usize] + reward > here.other {
                    let before = &endings[arc.from as usize];
                    here.enter(before.beside(arc.item) + reward, arc.item);
                }
            }
            begin = end as usize;
            let mut gain = None;
            while let Some((_, item)) = loops.next_if(|(at, _)| *at as usize == node) {
                *gain.get_or_insert(0) += rewards[*item as usize].max(0);
            }
            if let Some(gain) = gain {
                here = BestTwo::free(here.best + gain);
            }
            values.push(here.best);
            endings.push(here);
        }
    }

    fn longest_path_by_place(
        &self,
        rewards: &[i64],
        values: &mut Vec<i64>,
        endings: &mut Vec<BestTwo>,
    ) {
        let Some(places) = &self.places else {
            return;
        };
        let count = places.count;
        endings.resize(count, BestTwo::NOWHERE);
        if places.anywhere {
            endings.fill(BestTwo::free(0));
        } else {
            endings[places.start] = BestTwo::free(0);
        }
        values.push(0);
        let mut loops = self.loops.iter().peekable();
        let mut begin = 0;
        for (node, &end) in self.first[1..].iter().enumerate() {
            let here = endings.len();
            endings.extend_from_within(here - count..);
            let arcs = begin..end as usize;
            for (arc, &from) in self.arcs[arcs.clone()].iter().zip(&places.from[arcs]) {
                let before = endings[arc.from as usize * count + usize::from(from)];
                let reward = rewards[arc.item as usize];
                let to = &mut endings[here + usize::from(places.bins[arc.item as usize])];
                if before.best + reward > to.other {
                    to.enter(before.beside(arc.item) + reward, arc.item);
                }
            }
            begin = end as usize;
            if places.anywhere {
                let mut all = BestTwo::NOWHERE;
                endings[here..].iter().for_each(|ending| all.join(ending));
                endings[here..].fill(all);
            }
            let mut gain = None;
            while let Some((_, item)) = loops.next_if(|(at, _)| *at as usize == node) {
                *gain.get_or_insert(0) += rewards[*item as usize].max(0);
            }
            let best = endings[here..].iter().map(|ending| ending.best);
            let mut best = best.fold(UNREACHED, i64::max);
            if let Some(gain) = gain {
                best += gain;
                endings[here..].fill(BestTwo::free(best));
            }
            values.push(best);
        }
    }

    /// Calls `visit` with the items on the longest path over the first `nodes` nodes; `endings` must
    /// come from [`Self::longest_path`] with the same `rewards`.
    pub(in super::super) fn follow(
        &self,
        rewards: &[i64],
        endings: &[BestTwo],
        nodes: usize,
        mut visit: impl FnMut(u32),
    ) {
        let count = self.places.as_ref().map_or(1, |places| places.count);
        let anywhere = self.places.as_ref().is_some_and(|places| places.anywhere);
        let begins_at = |arc: usize| match &self.places {
            Some(places) => usize::from(places.from[arc]),
            None => 0,
        };
        let ends_at = |item: u32| match &self.places {
            Some(places) => usize::from(places.bins[item as usize]),
            None => 0,
        };
        let value_of =
            |at: usize, place: usize, next: u32| endings[at * count + place].beside(next);
        let mut at = nodes;
        // The item that follows, which must not be the last one here.
        let mut next = NONE;
        let mut place = (0..count)
            .rev()
            .max_by_key(|&place| value_of(at, place, next))
            .unwrap_or(0);
        while at > 0 {
            let mut value = value_of(at, place, next);
            if value == value_of(at - 1, place, next) {
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
            // Before loops the robot may have been anywhere and picked anything.
            let looped = begin < end;
            if looped {
                next = NONE;
            }
            let may_be = |p: usize| looped || anywhere || p == place;
            let waited = (0..count).find(|&p| may_be(p) && value_of(node, p, next) == value);
            if let Some(before) = waited {
                (at, place) = (node, before);
                continue;
            }
            let arcs = self.first[node] as usize..self.first[at] as usize;
            let leads_here = |arc: &usize| {
                let Arc { item, from } = self.arcs[*arc];
                let before = value_of(from as usize, begins_at(*arc), item);
                item != next && may_be(ends_at(item)) && before + rewards[item as usize] == value
            };
            match arcs.into_iter().find(leads_here) {
                Some(arc) => {
                    next = self.arcs[arc].item;
                    visit(next);
                    at = self.arcs[arc].from as usize;
                    place = begins_at(arc);
                }
                // Impossible: the value came from one of them.
                None => at = node,
            }
        }
    }
}
