//! Independent verification of any run, simulated or live.
//!
//! The checker only asks whether physics and the rules of the game allow the picks. It shares no
//! code with the engines, the windows or the closed form of the meeting point, so it exposes errors
//! there.

use crate::decision::{Failure, FailureCause, MissReason, Outcome, Pick, RobotFigures};
use crate::error::{Error, Result, counted};
use crate::pattern::{Item, Pattern};
use crate::station::{Robot, Station};

/// Largest deviation from the model [m or s] that is attributed to rounding, per unit of the times
/// and lengths involved.
const TOLERANCE: f64 = 1e-9;

/// Checks `outcome` against the model: every pick meets its item where the item is, within reach
/// and on the belt. No robot is in two places at once. No two robots claim an item at the same
/// time, and no robot claims one that is already picked. Times, figures and the list of missed
/// items are consistent.
/// With disturbances (`docs/model.md`), a failed attempt occupies its robot as long as a pick and
/// claims its item until the end of the grasp. Whether a grasp fails is random and is not checked.
///
/// # Errors
/// [`Refuted`](crate::error::ErrorKind) with the first violation.
pub fn check(station: &Station, pattern: &Pattern, outcome: &Outcome) -> Result<()> {
    let mut free_at = vec![0.0; station.robots().len()];
    // Who holds or held a claim on each item, and when the claim ends.
    let mut claims: Vec<Option<(usize, f64)>> = vec![None; pattern.len()];
    for (pick, cause) in attempts(outcome)? {
        match cause {
            Some(FailureCause::OutOfReach) => check_vain_way(station, pattern, pick)?,
            Some(FailureCause::Grasp) => {
                check_pick(station, pattern, pick)?;
                if pattern.items()[pick.item as usize].p_grasp == Some(1.0) {
                    return refute(pick, "no grasp of this item fails".into());
                }
            }
            None => check_pick(station, pattern, pick)?,
        }
        let ends = match cause {
            Some(_) => pick.grasp + station.robots()[pick.robot].grasp_time,
            None => f64::INFINITY,
        };
        let claim = claims[pick.item as usize].replace((pick.robot, ends));
        if let Some((other, until)) = claim
            && pick.decide < until - slack(pick.decide)
        {
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
    }
    check_missed(station, pattern, outcome, &claims)?;
    check_figures(station, pattern, outcome)
}

/// Picks and failed attempts, the latter with their cause, in order of decision.
fn attempts(outcome: &Outcome) -> Result<Vec<(&Pick, Option<FailureCause>)>> {
    let order = |a: &Pick, b: &Pick| a.decide.total_cmp(&b.decide).then(a.robot.cmp(&b.robot));
    let picks: Vec<_> = outcome.picks.iter().map(|pick| (pick, None)).collect();
    let failures = outcome.failures.iter();
    let failures: Vec<_> = failures.map(|f| (&f.attempt, Some(f.cause))).collect();
    for list in [&picks, &failures] {
        let late = |pair: &&[(&Pick, _)]| order(pair[0].0, pair[1].0).is_gt();
        if let Some(pair) = list.windows(2).find(late) {
            let problem = "attempts are not in order of decision, then robot";
            return refute(pair[1].0, problem.into());
        }
    }
    let mut all = [picks, failures].concat();
    all.sort_by(|a, b| order(a.0, b.0));
    Ok(all)
}

fn refute<T>(pick: &Pick, problem: String) -> Result<T> {
    Err(Error::refuted(format!(
        "robot {} picking item {} at t = {} s: {problem}",
        pick.robot, pick.item, pick.decide
    )))
}

fn slack(size: f64) -> f64 {
    TOLERANCE * (1.0 + size.abs())
}

/// Checks that the robot travels straight to the meeting point and back, takes the right time, and
/// stays within its reach and on the belt. Returns the robot, the item and the tolerance for
/// lengths [m].
fn check_way<'a>(
    station: &'a Station,
    pattern: &'a Pattern,
    pick: &Pick,
) -> Result<(&'a Robot, &'a Item, f64)> {
    let (Some(robot), Some(item)) = (
        station.robots().get(pick.robot),
        pattern.items().get(pick.item as usize),
    ) else {
        return refute(pick, "there is no such robot or item".into());
    };
    let belt = station.belt();
    let times = [pick.decide, pick.grasp, pick.release];
    if !times.iter().all(|t| t.is_finite()) || pick.decide < 0.0 {
        return refute(
            pick,
            format!("the times {times:?} are not possible in a run"),
        );
    }
    let tolerance = slack(pick.release) * (1.0 + belt.speed + robot.speed);
    let near = |a: f64, b: f64| is_near(a, b, tolerance);
    let way = nalgebra::distance(&pick.meet, &robot.bin);
    if !near(way, robot.speed * (pick.grasp - pick.decide)) {
        return refute(
            pick,
            format!(
                "travelling {way} m does not take {} s at {} m/s",
                pick.grasp - pick.decide,
                robot.speed
            ),
        );
    }
    let back = pick.grasp + robot.grasp_time + way / robot.speed + robot.release_time;
    if !near(pick.release, back) {
        return refute(
            pick,
            format!("it returns at {back} s, not {} s", pick.release),
        );
    }
    let off_base = nalgebra::distance(&pick.meet, &robot.base);
    if off_base > robot.reach + tolerance {
        return refute(
            pick,
            format!(
                "its meeting point is {off_base} m from the base, beyond its reach of {} m",
                robot.reach
            ),
        );
    }
    let x = pick.meet.x;
    if x < -tolerance || x > belt.length + tolerance {
        return refute(
            pick,
            format!("its meeting point at x = {x} m is off the belt"),
        );
    }
    Ok((robot, item, tolerance))
}

