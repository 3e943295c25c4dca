//! Detections. Those of one picture are matched to the items together, once all of them are there.

use super::Controller;
use super::tasks::RecheckCause;
use crate::association::{Association, AssociationGate, Match, associate};
use crate::operation::Mode;
use crate::protocol::{Detection, Rejected, Rejection};
use crate::sight::PlacedDetection;
use pickline::error::{shown, shown_number};
use pickline::plausible::{LENGTHS, question};

/// How far beside the belt a detection may be [m], because cameras are not exact.
const BESIDE: f64 = 0.05;
/// A task is sent again when its item has moved on the belt by more than this [m].
const MOVED: f64 = 1e-3;

impl Controller {
    /// Takes a detection at `time` [s]. It is matched when the picture is complete.
    pub(super) fn detect(&mut self, time: f64, detection: Detection) -> Result<(), Rejected> {
        self.check_across(detection.y)?;
        if self.world.awaits_belt() {
            self.check_room(self.picture.waiting.len(), detection.id.as_deref())?;
            self.picture.waiting.push((time, detection));
            return Ok(());
        }
        let travel = self.world.motion().travel(time);
        let sight = PlacedDetection::of(detection, time, travel);
        if !self.may_be_known(&sight) {
            self.check_along(&sight)?;
            self.check_room(self.picture.seen.len(), sight.id())?;
        }
        self.picture.seen.push(sight);
        Ok(())
    }

    /// Places the waiting detections, once the belt is heard after a restart.
    pub(super) fn place_waiting(&mut self) {
        for (time, detection) in std::mem::take(&mut self.picture.waiting) {
            if !self.picture.takes(detection.source.as_deref(), time) {
                self.close_picture();
            }
            if let Err(rejected) = self.detect(time, detection) {
                self.count_rejected(rejected.reason);
            }
        }
        self.close_picture();
    }

    fn check_across(&self, y: f64) -> Result<(), Rejected> {
        let half = 0.5 * self.station().belt().width;
        if y.abs() <= half + BESIDE {
            return Ok(());
        }
        let edge = shown_number(half);
        let expected = format!("|y| up to the belt's edge at {edge} m");
        Err(off_belt("y", y, half, &expected))
    }

    fn check_along(&self, sight: &PlacedDetection) -> Result<(), Rejected> {
        let length = self.station().belt().length;
        let x = sight.place + self.world.motion().travel(self.stamps.now());
        if x <= length {
            return Ok(());
        }
        let end = shown_number(length);
        let expected = format!("x up to the belt's end at {end} m, now");
        Err(off_belt("x", x, length, &expected))
    }

    /// Checks that there is room for one more item besides the `come` new ones.
    fn check_room(&self, come: usize, id: Option<&str>) -> Result<(), Rejected> {
        let most = self.config.most_items;
        if self.world.items().len() + come < most {
            return Ok(());
        }
        let id = shown(id.unwrap_or("without id"));
        Err(Rejected::new(
            Rejection::TooManyItems,
            format!("{id} exceeds the limit of {most} items; expected fewer at a time"),
        ))
    }

    /// Whether a known item is so near that the detection may show it.
    fn may_be_known(&self, sight: &PlacedDetection) -> bool {
        let items = self.world.items();
        let reach = self.gate().reach(sight.covariance, items.widest());
        let by_id = sight.id().and_then(|id| items.known_as(sight.source(), id));
        let by_id = by_id.and_then(|item| items.get(item));
        let is_near = by_id.is_some_and(|item| (item.place - sight.place).abs() <= 3.0 * reach);
        is_near || items.around(sight.place, reach).next().is_some()
    }

    fn gate(&self) -> AssociationGate {
        AssociationGate::new(self.config.tolerance)
    }

