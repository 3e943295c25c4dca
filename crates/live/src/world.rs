//! The known world: the belt, the items on it, and the windows in which each robot can leave for
//! them.
//!
//! Invariant: an item is in the windows of exactly those robots that may take it now: it is free,
//! the robot has not refused it, and the robot's departure window for it, by the planned motion of
//! the belt, has not closed. All changes of an item or the belt go through this module, which keeps
//! the two consistent.

mod sightings;

use super::belt::{BeltChange, BeltMotion};
use super::fate::Fate;
use super::items::{ItemState, Items, Tracked};
use super::protocol::BeltState;
use super::robots::Fleet;
use super::windows::Windows;
use pickline::decision::{BeltItem, Candidate, Odds};
use pickline::station::Station;
use std::ops::Range;

/// How far past the belt's end an item is kept [m], for late messages about it.
const PAST_THE_END: f64 = 0.5;

/// The belt, its items, and the windows that follow from both. Times are in controller time [s].
#[derive(Debug)]
pub(crate) struct World {
    /// The station as given in its file.
    nominal: Station,
    /// The station with the planned belt speed; none while no robot can work, because the belt runs
    /// backwards or is not slower than every arm.
    planning: Option<Station>,
    motion: BeltMotion,
    items: Items,
    windows: Vec<Windows>,
    /// Items that are real with a smaller probability are left.
    min_detection: f64,
    /// Whether the belt must be heard before anything is done, because it may have stopped in the
    /// meantime.
    awaits_belt: bool,
}

impl World {
    /// An empty belt with the speed in the station's file, and with `min_detection` as in
    /// [`Config`](super::controller::Config).
    pub(crate) fn new(station: Station, min_detection: f64) -> Self {
        let motion = BeltMotion::new(station.belt().speed);
        Self {
            planning: Some(station.clone()),
            windows: vec![Windows::default(); station.robots().len()],
            nominal: station,
            motion,
            items: Items::default(),
            min_detection,
            awaits_belt: false,
        }
    }

    /// The same line with this belt and these items. If the belt was ever heard, it must be heard again before
    /// anything is done.
    pub(crate) fn restored(&self, motion: Option<BeltMotion>, items: Items) -> Self {
        let mut world = Self::new(self.nominal.clone(), self.min_detection);
        world.motion = motion.unwrap_or(world.motion);
        world.items = items;
        world.awaits_belt = world.motion.is_heard();
        world.plan_station();
        world
    }

    /// The station as given in its file.
    pub(crate) fn station(&self) -> &Station {
        &self.nominal
    }

    /// The station with the planned belt speed; none while no robot can work.
    pub(crate) fn planning(&self) -> Option<&Station> {
        self.planning.as_ref()
    }

    /// Whether items are left on the belt on purpose.
    pub(crate) fn leaves_items(&self) -> bool {
        self.min_detection > 0.0 || self.nominal.leaves_items()
    }

    /// Whether an item is to be picked, and not left on purpose.
    fn is_taken(&self, tracked: &Tracked) -> bool {
        let class = self.nominal.class_id(tracked.features.class.as_deref());
        self.nominal.takes(class) && !tracked.features.is_too_uncertain(self.min_detection)
    }

    /// The belt's motion.
    pub(crate) fn motion(&self) -> &BeltMotion {
        &self.motion
    }

    /// All known items.
    pub(crate) fn items(&self) -> &Items {
        &self.items
    }

    /// Whether the line waits until the belt is heard.
    pub(crate) fn awaits_belt(&self) -> bool {
        self.awaits_belt
    }

    /// An item's x [m] and y [m] at time 0 if the belt had always moved as planned.
    pub(crate) fn planned_place(&self, item: u32) -> Option<(f64, f64)> {
        let tracked = self.items.get(item)?;
        Some((tracked.place + self.motion.planned_offset(), tracked.y))
    }

    /// Handles a belt message at `time` [s]. Also returns whether the line was waiting for it.
    pub(crate) fn hear_belt(&mut self, time: f64, belt: &BeltState) -> (BeltChange, bool) {
        let change = self.motion.hear(time, belt);
        let awaited = change != BeltChange::Late && std::mem::take(&mut self.awaits_belt);
        (change, awaited)
    }

    /// Takes the warnings about the belt since the last call.
    pub(crate) fn take_remarks(&mut self) -> Vec<String> {
        self.motion.take_remarks()
    }

    /// Whether the belt at `now` [s] is known not to be at its planned position.
    pub(crate) fn is_off(&self, now: f64) -> bool {
        !self.awaits_belt && self.motion.is_off(now)
    }

    /// Renews the plan from `now` [s] on with the newest measurement of the belt. The windows stay
    /// those of the old plan until [`World::rebuild_windows`].
    pub(crate) fn plan_again(&mut self, now: f64) {
        self.motion.plan_again(now);
        self.plan_station();
    }

