//! The known items, from their first detection until they have left the belt.

mod ids;

use super::association::{Covariance, largest_variance};
use super::features::Features;
use super::sight::PlacedDetection;
use super::windows::TimeKey;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet, HashMap};

pub use ids::IdNews;

/// The state of an item.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ItemState {
    /// No task is about it.
    Free,
    /// It is reserved for this task.
    Claimed(u64),
    /// It was picked at this time [s].
    Picked(f64),
    /// Too many attempts have failed.
    GivenUp,
    /// Its robot never reported a result.
    NoResult,
}

/// A known item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tracked {
    /// Its unique name in messages.
    pub id: String,
    /// Its x when the belt's travel was 0 [m].
    pub place: f64,
    /// Position across the belt [m].
    pub y: f64,
    /// Object-specific reward.
    pub weight: f64,
    /// What else the camera has reported about it.
    #[serde(default)]
    pub features: Features,
    /// Time of its last measurement [s].
    pub measured: f64,
    /// Covariance of its position at that time [m^2].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<Covariance>,
    /// The cameras that have seen it, and their ids for it.
    #[serde(default)]
    pub sightings: Vec<CameraRecord>,
    /// Number of pictures that show another item in its place, minus those that show both.
    #[serde(default)]
    pub overlooked: i32,
    /// Its state.
    pub state: ItemState,
    /// Whether any robot ever had a window for it.
    pub windowed: bool,
    /// Whether it was ever a candidate of a decision.
    pub offered: bool,
    /// Number of failed attempts.
    pub attempts: u32,
    /// The failed attempts in which the gripper reached it but the grasp failed.
    pub failed_grasps: u32,
    /// Robots that have dropped it, and when it may be offered to them again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub withheld: Vec<Withheld>,
    /// Whether it is let pass, because it came while the line was draining.
    #[serde(default)]
    pub barred: bool,
    /// Robots that refused it, one bit each; a station has at most 100.
    pub refused: u128,
    /// The tasks about it so far.
    pub tasks: Vec<u64>,
}

/// A robot that has dropped a task about an item.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Withheld {
    robot: usize,
    /// How often the robot has dropped it.
    times: u32,
    /// The robot is not offered the item before this time [s].
    until: f64,
}

/// How long an item is withheld from a robot that has dropped it [s]; it doubles each further time,
const FIRST_PAUSE: f64 = 1.0;
/// up to this [s].
const LONGEST_PAUSE: f64 = 60.0;

/// A camera's record of an item.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CameraRecord {
    /// The camera, if it has a name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// When the camera last saw the item [s].
    pub at: f64,
    /// The camera's ids for the item, the newest last.
    pub ids: Vec<String>,
}

impl Tracked {
    /// When `source` last saw it [s].
    pub fn seen_at(&self, source: Option<&str>) -> Option<f64> {
        self.sighting(source).map(|sighting| sighting.at)
    }

    /// Whether `source` has an id for it.
    pub fn is_named_by(&self, source: Option<&str>) -> bool {
        self.sighting(source).is_some_and(|s| !s.ids.is_empty())
    }

    fn sighting(&self, source: Option<&str>) -> Option<&CameraRecord> {
        let mut sightings = self.sightings.iter();
        sightings.find(|sighting| sighting.source.as_deref() == source)
    }

    /// Notes that `robot` has dropped it at `now` [s].
    pub fn withhold(&mut self, robot: usize, now: f64) {
        let known = self.withheld.iter().position(|w| w.robot == robot);
        let at = known.unwrap_or_else(|| {
            self.withheld.push(Withheld {
                robot,
                times: 0,
                until: now,
            });
            self.withheld.len() - 1
        });
        let withheld = &mut self.withheld[at];
        let pause = FIRST_PAUSE * f64::from(2u32.pow(withheld.times.min(16)));
        withheld.times += 1;
        withheld.until = now + pause.min(LONGEST_PAUSE);
    }

    /// The time from which it may be offered to `robot` [s].
    pub fn offered_from(&self, robot: usize) -> f64 {
        let found = self.withheld.iter().find(|w| w.robot == robot);
        found.map_or(f64::NEG_INFINITY, |withheld| withheld.until)
    }

    /// Whether it is free and may be offered.
    pub fn is_admitted(&self) -> bool {
        self.state == ItemState::Free && !self.barred
    }

    /// Whether it may be offered to `robot`.
    pub fn is_open_to(&self, robot: usize) -> bool {
        self.is_admitted() && self.refused & (1 << robot) == 0
    }

    /// The task that it is reserved for.
    pub fn claimed_by(&self) -> Option<u64> {
        match self.state {
            ItemState::Claimed(task) => Some(task),
            _ => None,
        }
    }
}

/// All known items.
#[derive(Debug, Clone, Default)]
pub struct Items {
    table: BTreeMap<u32, Tracked>,
    by_name: HashMap<String, u32>,
    /// The items with each id: one per camera that uses it.
    by_id: HashMap<String, Vec<u32>>,
    /// The largest variance of a position so far [m^2].
    widest: f64,
    by_place: BTreeSet<TimeKey>,
    numbers: Numbers,
    /// The items changed since the last [`Items::take_changed`]; none while changes are not
    /// tracked.
    changed: Option<BTreeSet<u32>>,
}

/// The names and numbers already used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Numbers {
    /// Number of the next item.
    next_item: u32,
    /// Number of unnamed items so far.
    unnamed: u64,
    /// Number of items so far whose name went to another one.
    #[serde(default)]
    renamed: u64,
}

