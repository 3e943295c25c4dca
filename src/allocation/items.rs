//! The items that robots have been told of, in order of arrival.

use crate::decision::Snapshot;
use crate::station::{ClassId, Station};
use std::collections::BTreeMap;

/// An item and what is kept of it.
#[derive(Debug, Clone)]
pub(super) struct KnownItem<T> {
    /// Position along the travel at time 0, as reported [m].
    x0: f64,
    /// Position across the belt, as reported [m].
    y: f64,
    /// When each robot can leave for it, from wherever its arm may be [s]; `None` for a robot that has
    /// no bin for it or cannot reach it.
    pub windows: Vec<Option<(f64, f64)>>,
    /// What the strategy keeps of it.
    pub state: T,
}

impl<T> KnownItem<T> {
    /// Whether `robot` can leave for it at `time` [s] or later.
    pub(super) fn can_be_taken(&self, robot: usize, time: f64) -> bool {
        self.windows[robot].is_some_and(|(_, close)| close >= time)
    }
}

/// What is kept of every item that is still on the belt, so that an item that comes back after a failed
/// grasp is known again.
#[derive(Debug, Clone)]
pub(super) struct KnownItems<T> {
    items: BTreeMap<u32, KnownItem<T>>,
    /// The unclaimed ones among them at this decision, in order of arrival.
    free: Vec<u32>,
}

impl<T> Default for KnownItems<T> {
    fn default() -> Self {
        Self {
            items: BTreeMap::new(),
            free: Vec::new(),
        }
    }
}

impl<T: Default> KnownItems<T> {
    /// Takes up what `snapshot` shows: new items, and new positions of known ones.
    pub(super) fn update(&mut self, snapshot: &Snapshot) {
        let station = snapshot.station;
        self.free.clear();
        // A robot may leave for an item before it is in view, so the candidates are merged in. Both
        // lists are sorted downstream first, which is the order of arrival.
        let (mut candidates, mut view) = (snapshot.candidates, snapshot.in_view);
        loop {
            let (item, x0, y, class) = match (candidates, view) {
                ([c, rest @ ..], [b, ..]) if (-c.x0, c.item) < (-b.x0, b.item) => {
                    candidates = rest;
                    (c.item, c.x0, c.y, c.class)
                }
                (_, [b, rest @ ..]) => {
                    view = rest;
                    if candidates.first().is_some_and(|c| c.item == b.item) {
                        candidates = &candidates[1..];
                    }
                    (b.item, b.x0, b.y, b.class)
                }
                ([c, rest @ ..], []) => {
                    candidates = rest;
                    (c.item, c.x0, c.y, c.class)
                }
                ([], []) => break,
            };
            if !station.takes(class) {
                continue;
            }
            self.free.push(item);
            match self.items.get_mut(&item) {
                // A live line measures items again.
                Some(known) if (known.x0, known.y) != (x0, y) => {
                    (known.x0, known.y) = (x0, y);
                    known.windows = windows(station, x0, y, class);
                }
                Some(_) => {}
                None => {
                    let windows = windows(station, x0, y, class);
                    let state = T::default();
                    let known = KnownItem {
                        x0,
                        y,
                        windows,
                        state,
                    };
                    self.items.insert(item, known);
                }
            }
        }
        let belt = station.belt();
        let travelled = belt.speed * snapshot.time;
        self.items
            .retain(|_, known| known.x0 + travelled <= belt.length);
    }

    /// Calls `each` with the unclaimed items, in order of arrival.
    pub(super) fn for_each_free(&mut self, mut each: impl FnMut(&mut KnownItem<T>)) {
        for item in &self.free {
            if let Some(known) = self.items.get_mut(item) {
                each(known);
            }
        }
    }

    /// The unclaimed items, in order of arrival.
    pub(super) fn free(&self) -> impl Iterator<Item = &KnownItem<T>> {
        self.free.iter().filter_map(|item| self.items.get(item))
    }

    /// What is kept of `item`.
    pub(super) fn get(&self, item: u32) -> Option<&KnownItem<T>> {
        self.items.get(&item)
    }
}

/// The windows of an item for each robot.
fn windows(station: &Station, x0: f64, y: f64, class: ClassId) -> Vec<Option<(f64, f64)>> {
    let robots = station.robots().iter().enumerate();
    let window = |(index, robot): (usize, &crate::station::Robot)| {
        let takes = station.has_bin_for(index, class);
        takes
            .then(|| robot.widest_window(station.belt(), x0, y))
            .flatten()
    };
    robots.map(window).collect()
}
