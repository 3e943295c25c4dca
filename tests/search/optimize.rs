//! What the search must find.

use pickline::dispatch::RuleAssignment;
use pickline::optimize::{
    Environment, Evaluator, Limits, Objective, Optimum, Progress, Risk, Search, SearchKind, Silent,
    SpeedScan, StopReason, find_optimum,
};
use pickline::pattern::{Item, Pattern, PatternSource, Recipe};
use pickline::sim::Conditions;
use pickline::station::{Station, built_in};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

fn both_methods() -> Search {
    Search::default()
        .with_kind(SearchKind::Both)
        .with_limits(Limits::NONE)
}

fn search(station: &Station, patterns: &[Pattern], objective: Objective, how: &Search) -> Optimum {
    let stop = AtomicBool::new(false);
    let environment = Environment {
        stop: &stop,
        progress: &Silent,
        ..Environment::QUIET
    };
    let evaluator = Evaluator::new(station, patterns, objective, &Conditions::default()).unwrap();
    find_optimum(&evaluator, how, &environment).unwrap()
}

fn balanced(station: &Station, items: usize, seed: u64) -> Vec<Pattern> {
    let recipe = Recipe::new(*station.belt(), items, seed);
    PatternSource::Balanced(120)
        .build(&recipe)
        .unwrap()
        .patterns
}

fn assert_best(name: &str, robots: usize, items: usize, seed: u64, expected: &str) {
    let station = built_in(name).unwrap().station(Some(robots)).unwrap();
    let patterns = balanced(&station, items, seed);
    let optimum = search(&station, &patterns, Objective::PickingRate, &both_methods());
    let best = optimum.ranking.best().assignment.to_string();
    assert_eq!(best, expected, "{name}, {robots} robots, seed {seed}");
    assert_eq!(optimum.stop, StopReason::Enumerated);
    assert_eq!(optimum.patterns, 240);
}

/// Jermann et al., Table 1, for two and three agents, on sets of several seeds.
#[test]
fn the_papers_assignments_come_first_on_the_wide_station() {
    for seed in 1..=4 {
        assert_best("paper", 2, 150, seed, "[SPT; FIFO]");
        assert_best("paper", 3, 150, seed, "[SPT; SPT; FIFO]");
    }
}

#[test]
fn the_papers_assignments_come_first_on_the_narrow_station() {
    for seed in 1..=4 {
        assert_best("paper-narrow", 2, 50, seed, "[SPT; FIFO]");
        assert_best("paper-narrow", 3, 50, seed, "[SPT; SPT; FIFO]");
    }
}

/// Jermann et al., Table 1, for four agents.
#[test]
fn the_papers_assignment_of_four_robots_is_in_the_tied_set() {
    let station = built_in("paper").unwrap().station(Some(4)).unwrap();
    let patterns = balanced(&station, 150, 1);
    let how = both_methods().with_kind(SearchKind::Exhaustive);
    let optimum = search(&station, &patterns, Objective::PickingRate, &how);
    let papers: RuleAssignment = "SPT,SPT,SPT,FIFO".parse().unwrap();
    let entry = optimum
        .ranking
        .entries
        .iter()
        .find(|e| e.assignment == papers);
    assert!(entry.unwrap().tied);
}

/// GRASP alone against the enumeration, under every objective and risk.
#[test]
fn grasp_finds_the_optimum_of_three_robots() {
    let station = built_in("paper").unwrap().station(Some(3)).unwrap();
    let patterns: Vec<Pattern> = balanced(&station, 60, 3).into_iter().step_by(12).collect();
    let scan = SpeedScan::new(0.005, &station).unwrap();
    for objective in [
        Objective::PickingRate,
        Objective::PickedShare,
        Objective::WeightedRate,
        Objective::MaxSpeed(scan),
    ] {
        for risk in [Risk::Mean, Risk::Worst, Risk::Cvar(0.2)] {
            let how = both_methods().with_risk(risk).with_scan(scan);
            let both = search(&station, &patterns, objective, &how);
            let gap = both.grasp_gap.unwrap();
            let best = both
                .ranking
                .entries
                .iter()
                .map(|e| e.value)
                .fold(0.0, f64::max);
            // A local optimum need not be global; it must not be far.
            assert!(
                (0.0..=0.01 * best).contains(&gap),
                "{objective:?} {risk}: {gap} of {best}"
            );
            let alone = how.with_kind(SearchKind::Grasp);
            let alone = search(&station, &patterns, objective, &alone);
            assert_eq!(alone.stop, StopReason::LocalOptima);
            assert_eq!(
                alone.grasp.unwrap().best,
                both.grasp.unwrap().best,
                "scores from the enumeration change nothing"
            );
            assert!(alone.runs < both.runs || objective == Objective::MaxSpeed(scan));
        }
    }
}