    fn plan_station(&mut self) {
        let backwards = self.motion.speed() < 0.0;
        let station = self.nominal.with_belt_speed(self.motion.planned_speed());
        self.planning = station.ok().filter(|_| !backwards);
    }

    /// Computes all windows again and wakes all waiting robots, because their waits were based on
    /// the old plan.
    pub(crate) fn rebuild_windows(&mut self, now: f64, fleet: &mut Fleet) {
        self.windows.iter_mut().for_each(Windows::clear);
        let items: Vec<u32> = self.items.iter().map(|(item, _)| item).collect();
        for item in items {
            self.open_windows(item, now, fleet);
        }
        fleet.wake_all(now);
    }

    /// Adds the windows of an item, if it is free, for every robot that may take it, and wakes
    /// robots that wait for a window.
    fn open_windows(&mut self, item: u32, now: f64, fleet: &mut Fleet) {
        self.open_windows_of(0..self.windows.len(), item, now, fleet);
    }

    /// The same for some robots only.
    fn open_windows_of(&mut self, robots: Range<usize>, item: u32, now: f64, fleet: &mut Fleet) {
        for windows in &mut self.windows[robots.clone()] {
            windows.remove(item);
        }
        let (Some(station), Some(tracked)) = (&self.planning, self.items.get(item)) else {
            return;
        };
        if tracked.state != ItemState::Free || !self.is_taken(tracked) {
            return;
        }
        let mut windowed = tracked.windowed;
        let x0 = tracked.place + self.motion.planned_offset();
        let class = station.class_id(tracked.features.class.as_deref());
        for index in robots {
            let robot = &station.robots()[index];
            if tracked.refused & (1 << index) != 0 {
                continue;
            }
            let Some(bin) = station.bin_for(index, class) else {
                continue;
            };
            let place = usize::from(fleet.get(index).place_of(robot));
            let window = robot.departure_window(station.belt(), place, x0, tracked.y);
            let Some((open, close)) = window.filter(|(_, close)| *close >= now) else {
                continue;
            };
            windowed = true;
            if tracked.barred {
                break;
            }
            let open = open.max(tracked.offered_from(index));
            if open > close {
                continue;
            }
            self.windows[index].add(Candidate {
                item,
                bin,
                class,
                x0,
                y: tracked.y,
                weight: tracked.weight,
                open,
                close,
            });
            fleet.window_opens(index, open.max(now));
        }
        if windowed != tracked.windowed
            && let Some(tracked) = self.items.get_mut(item)
        {
            tracked.windowed = true;
        }
    }

    /// Computes the windows of `robot` again, because its arm will be somewhere else.
    pub(crate) fn reopen_windows(&mut self, robot: usize, now: f64, fleet: &mut Fleet) {
        self.windows[robot].clear();
        let items: Vec<u32> = self.items.iter().map(|(item, _)| item).collect();
        for item in items {
            self.open_windows_of(robot..robot + 1, item, now, fleet);
        }
    }

    /// When `robot`, which is free from `from` [s] on, decides next; none if it has no window.
    pub(crate) fn next_decision(&mut self, robot: usize, now: f64, from: f64) -> Option<f64> {
        self.windows[robot].next_decision(now, from)
    }

    /// When the first window of `robot` opens after `time` [s].
    pub(crate) fn next_opening_after(&self, robot: usize, time: f64) -> Option<f64> {
        self.windows[robot].next_opening_after(time)
    }

    /// Fills in the candidates of `robot` at `time` [s], downstream first, and what can go wrong with
    /// each of them, and notes that they were offered.
    pub(crate) fn offer(
        &mut self,
        robot: usize,
        time: f64,
        into: &mut Vec<Candidate>,
        odds: &mut Vec<Odds>,
    ) {
        self.windows[robot].candidates(time, into);
        odds.clear();
        for candidate in into {
            let tracked = self.items.get(candidate.item);
            odds.push(tracked.map_or(Odds::SURE, |tracked| tracked.features.odds()));
            // A mutable access would count as a change.
            let is_new = tracked.is_some_and(|tracked| !tracked.offered);
            if is_new && let Some(tracked) = self.items.get_mut(candidate.item) {
                tracked.offered = true;
            }
        }
    }

    /// The free items from `from` [m] to the belt's end at `now` [s], downstream first.
    pub(crate) fn in_view(&self, from: f64, now: f64, into: &mut Vec<BeltItem>) {
        into.clear();
        let Some(station) = &self.planning else {
            return;
        };
        let belt = station.belt();
        let offset = self.motion.planned_offset();
        let travelled = offset + belt.speed * now;
        let (low, high) = (from - travelled, belt.length - travelled);
        // Slightly wider on both sides, because x decides, as in a simulation.
        for (item, tracked) in self.items.within(low - 1e-6, high + 1e-6) {
            let x0 = tracked.place + offset;
            let x = x0 + belt.speed * now;
            let class = station.class_id(tracked.features.class.as_deref());
            let is_offered = tracked.is_admitted() && self.is_taken(tracked);
            if is_offered && (from..=belt.length).contains(&x) {
                into.push(BeltItem {
                    item,
                    x0,
                    x,
                    y: tracked.y,
                    weight: tracked.weight,
                    class,
                    odds: tracked.features.odds(),
                });
            }
        }
    }