fn is_near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance + slack(a.max(b))
}

fn check_pick(station: &Station, pattern: &Pattern, pick: &Pick) -> Result<()> {
    let (_, item, tolerance) = check_way(station, pattern, pick)?;
    let belt = station.belt();
    let at_grasp = item.x0 + belt.speed * pick.grasp;
    if !is_near(pick.meet.x, at_grasp, tolerance) || !is_near(pick.meet.y, item.y, tolerance) {
        return refute(
            pick,
            format!(
                "it grasps at ({}, {}) while the item is at ({at_grasp}, {})",
                pick.meet.x, pick.meet.y, item.y
            ),
        );
    }
    Ok(())
}

/// Checks an attempt that found nothing: the robot made its move, and could not have met the item
/// at its true position.
fn check_vain_way(station: &Station, pattern: &Pattern, pick: &Pick) -> Result<()> {
    let (robot, item, tolerance) = check_way(station, pattern, pick)?;
    let belt = station.belt();
    // The gripper gains on the item, so the distance crosses zero exactly once; bisection finds
    // where.
    let position = |t: f64| nalgebra::Point2::new(item.x0 + belt.speed * t, item.y);
    let ahead =
        |t: f64| nalgebra::distance(&position(t), &robot.bin) - robot.speed * (t - pick.decide);
    let start = nalgebra::distance(&position(pick.decide), &robot.bin);
    let (mut low, mut high) = (
        pick.decide,
        pick.decide + start / (robot.speed - belt.speed),
    );
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if ahead(middle) > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let meet = position(high);
    let inside = robot.reach - nalgebra::distance(&meet, &robot.base);
    let inside = inside.min(meet.x).min(belt.length - meet.x);
    if inside > tolerance {
        return refute(
            pick,
            format!(
                "it found nothing, but it could have met the item at ({}, {})",
                meet.x, meet.y
            ),
        );
    }
    Ok(())
}

fn check_missed(
    station: &Station,
    pattern: &Pattern,
    outcome: &Outcome,
    claims: &[Option<(usize, f64)>],
) -> Result<()> {
    // The last claim on a picked item never ends.
    let missing: Vec<u32> = (0..pattern.len() as u32)
        .filter(|&item| claims[item as usize].is_none_or(|(_, ends)| ends.is_finite()))
        .collect();
    let listed: Vec<u32> = outcome.missed.iter().map(|miss| miss.item).collect();
    if missing != listed {
        return Err(Error::refuted(format!(
            "the missed items do not match: {} items were not picked, {} are listed as missed",
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
            return Err(Error::refuted(format!(
                "item {} is listed as {}, but {} robot can meet it",
                miss.item,
                miss.reason.name(),
                if reachable { "a" } else { "no" }
            )));
        }
        let attempted = claims[miss.item as usize].is_some();
        if reachable && attempted != (miss.reason == MissReason::GraspFailed) {
            return Err(Error::refuted(format!(
                "item {} is listed as {}, but was {}attempted",
                miss.item,
                miss.reason.name(),
                if attempted { "" } else { "not " }
            )));
        }
    }
    Ok(())
}

/// Whether the robot can meet the item within reach and on the belt if it leaves at some time >= 0.
/// Considers the meeting point furthest downstream.
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
    let (given, there) = (outcome.robots.len(), station.robots().len());
    if given != there {
        return Err(Error::refuted(format!(
            "there are figures for {}, but the station has {there}",
            counted(given, "robot")
        )));
    }
    // Figures recomputed from each robot's picks and failed attempts.
    let mut robots = vec![RobotFigures::default(); there];
    let mut end: f64 = 0.0;
    for pick in &outcome.picks {
        let robot = &mut robots[pick.robot];
        robot.picked += 1;
        robot.weight += pattern.items()[pick.item as usize].reward();
        robot.busy += pick.release - pick.decide;
        end = end.max(pick.release);
    }
    for Failure { attempt, .. } in &outcome.failures {
        let robot = &mut robots[attempt.robot];
        robot.failed += 1;
        robot.busy += attempt.release - attempt.decide;
        end = end.max(attempt.release);
    }
    let belt = station.belt();
    for miss in &outcome.missed {
        let leaves = (belt.length - pattern.items()[miss.item as usize].x0) / belt.speed;
        end = end.max(leaves);
    }
    let figures = &outcome.figures;
    let weight = robots.iter().map(|robot| robot.weight).sum();
    agree("items", figures.items as f64, pattern.len() as f64)?;
    agree("picked", figures.picked as f64, outcome.picks.len() as f64)?;
    agree("weight", figures.weight, weight)?;
    agree("end", figures.end, end)?;
    for (i, (given, did)) in outcome.robots.iter().zip(&robots).enumerate() {
        let of = |name: &str| format!("{name} of robot {i}");
        agree(&of("picks"), given.picked as f64, did.picked as f64)?;
        agree(
            &of("failed attempts"),
            given.failed as f64,
            did.failed as f64,
        )?;
        agree(&of("weight"), given.weight, did.weight)?;
        agree(&of("busy time"), given.busy, did.busy)?;
    }
    Ok(())
}

/// Checks that the reported figure equals the recomputed one; NaN never does.
fn agree(name: &str, given: f64, value: f64) -> Result<()> {
    if (given - value).abs() <= slack(value) {
        return Ok(());
    }
    Err(Error::refuted(format!(
        "{name} is reported as {given}, but is {value}"
    )))
}