    /// Completes the picture and matches its detections to the items. Any other message, a step of
    /// the clock and a report do so too.
    pub fn close_picture(&mut self) {
        let seen = std::mem::take(&mut self.picture.seen);
        let Some(first) = seen.first() else {
            return;
        };
        let motion = self.world.motion();
        let Association {
            matches,
            overlooked,
            beside,
        } = associate(self.world.items(), self.gate(), &seen, |time| {
            motion.travel(time)
        });
        let now = self.stamps.now();
        let mut items: Vec<Option<u32>> = vec![None; seen.len()];
        for (index, sight) in seen.iter().enumerate() {
            items[index] = match matches[index] {
                Match::Item(item) => {
                    self.see_again(item, sight);
                    Some(item)
                }
                Match::New => self.add_item(sight, &seen, &matches),
                Match::DoublesItem(item) => Some(item),
                Match::Repeats(_) | Match::Doubles(_) => None,
            };
        }
        // A repetition or second box comes after the detection that it refers to.
        for (index, sight) in seen.iter().enumerate() {
            let mut first = index;
            while let Match::Repeats(other) | Match::Doubles(other) = matches[first] {
                first = other;
            }
            let Some(item) = items[first] else {
                continue;
            };
            match matches[index] {
                Match::Repeats(_) => self.note("repeated_detection"),
                Match::Doubles(_) | Match::DoublesItem(_) => self.note_doubled(item, sight),
                Match::Item(_) | Match::New => continue,
            }
            self.world.see_double(item, sight, now, &mut self.fleet);
        }
        for item in beside {
            self.world.confirm(item);
        }
        for (item, other) in &overlooked {
            let names = [*item, *other].map(|item| self.name_of(item));
            let (world, fleet) = (&mut self.world, &mut self.fleet);
            if world.overlook(*item, *other, first.source(), now, fleet) {
                self.tally.unsee();
                self.note_fused(&names);
            }
        }
    }

    /// Handles a detection of a known item.
    fn see_again(&mut self, item: u32, sight: &PlacedDetection) {
        let now = self.stamps.now();
        let Some(again) = self.world.see_again(item, sight, now, &mut self.fleet) else {
            return;
        };
        let task = self.world.items().get(item).and_then(|t| t.claimed_by());
        if let Some(task) = task.filter(|_| again.moved > MOVED) {
            self.follow(task, RecheckCause::Item);
        }
        self.note_news(item, sight, again.news);
        self.note(if again.is_late {
            "late_detection"
        } else {
            "repeated_detection"
        });
    }

    /// Handles a detection of a new item.
    fn add_item(
        &mut self,
        sight: &PlacedDetection,
        seen: &[PlacedDetection],
        matches: &[Match],
    ) -> Option<u32> {
        let room = self.check_along(sight);
        if let Err(rejected) = room.and_then(|()| self.check_room(0, sight.id())) {
            self.count_rejected(rejected.reason);
            return None;
        }
        let items = self.world.items();
        let before = sight.id().and_then(|id| items.known_as(sight.source(), id));
        let is_shown = |before: u32| {
            let reach = 3.0 * self.gate().reach(sight.covariance, 0.0);
            let mut shown = matches.iter().zip(seen);
            shown.any(|(what, other)| {
                *what == Match::Item(before) && other.way(sight.place, sight.y) <= reach
            })
        };
        let is_split = before.is_some_and(is_shown);
        let now = self.stamps.now();
        let barred = self.operation.line() == Mode::Draining;
        let item = self.world.add(sight, barred, now, &mut self.fleet);
        self.tally.see();
        if let Some(before) = before {
            self.note_two(before, item, sight, is_split);
        }
        Some(item)
    }

    /// Forgets the items that have left the belt, so that memory does not grow.
    pub(super) fn forget_gone(&mut self) {
        let now = self.stamps.now();
        for (item, tracked, fate) in self.world.forget_gone(now) {
            self.tasks.lose_item(item, &tracked, fate, now);
            self.tally.forget(fate);
        }
        self.tasks.forget_past(now);
    }
}

fn off_belt(axis: &str, value: f64, most: f64, expected: &str) -> Rejected {
    let meant = question(value, "m", LENGTHS, |factor| {
        value.abs() >= 1.0 && (value * factor).abs() <= most
    });
    let value = shown_number(value);
    let problem = format!("the item is at {axis} = {value} m; expected {expected}{meant}");
    Rejected::new(Rejection::OffBelt, problem)
}
