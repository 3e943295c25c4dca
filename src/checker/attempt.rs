//! What is wrong with one attempt: the move, the meeting point, and the bin.

use super::physics::{CheckedLine, bin_of, left_reason, move_time, slack};
use super::violation::{Problem, ViolationKind};
use crate::decision::Pick;
use crate::error::rounded;
use crate::pattern::Item;
use crate::station::{Bin, Robot};
use nalgebra::Point2;

/// A computed number with the digits that rounding leaves.
pub(super) fn digits(value: f64) -> String {
    rounded(value, 12)
}

/// One attempt, by a robot that exists.
pub(super) struct Attempt<'a> {
    pub checked: &'a CheckedLine<'a>,
    pub robot: &'a Robot,
    /// The item; `None` if it does not exist.
    pub item: Option<&'a Item>,
    pub pick: &'a Pick,
    /// Where the arm is before it [m], if that is known.
    pub from: Option<Point2<f64>>,
}

fn grasps_before_leaving(pick: &Pick) -> String {
    format!(
        "it grasps at {} s, before it leaves at {} s",
        digits(pick.grasp),
        digits(pick.decide)
    )
}

fn releases_before_grasping(pick: &Pick) -> String {
    format!(
        "the item is in the bin at {} s, before the grasp begins at {} s",
        digits(pick.release),
        digits(pick.grasp)
    )
}

/// Whether a run has times like these.
pub(super) fn has_possible_times(pick: &Pick, tolerance: f64, problems: &mut Vec<Problem>) -> bool {
    let times = [pick.decide, pick.grasp, pick.release];
    let text = if !times.iter().all(|time| time.is_finite()) {
        format!("the times {times:?} are not possible in a run: not all are finite")
    } else if pick.decide < -tolerance {
        format!(
            "it leaves at {} s, before the run begins at 0 s",
            digits(pick.decide)
        )
    } else {
        return true;
    };
    problems.push(Problem::of(ViolationKind::Times, text));
    false
}

/// Whether the way out of an attempt whose places are not known takes time at all.
pub(super) fn check_way_out(pick: &Pick, tolerance: f64, problems: &mut Vec<Problem>) {
    let early = pick.decide - pick.grasp - slack(pick.decide);
    if 0.5 * early > tolerance {
        let text = grasps_before_leaving(pick);
        problems.push(Problem::off(ViolationKind::TravelTime, 0.5 * early, text));
    }
}

/// Whether the way back of an attempt whose places are not known takes at least as long as grasp and
/// release, which are `still` [s].
pub(super) fn check_way_back(pick: &Pick, still: f64, tolerance: f64, problems: &mut Vec<Problem>) {
    let early = pick.grasp + still - pick.release - slack(pick.release);
    if 0.5 * early > tolerance {
        let text = match pick.release < pick.grasp {
            true => releases_before_grasping(pick),
            false => format!(
                "grasp and release alone take {} s, but the item is in the bin {} s after the grasp \
                 begins",
                digits(still),
                digits(pick.release - pick.grasp)
            ),
        };
        problems.push(Problem::off(ViolationKind::ReturnTime, 0.5 * early, text));
    }
}

