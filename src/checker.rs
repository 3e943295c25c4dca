//! Independent verification of any run, simulated or live.
//!
//! The checker only asks whether physics and the rules of the game allow the picks. It shares no
//! code with the engines, the windows or the closed form of the meeting point, so it exposes errors
//! there.

use crate::decision::{Failure, FailureCause, LeftReason, MissReason, Outcome, Pick, RobotFigures};
use crate::error::{Error, Result, counted};
use crate::kinematics::TravelLaw;
use crate::pattern::{Item, Pattern};
use crate::station::{Robot, Station};
use nalgebra::Point2;

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
    // Where each arm is.
    let mut at: Vec<Point2<f64>> = station.robots().iter().map(|robot| robot.rest).collect();
    // Who holds or held a claim on each item, and when the claim ends.
    let mut claims: Vec<Option<(usize, f64)>> = vec![None; pattern.len()];
    for (pick, cause) in attempts(outcome)? {
        let from = at.get(pick.robot).copied().unwrap_or_default();
        match cause {
            Some(FailureCause::OutOfReach) => check_vain_way(station, pattern, pick, from)?,
            Some(FailureCause::Grasp) => {
                check_pick(station, pattern, pick, from)?;
                if pattern.items()[pick.item as usize].p_grasp == Some(1.0) {
                    return refute(pick, "no grasp of this item fails".into());
                }
            }
            None => check_pick(station, pattern, pick, from)?,
        }
        at[pick.robot] = station.robots()[pick.robot].bins[usize::from(pick.bin)].at;
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

/// The bin that the model gives items of this class, by its definition.
fn bin_of(robot: &Robot, class: Option<&str>) -> Option<usize> {
    let names =
        |classes: &Vec<String>| class.is_some_and(|class| classes.iter().any(|c| c == class));
    let mut bins = robot.bins.iter();
    let named = bins.position(|bin| bin.classes.as_ref().is_some_and(names));
    named.or_else(|| robot.bins.iter().position(|bin| bin.classes.is_none()))
}

/// Why the model leaves an item on the belt on purpose.
fn left_reason(station: &Station, item: &Item) -> Option<LeftReason> {
    let class = item.class.as_deref();
    let mut stated = station.classes().iter();
    if stated.any(|stated| Some(stated.name.as_str()) == class && !stated.wanted) {
        return Some(LeftReason::Unwanted);
    }
    let mut robots = station.robots().iter();
    let taken = robots.any(|robot| bin_of(robot, class).is_some());
    (!taken).then_some(LeftReason::NoBin)
}

/// The weight of an item: its own, or its reward times the value of its class.
fn weight_of(station: &Station, item: &Item) -> f64 {
    let mut stated = station.classes().iter();
    let stated = stated.find(|stated| Some(&stated.name) == item.class.as_ref());
    match (item.weight, stated) {
        (None, Some(class)) => class.value * item.reward(),
        _ => item.reward(),
    }
}

/// Time [s] for a move over this distance in the plane [m]: the lift, and then the profile of the
/// speed, whose peak is at most the top speed.
fn move_time(robot: &Robot, distance: f64) -> f64 {
    let length = distance + 2.0 * robot.arm.lift;
    match &robot.arm.law {
        TravelLaw::Constant { speed } => length / speed,
        TravelLaw::Trapezoid {
            speed,
            acceleration: a,
            deceleration: b,
        } => {
            let peak = speed.min((2.0 * length * a * b / (a + b)).sqrt());
            if peak == 0.0 {
                return 0.0;
            }
            let ramps = peak * peak * (0.5 / a + 0.5 / b);
            peak / a + peak / b + (length - ramps) / peak
        }
        TravelLaw::Table(points) => {
            let last = points.len() - 2;
            let piece = (0..last)
                .find(|&i| length < points[i + 1].0)
                .unwrap_or(last);
            let ((l0, t0), (l1, t1)) = (points[piece], points[piece + 1]);
            let share = (length - l0) / (l1 - l0);
            t0 * (1.0 - share) + t1 * share
        }
    }
}

/// Checks that the robot travels straight from `from` to the meeting point and to the right bin,
/// takes the right time, and stays within its reach and on the belt. Returns the robot, the item
/// and the tolerance for lengths [m].
fn check_way<'a>(
    station: &'a Station,
    pattern: &'a Pattern,
    pick: &Pick,
    from: Point2<f64>,
) -> Result<(&'a Robot, &'a Item, f64)> {
    let (Some(robot), Some(item)) = (
        station.robots().get(pick.robot),
        pattern.items().get(pick.item as usize),
    ) else {
        return refute(pick, "there is no such robot or item".into());
    };
    if let Some(reason) = left_reason(station, item) {
        return refute(
            pick,
            format!("the item is not to be picked: {}", reason.name()),
        );
    }
    let Some(bin) = robot.bins.get(usize::from(pick.bin)) else {
        return refute(pick, format!("the robot has no bin {}", pick.bin));
    };
    match bin_of(robot, item.class.as_deref()) {
        Some(right) if right == usize::from(pick.bin) => {}
        Some(right) => {
            let right = &robot.bins[right].name;
            return refute(
                pick,
                format!("the item goes into bin {right}, not {}", bin.name),
            );
        }
        None => return refute(pick, "the robot has no bin for the item".into()),
    }
    let belt = station.belt();
    let times = [pick.decide, pick.grasp, pick.release];
    if !times.iter().all(|t| t.is_finite()) || pick.decide < 0.0 {
        return refute(
            pick,
            format!("the times {times:?} are not possible in a run"),
        );
    }
    let (out, back) = (
        nalgebra::distance(&pick.meet, &from),
        nalgebra::distance(&pick.meet, &bin.at),
    );
    let tolerance = slack(pick.release) * (1.0 + belt.speed + top_speed(robot, belt.speed));
    let near = |a: f64, b: f64| is_near(a, b, tolerance);
    let travelled = match robot.arm.constant_speed() {
        Some(speed) => near(out, speed * (pick.grasp - pick.decide)),
        // A length that is off by the tolerance takes at most that much longer: T is less steep than
        // 1 / v.
        None => is_near(
            move_time(robot, out),
            pick.grasp - pick.decide,
            tolerance / belt.speed,
        ),
    };
    if !travelled {
        return refute(
            pick,
            format!(
                "travelling {out} m does not take {} s, but {} s",
                pick.grasp - pick.decide,
                move_time(robot, out),
            ),
        );
    }
    let home = pick.grasp + robot.grasp_time + move_time(robot, back) + bin.release_time;
    let returned = match robot.arm.constant_speed() {
        Some(_) => near(pick.release, home),
        None => is_near(pick.release, home, tolerance / belt.speed),
    };
    if !returned {
        return refute(
            pick,
            format!("it returns at {home} s, not {} s", pick.release),
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

/// The top speed of the arm [m/s]; that of the belt if it only has a table.
fn top_speed(robot: &Robot, belt_speed: f64) -> f64 {
    robot.arm.law.top_speed().unwrap_or(belt_speed)
}

fn is_near(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance + slack(a.max(b))
}

fn check_pick(station: &Station, pattern: &Pattern, pick: &Pick, from: Point2<f64>) -> Result<()> {
    let (_, item, tolerance) = check_way(station, pattern, pick, from)?;
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
fn check_vain_way(
    station: &Station,
    pattern: &Pattern,
    pick: &Pick,
    from: Point2<f64>,
) -> Result<()> {
    let (robot, item, tolerance) = check_way(station, pattern, pick, from)?;
    let belt = station.belt();
    // The gripper gains on the item while it is on the belt, so what it lacks crosses zero at most
    // once; bisection finds where.
    let position = |t: f64| Point2::new(item.x0 + belt.speed * t, item.y);
    let lacks =
        |t: f64| move_time(robot, nalgebra::distance(&position(t), &from)) - (t - pick.decide);
    let at = |x: f64| (x - item.x0) / belt.speed;
    let (mut low, mut high) = (pick.decide.max(at(0.0)), at(belt.length).max(pick.decide));
    if lacks(low) < 0.0 || lacks(high) > 0.0 {
        // It would meet the item beside the belt's length.
        return Ok(());
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
    let left = |item: u32| left_reason(station, &pattern.items()[item as usize]);
    let all = || 0..pattern.len() as u32;
    let missing: Vec<u32> = all()
        .filter(|&item| claims[item as usize].is_none_or(|(_, ends)| ends.is_finite()))
        .filter(|&item| left(item).is_none())
        .collect();
    let listed: Vec<u32> = outcome.missed.iter().map(|miss| miss.item).collect();
    if missing != listed {
        return Err(Error::refuted(format!(
            "the missed items do not match: {} items were not picked, {} are listed as missed",
            missing.len(),
            listed.len()
        )));
    }
    let on_purpose: Vec<_> = all()
        .filter_map(|item| left(item).map(|reason| (item, reason)))
        .collect();
    let listed = outcome.left.iter().map(|left| (left.item, left.reason));
    if !listed.eq(on_purpose.iter().copied()) {
        return Err(Error::refuted(format!(
            "the items that are left on purpose do not match: {} are not to be picked, {} are listed",
            on_purpose.len(),
            outcome.left.len()
        )));
    }
    for miss in &outcome.missed {
        let item = &pattern.items()[miss.item as usize];
        let takes = |robot: &&Robot| bin_of(robot, item.class.as_deref()).is_some();
        let reachable = station
            .robots()
            .iter()
            .filter(takes)
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
    let bins = robot.bins.iter().map(|bin| bin.at);
    let mut places = bins.chain([robot.rest]);
    let in_time = |from: Point2<f64>| {
        let way = (high - from.x).hypot(y - from.y);
        (high - x0) / belt.speed >= move_time(robot, way)
    };
    low <= high && places.any(in_time)
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
        robot.weight += weight_of(station, &pattern.items()[pick.item as usize]);
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
    let offered = pattern.len() - outcome.left.len();
    agree("items", figures.items as f64, offered as f64)?;
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
