//! A station with a pattern on its belt, made ready to simulate.

use super::claims::Claims;
use super::conditions::{Conditions, Disturbances};
use crate::decision::{Candidate, Figures};
use crate::error::Result;
use crate::pattern::Pattern;
use crate::station::{Belt, Station};

/// A pattern on a station, with every departure window computed once. All runs of
/// the pattern share it, whatever the strategy.
#[derive(Debug, Clone)]
pub struct Scene<'a> {
    station: &'a Station,
    pattern: &'a Pattern,
    conditions: Conditions,
    /// The items as the camera reports them, furthest downstream first.
    sightings: Vec<Sighting>,
    /// Per robot, the items that it has a window for, by opening time, then in the order
    /// of `sightings`.
    queues: Vec<Vec<Candidate>>,
    /// Per robot and item, the place in the robot's queue; filled only where an item can
    /// be given back.
    places: Vec<Vec<u32>>,
    /// The items that some robot has a window for.
    windowed: Claims,
    independent: bool,
}

/// An item as the camera reports it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting {
    pub item: u32,
    pub x0: f64,
    pub y: f64,
    pub weight: f64,
}

/// Stands for an item that is not in a queue; patterns hold at most ten million.
const NOWHERE: u32 = u32::MAX;

impl<'a> Scene<'a> {
    /// Puts `pattern` on `station`. Takes O(N n log n) for N robots and n items.
    ///
    /// # Errors
    /// An item beside the belt.
    pub fn new(station: &'a Station, pattern: &'a Pattern) -> Result<Self> {
        Self::under(station, pattern, Conditions::default())
    }

    /// As [`Scene::new`], under conditions other than those of the plain model.
    ///
    /// # Errors
    /// An item beside the belt, conditions that are none (see [`Conditions::check`]).
    pub fn under(
        station: &'a Station,
        pattern: &'a Pattern,
        conditions: Conditions,
    ) -> Result<Self> {
        conditions.check()?;
        pattern.check_on(station)?;
        let mut scene = Self {
            station,
            pattern,
            conditions,
            sightings: sightings(station, pattern, &conditions),
            queues: vec![Vec::new(); station.robots().len()],
            places: Vec::new(),
            windowed: Claims::none(pattern.len()),
            independent: true,
        };
        scene.find_windows();
        if conditions.disturbances.any() {
            scene.find_places();
        }
        Ok(scene)
    }

    /// The same scene with decisions at multiples of `1 / hz` seconds only (the
    /// paper's system updates at 10 Hz); 0 is exact.
    ///
    /// # Errors
    /// A frequency that is negative or not a number, or past 1 MHz.
    pub fn with_update_hz(mut self, hz: f64) -> Result<Self> {
        // No window depends on it.
        self.conditions.update_hz = hz;
        self.conditions.check()?;
        Ok(self)
    }

    /// The same scene with a camera at `x` [m], negative for upstream of the belt's
    /// start: an item is known only once it has passed it, so no window of it opens
    /// earlier.
    ///
    /// # Errors
    /// A position that is not a number or absurdly large.
    pub fn with_camera_x(self, x: f64) -> Result<Self> {
        let conditions = Conditions {
            camera_x: Some(x),
            ..self.conditions
        };
        Self::under(self.station, self.pattern, conditions)
    }

    /// The same scene where things go wrong.
    ///
    /// # Errors
    /// A deviation or a probability that is none.
    pub fn with_disturbances(self, disturbances: Disturbances) -> Result<Self> {
        let conditions = Conditions {
            disturbances,
            ..self.conditions
        };
        Self::under(self.station, self.pattern, conditions)
    }

    fn find_windows(&mut self) {
        let belt = self.station.belt();
        for seen in &self.sightings {
            let known = self.conditions.camera_x.map(|x| known_from(x, seen, belt));
            let mut upstream_close = f64::NEG_INFINITY;
            for (robot, queue) in self.station.robots().iter().zip(&mut self.queues) {
                let Some((mut open, close)) = robot.departure_window(belt, seen.x0, seen.y) else {
                    continue;
                };
                if let Some(known) = known {
                    open = open.max(known);
                    if open > close {
                        continue;
                    }
                }
                self.windowed.insert(seen.item);
                self.independent &= upstream_close < open;
                upstream_close = upstream_close.max(close);
                queue.push(Candidate {
                    item: seen.item,
                    x0: seen.x0,
                    y: seen.y,
                    weight: seen.weight,
                    open,
                    close,
                });
            }
        }
        for queue in &mut self.queues {
            queue.sort_by(|a, b| a.open.total_cmp(&b.open));
        }
    }

    fn find_places(&mut self) {
        let items = self.pattern.len();
        let places = |queue: &Vec<Candidate>| {
            let mut places = vec![NOWHERE; items];
            for (place, candidate) in queue.iter().enumerate() {
                places[candidate.item as usize] = place as u32;
            }
            places
        };
        self.places = self.queues.iter().map(places).collect();
    }

    /// Where `item` is in the queue of robot `robot`, on a scene with disturbances.
    pub(super) fn place(&self, robot: usize, item: u32) -> Option<usize> {
        let place = *self.places.get(robot)?.get(item as usize)?;
        (place != NOWHERE).then_some(place as usize)
    }

