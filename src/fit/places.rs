//! Whether the places of moves are those of the station.
//!
//! A law can be fitted to moves between any places. But a simulation of the station moves between the
//! station's, so moves from elsewhere mean another station, other axes or another unit.

use super::timed_move::TimedMove;
use crate::error::{Error, Result, counted, rounded, shown};
use crate::station::{Belt, Robot};
use nalgebra::{Point2, distance};

/// Places that are nearer than this are one [m]: stacks and trays spread releases by a few centimetres.
const SAME_PLACE: f64 = 0.05;

/// A place of a move that the station does not have: line or task, and what it is.
struct Stray {
    line: String,
    problem: String,
}

/// What is to be said about the places of the moves of `robot`.
///
/// # Errors
/// Not a single item was released into one of its bins, or met within its reach.
pub(super) fn check_places(robot: &Robot, belt: &Belt, moves: &[TimedMove]) -> Result<Vec<String>> {
    let releases: Vec<_> = moves.iter().filter(|m| m.bin.is_some()).collect();
    let misplaced: Vec<Stray> = releases.iter().filter_map(|m| released(robot, m)).collect();
    refuse(
        robot,
        &misplaced,
        releases.len(),
        "is at a bin of this robot",
    )?;
    // Where an item that moves on is met, is not recorded.
    let meetings: Vec<_> = moves.iter().filter(|m| m.chased.is_none()).collect();
    let beyond: Vec<Stray> = meetings
        .iter()
        .filter_map(|m| met(robot, belt, m))
        .collect();
    refuse(
        robot,
        &beyond,
        meetings.len(),
        "is met where this robot can",
    )?;
    let departures: Vec<Stray> = moves.iter().filter_map(|m| left(robot, m)).collect();
    let mut notes = Vec::new();
    let mut note = |strays: &[Stray], all: usize, things: &str, what: &str| {
        if let Some(first) = strays.first() {
            notes.push(format!(
                "{} of {all} {things} {what}; the first, {}, {}",
                strays.len(),
                first.line,
                first.problem
            ));
        }
    };
    note(
        &misplaced,
        releases.len(),
        "releases",
        "are at no bin of this robot, and count for the nearest: correct them, or the bins of the \
         station",
    );
    note(
        &beyond,
        meetings.len(),
        "items",
        "are met where this robot cannot by its station: correct them, or its base, its reach and the \
         belt",
    );
    note(
        &departures,
        moves.len(),
        "moves",
        "begin neither at a bin nor at the rest of this robot, where all simulated ones begin: correct \
         them, or the bins and the rest of the station",
    );
    Ok(notes)
}

/// Refuses moves all of which are strays.
fn refuse(robot: &Robot, strays: &[Stray], all: usize, expected: &str) -> Result<()> {
    match strays.first() {
        Some(first) if strays.len() == all => Err(Error::input(
            format!("robot `{}`: {}", shown(&robot.name), first.line),
            format!(
                "{}, and none of {} {expected}",
                first.problem,
                counted(all, "item")
            ),
            "give the station that these moves are of as 'station', or correct the places: x along the \
             belt from its upstream end, y across it from its middle, in metres",
        )),
        _ => Ok(()),
    }
}

/// The release of this move, if it is at no bin.
fn released(robot: &Robot, timed: &TimedMove) -> Option<Stray> {
    let at = timed.bin?;
    let off = |place: Point2<f64>| distance(&place, &at);
    let bins = robot.bins.iter();
    let nearest = bins.min_by(|a, b| off(a.at).total_cmp(&off(b.at)))?;
    (off(nearest.at) > SAME_PLACE).then(|| Stray {
        line: line_of(timed),
        problem: format!(
            "releases at {}, {} m from the nearest bin, `{}` at {}",
            point(at),
            rounded(off(nearest.at), 3),
            shown(&nearest.name),
            point(nearest.at)
        ),
    })
}

/// The meeting of this move, if the robot cannot be there or the belt is not.
fn met(robot: &Robot, belt: &Belt, timed: &TimedMove) -> Option<Stray> {
    let at = timed.meet;
    let way = distance(&robot.base, &at);
    let along = at.x - at.x.clamp(0.0, belt.length);
    let across = (at.y.abs() - 0.5 * belt.width).max(0.0);
    let problem = if along.hypot(across) > SAME_PLACE {
        format!(
            "meets its item at {}, {} m beside the belt, which is {} m long and {} m wide",
            point(at),
            rounded(along.hypot(across), 3),
            belt.length,
            belt.width
        )
    } else if way > robot.reach + SAME_PLACE {
        format!(
            "meets its item at {}, {} m from its base, but it reaches {} m",
            point(at),
            rounded(way, 3),
            robot.reach
        )
    } else {
        return None;
    };
    Some(Stray {
        line: line_of(timed),
        problem,
    })
}

/// The beginning of this move, if the arm never waits there.
fn left(robot: &Robot, timed: &TimedMove) -> Option<Stray> {
    let off = |index: usize| distance(&robot.place(index), &timed.from);
    let is_place = (0..robot.places()).any(|index| off(index) <= SAME_PLACE);
    (!is_place).then(|| Stray {
        line: line_of(timed),
        problem: format!("begins at {}", point(timed.from)),
    })
}

/// What a reader finds this move by.
fn line_of(timed: &TimedMove) -> String {
    let kind = match timed.chased {
        Some(_) => "task",
        None => "line",
    };
    format!("{kind} {}", timed.line)
}

fn point(at: Point2<f64>) -> String {
    format!("({}, {})", rounded(at.x, 4), rounded(at.y, 4))
}
