//! Independent re-verification of any run, simulated or live.
//!
//! It asks of the picks only whether physics and the rules of the game allow them:
//! it shares no code with the engines, the windows or the closed form of the meeting
//! point, so an error there shows here.

use crate::decision::{MissReason, Outcome, Pick};
use crate::error::{Error, Result};
use crate::pattern::Pattern;
use crate::station::{Robot, Station};

/// Largest deviation from the model [m or s] that is put down to rounding, per unit
/// of the times and lengths involved.
const TOLERANCE: f64 = 1e-9;

/// Checks `outcome` against the model: every pick meets its item where the item is,
/// within reach and on the belt; no robot is in two places; no item is claimed twice;
/// times, figures and the list of missed items add up.
///
/// # Errors
/// [`Error::Refuted`] with the first thing that is wrong.
pub fn check(station: &Station, pattern: &Pattern, outcome: &Outcome) -> Result<()> {
    let mut free_at = vec![0.0; station.robots().len()];
    let mut owner: Vec<Option<usize>> = vec![None; pattern.len()];
    let mut last = (0.0, 0);
    for pick in &outcome.picks {
        check_pick(station, pattern, pick)?;
        if let Some(other) = owner[pick.item as usize].replace(pick.robot) {
            return refute(
                pick,
                format!("the item was already claimed by robot {other}"),
            );
        }
        if pick.decide < free_at[pick.robot] - slack(pick.decide) {
            return refute(
                pick,
                format!("the robot is busy until {} s", free_at[pick.robot]),
            );
        }
        free_at[pick.robot] = pick.release;
        if (pick.decide, pick.robot) < last {
            return refute(
                pick,
                "picks are not in order of decision, then robot".into(),
            );
        }
        last = (pick.decide, pick.robot);
    }
    check_missed(station, pattern, outcome, &owner)?;
    check_figures(station, pattern, outcome)
}

fn refute<T>(pick: &Pick, problem: String) -> Result<T> {
    Err(Error::Refuted(format!(
        "robot {} picking item {} at t = {} s: {problem}",
        pick.robot, pick.item, pick.decide
    )))
}

fn slack(size: f64) -> f64 {
    TOLERANCE * (1.0 + size.abs())
}

fn check_pick(station: &Station, pattern: &Pattern, pick: &Pick) -> Result<()> {
    let (Some(robot), Some(item)) = (
        station.robots().get(pick.robot),
        pattern.items().get(pick.item as usize),
    ) else {
        return refute(pick, "there is no such robot or item".into());
    };
    let belt = station.belt();
    let times = [pick.decide, pick.grasp, pick.release];
    if !times.iter().all(|t| t.is_finite()) || pick.decide < 0.0 {
        return refute(pick, format!("the times {times:?} are not times of a run"));
    }
    let tolerance = slack(pick.release) * (1.0 + belt.speed + robot.speed);
    let near = |a: f64, b: f64| (a - b).abs() <= tolerance + slack(a.max(b));
    let at_grasp = item.x0 + belt.speed * pick.grasp;
    if !near(pick.meet.x, at_grasp) || !near(pick.meet.y, item.y) {
        return refute(
            pick,
            format!(
                "it meets at ({}, {}) while the item is at ({at_grasp}, {})",
                pick.meet.x, pick.meet.y, item.y
            ),
        );
    }
    let way = nalgebra::distance(&pick.meet, &robot.bin);
    if !near(way, robot.speed * (pick.grasp - pick.decide)) {
        return refute(
            pick,
            format!(
                "the way of {way} m does not take {} s at {} m/s",
                pick.grasp - pick.decide,
                robot.speed
            ),
        );
    }
    let back = pick.grasp + robot.grasp_time + way / robot.speed + robot.release_time;
    if !near(pick.release, back) {
        return refute(
            pick,
            format!("it is back at {back} s, not {} s", pick.release),
        );
    }
    let off_base = nalgebra::distance(&pick.meet, &robot.base);
    if off_base > robot.reach + tolerance {
        return refute(
            pick,
            format!(
                "it meets {off_base} m from the base, past its reach of {} m",
                robot.reach
            ),
        );
    }
    if pick.meet.x < -tolerance || pick.meet.x > belt.length + tolerance {
        return refute(
            pick,
            format!("it meets at x = {} m, off the belt", pick.meet.x),
        );
    }
    Ok(())
}

