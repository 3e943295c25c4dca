//! The smallest distance between two arms over a whole run, in continuous time.

use super::segment::{Nearest, Segment};
use crate::decision::{Outcome, Pick};
use crate::kinematics::Arm;
use crate::station::{Robot, Station};
use nalgebra::Point2;

/// Maximum difference between the reported distance and the true minimum [m].
pub const TOLERANCE: f64 = 1e-4;

/// The moment in a run at which two arms are closest to each other.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Clearance {
    /// Distance between the arms [m]; 0 if they cross.
    pub distance: f64,
    /// The time of this moment [s].
    pub time: f64,
    /// Indices of the two robots, upstream first.
    pub robots: [usize; 2],
    /// The nearest point on each arm [m].
    pub points: [Point2<f64>; 2],
}

/// The smallest distance between the arms of any two robots in the run `outcome`, to within
/// [`TOLERANCE`], in continuous time; `None` for a single robot.
///
/// A tool point leaves its place at the decision, moves on a straight line to the meeting point, stays
/// there during the grasp, and moves on a straight line to the bin. Between two turning points the
/// distance between the arms therefore changes by at most the sum of the lengths that the tool points
/// travel. The search bisects a time interval until this Lipschitz bound shows that it contains no
/// smaller distance (Piyavskii 1972, doi:10.1016/0041-5553(72)90115-2; Shubert 1972,
/// doi:10.1137/0709036).
pub fn smallest(station: &Station, outcome: &Outcome) -> Option<Clearance> {
    let robots = station.robots();
    let ways: Vec<Way> = (0..robots.len())
        .map(|i| Way::of(i, station, outcome))
        .collect();
    let mut best: Option<Clearance> = None;
    for first in 0..robots.len() {
        for second in first + 1..robots.len() {
            let pair = Pair {
                robots: [first, second],
                bases: [robots[first].base, robots[second].base],
            };
            let bases = (pair.bases[0] - pair.bases[1]).norm();
            let apart = bases - ways[first].furthest - ways[second].furthest;
            if best.is_none_or(|best| apart < best.distance - TOLERANCE) {
                pair.search([&ways[first], &ways[second]], &mut best);
            }
        }
    }
    best
}

/// The path of a tool point from turning point to turning point.
struct Way<'a> {
    arm: &'a Arm,
    /// Times [s] in order, with the position of the tool point at each [m].
    turns: Vec<(f64, Point2<f64>)>,
    /// Maximum distance of the tool point from its base [m].
    furthest: f64,
}

impl<'a> Way<'a> {
    fn of(index: usize, station: &'a Station, outcome: &Outcome) -> Self {
        let robot: &Robot = &station.robots()[index];
        let failed = outcome.failures.iter().map(|failure| &failure.attempt);
        let own = outcome.picks.iter().chain(failed);
        let mut trips: Vec<&Pick> = own.filter(|trip| trip.robot == index).collect();
        trips.sort_by(|a, b| a.decide.total_cmp(&b.decide));
        let mut turns = vec![(0.0, robot.rest)];
        let mut place = robot.rest;
        for trip in trips {
            let bin = &robot.bins[usize::from(trip.bin)];
            let leaves = trip.grasp + robot.grasp_time;
            let home = (trip.release - bin.release_time).max(leaves);
            turns.extend([
                (trip.decide, place),
                (trip.grasp, trip.meet),
                (leaves, trip.meet),
                (home, bin.at),
            ]);
            place = bin.at;
        }
        let away = turns.iter().map(|(_, tool)| (tool - robot.base).norm());
        Self {
            arm: &robot.arm,
            furthest: away.fold(0.0, f64::max),
            turns,
        }
    }

    /// The time of this turn [s]; infinity if there is no such turn.
    fn time(&self, turn: usize) -> f64 {
        self.turns.get(turn).map_or(f64::INFINITY, |turn| turn.0)
    }

