//! Checks that the node and the line have the same station.
//!
//! Both are started by hand, each with a station file. If the files differ, tasks are for unknown
//! robots or for places that robots cannot reach, and nothing is picked. That is an error, not a
//! result.

use super::protocol::{Rejection, Status, Task};
use pickline::error::{Error, Result, shown};
use pickline::files::fingerprint;
use pickline::station::{Bin, Station, to_toml};

/// Bins further apart than this are different bins [m].
const SAME_PLACE: f64 = 1e-3;

/// A hash of the layout of `station`: of everything but the belt's speed, which the line itself
/// reports.
pub(crate) fn layout_hash(station: &Station) -> String {
    // Any fixed speed below that of every arm will do.
    const SPEED: f64 = 1e-6;
    let still = station.with_belt_speed(SPEED);
    fingerprint(to_toml(still.as_ref().unwrap_or(station)))
}

/// Checks that the node which sends `status` runs `station`.
///
/// # Errors
/// The node has another station.
pub fn check_status(station: &Station, status: &Status) -> Result<()> {
    let own: Vec<&str> = station.robots().iter().map(|r| r.name.as_str()).collect();
    let theirs: Vec<&str> = status.robots.iter().map(|r| r.name.as_str()).collect();
    if own != theirs {
        return Err(another(&format!(
            "the node's robots are {}, this station's are {}",
            quoted_names(&theirs),
            quoted_names(&own)
        )));
    }
    match &status.layout {
        Some(layout) if *layout != layout_hash(station) => Err(another(
            "the robots have the same names, but the belt's size or the robots' positions, \
             reaches, speeds or dwell times differ",
        )),
        _ => Ok(()),
    }
}

/// Checks that `task` can be for a robot of `station`.
///
/// # Errors
/// The task is from a node with another station.
pub fn check_task(station: &Station, task: &Task) -> Result<()> {
    let robot = station.robots().iter().find(|r| r.name == task.robot);
    let Some(robot) = robot else {
        return Err(another(&format!(
            "the node sent a task for `{}`, which is not a robot of this station",
            shown(&task.robot)
        )));
    };
    let away = |bin: &Bin| (bin.at.x - task.bin.x).hypot(bin.at.y - task.bin.y);
    if robot.bins.iter().any(|bin| away(bin) <= SAME_PLACE) {
        return Ok(());
    }
    let own = robot.bins.iter();
    let own: Vec<String> = own
        .map(|bin| format!("({}, {})", bin.at.x, bin.at.y))
        .collect();
    Err(another(&format!(
        "the node has the bin of `{}` at ({}, {}) m, this station has it at {} m",
        shown(&robot.name),
        task.bin.x,
        task.bin.y,
        own.join(" or ")
    )))
}

/// Checks, at the end of a run of `station` with the last `status`, that at least one of its robots
/// was heard if any robot was.
///
/// # Errors
/// Only robots with other names were heard.
pub(crate) fn check_heard(station: &Station, status: &Status) -> Result<()> {
    let strangers = status.rejected.get(Rejection::UnknownRobot.name());
    let silent = status.robots.iter().all(|robot| robot.state == "unknown");
    if !silent || strangers.is_none() {
        return Ok(());
    }
    let own: Vec<&str> = station.robots().iter().map(|r| r.name.as_str()).collect();
    Err(another(&format!(
        "none of the robots that were heard is one of {}",
        quoted_names(&own)
    )))
}

fn quoted_names(names: &[&str]) -> String {
    const MOST: usize = 6;
    let some = names
        .iter()
        .take(MOST)
        .map(|name| format!("`{}`", shown(name)));
    let mut text = some.collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        text += &format!(" and {} more", names.len() - MOST);
    }
    text
}

fn another(problem: &str) -> Error {
    Error::usage(
        "'station'",
        format!("the node and the line have different stations: {problem}"),
        "start both with the same 'station' and 'robots'",
    )
}