impl Items {
    /// Restores the items from a table.
    pub fn restore(table: BTreeMap<u32, Tracked>, numbers: Numbers) -> Self {
        let mut items = Self {
            numbers,
            ..Self::default()
        };
        for (item, tracked) in &table {
            items.by_name.insert(tracked.id.clone(), *item);
            items.by_place.insert(TimeKey(tracked.place, *item));
            let variance = largest_variance(tracked.covariance);
            items.widest = items.widest.max(variance);
            for id in tracked.sightings.iter().flat_map(|s| &s.ids) {
                items.by_id.entry(id.clone()).or_default().push(*item);
            }
        }
        items.table = table;
        items
    }

    /// The names and numbers already used.
    pub fn numbers(&self) -> Numbers {
        self.numbers
    }

    /// Tracks changes from now on.
    pub fn watch(&mut self) {
        self.changed = Some(BTreeSet::new());
    }

    /// Takes the items changed since the last call, with their present values; none for those that
    /// are forgotten.
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

    /// Number of known items.
    pub fn len(&self) -> usize {
        self.table.len()
    }

    /// The item with this number.
    pub fn get(&self, item: u32) -> Option<&Tracked> {
        self.table.get(&item)
    }

    /// The item with this number, to be changed. Use [`Items::place`] to change its place.
    pub fn get_mut(&mut self, item: u32) -> Option<&mut Tracked> {
        self.note_change(item);
        self.table.get_mut(&item)
    }

    /// All items by number.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &Tracked)> {
        self.table.iter().map(|(item, tracked)| (*item, tracked))
    }

    /// The largest variance of any position so far [m^2].
    pub fn widest(&self) -> f64 {
        self.widest
    }

    /// The items within `reach` [m] of a place along the belt, upstream first.
    pub fn around(&self, place: f64, reach: f64) -> impl Iterator<Item = (u32, &Tracked)> {
        let range = TimeKey(place - reach, 0)..=TimeKey(place + reach, u32::MAX);
        let found = self.by_place.range(range);
        found.map(|key| (key.1, &self.table[&key.1]))
    }

    /// Adds an item that is seen for the first time. Its name is its id; an item that has this name
    /// but no longer the id is renamed. Without an id, or if another camera uses the id for another
    /// item, it gets a new name.
    pub fn add(&mut self, sight: &PlacedDetection) -> u32 {
        let (source, id) = (sight.source(), sight.id());
        if let Some(id) = id {
            if let Some(before) = self.known_as(source, id) {
                self.release(before, source, id);
            }
            if !self.is_name_in_use(id) {
                self.free_name(id);
            }
        }
        let name = match id {
            None => self.unused_name(),
            Some(id) if self.by_name.contains_key(id) => self.name_after(id),
            Some(id) => id.to_owned(),
        };
        let number = self.numbers.next_item;
        // Wraps after 4 billion items, when the first ones are long forgotten.
        self.numbers.next_item = number.wrapping_add(1);
        self.note_change(number);
        self.by_name.insert(name.clone(), number);
        self.by_place.insert(TimeKey(sight.place, number));
        self.widest = self.widest.max(largest_variance(sight.covariance));
        let tracked = Tracked {
            id: name,
            place: sight.place,
            y: sight.y,
            weight: sight.features.reward(),
            features: sight.features.clone(),
            measured: sight.time,
            covariance: sight.covariance,
            sightings: Vec::new(),
            overlooked: 0,
            state: ItemState::Free,
            windowed: false,
            offered: false,
            attempts: 0,
            failed_grasps: 0,
            withheld: Vec::new(),
            barred: false,
            refused: 0,
            tasks: Vec::new(),
        };
        self.table.insert(number, tracked);
        self.sight(number, sight, true);
        number
    }

    /// Notes a measurement of an item at `time` [s].
    pub fn measure(&mut self, item: u32, time: f64, covariance: Option<Covariance>) {
        self.widest = self.widest.max(largest_variance(covariance));
        if let Some(tracked) = self.get_mut(item) {
            (tracked.measured, tracked.covariance) = (time, covariance);
        }
    }

    /// Moves an item.
    pub fn place(&mut self, item: u32, place: f64, y: f64) {
        self.note_change(item);
        if let Some(tracked) = self.table.get_mut(&item) {
            self.by_place.remove(&TimeKey(tracked.place, item));
            (tracked.place, tracked.y) = (place, y);
            self.by_place.insert(TimeKey(place, item));
        }
    }

    /// The items whose place is within `low..=high` [m], downstream first; equal places in order of
    /// arrival.
    pub fn within(&self, low: f64, high: f64) -> impl Iterator<Item = (u32, &Tracked)> {
        let from = TimeKey(low, 0);
        let range = (low <= high).then(|| self.by_place.range(from..=TimeKey(high, u32::MAX)));
        let mut found: Vec<TimeKey> = range.into_iter().flatten().copied().collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        found.into_iter().map(|key| (key.1, &self.table[&key.1]))
    }

    /// Removes an item.
    pub fn forget(&mut self, item: u32) -> Option<Tracked> {
        self.note_change(item);
        let tracked = self.table.remove(&item)?;
        self.by_name.remove(&tracked.id);
        for id in tracked.sightings.iter().flat_map(|s| &s.ids) {
            self.unlist(id, item);
        }
        self.by_place.remove(&TimeKey(tracked.place, item));
        Some(tracked)
    }
}
