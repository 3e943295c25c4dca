//! Whether node and station speak of the same line.
//!
//! Both are started by hand, each with a station file. Where the files differ, tasks are
//! for robots that are not there or for places that they cannot reach, and nothing is
//! picked: that is an error, not a result.

use super::protocol::{Rejection, Status, Task};
use pickline::error::{Error, Result, shown};
use pickline::files::fingerprint;
use pickline::station::{Station, to_toml};

/// Bins further apart than this are two bins [m].
const SAME_PLACE: f64 = 1e-3;

/// Identifies the layout of `station`: everything but the speed of the belt, which the
/// line itself reports.
pub fn layout_hash(station: &Station) -> String {
    // Any speed does that every arm exceeds, as long as it is always the same.
    const SPEED: f64 = 1e-6;
    let still = station.with_belt_speed(SPEED);
    fingerprint(to_toml(still.as_ref().unwrap_or(station)))
}

/// Checks that the node which sends `status` runs `station`.
///
/// # Errors
/// A node of another station.
pub fn check_status(station: &Station, status: &Status) -> Result<()> {
    let own: Vec<&str> = station.robots().iter().map(|r| r.name.as_str()).collect();
    let theirs: Vec<&str> = status.robots.iter().map(|r| r.name.as_str()).collect();
    if own != theirs {
        return Err(another(&format!(
            "the robots of the node are {}, those of this station {}",
            listed(&theirs),
            listed(&own)
        )));
    }
    match &status.layout {
        Some(layout) if *layout != layout_hash(station) => Err(another(
            "its robots have the same names, but the size of the belt, or their places, \
             reaches, speeds or dwell times differ",
        )),
        _ => Ok(()),
    }
}

/// Checks that `task` can be for a robot of `station`.
///
/// # Errors
/// A task of a node of another station.
pub fn check_task(station: &Station, task: &Task) -> Result<()> {
    let robot = station.robots().iter().find(|r| r.name == task.robot);
    let Some(robot) = robot else {
        return Err(another(&format!(
            "the node has a task for `{}`, which is no robot of this station",
            shown(&task.robot)
        )));
    };
    let away = (robot.bin.x - task.bin.x).hypot(robot.bin.y - task.bin.y);
    if away <= SAME_PLACE {
        return Ok(());
    }
    Err(another(&format!(
        "for the node the bin of `{}` is at ({}, {}) m, here it is at ({}, {}) m",
        shown(&robot.name),
        task.bin.x,
        task.bin.y,
        robot.bin.x,
        robot.bin.y
    )))
}

/// Checks, at the end of a run of `station` that ended with `status`, that its own robots
/// were heard, if any robot was.
///
/// # Errors
/// Messages from robots of other names only.
pub fn check_heard(station: &Station, status: &Status) -> Result<()> {
    let strangers = status.rejected.get(Rejection::UnknownRobot.name());
    let silent = status.robots.iter().all(|robot| robot.state == "unknown");
    if !silent || strangers.is_none() {
        return Ok(());
    }
    let own: Vec<&str> = station.robots().iter().map(|r| r.name.as_str()).collect();
    Err(another(&format!(
        "the robots that were heard have other names than {}",
        listed(&own)
    )))
}

fn listed(names: &[&str]) -> String {
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
    Error::input(
        "--station",
        format!("the node and the line are of different stations: {problem}"),
        "start both with the same --station and --robots",
    )
}
