//! What the camera tells, and what becomes of items.

use super::Controller;
use crate::error::{shown, shown_number};
use crate::live::items::State;
use crate::live::protocol::{Detection, Rejected, Rejection};
use crate::pattern::Item;
use crate::plausible::{LENGTHS, question};

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

impl Controller {
    /// The camera saw something at `time` [s].
    pub(super) fn detect(&mut self, time: f64, detection: Detection) -> Result<(), Rejected> {
        let belt = *self.station().belt();
        let y = detection.y;
        let off_belt = |axis: &str, value: f64, most: f64, expected: String| {
            let meant = question(value, "m", LENGTHS, |factor| (value * factor).abs() <= most);
            let value = shown_number(value);
            let problem = format!("the item is at {axis} = {value} m; expected {expected}{meant}");
            Rejected::new(Rejection::OffBelt, problem)
        };
        if y.abs() > 0.5 * belt.width + BESIDE {
            let edge = shown_number(0.5 * belt.width);
            return Err(off_belt(
                "y",
                y,
                0.5 * belt.width,
                format!("|y| up to the belt's edge at {edge} m"),
            ));
        }
        let place = detection.x - self.world.motion().travel(time);
        let known = match &detection.id {
            Some(id) => self.world.items().find(id),
            None => self.associate(time, place, &detection),
        };
        if let Some(item) = known {
            self.see_again(item, time, place, &detection);
            return Ok(());
        }
        let x = place + self.world.motion().travel(self.stamps.now());
        if x > belt.length {
            let end = shown_number(belt.length);
            return Err(off_belt(
                "x",
                x,
                belt.length,
                format!("x up to the belt's end at {end} m, now"),
            ));
        }
        if self.world.items().len() >= self.config.most_items {
            let most = self.config.most_items;
            let id = shown(detection.id.as_deref().unwrap_or("without id"));
            return Err(Rejected::new(
                Rejection::TooManyItems,
                format!("{id} is one more than {most} items; expected fewer at a time"),
            ));
        }
        let figures = described(&detection);
        let now = self.stamps.now();
        let at = (place, time);
        self.world
            .add(detection.id, at, &figures, now, &mut self.fleet);
        self.tally.see();
        Ok(())
    }

    /// The item that a detection without id is of.
    fn associate(&self, time: f64, place: f64, detection: &Detection) -> Option<u32> {
        let variance = detection.covariance.map_or(0.0, |[xx, _, yy]| xx.max(yy));
        let gate = self.config.tolerance.max(DEVIATIONS * variance.sqrt());
        self.world
            .items()
            .nearest((place, detection.y), gate, |tracked, way| {
                // One picture shows an item once.
                let fits = tracked.measured != time || way <= TWIN;
                // What lies where an item was picked before is another one.
                fits && !matches!(tracked.state, State::Picked(at) if at < time)
            })
    }

    fn see_again(&mut self, item: u32, time: f64, place: f64, detection: &Detection) {
        let Some(tracked) = self.world.items().get(item) else {
            return;
        };
        let is_late = time < tracked.measured;
        let moved = (tracked.place - place).hypot(tracked.y - detection.y);
        let state = tracked.state;
        let now = self.stamps.now();
        if !is_late {
            self.world.describe(item, now, &mut self.fleet, |tracked| {
                tracked.measured = time;
                if detection.weight.or(detection.area_cm2).is_some() {
                    tracked.weight = described(detection).reward();
                }
            });
            if moved > SAME {
                let to = (place, detection.y);
                self.world.place(item, to, now, &mut self.fleet);
                match state {
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

    /// Forgets what has left the belt, so that memory does not grow.
    pub(super) fn forget_gone(&mut self) {
        for (_, tracked, fate) in self.world.forget_gone(self.stamps.now()) {
            self.tasks.forget(&tracked.tasks);
            self.tally.forget(fate);
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
