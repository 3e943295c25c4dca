//! Independent verification of any run, simulated or live.
//!
//! The checker only asks whether physics and the rules of the game allow the picks. It shares no
//! code with the engines, the windows or the closed form of the meeting point, so it exposes errors
//! there.

mod attempt;
mod figures;
mod physics;
mod picks_file;
mod violation;

pub use figures::figures;
pub use picks_file::{PicksFile, UnknownRow, read_picks};
pub use violation::{Terms, Violation, ViolationKind};

use attempt::{Attempt, check_way_back, check_way_out, digits, has_possible_times};
use physics::{CheckedLine, bin_of, can_be_met, left_reason, slack, weight_of};
use violation::Problem;

use crate::decision::{Failure, FailureCause, LeftReason, MissReason, Outcome, Pick, RobotFigures};
use crate::error::{Error, Result, counted};
use crate::pattern::Pattern;
use crate::station::{Robot, Station};
use nalgebra::Point2;
use std::cmp::Ordering;
use std::collections::HashSet;

/// Who holds or held a claim on an item, and when the claim ends [s]; never for a picked item.
type Claim = Option<(usize, f64)>;

/// Checks `outcome` against the model: every pick meets its item where the item is, within reach
/// and on the belt, and takes it to its bin. No robot is in two places at once. No two robots claim
/// an item at the same time, and no robot claims one that is already picked. Times, figures and the
/// lists of missed items and of items left on purpose are consistent.
/// With disturbances (`docs/model.md`), a failed attempt occupies its robot as long as a pick and
/// claims its item until the end of the grasp. Whether a grasp fails is random and is not checked.
/// Nor is when robots are down, but none of them decides then.
/// Items may be left for their low `p_detection`, if all others have a higher one.
///
/// # Errors
/// [`Refuted`](crate::error::ErrorKind) with the first violation.
pub fn check(station: &Station, pattern: &Pattern, outcome: &Outcome) -> Result<()> {
    let checked = CheckedLine {
        station,
        pattern,
        terms: Terms::default(),
    };
    check_downtimes(station, outcome)?;
    let mut first = None;
    let claims = follow(&checked, &attempts(outcome)?, &mut |violation| {
        first.get_or_insert(violation);
    });
    if let Some(violation) = first {
        return Err(violation.into());
    }
    check_missed(station, pattern, outcome, &claims)?;
    check_figures(station, pattern, outcome)
}

/// All that is wrong with `attempts`, which may come from any program, in order of decision and
/// robot. Those that failed have a cause. Apart from `terms`, it is checked what [`check`] checks of
/// each attempt. Of an attempt with a robot, an item or a bin that does not exist, it is checked what
/// does not depend on that: the order of its times at least. A place of the meeting that is not known is
/// no number.
pub fn violations(
    station: &Station,
    pattern: &Pattern,
    attempts: &[(Pick, Option<FailureCause>)],
    terms: Terms,
) -> Vec<Violation> {
    let checked = CheckedLine {
        station,
        pattern,
        terms,
    };
    let attempts = attempts.iter().enumerate();
    let attempts = attempts.map(|(index, (pick, cause))| Listed {
        index,
        pick,
        cause: *cause,
    });
    let mut attempts: Vec<Listed> = attempts.collect();
    attempts.sort_by(Listed::order);
    let mut list = Vec::new();
    follow(&checked, &attempts, &mut |violation| list.push(violation));
    list
}

/// An attempt and its index in the list that is checked.
#[derive(Clone, Copy)]
struct Listed<'a> {
    index: usize,
    pick: &'a Pick,
    /// Why it failed, if it did.
    cause: Option<FailureCause>,
}

impl Listed<'_> {
    /// By decision, then by robot.
    fn order(&self, other: &Self) -> Ordering {
        let times = self.pick.decide.total_cmp(&other.pick.decide);
        times.then(self.pick.robot.cmp(&other.pick.robot))
    }
}