fn check_missed(
    station: &Station,
    pattern: &Pattern,
    outcome: &Outcome,
    owner: &[Option<usize>],
) -> Result<()> {
    let missing: Vec<u32> = (0..pattern.len() as u32)
        .filter(|&item| owner[item as usize].is_none())
        .collect();
    let listed: Vec<u32> = outcome.missed.iter().map(|miss| miss.item).collect();
    if missing != listed {
        return Err(Error::Refuted(format!(
            "{} items were not picked, {} are listed as missed, or others",
            missing.len(),
            listed.len()
        )));
    }
    for miss in &outcome.missed {
        let item = &pattern.items()[miss.item as usize];
        let reachable = station
            .robots()
            .iter()
            .any(|robot| can_be_met(station, robot, item.x0, item.y));
        if reachable == (miss.reason == MissReason::Unreachable) {
            return Err(Error::Refuted(format!(
                "item {} is listed as {} but a robot {} meet it",
                miss.item,
                miss.reason.name(),
                if reachable { "can" } else { "cannot" }
            )));
        }
    }
    Ok(())
}

/// Whether the robot, leaving at some time >= 0, meets the item within reach and on
/// the belt: looks for the furthest downstream place where it could be met.
fn can_be_met(station: &Station, robot: &Robot, x0: f64, y: f64) -> bool {
    let belt = station.belt();
    let dy = (y - robot.base.y).abs();
    if dy > robot.reach {
        return false;
    }
    let half = ((robot.reach - dy) * (robot.reach + dy)).sqrt();
    let low = (robot.base.x - half).max(0.0);
    let high = (robot.base.x + half).min(belt.length);
    let way = (high - robot.bin.x).hypot(y - robot.bin.y);
    low <= high && (high - x0) / belt.speed >= way / robot.speed
}

fn check_figures(station: &Station, pattern: &Pattern, outcome: &Outcome) -> Result<()> {
    let figures = &outcome.figures;
    let belt = station.belt();
    let last_release = outcome.picks.iter().map(|p| p.release).fold(0.0, f64::max);
    let last_leaves = outcome
        .missed
        .iter()
        .map(|miss| (belt.length - pattern.items()[miss.item as usize].x0) / belt.speed)
        .fold(0.0, f64::max);
    let weight: f64 = outcome
        .picks
        .iter()
        .map(|pick| pattern.items()[pick.item as usize].reward())
        .sum();
    let busy: f64 = outcome.picks.iter().map(|p| p.release - p.decide).sum();
    let pairs = [
        ("items", figures.items as f64, pattern.len() as f64),
        ("picked", figures.picked as f64, outcome.picks.len() as f64),
        ("weight", figures.weight, weight),
        ("end", figures.end, last_release.max(last_leaves)),
        (
            "picks of the robots",
            outcome.robots.iter().map(|r| r.picked).sum::<usize>() as f64,
            outcome.picks.len() as f64,
        ),
        (
            "busy time of the robots",
            outcome.robots.iter().map(|r| r.busy).sum(),
            busy,
        ),
    ];
    // Put so that a figure which is not a number does not pass.
    let equal = |a: f64, b: f64| (a - b).abs() <= slack(b);
    match pairs.iter().find(|(_, a, b)| !equal(*a, *b)) {
        None => Ok(()),
        Some((name, a, b)) => Err(Error::Refuted(format!("{name} is given as {a} but is {b}"))),
    }
}
