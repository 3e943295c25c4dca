//! What the cameras say of items: new ones, known ones, and two that turn out to be one.

use super::World;
use crate::items::{IdNews, ItemState, Redetection, Tracked};
use crate::robots::Fleet;
use crate::sight::PlacedDetection;

/// Positions that differ by less than this [m] are the same.
const SAME: f64 = 1e-4;
/// A picture that shows two items beside each other outweighs this many that show only one of them.
const CONFIRMED: i32 = 3;
/// Surplus of pictures with only one item after which the two are merged.
const MOST_OVERLOOKED: i32 = 3;
/// Lower limit of the surplus, so that an item that was often seen can still be merged eventually.
const LEAST_OVERLOOKED: i32 = -30;

impl World {
    /// Adds an item that is seen for the first time.
    pub(crate) fn add(
        &mut self,
        sight: &PlacedDetection,
        barred: bool,
        now: f64,
        fleet: &mut Fleet,
    ) -> u32 {
        let item = self.items.add(sight);
        self.weigh(item);
        if barred && let Some(tracked) = self.items.get_mut(item) {
            tracked.barred = true;
        }
        self.open_windows(item, now, fleet);
        item
    }

    /// Handles a detection of a known item. A detection older than what is known does not move it.
    pub(crate) fn see_again(
        &mut self,
        item: u32,
        sight: &PlacedDetection,
        now: f64,
        fleet: &mut Fleet,
    ) -> Option<Redetection> {
        let tracked = self.items.get(item)?;
        let is_late = sight.time < tracked.measured;
        let is_newer = tracked
            .seen_at(sight.source())
            .is_none_or(|at| sight.time >= at);
        let moved = sight.way(tracked.place, tracked.y);
        let moved = if is_late || moved <= SAME { 0.0 } else { moved };
        if !is_late {
            self.items.measure(item, sight.time, sight.covariance);
        }
        if moved > 0.0 {
            self.items.place(item, sight.place, sight.y);
        }
        let (news, weighs) = self.hear_more(item, sight, is_newer);
        if weighs || moved > 0.0 {
            self.open_windows(item, now, fleet);
        }
        Some(Redetection {
            is_late,
            moved,
            news,
        })
    }

    /// A picture shows an item twice: features of the second detection count if the first lacks
    /// them.
    pub(crate) fn see_double(
        &mut self,
        item: u32,
        sight: &PlacedDetection,
        now: f64,
        fleet: &mut Fleet,
    ) {
        let (_, weighs) = self.hear_more(item, sight, false);
        if weighs {
            self.open_windows(item, now, fleet);
        }
    }

    /// Adopts the features of an item from a detection. Returns what is new about its id, and
    /// whether its windows have changed.
    fn hear_more(&mut self, item: u32, sight: &PlacedDetection, is_newer: bool) -> (IdNews, bool) {
        let news = self.items.sight(item, sight, is_newer);
        let Some(tracked) = self.items.get_mut(item) else {
            return (news, false);
        };
        let class = tracked.features.class.clone();
        let least = self.min_detection;
        let was_uncertain = tracked.features.is_too_uncertain(least);
        tracked.features.take(sight.features.clone(), is_newer);
        let another_class = class != tracked.features.class;
        let is_uncertain = tracked.features.is_too_uncertain(least);
        let weighs = self.weigh(item) || is_uncertain != was_uncertain;
        // The class may decide which robots can take it, and into which bin.
        (news, weighs || (another_class && !self.nominal.is_plain()))
    }

    /// Computes the weight of an item from its features and its class; returns whether it has
    /// changed.
    fn weigh(&mut self, item: u32) -> bool {
        let Some(tracked) = self.items.get_mut(item) else {
            return false;
        };
        let weight = tracked.features.weight_on(&self.nominal);
        std::mem::replace(&mut tracked.weight, weight) != weight
    }

    /// Notes that a picture has shown an item beside others.
    pub(crate) fn confirm(&mut self, item: u32) {
        let before = self
            .items
            .get(item)
            .map_or(LEAST_OVERLOOKED, |t| t.overlooked);
        if before > LEAST_OVERLOOKED
            && let Some(tracked) = self.items.get_mut(item)
        {
            tracked.overlooked = (before - CONFIRMED).max(LEAST_OVERLOOKED);
        }
    }

    /// Notes that a picture of `source` has shown `other` and not `item`, although they are so near
    /// that they may be one. After enough such pictures the two are merged, which is returned. The
    /// younger one is forgotten, but an item to which a robot was ever sent stays.
    pub(crate) fn overlook(
        &mut self,
        item: u32,
        other: u32,
        source: Option<&str>,
        now: f64,
        fleet: &mut Fleet,
    ) -> bool {
        let (Some(tracked), Some(shown)) = (self.items.get(item), self.items.get(other)) else {
            return false;
        };
        let is_untouched = |t: &Tracked| t.state == ItemState::Free && t.tasks.is_empty();
        if tracked.seen_at(source).is_none() || !is_untouched(tracked) {
            return false;
        }
        if tracked.overlooked < MOST_OVERLOOKED {
            if let Some(tracked) = self.items.get_mut(item) {
                tracked.overlooked += 1;
            }
            return false;
        }
        let is_younger = other > item && is_untouched(shown);
        let (gone, stays) = if is_younger {
            (other, item)
        } else {
            (item, other)
        };
        self.close_windows(gone);
        self.items.fuse(gone, stays);
        self.open_windows(stays, now, fleet);
        true
    }
}
