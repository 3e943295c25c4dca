//! What keeps an item from following itself on a path.
//!
//! Nothing else stops a path from picking an item again and again while its window is open. So a node has
//! not only the value of its best path but also that of the best one with another item next to the
//! node: the first goes on with every item but its own, the second with that one, as Christofides,
//! Mingozzi and Toth 1981 (DOI 10.1007/BF01589353) exclude cycles of two.

/// The value of a node that no path leads to, far from the limits of the number type.
pub(super) const UNREACHED: i64 = i64::MIN / 4;
/// No item.
pub(super) const NONE: u32 = u32::MAX;

/// The values of the best paths up to a node and a place, or from there on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in super::super) struct BestTwo {
    /// The value of the best one.
    pub(in super::super) best: i64,
    /// The value of the best one with another item next to the node.
    pub(super) other: i64,
    /// The item next to the node on the best one; none if every item may be picked on the other side.
    item: u32,
}

impl BestTwo {
    /// No path.
    pub(super) const NOWHERE: Self = Self {
        best: UNREACHED,
        other: UNREACHED,
        item: NONE,
    };

    /// A path of this value, on whose other side every item may be picked.
    pub(in super::super) fn free(value: i64) -> Self {
        Self {
            best: value,
            other: value,
            item: NONE,
        }
    }

    /// The value of the best path on whose other side `item` may be picked.
    pub(in super::super) fn beside(&self, item: u32) -> i64 {
        if self.item == item {
            self.other
        } else {
            self.best
        }
    }

    /// Adds a path of this value with `item` next to the node.
    pub(super) fn enter(&mut self, value: i64, item: u32) {
        if item == self.item {
            self.best = self.best.max(value);
        } else if value > self.best {
            self.other = self.best;
            self.best = value;
            self.item = item;
        } else {
            self.other = self.other.max(value);
        }
    }

    /// Adds all paths of `more`.
    pub(super) fn join(&mut self, more: &Self) {
        let (high, low) = if more.best > self.best {
            (*more, *self)
        } else {
            (*self, *more)
        };
        // The best paths of both have one item, or the lower one is another path with another item.
        let other = if low.item == high.item {
            low.other
        } else {
            low.best
        };
        *self = Self {
            other: high.other.max(other),
            ..high
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The best paths among `paths`, each with a value and an item, and a free path of value 0.
    fn of(paths: &[(i64, u32)]) -> BestTwo {
        let mut best = BestTwo::free(0);
        for (value, item) in paths {
            best.enter(*value, *item);
        }
        best
    }

    proptest! {
        /// For every item, the best path is found that has another item next to the node, whatever the
        /// order in which paths are added, one by one or joined.
        #[test]
        fn every_item_finds_its_best_path(
            paths in prop::collection::vec((-3..6i64, 0..4u32), 0..8),
            cut in 0..8usize,
        ) {
            let whole = of(&paths);
            let (first, second) = paths.split_at(cut.min(paths.len()));
            let mut joined = of(first);
            joined.join(&of(second));
            for item in 0..5 {
                let others = paths.iter().filter(|(_, other)| *other != item);
                let best = others.map(|(value, _)| *value).fold(0, i64::max);
                prop_assert_eq!(whole.beside(item), best);
                prop_assert_eq!(joined.beside(item), best);
            }
            let all = paths.iter().map(|(value, _)| *value).fold(0, i64::max);
            prop_assert_eq!((whole.best, joined.best), (all, all));
        }
    }
}