    /// Whether any robot has a window for `item` where and from when on the camera
    /// reports it.
    pub(super) fn has_window(&self, item: u32) -> bool {
        self.windowed.contains(item)
    }

    /// The items as they are reported, furthest downstream first.
    pub(super) fn sightings(&self) -> &[Sighting] {
        &self.sightings
    }

    /// Whether the camera knows of the item at `time` [s].
    #[inline]
    pub(super) fn knows(&self, seen: &Sighting, time: f64) -> bool {
        let belt = self.station.belt();
        match self.conditions.camera_x {
            None => seen.x0 + belt.speed * time >= 0.0,
            // As for the windows, so that every candidate is in view.
            Some(x) => known_from(x, seen, belt) <= time,
        }
    }

    /// The conditions.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// The station.
    pub fn station(&self) -> &'a Station {
        self.station
    }

    /// The pattern.
    pub fn pattern(&self) -> &'a Pattern {
        self.pattern
    }

    /// The items that robot `index` has a window for, by opening time, then
    /// furthest downstream first.
    pub fn queue(&self, index: usize) -> &[Candidate] {
        &self.queues[index]
    }

    /// Whether downstream decisions can never change upstream ones: for every item
    /// and every pair of robots that have a window for it, the upstream one's closes
    /// strictly before the downstream one's opens, and nothing that goes wrong gives an
    /// item back.
    pub fn is_independent(&self) -> bool {
        self.independent && !self.conditions.disturbances.any()
    }

    /// `time` [s] rounded up to the next update; a value within 1e-9 ticks of one
    /// stays as it is.
    pub(super) fn tick(&self, time: f64) -> f64 {
        next_update(time, self.conditions.update_hz)
    }

    /// The figures of a run whose last release is at `last_release` [s] and in which
    /// `last_missing` was the last unpicked item.
    pub(super) fn figures(
        &self,
        picked: usize,
        weight: f64,
        last_release: f64,
        last_missing: Option<usize>,
    ) -> Figures {
        Figures {
            items: self.pattern.len(),
            picked,
            weight,
            end: match last_missing {
                None => last_release,
                Some(item) => last_release.max(self.leaves_belt(item)),
            },
        }
    }

    /// When item `index` would leave the belt [s].
    pub fn leaves_belt(&self, index: usize) -> f64 {
        let belt = self.station.belt();
        (belt.length - self.pattern.items()[index].x0) / belt.speed
    }
}

/// The items as the camera reports them, furthest downstream first.
fn sightings(station: &Station, pattern: &Pattern, conditions: &Conditions) -> Vec<Sighting> {
    let width = station.belt().width;
    let noise = &conditions.disturbances;
    let items = pattern.items().iter().zip(0u32..);
    let mut sightings: Vec<Sighting> = items
        .map(|(item, index)| {
            let (x0, y) = noise.reported(index, item, width);
            let weight = item.reward();
            Sighting {
                item: index,
                x0,
                y,
                weight,
            }
        })
        .collect();
    if noise.position_noise > 0.0 {
        sightings.sort_by(|a, b| b.x0.total_cmp(&a.x0));
    }
    sightings
}

/// When the item passes a camera at `x` [m], so that it is known from then on [s].
fn known_from(x: f64, seen: &Sighting, belt: &Belt) -> f64 {
    (x - seen.x0) / belt.speed
}

/// `time` [s] rounded up to the next multiple of `1 / hz` seconds.
fn next_update(time: f64, hz: f64) -> f64 {
    if hz == 0.0 {
        return time;
    }
    let ticks = time * hz;
    if (ticks - ticks.round()).abs() <= 1e-9 {
        time
    } else {
        ticks.ceil() / hz
    }
}

#[cfg(test)]
mod tests {
    use super::next_update;

    #[test]
    fn times_are_rounded_up_to_the_next_update() {
        for (time, hz, expected) in [
            (0.31, 10.0, 0.4),
            (0.39, 10.0, 0.4),
            (0.3, 10.0, 0.3),
            (0.7, 0.5, 2.0),
            // Half a billionth of a tick is rounding, two are not.
            (0.3 + 5e-11, 10.0, 0.3 + 5e-11),
            (0.3 - 5e-11, 10.0, 0.3 - 5e-11),
            (0.3 + 2e-10, 10.0, 0.4),
            (0.3 - 2e-10, 10.0, 0.3),
            (f64::INFINITY, 10.0, f64::INFINITY),
            // At 0 Hz it may be decided at any time.
            (0.31, 0.0, 0.31),
            (f64::INFINITY, 0.0, f64::INFINITY),
        ] {
            assert_eq!(next_update(time, hz), expected, "{time} s at {hz} Hz");
        }
    }

    /// Whatever the rounding of the product and of the quotient.
    #[test]
    fn no_update_is_in_the_past() {
        for tick in 0..20_000 {
            for hz in [0.3, 7.0, 10.0, 13.7, 60.0, 1e6] {
                let exact = f64::from(tick) / hz;
                for time in [
                    exact,
                    exact.next_up(),
                    exact.next_down().max(0.0),
                    exact + 0.3 / hz,
                ] {
                    let next = next_update(time, hz);
                    assert!(
                        next >= time && next - time < 1.0 / hz,
                        "{time} s at {hz} Hz"
                    );
                }
            }
        }
    }
}
