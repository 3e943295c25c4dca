//! The longest paths from each node of a network on, on which no item follows itself.

use super::best_two::BestTwo;
use super::{Arc, ArcPlaces, SlotNetwork};
use std::ops::Range;

impl SlotNetwork {
    /// The best value of any path from each position of [`Self::longest_path`] on: what a robot
    /// that is free after the first `i` nodes can still get, in `values[i]`; for a robot with several
    /// places, at [`Self::position`] of each. Recomputes the positions of `places` and assumes that
    /// later values are up to date.
    pub(in super::super) fn longest_path_from(
        &self,
        rewards: &[i64],
        values: &mut [BestTwo],
        places: Range<usize>,
    ) {
        if let Some(own) = &self.places {
            return self.longest_path_from_places(own, rewards, values, places);
        }
        values[places.clone()].fill(BestTwo::free(0));
        // An arc into a later node begins after `places`.
        let end = (places.end + self.longest_arc).min(self.slots.len());
        let begin = |node: u32| (node as usize) < end;
        let mut loops = self.loops.partition_point(|(node, _)| begin(*node));
        for node in (places.start..end).rev() {
            let mut here = values[node + 1];
            while loops > 0 && self.loops[loops - 1].0 as usize == node {
                loops -= 1;
                // After loops the first item is not known.
                here = BestTwo::free(here.best + rewards[self.loops[loops].1 as usize].max(0));
            }
            if node < places.end {
                values[node].join(&here);
            }
            for arc in &self.arcs[self.first[node] as usize..self.first[node + 1] as usize] {
                let from = arc.from as usize;
                if places.contains(&from) {
                    values[from]
                        .enter(here.beside(arc.item) + rewards[arc.item as usize], arc.item);
                }
            }
        }
    }

    fn longest_path_from_places(
        &self,
        own: &ArcPlaces,
        rewards: &[i64],
        values: &mut [BestTwo],
        span: Range<usize>,
    ) {
        let count = own.count;
        values[span.start * count..span.end * count].fill(BestTwo::free(0));
        // An arc into a later node begins after `span`.
        let end = (span.end + self.longest_arc).min(self.slots.len());
        let begin = |node: u32| (node as usize) < end;
        let mut loops = self.loops.partition_point(|(node, _)| begin(*node));
        let mut here = vec![BestTwo::free(0); count];
        for node in (span.start..end).rev() {
            here.copy_from_slice(&values[(node + 1) * count..(node + 2) * count]);
            let mut gain = None;
            while loops > 0 && self.loops[loops - 1].0 as usize == node {
                loops -= 1;
                *gain.get_or_insert(0) += rewards[self.loops[loops].1 as usize].max(0);
            }
            if let Some(gain) = gain {
                let best = here.iter().map(|from| from.best).fold(0, i64::max);
                here.fill(BestTwo::free(best + gain));
            }
            if node < span.end {
                for (value, here) in values[node * count..].iter_mut().zip(&here) {
                    value.join(here);
                }
            }
            for arc in self.first[node] as usize..self.first[node + 1] as usize {
                let Arc { item, from } = self.arcs[arc];
                if span.contains(&(from as usize)) {
                    let to = here[usize::from(own.bins[item as usize])];
                    let value = &mut values[from as usize * count + usize::from(own.from[arc])];
                    value.enter(to.beside(item) + rewards[item as usize], item);
                }
            }
        }
    }
}
