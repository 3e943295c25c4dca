//! All violations of a run are listed, each with the tolerance from which on it is accepted.

use super::bench::Bench;
use pickline::checker::{Terms, Violation, ViolationKind, violations};
use pickline::decision::{FailureCause, Outcome, Pick};
use pickline::pattern::{ClassShares, Pattern, grid, random_stream};
use pickline::sim::{Conditions, Disturbances, Scene, simulate_rules};
use pickline::station::{Station, built_in};
use rand::RngExt as _;
use std::collections::BTreeSet;

type Attempts = Vec<(Pick, Option<FailureCause>)>;

fn attempts(outcome: &Outcome) -> Attempts {
    let picks = outcome.picks.iter().map(|pick| (*pick, None));
    let failures = outcome.failures.iter();
    let failures = failures.map(|f| (f.attempt, Some(f.cause)));
    picks.chain(failures).collect()
}

/// A run on a built-in station, with grasps that fail.
fn run_on(name: &str) -> (Station, Pattern, Attempts) {
    let station = built_in(name).unwrap().station(None).unwrap();
    let classes: ClassShares = "pet:0.4,hdpe:0.3,wood:0.2".parse().unwrap();
    let pattern = grid(station.belt().width, 0.12, 120).unwrap();
    let pattern = classes.apply(&pattern, &mut random_stream(3, 0)).unwrap();
    let disturbances = Disturbances::default()
        .with_grasp_failures(true)
        .with_default_p_grasp(0.8)
        .with_seed(5);
    let conditions = Conditions::default().with_disturbances(disturbances);
    let scene = Scene::under(&station, &pattern, conditions).unwrap();
    let rules = vec!["SPT"; station.robots().len()].join(",");
    let outcome = simulate_rules(&scene, &rules.parse().unwrap()).unwrap();
    assert!(outcome.picks.len() > 20 && outcome.failures.len() > 2);
    let attempts = attempts(&outcome);
    (station, pattern, attempts)
}

/// Moves each time by up to `most` [s], and the meeting point with the item.
fn shake(station: &Station, pattern: &Pattern, attempts: &Attempts, most: f64) -> Attempts {
    let mut rng = random_stream(11, 0);
    let mut off = || most * (2.0 * rng.random::<f64>() - 1.0);
    let mut shaken = attempts.clone();
    for (pick, _) in &mut shaken {
        pick.decide += off();
        pick.grasp += off();
        pick.release += off();
        pick.meet.x = pattern.items()[pick.item as usize].x0 + station.belt().speed * pick.grasp;
    }
    shaken
}

#[test]
fn times_that_are_off_are_accepted_with_that_tolerance() {
    for name in ["paper", "delta", "sorting"] {
        let (station, pattern, exact) = run_on(name);
        let judged = |attempts: &Attempts, terms| violations(&station, &pattern, attempts, terms);
        assert_eq!(judged(&exact, Terms::default()), [], "{name}");
        for most in [0.0005, 0.01] {
            let shaken = shake(&station, &pattern, &exact, most);
            let found = judged(&shaken, Terms::default());
            assert!(found.len() > 20, "{name}: {}", found.len());
            let tolerant = Terms::default().with_tolerance(most);
            assert_eq!(judged(&shaken, tolerant), [], "{name}, {most} s");
            // Each is accepted from what it says on, and not with less.
            let needed = |v: &Violation| v.accepted_from.unwrap();
            let most_needed = found.iter().map(needed).fold(0.0, f64::max);
            assert!(most_needed <= most, "{name}");
            let enough = Terms::default().with_tolerance(most_needed);
            assert_eq!(judged(&shaken, enough), [], "{name}");
            let less = Terms::default().with_tolerance(most_needed.next_down());
            assert!(!judged(&shaken, less).is_empty(), "{name}");
        }
    }
}

