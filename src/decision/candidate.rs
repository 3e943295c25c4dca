//! An item from the view of one robot.

use crate::kinematics::{self, Encounter};
use crate::station::{Belt, ClassId, Robot, Station};
use nalgebra::Point2;

/// An item that a robot can still reach, with its departure window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Index of the item in its pattern (furthest downstream first).
    pub item: u32,
    /// The bin of the robot that it goes into.
    pub bin: u16,
    /// Its class on the station.
    pub class: ClassId,
    /// Position along the travel at time 0, as reported [m].
    pub x0: f64,
    /// Position across the belt, as reported [m].
    pub y: f64,
    /// Object-specific reward r of the item, 0 or more.
    pub weight: f64,
    /// First departure time at which the robot, from where it is now, meets it in its workspace once
    /// it knows of the item [s].
    pub open: f64,
    /// Last such departure time [s].
    pub close: f64,
}

impl Candidate {
    /// Whether this item is further downstream than `other`; on a tie, whether its index is lower.
    #[inline(always)]
    pub fn is_before(&self, other: &Self) -> bool {
        self.x0 > other.x0 || (self.x0 == other.x0 && self.item < other.item)
    }
}

/// Share by which bounds of times are wider than they would have to be without rounding.
const ROUNDING: f64 = 1e-9;

/// A robot that is about to decide, where it is, and the time: what is needed to compute the figures
/// of a [`Candidate`].
///
/// Figures are computed on demand, so a rule only pays for those that it uses.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// The robot that chooses among the candidates.
    pub robot: &'a Robot,
    /// Where its arm is: a bin, or its rest [m].
    pub from: Point2<f64>,
    /// Belt speed [m/s].
    pub belt_speed: f64,
    /// Belt length [m].
    pub belt_length: f64,
    /// Time of the decision [s].
    pub time: f64,
    /// The way out and back, if it is the same line at constant speed for all candidates.
    shuttle: Option<Shuttle>,
}

/// An arm at constant speed that leaves its only bin and returns there. A copy of its figures, because
/// rules compute them for every candidate.
#[derive(Debug, Clone, Copy)]
struct Shuttle {
    /// Speed of the arm [m/s].
    speed: f64,
    /// Duration of a grasp [s].
    grasp_time: f64,
    /// Duration of a release [s].
    release_time: f64,
}

impl Shuttle {
    /// That of a robot whose arm is at `from` [m].
    #[inline]
    fn of(robot: &Robot, from: Point2<f64>) -> Option<Self> {
        let [bin] = &robot.bins[..] else {
            return None;
        };
        let speed = robot.arm.constant_speed().filter(|_| bin.at == from)?;
        Some(Self {
            speed,
            grasp_time: robot.grasp_time,
            release_time: bin.release_time,
        })
    }
}

impl<'a> Moment<'a> {
    /// Robot `index` of `station`, whose arm is at its place `place` ([`Robot::place`]) and which
    /// decides at `time` [s].
    #[inline]
    pub fn new(station: &'a Station, index: usize, place: usize, time: f64) -> Self {
        Self::at(&station.robots()[index], station.belt(), place, time)
    }

    /// A robot at this belt, whose arm is at its place `place` ([`Robot::place`]) and which decides at
    /// `time` [s].
    #[inline]
    pub fn at(robot: &'a Robot, belt: &Belt, place: usize, time: f64) -> Self {
        let from = robot.place(place);
        Self {
            robot,
            from,
            belt_speed: belt.speed,
            belt_length: belt.length,
            time,
            shuttle: Shuttle::of(robot, from),
        }
    }

    /// The same with the arm at another place ([`Robot::place`]).
    pub(crate) fn with_place(self, place: usize) -> Self {
        let from = self.robot.place(place);
        Self {
            from,
            shuttle: Shuttle::of(self.robot, from),
            ..self
        }
    }

    /// Current position of the item along the travel [m].
    #[inline(always)]
    pub fn x(&self, candidate: &Candidate) -> f64 {
        candidate.x0 + self.belt_speed * self.time
    }

    /// Time from where the arm is to the meeting point [s].
    #[inline(always)]
    pub fn travel_time(&self, candidate: &Candidate) -> f64 {
        let x = self.x(candidate);
        if let Some(shuttle) = &self.shuttle {
            let (dx, dy) = (x - self.from.x, candidate.y - self.from.y);
            return kinematics::travel_time(dx, dy, self.belt_speed, shuttle.speed);
        }
        self.robot.arm.travel_time(&Encounter {
            dx: x - self.from.x,
            dy: candidate.y - self.from.y,
            belt_speed: self.belt_speed,
            upstream: -x,
            downstream: self.belt_length - x,
        })
    }

    /// Total time of the pick, until the item is in its bin and the robot is free again [s].
    #[inline(always)]
    pub fn processing_time(&self, candidate: &Candidate) -> f64 {
        self.pick_time(candidate, self.travel_time(candidate))
    }

    /// A time [s] that [`Moment::processing_time`] is not below, if one costs much less: for an arm that
    /// accelerates. Otherwise negative infinity.
    #[inline(always)]
    pub fn least_processing_time(&self, candidate: &Candidate) -> f64 {
        let bound = |dx: f64, dy: f64, off_bin: (f64, f64)| {
            let arm = &self.robot.arm;
            let (travel, way) = arm.least_travel_time(dx, dy, self.belt_speed)?;
            // Elsewhere, the bin is at least as far as it is across the belt.
            let back = if off_bin == (0.0, 0.0) {
                way
            } else {
                (dy - off_bin.1).abs()
            };
            Some((1.0 - ROUNDING) * (travel + arm.time(back)))
        };
        self.bounded(candidate, bound).unwrap_or(f64::NEG_INFINITY)
    }