/// Calls `report` for everything that is wrong with `attempts`, which are in order of decision.
/// Returns the last claim on each item.
fn follow(
    checked: &CheckedLine,
    attempts: &[Listed],
    report: &mut dyn FnMut(Violation),
) -> Vec<Claim> {
    let robots = checked.station.robots();
    let mut free_at = vec![0.0; robots.len()];
    let mut places: Vec<_> = robots.iter().map(|robot| Some(robot.rest)).collect();
    let mut claims: Vec<Claim> = vec![None; checked.pattern.len()];
    let mut problems = Vec::new();
    for &Listed { index, pick, cause } in attempts {
        let robot = robots.get(pick.robot);
        let item = checked.pattern.items().get(pick.item as usize);
        if robot.is_none() || item.is_none() {
            let text = "there is no such robot or item";
            problems.push(Problem::of(ViolationKind::Unknown, text));
        }
        match robot {
            Some(robot) => {
                let attempt = Attempt {
                    checked,
                    robot,
                    item,
                    pick,
                    from: places[pick.robot],
                };
                check_attempt(&attempt, cause, &mut problems);
            }
            None => {
                let tolerance = checked.terms.tolerance;
                if has_possible_times(pick, tolerance, &mut problems) {
                    check_way_out(pick, tolerance, &mut problems);
                    check_way_back(pick, 0.0, tolerance, &mut problems);
                }
            }
        }
        if item.is_some() {
            let ends = match (cause, robot) {
                (Some(_), Some(robot)) => pick.grasp + robot.grasp_time,
                (Some(_), None) => pick.grasp,
                (None, _) => f64::INFINITY,
            };
            let claim = claims[pick.item as usize].replace((pick.robot, ends));
            problems.extend(claim.and_then(|(other, until)| {
                let text = match robots.get(other) {
                    Some(other) => {
                        let name = &other.name;
                        format!("the item was already claimed by robot `{name}`")
                    }
                    None => "the item was already claimed by an unknown robot".to_owned(),
                };
                too_early(checked, pick, until, ViolationKind::Claimed, text)
            }));
        }
        if let Some(robot) = robot {
            places[pick.robot] = place_after(robot, pick);
            let free = free_at[pick.robot];
            let text = format!("the robot is busy until {} s", digits(free));
            problems.extend(too_early(checked, pick, free, ViolationKind::Busy, text));
            free_at[pick.robot] = pick.release;
        }
        for problem in problems.drain(..) {
            report(problem.in_pick(index, pick));
        }
    }
    claims
}

/// Where the arm is after an attempt [m]; `None` if the bin is unknown and there are several.
fn place_after(robot: &Robot, pick: &Pick) -> Option<Point2<f64>> {
    let bin = robot.bins.get(usize::from(pick.bin));
    let only = || (robot.bins.len() == 1).then(|| &robot.bins[0]);
    bin.or_else(only).map(|bin| bin.at)
}

/// What is wrong with an attempt by itself.
fn check_attempt(attempt: &Attempt, cause: Option<FailureCause>, problems: &mut Vec<Problem>) {
    attempt.check_way(problems);
    if cause == Some(FailureCause::OutOfReach) {
        if problems.is_empty() {
            attempt.check_vanity(problems);
        }
    } else {
        attempt.check_meeting(problems);
    }
    attempt.check_conditions(problems);
    let is_sure = attempt.item.is_some_and(|item| item.p_grasp == Some(1.0));
    if cause == Some(FailureCause::Grasp) && is_sure {
        let text = "no grasp of this item fails";
        problems.push(Problem::of(ViolationKind::SureGrasp, text));
    }
}

/// The problem that a robot leaves before `until` [s], if it does. Both times may be off.
fn too_early(
    checked: &CheckedLine,
    pick: &Pick,
    until: f64,
    kind: ViolationKind,
    text: String,
) -> Option<Problem> {
    let early = until - slack(pick.decide) - pick.decide;
    let tolerance = 0.5 * early;
    (tolerance > checked.terms.tolerance).then(|| Problem::off(kind, tolerance, text))
}

