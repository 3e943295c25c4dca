//! What the camera tells, and what becomes of items.

use super::Controller;
use crate::decision::Candidate;
use crate::error::{shown, shown_number};
use crate::live::items::{State, Tracked};
use crate::live::protocol::{Detection, MissedCounts, Rejected, Rejection};
use crate::live::robots::{Service, Wait};
use crate::pattern::Item;

/// How far past the belt's end an item is kept [m], so that late news of it finds it.
const PAST_THE_END: f64 = 0.5;
/// How far beside the belt a detection may lie [m]: cameras are not exact.
const BESIDE: f64 = 0.05;
/// A position that differs by less [m] is the same.
const SAME: f64 = 1e-4;
/// Tasks are sent anew when their item has moved on the belt by more than this [m].
const MOVED: f64 = 1e-3;
/// Detections of one picture that are nearer to each other than this [m] are of one item.
const TWIN: f64 = 1e-3;
/// Detections of one item lie within so many standard deviations of it.
const DEVIATIONS: f64 = 3.0;

/// What becomes of an item that is not picked nor claimed.
pub(super) enum Fate {
    Picked,
    Claimed,
    OnBelt,
    Unreachable,
    GraspFailed,
    NoResult,
    PassedOver,
    Busy,
}

impl Fate {
    /// Why the item was missed, as the figures name it; none when it was not.
    pub fn reason(&self) -> Option<&'static str> {
        match self {
            Self::Unreachable => Some("unreachable"),
            Self::GraspFailed => Some("grasp_failed"),
            Self::NoResult => Some("no_result"),
            Self::PassedOver => Some("passed_over"),
            Self::Busy => Some("busy"),
            Self::Picked | Self::Claimed | Self::OnBelt => None,
        }
    }

    /// Adds it to the counts; false when it is none of theirs.
    pub fn count(&self, missed: &mut MissedCounts) -> bool {
        let count = match self {
            Self::Unreachable => &mut missed.unreachable,
            Self::GraspFailed => &mut missed.grasp_failed,
            Self::NoResult => &mut missed.no_result,
            Self::PassedOver => &mut missed.passed_over,
            Self::Busy => &mut missed.busy,
            Self::Picked | Self::Claimed | Self::OnBelt => return false,
        };
        *count += 1;
        true
    }
}

impl Controller {
    /// The camera saw something at `time` [s].
    pub(super) fn detect(&mut self, time: f64, detection: Detection) -> Result<(), Rejected> {
        let belt = *self.nominal.belt();
        let y = detection.y;
        let off_belt = |axis: &str, value: f64, expected: String| {
            let value = shown_number(value);
            let problem = format!("the item is at {axis} = {value} m; expected {expected}");
            Rejected::new(Rejection::OffBelt, problem)
        };
        if y.abs() > 0.5 * belt.width + BESIDE {
            let edge = shown_number(0.5 * belt.width);
            return Err(off_belt(
                "y",
                y,
                format!("|y| up to the belt's edge at {edge} m"),
            ));
        }
        let place = detection.x - self.motion.travel(time);
        let known = match &detection.id {
            Some(id) => self.items.find(id),
            None => self.associate(time, place, &detection),
        };
        if let Some(item) = known {
            self.see_again(item, time, place, &detection);
            return Ok(());
        }
        let x = place + self.motion.travel(self.clock.now);
        if x > belt.length {
            let end = shown_number(belt.length);
            return Err(off_belt(
                "x",
                x,
                format!("x up to the belt's end at {end} m, now"),
            ));
        }
        if self.items.len() >= self.config.most_items {
            let most = self.config.most_items;
            let id = shown(detection.id.as_deref().unwrap_or("without id"));
            return Err(Rejected::new(
                Rejection::TooManyItems,
                format!("{id} is one more than {most} items; expected fewer at a time"),
            ));
        }
        let figures = described(&detection);
        let item = self.items.add(detection.id, place, time, &figures);
        self.seen += 1;
        self.open_windows(item);
        Ok(())
    }

    /// The item that a detection without id is of.
    fn associate(&self, time: f64, place: f64, detection: &Detection) -> Option<u32> {
        let variance = detection.covariance.map_or(0.0, |[xx, _, yy]| xx.max(yy));
        let gate = self.config.tolerance.max(DEVIATIONS * variance.sqrt());
        self.items
            .nearest((place, detection.y), gate, |tracked, way| {
                // One picture shows an item once.
                let fits = tracked.measured != time || way <= TWIN;
                // What lies where an item was picked before is another one.
                fits && !matches!(tracked.state, State::Picked(at) if at < time)
            })
    }