#[test]
fn every_violation_is_listed_with_its_attempt() {
    let (station, pattern, exact) = run_on("sorting");
    let mut bent = exact.clone();
    // In another order than that of the decisions.
    bent.reverse();
    let wrong_bin = bent
        .iter()
        .position(|(pick, _)| station.robots()[pick.robot].bins.len() > 1);
    let wrong_bin = wrong_bin.unwrap();
    let pick = &mut bent[wrong_bin].0;
    pick.bin = (pick.bin + 1) % station.robots()[pick.robot].bins.len() as u16;
    let late = (wrong_bin + 3) % bent.len();
    bent[late].0.release += 0.5;
    let twice = bent[0];
    bent.push(twice);
    let found = violations(&station, &pattern, &bent, Terms::default());
    let of = |attempt: usize| {
        let own = found.iter().filter(move |v| v.attempt == attempt);
        own.map(|v| v.kind).collect::<BTreeSet<_>>()
    };
    assert!(of(wrong_bin).contains(&ViolationKind::Bin), "{found:?}");
    assert!(of(late).contains(&ViolationKind::ReturnTime), "{found:?}");
    let again = of(bent.len() - 1);
    assert!(again.contains(&ViolationKind::Claimed), "{found:?}");
    assert!(again.contains(&ViolationKind::Busy), "{found:?}");
    let right = |v: &&Violation| v.kind == ViolationKind::Bin;
    let bin = found.iter().find(right).unwrap();
    assert!(
        bin.problem.starts_with("the item goes into bin "),
        "{bin:?}"
    );
    assert_eq!(bin.accepted_from, None);
}

#[test]
fn cameras_and_clocks_are_terms() {
    let bench = Bench::new();
    let picks = attempts(&bench.finish(bench.run()));
    let judged = |terms| violations(&bench.station, &bench.pattern, &picks, terms);
    assert_eq!(judged(Terms::default()), []);
    let kinds = |found: &[Violation]| found.iter().map(|v| v.kind).collect::<BTreeSet<_>>();
    // Everything is met upstream of the camera, or long after it.
    assert_eq!(judged(Terms::default().with_camera_x(-1.0)), []);
    let unseen = judged(Terms::default().with_camera_x(1.2));
    assert_eq!(kinds(&unseen), BTreeSet::from([ViolationKind::Unseen]));
    let camera = |v: &Violation| (1.2 - bench.pattern.items()[v.item as usize].x0) / 0.3;
    for violation in &unseen {
        let early = camera(violation) - violation.time;
        assert!((violation.accepted_from.unwrap() - early).abs() < 1e-12);
    }
    let early = |(pick, _): &&(Pick, _)| {
        pick.decide < (1.2 - bench.pattern.items()[pick.item as usize].x0) / 0.3
    };
    assert_eq!(unseen.len(), picks.iter().filter(early).count());
    let off_beat = judged(Terms::default().with_update_hz(0.5));
    assert_eq!(kinds(&off_beat), BTreeSet::from([ViolationKind::OffBeat]));
    let is_off = |(pick, _): &&(Pick, _)| {
        let updates = pick.decide / 2.0;
        (updates - updates.round()).abs() > 1e-6
    };
    let off = picks.iter().filter(is_off).count();
    assert!(off > 2 && off_beat.len() == off, "{off_beat:?}");
    assert!(Terms::default().with_tolerance(-1.0).check().is_err());
    assert!(Terms::default().with_tolerance(f64::NAN).check().is_err());
}

#[test]
fn one_time_that_is_off_is_noticed_from_about_twice_the_tolerance_on() {
    let (station, pattern, exact) = run_on("paper");
    let tolerant = Terms::default().with_tolerance(0.1);
    for (off, is_noticed) in [(0.19, false), (-0.19, false), (0.22, true), (-0.22, true)] {
        let mut bent = exact.clone();
        bent[7].0.release += off;
        let found = violations(&station, &pattern, &bent, tolerant);
        assert_eq!(!found.is_empty(), is_noticed, "{off}: {found:?}");
    }
}

#[test]
fn times_in_the_wrong_order_are_named_as_such() {
    let (station, pattern, exact) = run_on("sorting");
    for (field, words) in [
        (0, "before it leaves at"),
        (1, "in the bin at 1 s, before the grasp begins at"),
    ] {
        let mut bent = exact.clone();
        let pick = &mut bent[7].0;
        match field {
            0 => pick.decide = pick.grasp + 1.0,
            _ => pick.release = 1.0,
        }
        let found = violations(&station, &pattern, &bent, Terms::default());
        let named = |v: &Violation| v.attempt == 7 && v.problem.contains(words);
        assert!(found.iter().any(named), "{words}: {found:?}");
    }
}