#[test]
fn auto_enumerates_short_lines_and_searches_long_ones() {
    for (robots, kind) in [
        (1, SearchKind::Both),
        (2, SearchKind::Exhaustive),
        (3, SearchKind::Exhaustive),
        (4, SearchKind::Both),
        (7, SearchKind::Exact),
    ] {
        let station = built_in("paper").unwrap().station(Some(robots)).unwrap();
        let patterns: Vec<Pattern> = balanced(&station, 20, 3).into_iter().step_by(60).collect();
        let how = both_methods().with_kind(SearchKind::Auto);
        let optimum = search(&station, &patterns, Objective::PickingRate, &how);
        assert_eq!(optimum.kind, kind, "{robots} robots");
    }
}

/// One slow robot that has time for one of two items at its second decision: PP takes
/// the heavy one, FIFO the one ahead of it.
#[test]
fn a_case_with_a_known_answer() {
    let station = built_in("paper").unwrap().station(Some(1)).unwrap();
    let slow = Station::new(
        *station.belt(),
        vec![station.robots()[0].clone().with_dwell(15.0, 10.0)],
    )
    .unwrap();
    let item = |id: &str, x0: f64, y: f64, weight: f64| Item {
        weight: Some(weight),
        ..Item::at(id, x0, y)
    };
    // Both are in reach when the robot decides for the second time; there is time
    // for one of them only.
    let pattern = Pattern::new(vec![
        item("first", 0.0, -0.5, 1.0),
        item("light", -0.4, -0.5, 1.0),
        item("heavy", -0.5, -0.3, 5.0),
    ])
    .unwrap();
    let patterns = [pattern];
    let optimum = search(&slow, &patterns, Objective::WeightedRate, &both_methods());
    let value = |rule: &str| {
        let rule: RuleAssignment = rule.parse().unwrap();
        let found = optimum
            .ranking
            .entries
            .iter()
            .find(|e| e.assignment == rule);
        found.unwrap().value
    };
    assert!(
        value("PP") > 1.5 * value("FIFO"),
        "{} {}",
        value("PP"),
        value("FIFO")
    );
    let best = optimum.ranking.best();
    assert_eq!(best.value, value("PP"));
}

/// The tie-break never lets an assignment win that is proven worse than another.
#[test]
fn no_assignment_is_proven_better_than_the_best() {
    for seed in 1..=4 {
        let station = built_in("paper").unwrap().station(Some(2)).unwrap();
        let patterns = balanced(&station, 150, seed);
        let optimum = search(&station, &patterns, Objective::PickingRate, &both_methods());
        for entry in &optimum.ranking.entries {
            assert!(
                entry.difference.unwrap().high >= 0.0,
                "{}",
                entry.assignment
            );
        }
    }
}

/// What is told within a stage.
#[derive(Default)]
struct Told(Mutex<Vec<String>>);

impl Progress for Told {
    fn begin(&self, _: &str, _: u64, _: &str) {}
    fn advance(&self, _: u64) {}
    fn doing(&self, text: &str) {
        self.0.lock().unwrap().push(text.to_owned());
    }
    fn incumbent(&self, _: &str) {}
    fn end(&self) {}
}

/// A start of GRASP takes minutes on a long line: it tells how far it is. Without a scan no
/// tie is broken by speed.
#[test]
fn a_long_line_reports_how_far_a_start_is() {
    let station = built_in("paper").unwrap().station(Some(7)).unwrap();
    let patterns = &balanced(&station, 20, 1)[..3];
    let plain = Conditions::default();
    let evaluator = Evaluator::new(&station, patterns, Objective::PickingRate, &plain).unwrap();
    let stop = AtomicBool::new(false);
    let told = Told::default();
    let environment = Environment {
        stop: &stop,
        progress: &told,
        ..Environment::QUIET
    };
    let how = both_methods().with_kind(SearchKind::Grasp).with_scan(None);
    let optimum = find_optimum(&evaluator, &how, &environment).unwrap();
    let told = told.0.into_inner().unwrap();
    // The first step of the first start tries every rule for the first robot.
    for pattern in 1..=3 {
        let words = format!("6 assignments at once, pattern {pattern}/3");
        assert!(told[..3].contains(&words), "{words} not in {told:?}");
    }
    assert!(optimum.ranking.contenders > 1);
    let entries = &optimum.ranking.entries;
    assert!(entries.iter().all(|entry| entry.max_speed.is_none()));
}
