//! The names and ids of items.
//!
//! An item has one unique name, which messages use. Each camera may know it by its own ids, and
//! each id of a camera belongs to one item at a time.

use super::tracked::{CameraRecord, Tracked};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};

/// Maximum number of ids of one camera that are kept for an item, for a tracker that alternates
/// between ids.
const MOST_IDS: usize = 4;

/// What an id has shown about an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum IdNews {
    /// Nothing new.
    Nothing,
    /// The tracker had another id for the item before.
    Renumbered,
    /// Another tracker also has an id for the item.
    Fused,
}

/// Prefix of the names of items without an id.
const UNNAMED: &str = "auto:";

/// The names and numbers already used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub(crate) struct Numbers {
    /// Number of the next item.
    next_item: u32,
    /// Number of unnamed items so far.
    unnamed: u64,
    /// Number of items so far whose name went to another one.
    #[serde(default)]
    renamed: u64,
}

/// The names and ids in use. It holds every name and id of the items in the table, and no other.
#[derive(Debug, Clone, Default)]
pub(super) struct ItemIds {
    by_name: HashMap<String, u32>,
    /// The items with each id: one per camera that uses it.
    by_id: HashMap<String, Vec<u32>>,
    numbers: Numbers,
}

impl ItemIds {
    /// Restores the names and ids of the items in `table`.
    pub(super) fn restore(table: &BTreeMap<u32, Tracked>, numbers: Numbers) -> Self {
        let mut ids = Self {
            numbers,
            ..Self::default()
        };
        for (item, tracked) in table {
            ids.by_name.insert(tracked.id.clone(), *item);
            for id in tracked.ids() {
                ids.by_id.entry(id.clone()).or_default().push(*item);
            }
        }
        ids
    }

    /// The names and numbers already used.
    pub(super) fn numbers(&self) -> Numbers {
        self.numbers
    }

    /// The number of the item in `table` that `source` has seen under `id`.
    pub(super) fn known_as(
        &self,
        table: &BTreeMap<u32, Tracked>,
        source: Option<&str>,
        id: &str,
    ) -> Option<u32> {
        let mut items = self.by_id.get(id)?.iter().copied();
        items.find(|item| table.get(item).is_some_and(|t| t.is_known_as(source, id)))
    }

    /// Whether an item in `table` has this name because a camera has this id for it.
    pub(super) fn is_name_in_use(&self, table: &BTreeMap<u32, Tracked>, name: &str) -> bool {
        let item = self.by_name.get(name).and_then(|item| table.get(item));
        item.is_some_and(|tracked| tracked.ids().any(|id| id == name))
    }

    /// The number and the name of a new item: its id if no other item has this name, otherwise a
    /// new name.
    pub(super) fn add(&mut self, id: Option<&str>) -> (u32, String) {
        let name = match id {
            None => self.unused_name(),
            Some(id) if self.by_name.contains_key(id) => self.name_after(id),
            Some(id) => id.to_owned(),
        };
        let number = self.numbers.next_item;
        // Wraps after 4 billion items, when the first ones are long forgotten.
        self.numbers.next_item = number.wrapping_add(1);
        self.by_name.insert(name.clone(), number);
        (number, name)
    }

    /// A new name for an item without an id.
    fn unused_name(&mut self) -> String {
        loop {
            self.numbers.unnamed += 1;
            let name = format!("{UNNAMED}{}", self.numbers.unnamed);
            if !self.by_name.contains_key(&name) {
                return name;
            }
        }
    }

    /// A new name for an item whose id is the name of another item.
    fn name_after(&mut self, id: &str) -> String {
        loop {
            self.numbers.renamed += 1;
            let name = format!("{id}~{}", self.numbers.renamed);
            if !self.by_name.contains_key(&name) {
                return name;
            }
        }
    }

    /// Frees a name. Returns the item that has it and the item's new name, if there is one.
    pub(super) fn free_name(&mut self, name: &str) -> Option<(u32, String)> {
        let item = self.by_name.get(name).copied()?;
        let other = self.name_after(name);
        self.by_name.remove(name);
        self.by_name.insert(other.clone(), item);
        Some((item, other))
    }

    /// Notes that a camera saw the item at a time [s], under `id` if given, which no other item
    /// has.
    pub(super) fn adopt(
        &mut self,
        item: u32,
        tracked: &mut Tracked,
        (source, time): (Option<&str>, f64),
        id: Option<&str>,
    ) -> IdNews {
        let is_named = tracked.ids().next().is_some();
        // Another item may have taken the item's only id.
        let lost_its_id = !is_named && !tracked.id.starts_with(UNNAMED) && Some(&*tracked.id) != id;
        let its = |s: &CameraRecord| s.source.as_deref() == source;
        let place = tracked.sightings.iter().position(its);
        let place = place.unwrap_or_else(|| {
            tracked.sightings.push(CameraRecord {
                source: source.map(str::to_owned),
                at: time,
                ids: Vec::new(),
            });
            tracked.sightings.len() - 1
        });
        let its = &mut tracked.sightings[place];
        its.at = its.at.max(time);
        let Some(id) = id.filter(|id| its.ids.iter().all(|known| known != id)) else {
            return IdNews::Nothing;
        };
        let news = match (its.ids.is_empty(), is_named) {
            (true, false) if lost_its_id => IdNews::Renumbered,
            (true, false) => IdNews::Nothing,
            (true, true) => IdNews::Fused,
            (false, _) => IdNews::Renumbered,
        };
        its.ids.push(id.to_owned());
        let surplus = its.ids.len().saturating_sub(MOST_IDS);
        let forgotten: Vec<String> = its.ids.drain(..surplus).collect();
        for old in forgotten {
            self.unlist(&old, item);
        }
        self.by_id.entry(id.to_owned()).or_default().push(item);
        news
    }

