//! A station with a pattern on its belt, prepared for simulation.

use super::claims::Claims;
use super::conditions::Conditions;
use super::disturbances::Disturbances;
use super::downtimes::Downtimes;
use super::updates::next_update;
use super::windows::Windows;
use crate::decision::{Candidate, Figures, LeftItem, LeftReason, Odds};
use crate::error::{Error, Result};
use crate::pattern::{Item, Pattern};
use crate::station::{Belt, ClassId, Robot, Station};

/// A pattern on a station, with every departure window computed once. All runs of the pattern share
/// the scene, whatever the strategy.
#[derive(Debug, Clone)]
pub struct Scene<'a> {
    station: &'a Station,
    pattern: &'a Pattern,
    conditions: Conditions,
    /// The items as the camera reports them, furthest downstream first.
    sightings: Vec<CameraItem>,
    /// For each robot, the items that it has a window for, by opening time, then in the order of
    /// `sightings`. A robot with several places has the earliest opening and the latest closing over
    /// all of them here, and each window in `windows`.
    queues: Vec<Vec<Candidate>>,
    /// For each robot with several places, the windows from each of them.
    windows: Vec<Option<Windows>>,
    /// For each robot and item, the position in the robot's queue; filled only if items can be given
    /// back.
    positions: Vec<Vec<u32>>,
    /// The items that some robot has a window for.
    windowed: Claims,
    /// The items that are left on the belt on purpose.
    left: Vec<LeftItem>,
    /// The same as a set, in which a run begins: claimed by nobody, and free to nobody.
    not_offered: Claims,
    /// What can go wrong with each item; empty if nothing can.
    odds: Vec<Odds>,
    independent: bool,
    downtimes: Downtimes,
}

/// An item as the camera reports it.
#[derive(Debug, Clone, Copy)]
pub(super) struct CameraItem {
    pub item: u32,
    pub x0: f64,
    pub y: f64,
    pub weight: f64,
    pub class: ClassId,
}

/// Marks an item that is not in a queue; patterns have at most ten million items.
const NOWHERE: u32 = u32::MAX;

impl<'a> Scene<'a> {
    /// Puts `pattern` on `station`. Takes O(N n log n) for N robots and n items.
    ///
    /// # Errors
    /// If an item is beside the belt.
    pub fn new(station: &'a Station, pattern: &'a Pattern) -> Result<Self> {
        Self::under(station, pattern, Conditions::default())
    }

    /// Like [`Scene::new`], under conditions other than those of the plain model.
    ///
    /// # Errors
    /// If an item is beside the belt or a condition is not valid (see [`Conditions::check_on`]).
    pub fn under(
        station: &'a Station,
        pattern: &'a Pattern,
        conditions: Conditions,
    ) -> Result<Self> {
        conditions.check_on(station)?;
        pattern.check_on(station)?;
        let disturbed = conditions.disturbances.may_fail();
        let mut scene = Self {
            station,
            pattern,
            sightings: sightings(station, pattern, &conditions),
            odds: odds(pattern, &conditions),
            left: left_items(station, pattern, &conditions),
            conditions,
            queues: vec![Vec::new(); station.robots().len()],
            windows: Vec::new(),
            positions: Vec::new(),
            windowed: Claims::none(pattern.len()),
            not_offered: Claims::none(pattern.len()),
            independent: true,
            downtimes: Downtimes::default(),
        };
        for left in &scene.left {
            scene.not_offered.insert(left.item);
        }
        scene.find_windows();
        if disturbed {
            scene.find_positions();
        }
        if scene.conditions.has_outages() {
            scene.downtimes = Downtimes::new(&scene.conditions, station, scene.last_decision())?;
        }
        Ok(scene)
    }

    /// The same scene with decisions only at multiples of `1 / hz` seconds (the paper's system
    /// updates at 10 Hz); 0 means at any time.
    ///
    /// # Errors
    /// If the frequency is negative, not a number, or above 1 MHz.
    pub fn with_update_hz(mut self, hz: f64) -> Result<Self> {
        // The windows do not depend on it.
        self.conditions.update_hz = hz;
        self.conditions.check()?;
        Ok(self)
    }

