//! The known items, from their first detection until they have left the belt.

mod ids;
mod tracked;

use super::association::{Covariance, largest_variance};
use super::sight::PlacedDetection;
use super::windows::TimeKey;
use ids::ItemIds;
use std::collections::{BTreeMap, BTreeSet};

pub(crate) use ids::{IdNews, Numbers};
pub(crate) use tracked::{ItemState, Tracked};

/// What has changed about an item that was seen again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Redetection {
    /// Whether the detection is older than what is known.
    pub is_late: bool,
    /// How far it has moved on the belt [m].
    pub moved: f64,
    /// What is new about its id.
    pub news: IdNews,
}

/// All known items.
#[derive(Debug, Clone, Default)]
pub(crate) struct Items {
    table: BTreeMap<u32, Tracked>,
    ids: ItemIds,
    /// The largest variance of a position so far [m^2].
    widest: f64,
    by_place: BTreeSet<TimeKey>,
    /// The items changed since the last [`Items::take_changed`]; none while changes are not
    /// tracked.
    changed: Option<BTreeSet<u32>>,
}

impl Items {
    /// Restores the items from a table.
    pub(crate) fn restore(table: BTreeMap<u32, Tracked>, numbers: Numbers) -> Self {
        let mut items = Self {
            ids: ItemIds::restore(&table, numbers),
            ..Self::default()
        };
        for (item, tracked) in &table {
            items.by_place.insert(TimeKey(tracked.place, *item));
            let variance = largest_variance(tracked.covariance);
            items.widest = items.widest.max(variance);
        }
        items.table = table;
        items
    }

    /// The names and numbers already used.
    pub(crate) fn numbers(&self) -> Numbers {
        self.ids.numbers()
    }

    /// Tracks changes from now on.
    pub(crate) fn watch(&mut self) {
        self.changed = Some(BTreeSet::new());
    }

    /// Takes the items changed since the last call, with their present values; none for those that
    /// are forgotten.
    pub(crate) fn take_changed(&mut self) -> Vec<(u32, Option<Tracked>)> {
        let changed = self.changed.as_mut().map(std::mem::take);
        let changed = changed.into_iter().flatten();
        changed
            .map(|item| (item, self.table.get(&item).cloned()))
            .collect()
    }

    fn note_change(&mut self, item: u32) {
        if let Some(changed) = &mut self.changed {
            changed.insert(item);
        }
    }

    /// Number of known items.
    pub(crate) fn len(&self) -> usize {
        self.table.len()
    }

    /// The item with this number.
    pub(crate) fn get(&self, item: u32) -> Option<&Tracked> {
        self.table.get(&item)
    }

    /// The item with this number, to be changed. Use [`Items::place`] to change its place.
    pub(crate) fn get_mut(&mut self, item: u32) -> Option<&mut Tracked> {
        self.note_change(item);
        self.table.get_mut(&item)
    }

