//! The items that are known, from when they are first seen until they have left the belt.

use super::windows::Key;
use crate::pattern::Item;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// What has become of an item.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Nobody is after it.
    Free,
    /// Some robot is, by this task.
    Claimed(u64),
    /// It left the belt for a bin, at this time [s].
    Picked(f64),
    /// Attempts have failed too often.
    GivenUp,
    /// Its robot never said what came of it.
    NoResult,
}

/// One item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tracked {
    /// Its name in messages.
    pub id: String,
    /// Its x when the belt's travel was 0 [m].
    pub place: f64,
    /// Position across the belt [m].
    pub y: f64,
    /// Object-specific reward.
    pub weight: f64,
    /// What it is, if the camera has said so.
    pub class: Option<String>,
    /// When it was measured last [s].
    pub measured: f64,
    /// What has become of it.
    pub state: State,
    /// Whether some robot had a window for it.
    pub windowed: bool,
    /// Whether it was a candidate at some decision.
    pub offered: bool,
    /// Attempts that failed.
    pub attempts: u32,
    /// Robots that refused it, one bit each; a station has at most 100.
    pub refused: u128,
    /// Tasks that were about it.
    pub tasks: Vec<u64>,
}

impl Tracked {
    /// The task that is about it now.
    pub fn claimed_by(&self) -> Option<u64> {
        match self.state {
            State::Claimed(task) => Some(task),
            _ => None,
        }
    }
}

/// All items that are known.
#[derive(Debug, Clone, Default)]
pub struct Items {
    table: BTreeMap<u32, Tracked>,
    by_id: HashMap<String, u32>,
    by_place: BTreeSet<Key>,
    numbers: Numbers,
    /// Those that have changed since they were last asked for; none while nobody asks.
    changed: Option<BTreeSet<u32>>,
}

/// Which names and numbers are used up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Numbers {
    /// Number of the next item.
    next_item: u32,
    /// Items without a name so far.
    unnamed: u64,
}

impl Items {
    /// The items of a table.
    pub fn restore(table: BTreeMap<u32, Tracked>, numbers: Numbers) -> Self {
        let entries = table.iter();
        let by_id = entries.map(|(item, tracked)| (tracked.id.clone(), *item));
        let places = table
            .iter()
            .map(|(item, tracked)| Key(tracked.place, *item));
        Self {
            by_id: by_id.collect(),
            by_place: places.collect(),
            table,
            numbers,
            changed: None,
        }
    }

    /// Which names and numbers are used up.
    pub fn numbers(&self) -> Numbers {
        self.numbers
    }

    /// Takes note of changes from now on.
    pub fn watch(&mut self) {
        self.changed = Some(BTreeSet::new());
    }

    /// Those that have changed since the last call, with what they are now; nothing for
    /// those that are forgotten.
    pub fn take_changed(&mut self) -> Vec<(u32, Option<Tracked>)> {
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

    /// How many.
    pub fn len(&self) -> usize {
        self.table.len()
    }

    /// The item of this number.
    pub fn get(&self, item: u32) -> Option<&Tracked> {
        self.table.get(&item)
    }

    /// The item of this number, to be changed; its place is changed by [`Items::place`].
    pub fn get_mut(&mut self, item: u32) -> Option<&mut Tracked> {
        self.note_change(item);
        self.table.get_mut(&item)
    }

    /// All of them by number.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &Tracked)> {
        self.table.iter().map(|(item, tracked)| (*item, tracked))
    }

    /// The number of the item of this id.
    pub fn find(&self, id: &str) -> Option<u32> {
        self.by_id.get(id).copied()
    }

    /// The item nearest to a place within `gate` [m] of it, of those that `fits` allows.
    pub fn nearest(
        &self,
        (place, y): (f64, f64),
        gate: f64,
        fits: impl Fn(&Tracked, f64) -> bool,
    ) -> Option<u32> {
        let near = self
            .by_place
            .range(Key(place - gate, 0)..=Key(place + gate, u32::MAX));
        let mut best: Option<(f64, u32)> = None;
        for Key(_, item) in near {
            let tracked = &self.table[item];
            let way = (tracked.place - place).hypot(tracked.y - y);
            let nearer = best.is_none_or(|(least, _)| way < least);
            if way <= gate && nearer && fits(tracked, way) {
                best = Some((way, *item));
            }
        }
        best.map(|(_, item)| item)
    }

    /// Adds an item. One without a name gets one that no other has.
    pub fn add(&mut self, id: Option<String>, place: f64, time: f64, item: &Item) -> u32 {
        let id = id.unwrap_or_else(|| {
            loop {
                self.numbers.unnamed += 1;
                let id = format!("auto:{}", self.numbers.unnamed);
                if !self.by_id.contains_key(&id) {
                    break id;
                }
            }
        });
        let number = self.numbers.next_item;
        // Starts anew after 4 billion items, when those of old are long forgotten.
        self.numbers.next_item = number.wrapping_add(1);
        self.note_change(number);
        self.by_id.insert(id.clone(), number);
        self.by_place.insert(Key(place, number));
        let tracked = Tracked {
            id,
            place,
            y: item.y,
            weight: item.reward(),
            class: item.class.clone(),
            measured: time,
            state: State::Free,
            windowed: false,
            offered: false,
            attempts: 0,
            refused: 0,
            tasks: Vec::new(),
        };
        self.table.insert(number, tracked);
        number
    }

    /// Puts an item elsewhere.
    pub fn place(&mut self, item: u32, place: f64, y: f64) {
        self.note_change(item);
        if let Some(tracked) = self.table.get_mut(&item) {
            self.by_place.remove(&Key(tracked.place, item));
            (tracked.place, tracked.y) = (place, y);
            self.by_place.insert(Key(place, item));
        }
    }

    /// Those whose place is within `low..=high` [m], downstream first; equal places in
    /// the order in which they came.
    pub fn within(&self, low: f64, high: f64) -> impl Iterator<Item = (u32, &Tracked)> {
        let from = Key(low, 0);
        let range = (low <= high).then(|| self.by_place.range(from..=Key(high, u32::MAX)));
        let mut found: Vec<Key> = range.into_iter().flatten().copied().collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|key| (key.1, &self.table[&key.1]))
    }

    /// Removes an item.
    pub fn forget(&mut self, item: u32) -> Option<Tracked> {
        self.note_change(item);
        let tracked = self.table.remove(&item)?;
        self.by_id.remove(&tracked.id);
        self.by_place.remove(&Key(tracked.place, item));
        Some(tracked)
    }
}