    /// The same scene with a camera at `x` [m], negative if it is upstream of the start of the
    /// belt. An item is known only after it has passed the camera, so its windows do not open
    /// earlier.
    ///
    /// # Errors
    /// If the position is not a number or is too large.
    pub fn with_camera_x(self, x: f64) -> Result<Self> {
        let conditions = Conditions {
            camera_x: Some(x),
            ..self.conditions
        };
        Self::under(self.station, self.pattern, conditions)
    }

    /// The same scene with disturbances.
    ///
    /// # Errors
    /// If a standard deviation or a probability is not valid.
    pub fn with_disturbances(self, disturbances: Disturbances) -> Result<Self> {
        let conditions = Conditions {
            disturbances,
            ..self.conditions
        };
        Self::under(self.station, self.pattern, conditions)
    }

    fn find_windows(&mut self) {
        let station = self.station;
        let belt = station.belt();
        let items = self.pattern.len();
        self.windows = station
            .robots()
            .iter()
            .map(|robot| (robot.places() > 1).then(|| Windows::new(robot.places(), items)))
            .collect();
        let starts: Vec<_> = station.robots().iter().map(Robot::start).collect();
        for seen in &self.sightings {
            if self.not_offered.contains(seen.item) {
                continue;
            }
            let known = self.conditions.camera_x.map(|x| known_from(x, seen, belt));
            let mut upstream_close = f64::NEG_INFINITY;
            for (index, robot) in station.robots().iter().enumerate() {
                let Some(bin) = station.bin_for(index, seen.class) else {
                    continue;
                };
                let window = |place| window_when_known(robot, belt, place, seen, known);
                let widest = match &mut self.windows[index] {
                    // In place, because a closure that is called twice is not inlined.
                    None => window_when_known(robot, belt, starts[index], seen, known),
                    Some(windows) => windows.fill(seen.item, window),
                };
                let Some((open, close)) = widest else {
                    continue;
                };
                self.windowed.insert(seen.item);
                self.independent &= upstream_close < open;
                upstream_close = upstream_close.max(close);
                self.queues[index].push(Candidate {
                    item: seen.item,
                    bin,
                    class: seen.class,
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

    fn find_positions(&mut self) {
        let items = self.pattern.len();
        let positions = |queue: &Vec<Candidate>| {
            let mut positions = vec![NOWHERE; items];
            for (position, candidate) in queue.iter().enumerate() {
                positions[candidate.item as usize] = position as u32;
            }
            positions
        };
        self.positions = self.queues.iter().map(positions).collect();
    }

    /// The last time at which any robot may decide [s].
    fn last_decision(&self) -> f64 {
        let closes = self
            .queues
            .iter()
            .flatten()
            .map(|candidate| candidate.close);
        closes.fold(0.0, f64::max)
    }

    /// The position of `item` in the queue of robot `robot`, on a scene with disturbances.
    pub(super) fn position(&self, robot: usize, item: u32) -> Option<usize> {
        let position = *self.positions.get(robot)?.get(item as usize)?;
        (position != NOWHERE).then_some(position as usize)
    }

    /// The windows of robot `robot` from each of its places; `None` if it has only one place, whose
    /// windows are in its queue.
    pub(super) fn windows(&self, robot: usize) -> Option<&Windows> {
        self.windows[robot].as_ref()
    }

    /// The window [s] of `candidate`, from the queue of robot `robot`, from the robot's place
    /// `place`; `None` if there is none.
    pub fn window(&self, robot: usize, candidate: &Candidate, place: usize) -> Option<(f64, f64)> {
        match &self.windows[robot] {
            None => Some((candidate.open, candidate.close)),
            Some(windows) => {
                let (open, close) = windows.of(candidate.item, place);
                (open <= close).then_some((open, close))
            }
        }
    }

    /// The items that are left on the belt on purpose, downstream first.
    pub fn left(&self) -> &[LeftItem] {
        &self.left
    }

    /// The same as a set.
    pub(super) fn not_offered(&self) -> &Claims {
        &self.not_offered
    }

    /// Number of items that are to be picked.
    pub fn offered(&self) -> usize {
        self.pattern.len() - self.left.len()
    }

    /// Whether any robot has a window for the reported position of `item` after the camera has seen
    /// it.
    pub(super) fn has_window(&self, item: u32) -> bool {
        self.windowed.contains(item)
    }

    /// The items as they are reported, furthest downstream first.
    pub(super) fn sightings(&self) -> &[CameraItem] {
        &self.sightings
    }

    /// Whether the camera knows of the item at `time` [s].
    #[inline]
    pub(super) fn knows(&self, seen: &CameraItem, time: f64) -> bool {
        let belt = self.station.belt();
        match self.conditions.camera_x {
            None => seen.x0 + belt.speed * time >= 0.0,
            // Computed as for the windows, so that every candidate is in view.
            Some(x) => known_from(x, seen, belt) <= time,
        }
    }

    /// The conditions of the scene.
    pub fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// The station that picks.
    pub fn station(&self) -> &'a Station {
        self.station
    }

    /// The pattern that is picked.
    pub fn pattern(&self) -> &'a Pattern {
        self.pattern
    }

    /// The items that robot `index` has a window for, by opening time, then furthest downstream
    /// first. For a robot with several places, `open` and `close` are the earliest and the latest
    /// over all of them ([`Scene::window`] has those of one).
    pub fn queue(&self, index: usize) -> &[Candidate] {
        &self.queues[index]
    }

    /// Whether downstream decisions can never affect upstream ones. For every item and every pair
    /// of robots that have a window for it, the upstream window must close strictly before the
    /// downstream one opens, and no disturbance may give an item back.
    pub fn is_independent(&self) -> bool {
        self.independent && !self.conditions.disturbances.may_fail()
    }

    /// When `robot` makes a decision that is due at `time` [s]: at the next update at which it is
    /// not down; infinite if it never is ready again. A value within 1e-9 ticks of an update is
    /// unchanged.
    #[inline]
    pub(super) fn postponed(&self, robot: usize, time: f64) -> f64 {
        let hz = self.conditions.update_hz;
        let mut time = next_update(time, hz);
        while let Some(ready) = self.downtimes.ends(robot, time) {
            time = next_update(ready, hz);
        }
        time
    }

    /// Whether `robot` is down at `time` [s].
    #[inline]
    pub(super) fn is_down(&self, robot: usize, time: f64) -> bool {
        self.downtimes.ends(robot, time).is_some()
    }

    /// The items for which some robot is down during its window.
    pub(super) fn lost_windows(&self) -> Claims {
        let mut lost = Claims::none(self.pattern.len());
        if !self.downtimes.is_empty() {
            for (robot, queue) in self.queues.iter().enumerate() {
                let windows = queue
                    .iter()
                    .filter(|window| self.downtimes.touch(robot, (window.open, window.close)));
                windows.for_each(|window| lost.insert(window.item));
            }
        }
        lost
    }

    /// The times in which robots are down while they may decide.
    pub(super) fn downtimes(&self) -> &Downtimes {
        &self.downtimes
    }

    /// The figures of a run with the last release at `last_release` [s] and with `last_missing` as
    /// the last unpicked item.
    pub(super) fn figures(
        &self,
        picked: usize,
        weight: f64,
        last_release: f64,
        last_missing: Option<usize>,
    ) -> Figures {
        Figures {
            items: self.offered(),
            picked,
            weight,
            end: match last_missing {
                None => last_release,
                Some(item) => last_release.max(self.leaves_belt(item)),
            },
        }
    }

    /// What can go wrong with `item`, as far as it is known beforehand.
    #[inline]
    pub(super) fn odds(&self, item: u32) -> Odds {
        let odds = self.odds.get(item as usize);
        odds.copied().unwrap_or(Odds::SURE)
    }

    /// Whether nothing is known that can go wrong with any item.
    pub(super) fn is_sure(&self) -> bool {
        self.odds.is_empty()
    }

    /// When item `index` would leave the belt [s].
    pub fn leaves_belt(&self, index: usize) -> f64 {
        let belt = self.station.belt();
        (belt.length - self.pattern.items()[index].x0) / belt.speed
    }
}

/// The items as the camera reports them, furthest downstream first.
fn sightings(station: &Station, pattern: &Pattern, conditions: &Conditions) -> Vec<CameraItem> {
    let width = station.belt().width;
    let noise = &conditions.disturbances;
    let items = pattern.items().iter().zip(0u32..);
    let mut sightings: Vec<CameraItem> = items
        .map(|(item, index)| {
            let (x0, y) = noise.reported(index, item, width);
            CameraItem {
                item: index,
                x0,
                y,
                weight: item.weight_on(station),
                class: item.class_on(station),
            }
        })
        .collect();
    if noise.position_noise > 0.0 {
        sightings.sort_by(|a, b| b.x0.total_cmp(&a.x0));
    }
    sightings
}

/// What can go wrong with each item; empty if nothing can.
fn odds(pattern: &Pattern, conditions: &Conditions) -> Vec<Odds> {
    let disturbances = &conditions.disturbances;
    let of_item = |item: &Item| Odds {
        grasp: disturbances.p_grasp(item),
        detection: disturbances.p_detection(item),
    };
    let is_sure = |item: &Item| of_item(item) == Odds::SURE;
    if pattern.items().iter().all(is_sure) {
        return Vec::new();
    }
    pattern.items().iter().map(of_item).collect()
}

/// The items that are left on the belt on purpose, downstream first.
fn left_items(station: &Station, pattern: &Pattern, conditions: &Conditions) -> Vec<LeftItem> {
    if !station.leaves_items() && conditions.min_detection <= 0.0 {
        return Vec::new();
    }
    let reason = |item: &Item| {
        let uncertain = || conditions.is_too_uncertain(item);
        foreign_reason(station, item).or_else(|| uncertain().then_some(LeftReason::LowDetection))
    };
    let items = pattern.items().iter().zip(0u32..);
    items
        .filter_map(|(item, index)| {
            let reason = reason(item)?;
            Some(LeftItem {
                item: index,
                reason,
            })
        })
        .collect()
}

/// Why the station never picks an item, if it does not.
fn foreign_reason(station: &Station, item: &Item) -> Option<LeftReason> {
    let class = item.class.as_deref();
    let stated = class.and_then(|name| station.class(name));
    if stated.is_some_and(|class| !class.wanted) {
        return Some(LeftReason::Unwanted);
    }
    (!station.takes(station.class_id(class))).then_some(LeftReason::NoBin)
}

/// Checks that the station picks some item of `patterns`, whatever the conditions.
///
/// # Errors
/// It picks none: what is best for such patterns says nothing.
pub(crate) fn check_offered(station: &Station, patterns: &[Pattern]) -> Result<()> {
    let mut items = patterns.iter().flat_map(|pattern| pattern.items());
    if items.any(|item| foreign_reason(station, item).is_none()) {
        return Ok(());
    }
    Err(Error::usage(
        "the patterns",
        "no item is to be picked: robots have no bin for any of them, or all are unwanted",
        "give the items classes that robots have bins for, by 'classes' (such as pet:0.4,hdpe:0.6) \
         where patterns are generated or by the column class of a file",
    ))
}

/// The departure window [s] of an item for a robot at its place `place`, from `known` [s] on.
#[inline(always)]
fn window_when_known(
    robot: &Robot,
    belt: &Belt,
    place: usize,
    seen: &CameraItem,
    known: Option<f64>,
) -> Option<(f64, f64)> {
    let (open, close) = robot.departure_window(belt, place, seen.x0, seen.y)?;
    let open = known.map_or(open, |known| open.max(known));
    (open <= close).then_some((open, close))
}

/// When the item passes a camera at `x` [m], from which time on it is known [s].
fn known_from(x: f64, seen: &CameraItem, belt: &Belt) -> f64 {
    (x - seen.x0) / belt.speed
}
