//! A recorded move of an arm, and what is implausible about many of them.

use super::model::{Leg, Observation};
use super::robust::median;
use crate::error::{Error, Result, rounded};
use crate::kinematics::{Encounter, distance};
use crate::station::Robot;
use nalgebra::Point2;
use std::collections::HashSet;

/// An item that an arm has met at an unknown time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Chased {
    /// Speed of the belt meanwhile [m/s].
    pub belt_speed: f64,
    /// Length of the belt [m].
    pub belt_length: f64,
}

impl Chased {
    /// An item on a belt of this speed [m/s] and length [m].
    pub fn new(belt_speed: f64, belt_length: f64) -> Self {
        Self {
            belt_speed,
            belt_length,
        }
    }
}

/// One recorded move of an arm, from a place to an item and on to a bin. What is not known is `None`.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct TimedMove {
    /// Index of the robot.
    pub robot: usize,
    /// Line of the file, or number of the task, that it comes from.
    pub line: u64,
    /// Where the arm was before [m].
    pub from: Point2<f64>,
    /// Where it met the item, or, if the item is `chased`, where that was at the departure [m].
    pub meet: Point2<f64>,
    /// When it left [s].
    pub depart: Option<f64>,
    /// Start of the grasp [s].
    pub grasp: Option<f64>,
    /// Where it released the item [m].
    pub bin: Option<Point2<f64>>,
    /// When the item was in the bin [s].
    pub release: Option<f64>,
    /// The belt, if the time of the grasp is unknown and the item moved on until then.
    pub chased: Option<Chased>,
    /// End of a grasp that failed [s].
    pub failed: Option<f64>,
}

impl TimedMove {
    /// A move of the robot with this index from `from` to `meet` [m], without times.
    pub fn new(robot: usize, line: u64, from: Point2<f64>, meet: Point2<f64>) -> Self {
        Self {
            robot,
            line,
            from,
            meet,
            depart: None,
            grasp: None,
            bin: None,
            release: None,
            chased: None,
            failed: None,
        }
    }

    /// Its measured times; `row` is its index among the moves of `robot`.
    pub(super) fn observations(&self, robot: &Robot, row: usize) -> Vec<Observation> {
        let out = nalgebra::distance(&self.from, &self.meet);
        let home = self
            .bin
            .map(|at| (nalgebra::distance(&self.meet, &at), nearest_bin(robot, at)));
        let mut list = Vec::new();
        let mut push = |leg: Leg, begin: Option<f64>, end: Option<f64>| {
            if let Some((begin, end)) = begin.zip(end) {
                let time = end - begin;
                list.push(Observation { row, leg, time });
            }
        };
        if let Some(belt) = &self.chased {
            let item = self.encounter(belt);
            push(Leg::Chase(item), self.depart, self.failed);
            if let Some(at) = self.bin {
                let place = [at.x - self.from.x, at.y - self.from.y];
                let leg = Leg::ChaseHome(item, place, nearest_bin(robot, at));
                push(leg, self.depart, self.release);
            }
            return list;
        }
        push(Leg::Out(out), self.depart, self.grasp);
        if let Some((back, bin)) = home {
            match self.grasp {
                Some(grasp) => push(Leg::Back(back, bin), Some(grasp), self.release),
                None => push(Leg::Whole(out, back, bin), self.depart, self.release),
            }
        }
        list
    }

    fn encounter(&self, belt: &Chased) -> Encounter {
        Encounter {
            dx: self.meet.x - self.from.x,
            dy: self.meet.y - self.from.y,
            belt_speed: belt.belt_speed,
            upstream: -self.meet.x,
            downstream: belt.belt_length - self.meet.x,
        }
    }
}

/// The bin of `robot` that is nearest to `at` [m].
fn nearest_bin(robot: &Robot, at: Point2<f64>) -> usize {
    let off = |index: &usize| {
        let bin = robot.bins[*index].at;
        distance(bin.x - at.x, bin.y - at.y)
    };
    let bins = 0..robot.bins.len();
    bins.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(0)
}

/// `moves` of one robot without those that are there twice. An arm does not leave twice at one time, so
/// these are copies, of which the second tells nothing. Where all moves begin at the same time, the times
/// are durations, and equal ones are measured.
pub(super) fn without_copies(moves: Vec<TimedMove>) -> Vec<TimedMove> {
    let start = |m: &TimedMove| m.depart.or(m.grasp).map(f64::to_bits);
    let first = moves.first().and_then(start);
    if moves.iter().all(|m| start(m) == first) {
        return moves;
    }
    let key = |m: &TimedMove| {
        let places = [Some(m.from), Some(m.meet), m.bin];
        let places = places.map(|at| at.map(|at| [at.x.to_bits(), at.y.to_bits()]));
        let times = [m.depart, m.grasp, m.release, m.failed];
        (places, times.map(|time| time.map(f64::to_bits)))
    };
    let mut known = HashSet::new();
    let kept = moves.into_iter().filter(|m| known.insert(key(m)));
    kept.collect()
}

/// Ways of a pick are not longer than this [m], nor times than this [s].
const LONGEST_WAY: f64 = 20.0;
const LONGEST_TIME: f64 = 60.0;

/// Checks that places are in metres and times in seconds, by their medians.
///
/// # Errors
/// Medians that no arm has.
pub(super) fn check_units(moves: &[TimedMove]) -> Result<()> {
    let ways = moves.iter().map(|m| nalgebra::distance(&m.from, &m.meet));
    let way = median(ways.collect());
    if way > LONGEST_WAY {
        return Err(Error::input(
            "moves",
            format!(
                "half of the ways to an item are longer than {} m",
                rounded(way, 3)
            ),
            "give metres; if these are millimetres, name the columns from_x_mm, from_y_mm and so on",
        ));
    }
    let times = moves.iter().filter_map(|m| {
        let end = m.release.or(m.failed).or(m.grasp)?;
        Some(end - m.depart.or(m.grasp)?)
    });
    let times: Vec<f64> = times.filter(|time| *time > 0.0).collect();
    let time = median(times);
    if time > LONGEST_TIME {
        return Err(Error::input(
            "moves",
            format!("half of them take longer than {} s", rounded(time, 3)),
            "give seconds; if these are milliseconds, name the columns depart_ms, grasp_ms and \
             release_ms",
        ));
    }
    Ok(())
}