    /// Position of the tool point at `time` [s]. `next`, the first turn not yet passed, is advanced
    /// to the first turn after `time`.
    fn pass(&self, time: f64, next: &mut usize) -> Point2<f64> {
        while self.time(*next) <= time {
            *next += 1;
        }
        let (before, from) = self.turns[*next - 1];
        match self.turns.get(*next) {
            Some(&(after, to)) => {
                let share = match self.arm.constant_speed() {
                    Some(_) => (time - before) / (after - before),
                    None => {
                        let way = (to - from).norm();
                        self.arm.progress(way, time - before, after - before)
                    }
                };
                from + (to - from) * share
            }
            None => from,
        }
    }

    /// Position at `time` [s], between the turns around `next`.
    fn at(&self, time: f64, next: usize) -> Point2<f64> {
        self.pass(time, &mut { next })
    }
}

/// Where the tool points are at a time [s] between two moments.
type Middle<'a> = &'a dyn Fn(f64, &ArmsAt, &ArmsAt) -> [Point2<f64>; 2];

/// A pair of robots.
struct Pair {
    robots: [usize; 2],
    bases: [Point2<f64>; 2],
}

/// The two arms at one moment.
#[derive(Clone, Copy)]
struct ArmsAt {
    time: f64,
    tools: [Point2<f64>; 2],
    nearest: Nearest,
}

impl Pair {
    fn moment(&self, time: f64, tools: [Point2<f64>; 2]) -> ArmsAt {
        let arm = |i: usize| Segment {
            from: self.bases[i],
            to: tools[i],
        };
        ArmsAt {
            time,
            tools,
            nearest: arm(0).nearest(&arm(1)),
        }
    }

    /// Visits the turns of both arms in order of time.
    fn search(&self, ways: [&Way; 2], best: &mut Option<Clearance>) {
        let mut next = [1, 1];
        let mut last = self.moment(0.0, ways.map(|way| way.turns[0].1));
        self.note(&last, best);
        loop {
            let own = [0, 1].map(|i| ways[i].time(next[i]));
            let time = own[0].min(own[1]);
            if time == f64::INFINITY {
                return;
            }
            let between = next;
            let tools = [0, 1].map(|i| ways[i].pass(time, &mut next[i]));
            let moment = self.moment(time, tools);
            let uniform = ways.iter().all(|way| way.arm.constant_speed().is_some());
            if uniform {
                let middle = |_, from: &ArmsAt, to: &ArmsAt| {
                    [0, 1].map(|i| nalgebra::center(&from.tools[i], &to.tools[i]))
                };
                self.halve(&last, &moment, &middle, best);
            } else {
                let middle =
                    |time, _: &ArmsAt, _: &ArmsAt| [0, 1].map(|i| ways[i].at(time, between[i]));
                self.halve(&last, &moment, &middle, best);
            }
            self.note(&moment, best);
            last = moment;
        }
    }

    /// Searches between two moments between which both tool points move on straight lines. `middle`
    /// gives the tool points at a time [s] between two moments, half-way if they move uniformly.
    fn halve(&self, from: &ArmsAt, to: &ArmsAt, middle: Middle, best: &mut Option<Clearance>) {
        let least = best.map_or(f64::INFINITY, |best| best.distance);
        let moved: f64 = (0..2).map(|i| (to.tools[i] - from.tools[i]).norm()).sum();
        let bound = 0.5 * (from.nearest.distance + to.nearest.distance - moved);
        if bound.max(0.0) >= least - TOLERANCE {
            return;
        }
        let time = f64::midpoint(from.time, to.time);
        if time <= from.time || time >= to.time {
            return;
        }
        let moment = self.moment(time, middle(time, from, to));
        // Search the earlier half first, so that on a tie the earlier moment is reported.
        self.halve(from, &moment, middle, best);
        self.note(&moment, best);
        self.halve(&moment, to, middle, best);
    }

    fn note(&self, moment: &ArmsAt, best: &mut Option<Clearance>) {
        if best.is_none_or(|best| moment.nearest.distance < best.distance) {
            *best = Some(Clearance {
                distance: moment.nearest.distance,
                time: moment.time,
                robots: self.robots,
                points: moment.nearest.points,
            });
        }
    }
}
