//! What is wrong with one attempt: the move, the meeting point, and the bin.

use super::physics::{CheckedLine, bin_of, left_reason, move_time, slack_of};
use crate::decision::Pick;
use crate::pattern::Item;
use crate::station::{Bin, Robot};
use nalgebra::Point2;

/// One attempt, by a robot and at an item that exist.
pub(super) struct Attempt<'a> {
    pub checked: &'a CheckedLine<'a>,
    pub robot: &'a Robot,
    pub item: &'a Item,
    pub pick: &'a Pick,
    /// Where the arm is before it [m].
    pub from: Point2<f64>,
}

impl Attempt<'_> {
    /// Tolerance for lengths [m].
    fn tolerance(&self) -> f64 {
        let belt_speed = self.checked.station.belt().speed;
        let top_speed = self.robot.arm.law.top_speed().unwrap_or(belt_speed);
        self.slack(self.pick.release) * (1.0 + belt_speed + top_speed)
    }

    fn slack(&self, size: f64) -> f64 {
        slack_of(self.checked.tolerance, size)
    }

    fn is_near(&self, a: f64, b: f64, tolerance: f64) -> bool {
        (a - b).abs() <= tolerance + self.slack(a.max(b))
    }

    /// Whether the item is to be picked, and goes into this bin.
    fn check_bin(&self, problems: &mut Vec<String>) -> Option<&Bin> {
        let (robot, pick) = (self.robot, self.pick);
        if let Some(reason) = left_reason(self.checked.station, self.item) {
            problems.push(format!("the item is not to be picked: {}", reason.name()));
        }
        let Some(bin) = robot.bins.get(usize::from(pick.bin)) else {
            problems.push(format!("the robot has no bin {}", pick.bin));
            return None;
        };
        match bin_of(robot, self.item.class.as_deref()) {
            Some(right) if right == usize::from(pick.bin) => {}
            Some(right) => {
                let right = &robot.bins[right].name;
                problems.push(format!("the item goes into bin {right}, not {}", bin.name));
            }
            None => problems.push("the robot has no bin for the item".into()),
        }
        Some(bin)
    }

    /// Whether the robot travels straight to the meeting point and to the bin, takes the right time,
    /// and stays within its reach and on the belt.
    pub(super) fn check_way(&self, problems: &mut Vec<String>) {
        let (robot, pick) = (self.robot, self.pick);
        let belt = self.checked.station.belt();
        let bin = self.check_bin(problems);
        let times = [pick.decide, pick.grasp, pick.release];
        if !times.iter().all(|t| t.is_finite()) || pick.decide < 0.0 {
            problems.push(format!("the times {times:?} are not possible in a run"));
            return;
        }
        let tolerance = self.tolerance();
        // A length that is off by the tolerance takes at most that much longer: T is less steep than
        // 1 / v.
        let in_time = tolerance / belt.speed;
        let out = nalgebra::distance(&pick.meet, &self.from);
        let travelled = match robot.arm.constant_speed() {
            Some(speed) => self.is_near(out, speed * (pick.grasp - pick.decide), tolerance),
            None => self.is_near(move_time(robot, out), pick.grasp - pick.decide, in_time),
        };
        if !travelled {
            problems.push(format!(
                "travelling {out} m does not take {} s, but {} s",
                pick.grasp - pick.decide,
                move_time(robot, out),
            ));
        }
        if let Some(bin) = bin {
            let back = nalgebra::distance(&pick.meet, &bin.at);
            let home = pick.grasp + robot.grasp_time + move_time(robot, back) + bin.release_time;
            let returned = match robot.arm.constant_speed() {
                Some(_) => self.is_near(pick.release, home, tolerance),
                None => self.is_near(pick.release, home, in_time),
            };
            if !returned {
                problems.push(format!("it returns at {home} s, not {} s", pick.release));
            }
        }
        let off_base = nalgebra::distance(&pick.meet, &robot.base);
        if off_base > robot.reach + tolerance {
            problems.push(format!(
                "its meeting point is {off_base} m from the base, beyond its reach of {} m",
                robot.reach
            ));
        }
        let x = pick.meet.x;
        if x < -tolerance || x > belt.length + tolerance {
            problems.push(format!("its meeting point at x = {x} m is off the belt"));
        }
    }

    /// Whether the robot grasps where the item is.
    pub(super) fn check_meeting(&self, problems: &mut Vec<String>) {
        let (item, pick) = (self.item, self.pick);
        let at_grasp = item.x0 + self.checked.station.belt().speed * pick.grasp;
        let tolerance = self.tolerance();
        let near = |a: f64, b: f64| self.is_near(a, b, tolerance);
        if !near(pick.meet.x, at_grasp) || !near(pick.meet.y, item.y) {
            problems.push(format!(
                "it grasps at ({}, {}) while the item is at ({at_grasp}, {})",
                pick.meet.x, pick.meet.y, item.y
            ));
        }
    }

    /// Whether an attempt that found nothing could have met the item at its true position.
    pub(super) fn check_vanity(&self, problems: &mut Vec<String>) {
        let Self {
            robot, item, pick, ..
        } = *self;
        let (from, tolerance) = (self.from, self.tolerance());
        let belt = self.checked.station.belt();
        // The gripper gains on the item while it is on the belt, so what it lacks crosses zero at most
        // once; bisection finds where.
        let position = |t: f64| Point2::new(item.x0 + belt.speed * t, item.y);
        let lacks =
            |t: f64| move_time(robot, nalgebra::distance(&position(t), &from)) - (t - pick.decide);
        let at = |x: f64| (x - item.x0) / belt.speed;
        let (mut low, mut high) = (pick.decide.max(at(0.0)), at(belt.length).max(pick.decide));
        if lacks(low) < 0.0 || lacks(high) > 0.0 {
            // It would meet the item beside the belt's length.
            return;
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if lacks(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let meet = position(high);
        let inside = robot.reach - nalgebra::distance(&meet, &robot.base);
        let inside = inside.min(meet.x).min(belt.length - meet.x);
        if inside > tolerance {
            problems.push(format!(
                "it found nothing, but it could have met the item at ({}, {})",
                meet.x, meet.y
            ));
        }
    }
}