    /// Removes an id of `source` from this item.
    pub(super) fn release(
        &mut self,
        item: u32,
        tracked: &mut Tracked,
        source: Option<&str>,
        id: &str,
    ) {
        for sighting in &mut tracked.sightings {
            if sighting.source.as_deref() == source {
                sighting.ids.retain(|known| known != id);
            }
        }
        self.unlist(id, item);
    }

    /// Removes the name and the ids of an item that is forgotten.
    pub(super) fn forget(&mut self, item: u32, tracked: &Tracked) {
        self.by_name.remove(&tracked.id);
        for id in tracked.ids() {
            self.unlist(id, item);
        }
    }

    /// Removes one entry for this id and item from the list of ids.
    fn unlist(&mut self, id: &str, item: u32) {
        if let Some(items) = self.by_id.get_mut(id) {
            if let Some(place) = items.iter().position(|other| *other == item) {
                items.swap_remove(place);
            }
            if items.is_empty() {
                self.by_id.remove(id);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::Features;
    use crate::items::Items;
    use crate::sight::PlacedDetection;

    fn sight(source: Option<&str>, id: Option<&str>, time: f64) -> PlacedDetection {
        PlacedDetection {
            source: source.map(str::to_owned),
            id: id.map(str::to_owned),
            time,
            place: time,
            y: 0.0,
            covariance: None,
            features: Features::default(),
        }
    }

    fn name(items: &Items, item: u32) -> &str {
        items.get(item).map_or("", |tracked| tracked.id.as_str())
    }

    #[test]
    fn no_two_items_have_one_name() {
        let mut items = Items::default();
        let (left, right) = (Some("left"), Some("right"));
        let a = items.add(&sight(left, Some("1"), 0.0));
        // Another camera counts ids separately.
        let b = items.add(&sight(right, Some("1"), 1.0));
        assert_eq!((name(&items, a), name(&items, b)), ("1", "1~1"));
        assert_eq!(items.known_as(left, "1"), Some(a));
        assert_eq!(items.known_as(right, "1"), Some(b));
        // The tracker of the first restarts.
        let c = items.add(&sight(left, Some("1"), 2.0));
        assert_eq!((name(&items, a), name(&items, c)), ("1~2", "1"));
        assert_eq!(items.known_as(left, "1"), Some(c));
        // Generated names do not block any id.
        let d = items.add(&sight(None, None, 3.0));
        let e = items.add(&sight(None, Some("auto:1"), 4.0));
        assert_eq!((name(&items, d), name(&items, e)), ("auto:1~3", "auto:1"));
        for item in [a, b, c, d, e] {
            items.forget(item);
        }
        assert!(items.ids.by_name.is_empty() && items.ids.by_id.is_empty());
    }

    #[test]
    fn an_id_is_that_of_one_item_and_an_item_has_few() {
        let mut items = Items::default();
        let a = items.add(&sight(None, Some("a"), 0.0));
        let b = items.add(&sight(None, Some("b"), 0.0));
        assert_eq!(
            items.sight(a, &sight(None, Some("b"), 1.0), true),
            IdNews::Renumbered
        );
        assert_eq!(items.known_as(None, "b"), Some(a));
        assert!(!items.get(b).unwrap().is_named_by(None));
        // Older detections take nothing away.
        items.sight(b, &sight(None, Some("b"), 0.5), false);
        assert_eq!(items.known_as(None, "b"), Some(a));
        let other = Some("other");
        assert_eq!(
            items.sight(a, &sight(other, Some("7"), 1.0), true),
            IdNews::Fused
        );
        assert_eq!(
            items.sight(a, &sight(other, Some("7"), 2.0), true),
            IdNews::Nothing
        );
        for number in 0..10 {
            items.sight(a, &sight(None, Some(&number.to_string()), 2.0), true);
        }
        assert_eq!(items.known_as(None, "9"), Some(a));
        assert_eq!(items.known_as(None, "0"), None);
        items.fuse(a, b);
        assert_eq!(items.known_as(None, "9"), Some(b));
        assert_eq!(items.known_as(other, "7"), Some(b));
    }

    #[test]
    fn what_is_restored_is_what_was() {
        let mut items = Items::default();
        items.watch();
        for number in 0..20u32 {
            let id = (number % 7).to_string();
            let source = (number % 3 == 0).then_some("left");
            items.add(&sight(source, Some(&id), f64::from(number)));
        }
        let table = items.take_changed().into_iter();
        let table = table.filter_map(|(item, tracked)| Some((item, tracked?)));
        let again = Items::restore(table.collect(), items.numbers());
        for number in 0..7 {
            for source in [None, Some("left")] {
                let id = number.to_string();
                assert_eq!(again.known_as(source, &id), items.known_as(source, &id));
            }
        }
        assert_eq!(again.ids.by_name, items.ids.by_name);
    }
}
