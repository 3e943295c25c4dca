//! When robots are free again: the durations of picks, forwards and backwards.

use crate::decision::{Candidate, Moment};
use crate::kinematics;
use crate::station::{Belt, ClassId, Robot};

/// One item for one robot.
#[derive(Debug, Clone, Copy)]
pub(super) struct ItemReach {
    /// Position along the travel at time 0 [m].
    pub x0: f64,
    /// Position across the belt [m].
    pub y: f64,
    /// The bin that it goes into, which is where the arm is then.
    pub bin: u16,
    /// First departure that meets it, from any place [s]; infinite if there is none.
    pub open: f64,
    /// Last departure that meets it, from any place [s]; minus infinity if there is none.
    pub close: f64,
    /// Shortest possible duration of picking it [s].
    pub shortest: f64,
}

/// One robot, and where it is.
#[derive(Debug, Clone)]
pub(super) struct RobotTiming {
    pub(super) robot: Robot,
    /// Where the arm is when it is free.
    pub(super) place: u16,
    /// Number of places.
    pub(super) places: usize,
    /// Position along the belt of the only place, speed and dwell times, of a robot that is
    /// [plain](Robot::is_plain).
    plain: Option<PlainTiming>,
    belt: Belt,
}

#[derive(Debug, Clone, Copy)]
struct PlainTiming {
    bin_x: f64,
    bin_y: f64,
    speed: f64,
    grasp: f64,
    release: f64,
}

impl RobotTiming {
    pub(super) fn of(robot: &Robot, belt: &Belt) -> Self {
        let bin = &robot.bins[0];
        let speed = robot.arm.constant_speed().filter(|_| robot.places() == 1);
        Self {
            robot: robot.clone(),
            place: 0,
            belt: *belt,
            places: robot.places(),
            plain: speed.map(|speed| PlainTiming {
                bin_x: bin.at.x,
                bin_y: bin.at.y,
                speed,
                grasp: robot.grasp_time,
                release: bin.release_time,
            }),
        }
    }

    /// The belt is this one from now on.
    pub(super) fn put_on(&mut self, belt: &Belt) {
        self.belt = *belt;
    }

    /// When the robot is free again if it leaves `from` for the item at `start` [s].
    #[inline(always)]
    pub(super) fn finish(&self, from: u16, reach: &ItemReach, start: f64) -> f64 {
        let Some(plain) = &self.plain else {
            return self.general_finish(from, reach, start);
        };
        let dx = reach.x0 + self.belt.speed * start - plain.bin_x;
        let dy = reach.y - plain.bin_y;
        let travel = kinematics::travel_time(dx, dy, self.belt.speed, plain.speed);
        start + kinematics::processing_time(travel, plain.grasp, plain.release)
    }

    fn general_finish(&self, from: u16, reach: &ItemReach, start: f64) -> f64 {
        let moment = Moment::at(&self.robot, &self.belt, usize::from(from), start);
        start + moment.processing_time(&reach.candidate())
    }

    /// The shortest possible duration of picking an item [s].
    pub(super) fn shortest(&self, reach: &ItemReach) -> f64 {
        let Some(plain) = &self.plain else {
            return self.general_shortest(reach);
        };
        // The travel time of [`kinematics::travel_time`] is shortest where its derivative along the
        // belt is zero, `dx = -|dy| v / u`, and increases on both sides.
        let dx = -(reach.y - plain.bin_y).abs() * self.belt.speed / plain.speed;
        let at = (dx + plain.bin_x - reach.x0) / self.belt.speed;
        let at = at.clamp(reach.open, reach.close);
        self.finish(0, reach, at) - at
    }

    /// The same for any robot: over its places, the least of the durations with a meeting point
    /// opposite the place, opposite the bin, or half-way.
    fn general_shortest(&self, reach: &ItemReach) -> f64 {
        let robot = &self.robot;
        let bin = &robot.bins[usize::from(reach.bin)];
        let (base, length) = (robot.base, self.belt.length);
        let range = kinematics::meeting_range(base.x, base.y, robot.reach, reach.y, length);
        let Some((first, last)) = range else {
            return f64::INFINITY;
        };
        let way =
            |x: f64, to: nalgebra::Point2<f64>| kinematics::distance(x - to.x, reach.y - to.y);
        let mut least = f64::INFINITY;
        for place in 0..self.places {
            let from = robot.place(place);
            for x in [from.x, bin.at.x, f64::midpoint(from.x, bin.at.x)] {
                let x = x.clamp(first, last);
                let travel = robot.arm.time(way(x, from)) + robot.arm.time(way(x, bin.at));
                least = least.min(travel);
            }
        }
        least + robot.grasp_time + bin.release_time
    }

    /// The last departure from `from`, in its window for the item [s], at which the robot is free
    /// again by `deadline` [s]. This is the inverse of [`RobotTiming::finish`], which increases with the departure
    /// because the arm is faster than the belt.
    #[inline(always)]
    pub(super) fn latest_start(
        &self,
        from: u16,
        reach: &ItemReach,
        window: (f64, f64),
        deadline: f64,
    ) -> f64 {
        let Some(plain) = &self.plain else {
            return self.general_latest_start(from, reach, window, deadline);
        };
        // Backwards in time the belt moves the other way, so the way back has the meeting point's
        // closed form with -v.
        let lifted = deadline - plain.grasp - plain.release;
        let dx = reach.x0 + self.belt.speed * lifted - plain.bin_x;
        let dy = reach.y - plain.bin_y;
        let travel = kinematics::travel_time(dx, dy, -self.belt.speed, plain.speed);
        lifted - 2.0 * travel
    }

    /// The same for any robot, by the secant method inside a bracket (Illinois variant: Dowell and
    /// Jarratt 1971, DOI 10.1007/BF01934364). Errs on the early side.
    fn general_latest_start(
        &self,
        from: u16,
        reach: &ItemReach,
        (open, close): (f64, f64),
        deadline: f64,
    ) -> f64 {
        /// Accuracy [s]; the plan is checked again with exact times.
        const CLOSE: f64 = 1e-9;
        if open > close {
            return f64::NEG_INFINITY;
        }
        let late = |start: f64| self.general_finish(from, reach, start) - deadline;
        let (mut low, mut high) = (open, close);
        let (mut below, mut above) = (late(low), late(high));
        if above <= 0.0 {
            return close;
        }
        if below > 0.0 {
            return f64::NEG_INFINITY;
        }
        // The weights of the ends; the one of an end that stays twice in a row is halved.
        let mut kept = None;
        for _ in 0..100 {
            if high - low <= CLOSE {
                break;
            }
            let at = low + (high - low) * (below / (below - above));
            let value = late(at);
            let is_late = value > 0.0;
            if is_late {
                (high, above) = (at, value);
                below *= if kept == Some(is_late) { 0.5 } else { 1.0 };
            } else {
                (low, below) = (at, value);
                above *= if kept == Some(is_late) { 0.5 } else { 1.0 };
                if value >= -CLOSE {
                    break;
                }
            }
            kept = Some(is_late);
        }
        low
    }
}

impl ItemReach {
    /// As the candidate of its robot; only the position and the bin are of use.
    fn candidate(&self) -> Candidate {
        Candidate {
            item: 0,
            bin: self.bin,
            class: ClassId::OTHER,
            x0: self.x0,
            y: self.y,
            weight: 0.0,
            open: self.open,
            close: self.close,
        }
    }
}