/// Picks and failed attempts, the latter with their cause, in order of decision.
fn attempts(outcome: &Outcome) -> Result<Vec<Listed<'_>>> {
    let picks = outcome.picks.iter().map(|pick| (pick, None));
    let failures = outcome.failures.iter();
    let failures = failures.map(|f| (&f.attempt, Some(f.cause)));
    let all = picks.chain(failures).enumerate();
    let mut all: Vec<_> = all
        .map(|(index, (pick, cause))| Listed { index, pick, cause })
        .collect();
    let (picks, failures) = all.split_at(outcome.picks.len());
    for list in [picks, failures] {
        let late = |pair: &&[Listed]| pair[0].order(&pair[1]).is_gt();
        if let Some(pair) = list.windows(2).find(late) {
            let text = "attempts are not in order of decision, then robot";
            let problem = Problem::of(ViolationKind::Times, text);
            return Err(problem.in_pick(pair[1].index, pair[1].pick).into());
        }
    }
    all.sort_by(Listed::order);
    Ok(all)
}

/// Checks that the times in which robots were down are possible, and that no robot decided then.
fn check_downtimes(station: &Station, outcome: &Outcome) -> Result<()> {
    let mut of_robots: Vec<Vec<(f64, f64)>> = vec![Vec::new(); station.robots().len()];
    for down in &outcome.downtimes {
        let possible = 0.0 <= down.from && down.from < down.to && down.to <= outcome.figures.end;
        let own = of_robots.get_mut(down.robot).filter(|own| {
            let before = own.last().map_or(f64::NEG_INFINITY, |&(_, to)| to);
            possible && before < down.from
        });
        let Some(own) = own else {
            return Err(Error::refuted(format!(
                "robot {} is listed as down from {} s to {} s, which is not possible",
                down.robot, down.from, down.to
            )));
        };
        own.push((down.from, down.to));
    }
    for Listed { index, pick, .. } in attempts(outcome)? {
        let own = of_robots.get(pick.robot).map_or(&[][..], Vec::as_slice);
        let begun = own.partition_point(|&(from, _)| from <= pick.decide);
        if let Some(&(from, to)) = own[..begun].last()
            && pick.decide < to - slack(to)
        {
            let text = format!("the robot is down from {from} s to {to} s");
            let problem = Problem::of(ViolationKind::Down, text);
            return Err(problem.in_pick(index, pick).into());
        }
    }
    Ok(())
}

fn check_missed(
    station: &Station,
    pattern: &Pattern,
    outcome: &Outcome,
    claims: &[Option<(usize, f64)>],
) -> Result<()> {
    let uncertain = too_uncertain(pattern, outcome)?;
    // The last claim on a picked item never ends.
    let left = |item: u32| {
        let reason = left_reason(station, &pattern.items()[item as usize]);
        reason.or_else(|| {
            uncertain
                .contains(&item)
                .then_some(LeftReason::LowDetection)
        })
    };
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
        if miss.reason == MissReason::RobotDown && outcome.downtimes.is_empty() {
            return Err(Error::refuted(format!(
                "item {} is listed as {}, but no robot was down",
                miss.item,
                miss.reason.name()
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

/// The items that are listed as left for their low `p_detection`, if some threshold explains them:
/// every other item that the station takes has a higher one.
fn too_uncertain(pattern: &Pattern, outcome: &Outcome) -> Result<HashSet<u32>> {
    let listed = outcome.left.iter();
    let listed = listed.filter(|left| left.reason == LeftReason::LowDetection);
    let listed: HashSet<u32> = listed.map(|left| left.item).collect();
    let p = |item: u32| {
        let item = pattern.items().get(item as usize);
        item.map_or(1.0, |item| item.p_detection.unwrap_or(1.0))
    };
    let highest = listed.iter().map(|item| p(*item)).reduce(f64::max);
    let offered = outcome.missed.iter().map(|miss| miss.item);
    let offered = offered.chain(outcome.picks.iter().map(|pick| pick.item));
    let lowest = offered.map(p).fold(f64::INFINITY, f64::min);
    match highest {
        Some(highest) if highest == 1.0 || highest >= lowest => Err(Error::refuted(format!(
            "an item with a p_detection of {highest} is left as too uncertain, but one with {} is \
             to be picked",
            lowest.min(1.0)
        ))),
        _ => Ok(listed),
    }
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