    fn see_again(&mut self, item: u32, time: f64, place: f64, detection: &Detection) {
        let Some(tracked) = self.items.get_mut(item) else {
            return;
        };
        let is_late = time < tracked.measured;
        let moved = (tracked.place - place).hypot(tracked.y - detection.y);
        let state = tracked.state;
        if !is_late {
            tracked.measured = time;
            if detection.weight.or(detection.area_cm2).is_some() {
                tracked.weight = described(detection).reward();
            }
            if moved > SAME {
                self.items.place(item, place, detection.y);
                match state {
                    State::Free => self.open_windows(item),
                    State::Claimed(task) if moved > MOVED => self.follow(task),
                    _ => {}
                }
            }
        }
        self.note(if is_late {
            "late_detection"
        } else {
            "repeated_detection"
        });
    }

    /// Opens the windows of an item, if it is free, for every robot that may take it, and
    /// wakes those that wait for one.
    pub(super) fn open_windows(&mut self, item: u32) {
        let (Some(station), Some(tracked)) = (&self.planning, self.items.get(item)) else {
            return;
        };
        let (now, mut windowed) = (self.clock.now, tracked.windowed);
        let x0 = tracked.place + self.motion.planned_offset();
        for (index, robot) in station.robots().iter().enumerate() {
            self.windows[index].remove(item);
            if tracked.state != State::Free || tracked.refused & (1 << index) != 0 {
                continue;
            }
            let window = robot.departure_window(station.belt(), x0, tracked.y);
            let Some((open, close)) = window.filter(|(_, close)| *close >= now) else {
                continue;
            };
            windowed = true;
            self.windows[index].add(Candidate {
                item,
                x0,
                y: tracked.y,
                weight: tracked.weight,
                open,
                close,
            });
            let info = &mut self.robots[index];
            if info.service == Service::Ready && info.wait == Wait::Window {
                info.free_at = info.free_at.min(open.max(now));
            }
        }
        if windowed != tracked.windowed
            && let Some(tracked) = self.items.get_mut(item)
        {
            tracked.windowed = true;
        }
    }

    /// An item is nobody's any more; it goes back to the pool, or is given up.
    pub(super) fn give_back(&mut self, item: u32) {
        if let Some(tracked) = self.items.get_mut(item) {
            let again = tracked.attempts < self.config.most_attempts;
            tracked.state = if again { State::Free } else { State::GivenUp };
            self.open_windows(item);
        }
    }

    /// What has become of an item that is at `x` [m].
    pub(super) fn fate(&self, tracked: &Tracked, x: f64) -> Fate {
        match tracked.state {
            State::Picked(_) => Fate::Picked,
            State::Claimed(_) => Fate::Claimed,
            State::NoResult => Fate::NoResult,
            State::GivenUp => Fate::GraspFailed,
            State::Free if x <= self.nominal.belt().length => Fate::OnBelt,
            State::Free if tracked.attempts > 0 => Fate::GraspFailed,
            State::Free if tracked.offered => Fate::PassedOver,
            State::Free if tracked.windowed => Fate::Busy,
            State::Free => Fate::Unreachable,
        }
    }

    /// Forgets what has left the belt, so that memory does not grow.
    pub(super) fn forget_gone(&mut self) {
        if self.awaits_belt {
            return;
        }
        let travel = self.motion.travel(self.clock.now);
        let end = self.nominal.belt().length + PAST_THE_END - travel;
        let past = self.items.within(end.next_up(), f64::INFINITY);
        let gone = past.filter(|(_, tracked)| !matches!(tracked.state, State::Claimed(_)));
        let gone: Vec<u32> = gone.map(|(item, _)| item).collect();
        for item in gone {
            let Some(tracked) = self.items.forget(item) else {
                continue;
            };
            for windows in &mut self.windows {
                windows.remove(item);
            }
            for task in &tracked.tasks {
                self.closed.remove(task);
            }
            match self.fate(&tracked, f64::INFINITY) {
                Fate::Picked => self.picked += 1,
                fate => {
                    fate.count(&mut self.missed);
                }
            }
        }
    }
}

/// The item as patterns describe it, for its weight.
fn described(detection: &Detection) -> Item {
    Item {
        y: detection.y,
        area_cm2: detection.area_cm2,
        p_detection: detection.p_detection,
        p_grasp: detection.p_grasp,
        weight: detection.weight,
        class: detection.class.clone(),
        ..Item::default()
    }
}