    /// Items that were let pass may be taken again. Their windows are added by
    /// [`World::rebuild_windows`].
    pub(crate) fn admit_all(&mut self) {
        let barred = self.items.iter().filter(|(_, tracked)| tracked.barred);
        let barred: Vec<u32> = barred.map(|(item, _)| item).collect();
        for item in barred {
            if let Some(tracked) = self.items.get_mut(item) {
                tracked.barred = false;
            }
        }
    }

    /// Reserves an item for `task`.
    pub(crate) fn claim(&mut self, item: u32, task: u64) {
        if let Some(tracked) = self.items.get_mut(item) {
            tracked.state = ItemState::Claimed(task);
            tracked.tasks.push(task);
        }
        self.close_windows(item);
    }

    /// Marks an item as picked at `time` [s], so that it is no longer offered.
    pub(crate) fn pick(&mut self, item: u32, time: f64) {
        if let Some(tracked) = self.items.get_mut(item) {
            tracked.state = ItemState::Picked(time);
        }
        self.close_windows(item);
    }

    /// Writes off the item of `task`, whose fate is unknown.
    pub(crate) fn write_off(&mut self, item: u32, task: u64) {
        if let Some(tracked) = self.claimed_by(item, task) {
            tracked.state = ItemState::NoResult;
        }
    }

    /// Notes that `robot` refuses this item.
    pub(crate) fn refuse(&mut self, item: u32, robot: usize) {
        if let Some(tracked) = self.items.get_mut(item) {
            tracked.refused |= 1 << robot;
        }
        self.windows[robot].remove(item);
    }

    /// Notes that `robot` has dropped the item at `now` [s], so that it is not offered to this
    /// robot for a while.
    pub(crate) fn withhold(&mut self, item: u32, robot: usize, now: f64) {
        if let Some(tracked) = self.items.get_mut(item) {
            tracked.withhold(robot, now);
        }
    }

    /// Counts a failed attempt at an item; `grasp` is whether it failed in the grasp itself.
    pub(crate) fn count_attempt(&mut self, item: u32, grasp: bool) {
        if let Some(tracked) = self.items.get_mut(item) {
            tracked.attempts += 1;
            tracked.failed_grasps += u32::from(grasp);
        }
    }

    /// Releases the item of `task`: it is free again, or given up after `most` attempts. An item
    /// that was picked meanwhile, or is reserved for another task, stays so.
    pub(crate) fn give_back(
        &mut self,
        item: u32,
        task: u64,
        most: u32,
        now: f64,
        fleet: &mut Fleet,
    ) {
        if let Some(tracked) = self.claimed_by(item, task) {
            let again = tracked.attempts < most;
            tracked.state = if again {
                ItemState::Free
            } else {
                ItemState::GivenUp
            };
            self.open_windows(item, now, fleet);
        }
    }

    fn claimed_by(&mut self, item: u32, task: u64) -> Option<&mut Tracked> {
        let claimed = self.items.get(item)?.claimed_by() == Some(task);
        claimed.then(|| self.items.get_mut(item)).flatten()
    }

    fn close_windows(&mut self, item: u32) {
        for windows in &mut self.windows {
            windows.remove(item);
        }
    }

    /// The fate of an item at `x` [m].
    pub(crate) fn fate(&self, tracked: &Tracked, x: f64) -> Fate {
        Fate::of(
            tracked,
            x > self.nominal.belt().length,
            self.is_taken(tracked),
        )
    }

    /// Forgets the items that have left the belt at `now` [s], so that memory does not grow.
    /// Returns them with their fates.
    pub(crate) fn forget_gone(&mut self, now: f64) -> Vec<(u32, Tracked, Fate)> {
        if self.awaits_belt {
            return Vec::new();
        }
        let end = self.nominal.belt().length + PAST_THE_END - self.motion.travel(now);
        let past = self.items.within(end.next_up(), f64::INFINITY);
        let gone = past.filter(|(_, tracked)| tracked.claimed_by().is_none());
        let gone: Vec<u32> = gone.map(|(item, _)| item).collect();
        let gone = gone.into_iter().filter_map(|item| {
            let tracked = self.items.forget(item)?;
            for windows in &mut self.windows {
                windows.remove(item);
            }
            let fate = self.fate(&tracked, f64::INFINITY);
            Some((item, tracked, fate))
        });
        gone.collect()
    }

    /// Tracks changes of the items from now on.
    pub(crate) fn watch(&mut self) {
        self.items.watch();
    }

    /// Takes the items changed since the last call; none for those that are forgotten.
    pub(crate) fn take_changed(&mut self) -> Vec<(u32, Option<Tracked>)> {
        self.items.take_changed()
    }
}