    /// A time [s] that [`Moment::processing_time`] does not exceed, likewise. Otherwise infinity.
    #[inline(always)]
    pub fn most_processing_time(&self, candidate: &Candidate) -> f64 {
        let bound = |dx: f64, dy: f64, off_bin: (f64, f64)| {
            let arm = &self.robot.arm;
            let (travel, way) = arm.most_travel_time(dx, dy, self.belt_speed)?;
            let farther = match off_bin == (0.0, 0.0) {
                true => 0.0,
                false => kinematics::distance(off_bin.0, off_bin.1),
            };
            Some((1.0 + ROUNDING) * (travel + arm.time(way + farther)))
        };
        self.bounded(candidate, bound).unwrap_or(f64::INFINITY)
    }

    /// A bound of the processing time [s] from one of the ways, which is given the item relative to the
    /// arm and the bin relative to the arm [m]; `None` where the time itself costs little.
    #[inline(always)]
    fn bounded(
        &self,
        candidate: &Candidate,
        ways: impl Fn(f64, f64, (f64, f64)) -> Option<f64>,
    ) -> Option<f64> {
        if self.shuttle.is_some() {
            return None;
        }
        let bin = &self.robot.bins[usize::from(candidate.bin)];
        let (dx, dy) = (self.x(candidate) - self.from.x, candidate.y - self.from.y);
        let off_bin = (bin.at.x - self.from.x, bin.at.y - self.from.y);
        let ways = ways(dx, dy, off_bin)?;
        Some(ways + self.robot.grasp_time + bin.release_time)
    }

    /// Like [`Moment::processing_time`], with the time `travel` [s] to the meeting point known.
    #[inline(always)]
    pub fn pick_time(&self, candidate: &Candidate, travel: f64) -> f64 {
        if let Some(shuttle) = &self.shuttle {
            let (grasp, release) = (shuttle.grasp_time, shuttle.release_time);
            return kinematics::processing_time(travel, grasp, release);
        }
        let robot = self.robot;
        let bin = &robot.bins[usize::from(candidate.bin)];
        if robot.arm.constant_speed().is_some() && bin.at == self.from {
            // Out and back along the same line.
            return kinematics::processing_time(travel, robot.grasp_time, bin.release_time);
        }
        let meet = self.x(candidate) + self.belt_speed * travel;
        let way = kinematics::distance(meet - bin.at.x, candidate.y - bin.at.y);
        travel + robot.grasp_time + robot.arm.time(way) + bin.release_time
    }

    /// Distance from the item's current position to the robot's base [m].
    #[inline(always)]
    pub fn distance_to_base(&self, candidate: &Candidate) -> f64 {
        kinematics::distance(
            self.x(candidate) - self.robot.base.x,
            candidate.y - self.robot.base.y,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::Arm;
    use nalgebra::Point2;

    fn candidate(item: u32, x0: f64) -> Candidate {
        Candidate {
            item,
            bin: 0,
            class: ClassId::OTHER,
            x0,
            y: 0.1,
            weight: 1.0,
            open: 0.0,
            close: 9.0,
        }
    }

    #[test]
    fn further_downstream_is_before_and_then_the_lower_index() {
        for (a, b, before) in [
            (candidate(1, 0.5), candidate(0, 0.4), true),
            (candidate(0, 0.4), candidate(1, 0.5), false),
            (candidate(0, 0.5), candidate(1, 0.5), true),
            (candidate(1, 0.5), candidate(0, 0.5), false),
            (candidate(1, 0.5), candidate(1, 0.5), false),
        ] {
            assert_eq!(a.is_before(&b), before, "{a:?} {b:?}");
        }
    }

    /// The figures that rules use, all with different numbers.
    #[test]
    fn a_moment_has_the_figures_of_its_robot_and_time() {
        let belt = Belt {
            speed: 0.1,
            length: 4.0,
            width: 1.0,
        };
        let robot = |x: f64, speed| {
            Robot::new(
                format!("r{x}"),
                Point2::new(x, -0.5),
                Point2::new(x + 0.2, -0.3),
                1.0,
                Arm::constant(speed),
            )
            .with_dwell(0.25, 0.5)
        };
        let station = Station::new(belt, vec![robot(1.0, 0.3), robot(2.0, 0.5)]).unwrap();
        let moment = Moment::new(&station, 1, 0, 10.0);
        assert_eq!((moment.robot.name.as_str(), moment.time), ("r2", 10.0));
        assert_eq!(moment.belt_speed, 0.1);
        // Now at (1.5, 0.1): 0.7 m upstream of the bin and 0.4 m to the side, k = 0.24.
        let item = candidate(3, 0.5);
        assert!((moment.x(&item) - 1.5).abs() < 1e-12);
        let tau = (0.1 * -0.7 + (0.01f64 * 0.49 + 0.24 * 0.65).sqrt()) / 0.24;
        assert!((moment.travel_time(&item) - tau).abs() < 1e-12);
        assert!((moment.processing_time(&item) - (2.0 * tau + 0.75)).abs() < 1e-12);
        // The base is 0.5 m downstream and 0.6 m to the side.
        let distance = 0.61f64.sqrt();
        assert!((moment.distance_to_base(&item) - distance).abs() < 1e-12);
    }
}
