//! The model of real lines (`docs/real-lines.md`) written down a third time, as plainly as possible:
//! every decision looks at every robot and every item, and every root is found by bisection. Both
//! engines follow it pick by pick.
//!
//! Keys and times that are found by different means differ in the last bits. The transcription
//! therefore follows the picks of a run: each must come at its time and be one of the best, up to
//! rounding, and no decision may be missing.

#[path = "../common/real_lines.rs"]
pub mod common_real_lines;

use common_real_lines::{Book, patterns, stations};
use nalgebra::Point2;
use pickline::checker;
use pickline::decision::Pick;
use pickline::dispatch::RuleAssignment;
use pickline::kinematics::TravelLaw;
use pickline::pattern::Pattern;
use pickline::sim::{Cascade, Scene, simulate_rules};
use pickline::station::Station;
use proptest::prelude::*;

/// Differences of times [s] and keys that are due to rounding.
const ROUNDING: f64 = 1e-9;

/// Follows `picks`, those of a run in which the robots follow `rules`.
fn follow(book: &Book, rules: &[&str], picks: &[Pick], hz: f64) -> Result<(), TestCaseError> {
    let tick = |t: f64| {
        let ticks = t * hz;
        match hz == 0.0 || (ticks - ticks.round()).abs() <= 1e-7 {
            true => t,
            false => ticks.ceil() / hz,
        }
    };
    let robots = book.station.robots();
    let mut free = vec![0.0; robots.len()];
    let mut place: Vec<Point2<f64>> = robots.iter().map(|robot| robot.rest).collect();
    let mut gone: Vec<bool> = book.items.iter().map(|item| !book.wanted(item)).collect();
    let mut picks = picks.iter();
    loop {
        // The earliest decision, and what each robot could take at its own.
        let mut next: Option<(f64, usize)> = None;
        for (i, robot) in robots.iter().enumerate() {
            let windows = || {
                let left = book.items.iter().zip(&gone).filter(|(_, gone)| !**gone);
                left.filter_map(|(item, _)| book.window(robot, place[i], item))
            };
            let mut from: f64 = free[i];
            let decision = loop {
                let opens = windows().filter(|w| w.1 >= from).map(|w| w.0.max(from));
                let Some(exact) = opens.reduce(f64::min) else {
                    break None;
                };
                let time = tick(exact);
                if windows().any(|w| w.0 <= time && time <= w.1) {
                    break Some(time);
                }
                from = time.max(exact.next_up());
            };
            if let Some(time) = decision
                && next.is_none_or(|(earliest, _)| time < earliest - ROUNDING)
            {
                next = Some((time, i));
            }
        }
        let (Some((time, i)), Some(pick)) = (next, picks.clone().next()) else {
            prop_assert_eq!(next.is_some(), picks.len() > 0, "one of them ends early");
            return Ok(());
        };
        picks.next();
        // Two decisions at the same time, up to rounding, may come in either order.
        prop_assert!(
            (pick.decide - time).abs() < ROUNDING * (1.0 + time),
            "{pick:?} {time}"
        );
        let (i, time) = (if pick.robot == i { i } else { pick.robot }, pick.decide);
        let (robot, from) = (&robots[i], place[i]);
        let slack = ROUNDING * (1.0 + time);
        let can = |j: &usize| {
            let window = book.window(robot, from, &book.items[*j]);
            !gone[*j] && window.is_some_and(|w| w.0 <= time + slack && time - slack <= w.1)
        };
        let can: Vec<usize> = (0..book.items.len()).filter(can).collect();
        let chosen = pick.item as usize;
        prop_assert!(can.contains(&chosen), "{pick:?} is not possible");
        let key = |j: usize| book.key(rules[i], robot, from, &book.items[j], time);
        // One that is possible only up to rounding need not have been seen.
        let sure = |j: &&usize| {
            let window = book.window(robot, from, &book.items[**j]);
            window.is_some_and(|w| w.0 <= time - slack && time + slack <= w.1)
        };
        let best = can
            .iter()
            .filter(sure)
            .map(|j| key(*j))
            .fold(key(chosen), f64::min);
        prop_assert!(
            key(chosen) - best <= ROUNDING * (1.0 + best.abs()),
            "{pick:?} has key {}, another one {best}",
            key(chosen)
        );
        let (meet, grasp, release) = book.pick(robot, from, &book.items[chosen], time);
        prop_assert!((pick.meet.x - meet).abs() < 1e-7, "{pick:?} {meet}");
        prop_assert!((pick.grasp - grasp).abs() < slack, "{pick:?} {grasp}");
        prop_assert!((pick.release - release).abs() < slack, "{pick:?} {release}");
        let bin = book.bin(robot, &book.items[chosen]).unwrap();
        prop_assert_eq!(usize::from(pick.bin), bin);
        place[i] = robot.bins[bin].at;
        free[i] = pick.release;
        gone[chosen] = true;
    }
}

fn cases() -> impl Strategy<Value = (Station, Pattern, RuleAssignment)> {
    stations().prop_flat_map(|station| {
        let rules = vec!["FIFO", "SPT", "LPT", "SD", "LD", "PP"];
        let count = station.robots().len();
        let rules = prop::collection::vec(prop::sample::select(rules), count);
        let rules = rules.prop_map(|rules| rules.join(",").parse().unwrap());
        let width = station.belt().width;
        (Just(station), patterns(width, 30), rules)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn both_engines_follow_the_page(
        (station, pattern, rules) in cases(),
        hz in prop_oneof![3 => Just(0.0), 1 => 0.5..20.0f64],
    ) {
        let scene = Scene::new(&station, &pattern).unwrap().with_update_hz(hz).unwrap();
        let outcome = simulate_rules(&scene, &rules).unwrap();
        checker::check(&station, &pattern, &outcome).map_err(|e| TestCaseError::fail(e.to_string()))?;
        let book = Book { station: &station, items: pattern.items() };
        follow(&book, &rules.names(), &outcome.picks, hz)?;
        let offered = pattern.items().iter().filter(|item| book.wanted(item)).count();
        prop_assert_eq!(outcome.figures.items, offered);
        prop_assert_eq!(outcome.left.len(), pattern.len() - offered);
        if let Some(mut cascade) = Cascade::new(&scene) {
            let mut picks = Vec::new();
            let figures = cascade.run_observed(rules.rules(), |pick| picks.push(pick));
            picks.sort_by(|a, b| a.decide.total_cmp(&b.decide).then(a.robot.cmp(&b.robot)));
            prop_assert_eq!(figures, outcome.figures);
            prop_assert_eq!(picks, outcome.picks);
        }
    }
}

/// Random moves with their travel times, for `tests/ruckig/run.sh`.
#[test]
fn moves_are_written_for_ruckig() {
    let mut rng = pickline::pattern::random_stream(15, 0);
    let mut between = |low: f64, high: f64| rng.random_range(low..high);
    let mut text = String::from("length_m,speed_m_s,acceleration_m_s2,deceleration_m_s2,time_s\n");
    for _ in 0..1000 {
        let length = between(0.001, 1.5);
        let law = TravelLaw::Trapezoid {
            speed: between(0.2, 12.0),
            acceleration: between(2.0, 150.0),
            deceleration: between(2.0, 150.0),
        };
        let TravelLaw::Trapezoid {
            speed,
            acceleration,
            deceleration,
        } = law
        else {
            unreachable!("it was just made");
        };
        let time = law.time(length);
        text += &format!("{length},{speed},{acceleration},{deceleration},{time}\n");
    }
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("ruckig");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("moves.csv"), text).unwrap();
}
