//! The full observation against a plain transcription of the tables in
//! `src/decision/observation/full.rs`, at the decisions of many runs on all kinds of lines.

use super::observation::{FULL, count, encoded};
use crate::common::{cases, lines, patterns, stations};
use pickline::decision::observation::Layout;
use pickline::decision::{Action, BeltItem, Candidate, Snapshot};
use pickline::pattern::Pattern;
use pickline::sim::{Run, Scene};
use pickline::station::{Belt, Robot, Station, built_in};
use proptest::prelude::*;

/// The best that `robot` can make of an item from `from` [s] on: the shortest processing time
/// [s] and the departure [s] for it. The place to meet it is the one nearest to the bin, of
/// those from where it is met at once to the end of the workspace.
fn best(robot: &Robot, belt: &Belt, (x0, y): (f64, f64), from: f64) -> Option<(f64, f64)> {
    let across = robot.reach * robot.reach - (y - robot.base.y).powi(2);
    let out = (robot.base.x + across.max(0.0).sqrt()).min(belt.length);
    let begin = (robot.base.x - across.max(0.0).sqrt()).max(0.0);
    if across < 0.0 || out < begin {
        return None;
    }
    let soonest = x0 + belt.speed * (from + tau(robot, belt, (x0, y), from));
    let meet = robot.bins[0].at.x.clamp(soonest, soonest.max(out));
    let way = (meet - robot.bins[0].at.x).hypot(y - robot.bins[0].at.y)
        / robot.arm.constant_speed().unwrap();
    let dwell = robot.grasp_time + robot.bins[0].release_time;
    Some((2.0 * way + dwell, (meet - x0) / belt.speed - way))
}

/// From the bin to the item [s], leaving at `time`.
fn tau(robot: &Robot, belt: &Belt, (x0, y): (f64, f64), time: f64) -> f64 {
    let (v, u) = (belt.speed, robot.arm.constant_speed().unwrap());
    let (dx, dy) = (x0 + v * time - robot.bins[0].at.x, y - robot.bins[0].at.y);
    let k = u * u - v * v;
    (v * dx + (v * v * dx * dx + k * (dx * dx + dy * dy)).sqrt()) / k
}