impl Attempt<'_> {
    /// Whether it is known where the item was met: for one that does not exist, only if the file says it.
    fn has_place(&self) -> bool {
        self.item.is_some() || self.pick.meet.iter().all(|at| at.is_finite())
    }

    /// Allowance for rounding of lengths [m].
    fn rounding(&self) -> f64 {
        let belt_speed = self.checked.station.belt().speed;
        let top_speed = self.robot.arm.law.top_speed().unwrap_or(belt_speed);
        slack(self.pick.release) * (1.0 + belt_speed + top_speed)
    }

    /// Whether what takes this tolerance [s] to be accepted is not; nor is what is no number.
    fn exceeds(&self, tolerance: f64) -> bool {
        tolerance > self.checked.terms.tolerance || tolerance.is_nan()
    }

    /// Deviation of two lengths [m] or times [s] beyond rounding; 0 if there is none.
    fn gap(a: f64, b: f64, rounding: f64) -> f64 {
        let (off, allowed) = ((a - b).abs(), rounding + slack(a.max(b)));
        // Both may be infinite.
        if off <= allowed { 0.0 } else { off - allowed }
    }

    /// Whether the item is to be picked, and goes into this bin.
    fn check_bin(&self, problems: &mut Vec<Problem>) -> Option<&Bin> {
        let (robot, pick) = (self.robot, self.pick);
        let left = |item: &Item| left_reason(self.checked.station, item);
        if let Some(reason) = self.item.and_then(left) {
            problems.push(Problem::of(
                ViolationKind::Unwanted,
                format!("the item is not to be picked: {}", reason.name()),
            ));
        }
        let wrong = |text: String| Problem::of(ViolationKind::Bin, text);
        let Some(bin) = robot.bins.get(usize::from(pick.bin)) else {
            let text = format!("the robot has no bin {}", pick.bin);
            problems.push(Problem::of(ViolationKind::Unknown, text));
            // Wherever it says that the item went, it can only have gone there.
            return (robot.bins.len() == 1).then(|| &robot.bins[0]);
        };
        let Some(item) = self.item else {
            return Some(bin);
        };
        match bin_of(robot, item.class.as_deref()) {
            Some(right) if right == usize::from(pick.bin) => {}
            Some(right) => {
                let right = &robot.bins[right].name;
                problems.push(wrong(format!(
                    "the item goes into bin {right}, not {}",
                    bin.name
                )));
            }
            None => problems.push(wrong("the robot has no bin for the item".into())),
        }
        Some(bin)
    }

    /// Whether the robot travels straight to the meeting point and to the bin, takes the right time,
    /// and stays within its reach and on the belt.
    pub(super) fn check_way(&self, problems: &mut Vec<Problem>) {
        let pick = self.pick;
        let bin = self.check_bin(problems);
        if !has_possible_times(pick, self.checked.terms.tolerance, problems) {
            return;
        }
        self.check_travel(problems);
        if let Some(bin) = bin {
            self.check_return(bin, problems);
        }
        if self.has_place() {
            self.check_place(problems);
        }
    }

    /// The least time [s] by which times and positions must be allowed to be off, so that a move over
    /// this distance [m] may take this time [s]: both its ends in time, and its end at the item by as
    /// far as the belt moves meanwhile.
    fn tolerance_for(&self, distance: f64, taken: f64) -> f64 {
        let shift = self.checked.station.belt().speed;
        let needed = move_time(self.robot, distance);
        let is_explained = |off: f64| match taken > needed {
            true => move_time(self.robot, distance + shift * off) + 2.0 * off >= taken,
            false => move_time(self.robot, (distance - shift * off).max(0.0)) - 2.0 * off <= taken,
        };
        // With this much the times alone explain it.
        let (mut low, mut high) = (0.0, 0.5 * (taken - needed).abs());
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            match is_explained(middle) {
                true => high = middle,
                false => low = middle,
            }
        }
        high
    }

    fn check_travel(&self, problems: &mut Vec<Problem>) {
        let (robot, pick) = (self.robot, self.pick);
        let from = self.from.filter(|_| self.has_place());
        let Some(from) = from else {
            check_way_out(pick, self.checked.terms.tolerance, problems);
            return;
        };
        let rounding = self.rounding();
        let out = nalgebra::distance(&pick.meet, &from);
        let taken = pick.grasp - pick.decide;
        let gap = match robot.arm.constant_speed() {
            Some(speed) => Self::gap(out, speed * taken, rounding),
            None => Self::gap(move_time(robot, out), taken, self.in_time(rounding)),
        };
        self.check_time(
            gap,
            (out, taken),
            ViolationKind::TravelTime,
            problems,
            || {
                if taken < 0.0 {
                    return grasps_before_leaving(pick);
                }
                format!(
                    "travelling {} m does not take {} s, but {} s",
                    digits(out),
                    digits(taken),
                    digits(move_time(robot, out)),
                )
            },
        );
    }

    fn check_return(&self, bin: &Bin, problems: &mut Vec<Problem>) {
        let (robot, pick) = (self.robot, self.pick);
        let still = robot.grasp_time + bin.release_time;
        if !self.has_place() {
            check_way_back(pick, still, self.checked.terms.tolerance, problems);
            return;
        }
        let rounding = self.rounding();
        let back = nalgebra::distance(&pick.meet, &bin.at);
        let home = pick.grasp + still + move_time(robot, back);
        let gap = match robot.arm.constant_speed() {
            Some(_) => Self::gap(pick.release, home, rounding),
            None => Self::gap(pick.release, home, self.in_time(rounding)),
        };
        let taken = pick.release - pick.grasp - still;
        self.check_time(
            gap,
            (back, taken),
            ViolationKind::ReturnTime,
            problems,
            || {
                if pick.release < pick.grasp {
                    return releases_before_grasping(pick);
                }
                format!(
                    "it returns at {} s, not {} s",
                    digits(home),
                    digits(pick.release)
                )
            },
        );
    }

    /// Reports a move over a distance [m] in a time [s] that differ by this gap [m or s] beyond
    /// rounding, unless that is within the tolerance.
    fn check_time(
        &self,
        gap: f64,
        (distance, taken): (f64, f64),
        kind: ViolationKind,
        problems: &mut Vec<Problem>,
        text: impl FnOnce() -> String,
    ) {
        if gap == 0.0 {
            return;
        }
        let tolerance = self.tolerance_for(distance, taken);
        if self.exceeds(tolerance) {
            problems.push(Problem::off(kind, tolerance, text()));
        }
    }

    /// The most that a path takes longer if it is longer by this [m]: T is less steep than 1 / v.
    fn in_time(&self, length: f64) -> f64 {
        length / self.checked.station.belt().speed
    }

    fn check_place(&self, problems: &mut Vec<Problem>) {
        let (robot, pick) = (self.robot, self.pick);
        let belt = self.checked.station.belt();
        let rounding = self.rounding();
        let off_base = nalgebra::distance(&pick.meet, &robot.base);
        if off_base > robot.reach + rounding {
            self.push_off(
                ViolationKind::Reach,
                off_base - robot.reach,
                problems,
                || {
                    format!(
                        "its meeting point is {} m from the base, beyond its reach of {} m",
                        digits(off_base),
                        robot.reach
                    )
                },
            );
        }
        let x = pick.meet.x;
        if x < -rounding || x > belt.length + rounding {
            let off_belt = (-x).max(x - belt.length);
            self.push_off(ViolationKind::OffBelt, off_belt, problems, || {
                format!("its meeting point at x = {} m is off the belt", digits(x))
            });
        }
    }

    /// Reports a position that is off by `length` [m], more than rounding, unless it is as far as
    /// the belt moves in the time by which times may be off.
    fn push_off(
        &self,
        kind: ViolationKind,
        length: f64,
        problems: &mut Vec<Problem>,
        text: impl FnOnce() -> String,
    ) {
        let tolerance = self.in_time(length);
        if self.exceeds(tolerance) {
            problems.push(Problem::off(kind, tolerance, text()));
        }
    }

    /// Whether the robot grasps where the item is.
    pub(super) fn check_meeting(&self, problems: &mut Vec<Problem>) {
        let (Some(item), pick) = (self.item, self.pick) else {
            return;
        };
        let at_grasp = item.x0 + self.checked.station.belt().speed * pick.grasp;
        let rounding = self.rounding();
        let off_x = Self::gap(pick.meet.x, at_grasp, rounding);
        let off_y = Self::gap(pick.meet.y, item.y, rounding);
        // Unlike `max`, this keeps what is no number.
        let farther = if off_x >= off_y { off_x } else { off_y };
        let off = if off_x.is_nan() { off_x } else { farther };
        if self.exceeds(self.in_time(off)) {
            problems.push(Problem::off(
                ViolationKind::Meeting,
                self.in_time(off),
                format!(
                    "it grasps at ({}, {}) while the item is at ({}, {})",
                    digits(pick.meet.x),
                    digits(pick.meet.y),
                    digits(at_grasp),
                    item.y
                ),
            ));
        }
    }

    /// Whether the item has passed the camera, and whether it is time for a decision, when the robot
    /// leaves.
    pub(super) fn check_conditions(&self, problems: &mut Vec<Problem>) {
        let (terms, decide) = (self.checked.terms, self.pick.decide);
        if let Some((camera, item)) = terms.camera_x.zip(self.item) {
            let seen = (camera - item.x0) / self.checked.station.belt().speed;
            let early = seen - decide;
            if early > slack(seen) + terms.tolerance {
                let text = format!("the item passes the camera only at {} s", digits(seen));
                problems.push(Problem::off(ViolationKind::Unseen, early, text));
            }
        }
        if terms.update_hz > 0.0 {
            let update = (decide * terms.update_hz).round() / terms.update_hz;
            let off = (decide - update).abs();
            if off > slack(decide) + terms.tolerance {
                let text = format!(
                    "it leaves at {} s, but the nearest update is at {} s",
                    digits(decide),
                    digits(update)
                );
                problems.push(Problem::off(ViolationKind::OffBeat, off, text));
            }
        }
    }

    /// Whether an attempt that found nothing could have met the item at its true position.
    pub(super) fn check_vanity(&self, problems: &mut Vec<Problem>) {
        let Self {
            robot,
            item,
            pick,
            from,
            ..
        } = *self;
        let (Some(from), Some(item)) = (from, item) else {
            return;
        };
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
        if inside > self.rounding() {
            self.push_off(ViolationKind::Vain, inside, problems, || {
                format!(
                    "it found nothing, but it could have met the item at ({}, {})",
                    digits(meet.x),
                    digits(meet.y)
                )
            });
        }
    }
}