    /// All items by number.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, &Tracked)> {
        self.table.iter().map(|(item, tracked)| (*item, tracked))
    }

    /// The largest variance of any position so far [m^2].
    pub(crate) fn widest(&self) -> f64 {
        self.widest
    }

    /// The items within `reach` [m] of a place along the belt, upstream first.
    pub(crate) fn around(&self, place: f64, reach: f64) -> impl Iterator<Item = (u32, &Tracked)> {
        let range = TimeKey(place - reach, 0)..=TimeKey(place + reach, u32::MAX);
        let found = self.by_place.range(range);
        found.map(|key| (key.1, &self.table[&key.1]))
    }

    /// Adds an item that is seen for the first time. Its name is its id; an item that has this name
    /// but no longer the id is renamed. Without an id, or if another camera uses the id for another
    /// item, it gets a new name.
    pub(crate) fn add(&mut self, sight: &PlacedDetection) -> u32 {
        let (source, id) = (sight.source(), sight.id());
        if let Some(id) = id {
            if let Some(before) = self.known_as(source, id) {
                self.release(before, source, id);
            }
            if !self.ids.is_name_in_use(&self.table, id)
                && let Some((item, other)) = self.ids.free_name(id)
                && let Some(tracked) = self.get_mut(item)
            {
                tracked.id = other;
            }
        }
        let (number, name) = self.ids.add(id);
        self.note_change(number);
        self.by_place.insert(TimeKey(sight.place, number));
        self.widest = self.widest.max(largest_variance(sight.covariance));
        self.table.insert(number, Tracked::new(name, sight));
        self.sight(number, sight, true);
        number
    }

    /// The number of the item that `source` has seen under `id`.
    pub(crate) fn known_as(&self, source: Option<&str>, id: &str) -> Option<u32> {
        self.ids.known_as(&self.table, source, id)
    }

    /// Notes which camera saw an item, and under which id. If this is newer than what is known, the
    /// id moves to this item; otherwise it stays with the item that has it.
    pub(crate) fn sight(&mut self, item: u32, sight: &PlacedDetection, is_newer: bool) -> IdNews {
        let source = sight.source();
        let owner = sight.id().and_then(|id| self.known_as(source, id));
        let is_free = owner.is_none_or(|owner| owner == item || is_newer);
        let id = sight.id().filter(|_| is_free);
        if let (Some(id), Some(owner)) = (id, owner)
            && owner != item
        {
            self.release(owner, source, id);
        }
        self.adopt(item, source, sight.time, id)
    }

    /// Notes that `source` saw the item at `time` [s], under `id` if given, which no other item
    /// has.
    fn adopt(&mut self, item: u32, source: Option<&str>, time: f64, id: Option<&str>) -> IdNews {
        self.note_change(item);
        let Some(tracked) = self.table.get_mut(&item) else {
            return IdNews::Nothing;
        };
        self.ids.adopt(item, tracked, (source, time), id)
    }

    /// Removes an id of `source` from this item.
    fn release(&mut self, item: u32, source: Option<&str>, id: &str) {
        self.note_change(item);
        if let Some(tracked) = self.table.get_mut(&item) {
            self.ids.release(item, tracked, source, id);
        }
    }

    /// Merges an item into `other`, which gets its ids, the features that only it had, and its
    /// position if that is newer.
    pub(crate) fn fuse(&mut self, item: u32, other: u32) {
        let Some(gone) = self.forget(item) else {
            return;
        };
        let Some(tracked) = self.get_mut(other) else {
            return;
        };
        let is_newer = gone.measured > tracked.measured;
        tracked.overlooked = tracked.overlooked.min(gone.overlooked);
        tracked.features.take(gone.features, is_newer);
        tracked.weight = tracked.features.reward();
        if is_newer {
            self.measure(other, gone.measured, gone.covariance);
            self.place(other, gone.place, gone.y);
        }
        for sighting in gone.sightings {
            let source = sighting.source.as_deref();
            for id in &sighting.ids {
                self.adopt(other, source, sighting.at, Some(id));
            }
        }
    }

    /// Notes a measurement of an item at `time` [s].
    pub(crate) fn measure(&mut self, item: u32, time: f64, covariance: Option<Covariance>) {
        self.widest = self.widest.max(largest_variance(covariance));
        if let Some(tracked) = self.get_mut(item) {
            (tracked.measured, tracked.covariance) = (time, covariance);
        }
    }

    /// Moves an item to another place along the belt and across it [m].
    pub(crate) fn place(&mut self, item: u32, place: f64, y: f64) {
        self.note_change(item);
        if let Some(tracked) = self.table.get_mut(&item) {
            self.by_place.remove(&TimeKey(tracked.place, item));
            (tracked.place, tracked.y) = (place, y);
            self.by_place.insert(TimeKey(place, item));
        }
    }

    /// The items whose place is within `low..=high` [m], downstream first; equal places in order of
    /// arrival.
    pub(crate) fn within(&self, low: f64, high: f64) -> impl Iterator<Item = (u32, &Tracked)> {
        let from = TimeKey(low, 0);
        let range = (low <= high).then(|| self.by_place.range(from..=TimeKey(high, u32::MAX)));
        let mut found: Vec<TimeKey> = range.into_iter().flatten().copied().collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|key| (key.1, &self.table[&key.1]))
    }

    /// Removes an item. Its name and its ids may be used again.
    pub(crate) fn forget(&mut self, item: u32) -> Option<Tracked> {
        self.note_change(item);
        let tracked = self.table.remove(&item)?;
        self.ids.forget(item, &tracked);
        self.by_place.remove(&TimeKey(tracked.place, item));
        Some(tracked)
    }
}