/// The tables of `src/decision/observation/full.rs`, for all candidates in their order.
fn transcribed(s: &Snapshot) -> (Vec<f64>, Vec<Vec<f64>>) {
    let (robots, belt) = (s.station.robots(), s.station.belt());
    let (own, n) = (&robots[s.robot], robots.len());
    let unit = own.reach / own.arm.constant_speed().unwrap();
    let log = |time: f64| (1.0 + time.clamp(0.0, 1e4) / unit).ln() / 3.0;
    let others = (n.max(2) - 1) as f64;
    let until = |robot: usize| (s.free_at[robot] - s.time).max(0.0);
    let busy = |robot: Option<usize>| match robot.filter(|robot| *robot < n) {
        Some(robot) => [f64::from(until(robot) > 0.0), log(until(robot))],
        None => [0.0, 0.0],
    };
    let (down, up) = (Some(s.robot + 1), s.robot.checked_sub(1));
    // In the workspace or upstream of it.
    let can = |robot: usize, item: &BeltItem| {
        let (dx, dy) = (item.x - robots[robot].base.x, item.y - robots[robot].base.y);
        let reach = robots[robot].reach.powi(2);
        dy * dy <= reach && (dx <= 0.0 || dx * dx + dy * dy <= reach)
    };
    let able = |item: &BeltItem| (0..n).filter(|robot| can(*robot, item)).count() as f64;
    let load = |robot: Option<usize>| {
        let robot = robot.filter(|robot| *robot < n);
        robot.map_or(0.0, |r| {
            s.in_view.iter().filter(|i| can(r, i)).count() as f64
        })
    };
    let mine: Vec<&BeltItem> = s.in_view.iter().filter(|item| can(s.robot, item)).collect();
    let elsewhere: f64 = (0..n)
        .filter(|r| *r != s.robot)
        .map(|r| load(Some(r)))
        .sum();
    let mut globals = vec![
        s.robot as f64 / others,
        f64::from(s.robot == 0),
        f64::from(s.robot + 1 == n),
        n as f64 / 6.0,
    ];
    globals.extend(busy(down));
    globals.extend(busy(up));
    globals.extend([
        (0..n)
            .filter(|r| *r != s.robot)
            .map(|r| log(until(r)))
            .sum::<f64>()
            / others,
        count(s.candidates.len() as f64),
        count(load(Some(s.robot))),
        count(mine.iter().filter(|item| able(item) == 1.0).count() as f64),
        count(load(down)),
        count(load(up)),
        count(elsewhere / others),
        count(s.in_view.len() as f64),
        belt.speed / own.arm.constant_speed().unwrap(),
        log(2.0 * own.reach / belt.speed),
        (own.grasp_time + own.bins[0].release_time) / unit,
        s.in_view.last().map_or(0.0, |item| item.x / belt.length),
        count(mine.iter().map(|item| 1.0 / able(item)).sum()),
    ]);
    let slot = |c: &Candidate| {
        let (x, place) = (c.x0 + belt.speed * s.time, (c.x0, c.y));
        let p = 2.0 * tau(own, belt, place, s.time) + own.grasp_time + own.bins[0].release_time;
        let (shortest, when) = best(own, belt, place, s.time).unwrap();
        let left = c.close - s.time;
        let side = if own.base.y <= 0.0 { 1.0 } else { -1.0 };
        let mut first = vec![
            1.0,
            (x - own.base.x) / own.reach,
            side * (c.y - own.base.y) / own.reach,
            p / (2.0 * unit),
            left / (2.0 * own.reach / belt.speed),
            log(left),
            c.weight,
            shortest / (2.0 * unit),
            log(when - s.time),
            (p - shortest) / (2.0 * unit),
        ];
        // Who else could: from when, the shortest time, until when.
        let takers: Vec<(usize, f64, f64, f64)> = (0..n)
            .filter(|robot| *robot != s.robot)
            .filter_map(|index| {
                let robot = &robots[index];
                let (open, close) = robot.departure_window(belt, 0, c.x0, c.y)?;
                let from = open.max(s.time).max(s.free_at[index]);
                if close < from {
                    return None;
                }
                let (p, _) = best(robot, belt, place, from)?;
                Some((index, from - s.time, p, close - s.time))
            })
            .collect();
        let least = |of: fn(&(usize, f64, f64, f64)) -> f64| takers.iter().map(of).reduce(f64::min);
        first.extend([
            takers.len() as f64 / others,
            f64::from(takers.iter().any(|taker| taker.0 == s.robot + 1)),
            least(|taker| taker.1).map_or(2.0, log),
            least(|taker| taker.2).map_or(2.0, |p| p / (2.0 * unit)),
            log(takers.iter().map(|taker| taker.3).fold(0.0, f64::max)),
        ]);
        first
    };
    let mut slots: Vec<Vec<f64>> = s.candidates.iter().map(slot).collect();
    let least = |feature: usize| {
        slots
            .iter()
            .map(|s| s[feature])
            .fold(f64::INFINITY, f64::min)
    };
    let (shortest, soonest) = (least(3), least(5));
    for slot in &mut slots {
        slot.push(slot[3] - shortest);
        slot.push(slot[5] - soonest);
    }
    (globals, slots)
}

/// Plays `pattern` and holds every observation to the transcription.
fn compare(station: &Station, pattern: &Pattern) -> usize {
    let scene = Scene::new(station, pattern).unwrap();
    let mut run = Run::new(&scene);
    let mut decisions = 0;
    while let Some(snapshot) = run.next_decision() {
        let layout = Layout {
            slots: snapshot.candidates.len(),
            ..FULL
        };
        let (observation, mask) = encoded(layout, &snapshot);
        assert!(mask.iter().all(|allowed| *allowed));
        let (globals, slots) = transcribed(&snapshot);
        let expected = [globals, slots.concat()].concat();
        for (index, (found, expected)) in observation.iter().zip(&expected).enumerate() {
            let near = (f64::from(*found) - expected).abs() <= 1e-4 * expected.abs().max(1.0);
            assert!(
                near,
                "{index}: {found}, expected {expected} at {snapshot:?}"
            );
        }
        assert_eq!(observation.len(), expected.len());
        // Of different places in the list, in the course of a run.
        let pick = (7 * decisions) % snapshot.candidates.len();
        run.act(Action::Pick(pick)).unwrap();
        decisions += 1;
    }
    decisions
}

#[test]
fn every_decision_of_the_papers_lines_has_the_features_of_the_tables() {
    for robots in 1..=4 {
        let station = built_in("paper").unwrap().station(Some(robots)).unwrap();
        let pattern = pickline::pattern::grid(station.belt().width, 0.2, 60).unwrap();
        assert!(compare(&station, &pattern) > 20);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..Default::default() })]

    #[test]
    fn every_decision_of_any_line_has_the_features_of_the_tables(
        (station, pattern, _) in cases(stations(), 30),
    ) {
        compare(&station, &pattern);
    }

    #[test]
    fn every_decision_of_like_robots_has_the_features_of_the_tables(
        (station, pattern) in lines().prop_flat_map(|station| {
            let width = station.belt().width;
            (Just(station), patterns(width, 30))
        }),
    ) {
        compare(&station, &pattern);
    }
}
