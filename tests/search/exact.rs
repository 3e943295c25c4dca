//! Branch and bound against the enumeration.

use crate::common::text;
use crate::real_lines;
use pickline::optimize::{
    Environment, Evaluator, Limits, MostRuns, Objective, Optimum, Risk, Search, SearchKind,
    StopReason, find_optimum,
};
use pickline::pattern::{Item, Pattern, PatternSource, Recipe};
use pickline::sim::Conditions;
use pickline::station::{Station, built_in};
use proptest::prelude::*;

fn search(
    (station, patterns): (&Station, &[Pattern]),
    (objective, risk): (Objective, Risk),
    kind: SearchKind,
    runs: MostRuns,
) -> Optimum {
    let evaluator = Evaluator::new(station, patterns, objective, &Conditions::default()).unwrap();
    let search = Search::default()
        .with_kind(kind)
        .with_risk(risk)
        .with_scan(None)
        .with_limits(Limits::default().with_runs(runs));
    find_optimum(&evaluator, &search, &Environment::QUIET).unwrap()
}

/// Patterns whose items have rewards of their own, unless `equal`.
fn patterns(station: &Station, count: usize, items: usize, equal: bool) -> Vec<Pattern> {
    let recipe = Recipe::new(*station.belt(), items, 7);
    let set = PatternSource::Balanced(count).build(&recipe).unwrap();
    let weigh = |pattern: Pattern| {
        let items = pattern.items().iter().enumerate();
        let items = items.map(|(i, item)| Item {
            weight: Some(if equal {
                0.5
            } else {
                0.1 + (i * 7 % 13) as f64
            }),
            ..item.clone()
        });
        Pattern::new(items.collect()).unwrap()
    };
    set.patterns.into_iter().map(weigh).collect()
}

/// The best figure and every assignment that has it.
fn winners(optimum: &Optimum) -> (f64, Vec<String>) {
    let entries = &optimum.ranking.entries;
    let best = entries.iter().map(|e| e.value).fold(0.0, f64::max);
    let mut names: Vec<String> = entries
        .iter()
        .filter(|e| e.value == best)
        .map(|e| e.assignment.to_string())
        .collect();
    names.sort();
    (best, names)
}

/// The same best figure to the bit, on lines that miss much and lines that miss nothing, in a part of the
/// passes.
#[test]
fn what_it_proves_is_what_the_enumeration_finds() {
    const OBJECTIVES: [Objective; 3] = [
        Objective::PickingRate,
        Objective::PickedShare,
        Objective::WeightedRate,
    ];
    let (mut cases, mut spared) = (0, 0);
    let mut check = |name: &str, robots: usize, speed: f64, equal: bool, risk: Risk| {
        let station = built_in(name).unwrap().station(Some(robots)).unwrap();
        let station = station.with_belt_speed(speed).unwrap();
        let patterns = patterns(&station, 4, 40, equal);
        for objective in OBJECTIVES {
            let of = |kind| {
                let line = (&station, &patterns[..]);
                search(line, (objective, risk), kind, MostRuns::Any)
            };
            let (whole, exact) = (of(SearchKind::Exhaustive), of(SearchKind::Exact));
            let case = format!("{name} {robots} {speed} {objective:?} {risk}");
            let ((best, all), (found, some)) = (winners(&whole), winners(&exact));
            assert_eq!(found, best, "{case}");
            assert!(
                !some.is_empty() && some.iter().all(|name| all.contains(name)),
                "{case}"
            );
            let proof = exact.proof.unwrap();
            assert_eq!(
                (exact.stop, exact.kind),
                (StopReason::Proven, SearchKind::Exact)
            );
            assert_eq!((proof.most, proof.gap), (best, 0.0), "{case}");
            assert!(whole.proof.is_none());
            cases += 1;
            spared += usize::from((proof.passes as f64) < 0.5 * proof.tree_passes);
        }
    };
    check("paper", 3, 0.05, true, Risk::Mean);
    check("paper", 4, 0.15, true, Risk::Mean);
    check("paper", 3, 0.2, false, Risk::Mean);
    check("paper-narrow", 3, 0.1, false, Risk::Mean);
    check("delta", 3, 0.4, false, Risk::Mean);
    check("delta", 3, 0.6, true, Risk::Mean);
    check("paper", 2, 0.15, false, Risk::Worst);
    check("delta", 3, 0.6, true, Risk::Cvar(0.25));
    // Ceilings that spare nothing would pass the rest.
    assert!(spared * 2 > cases, "{spared} of {cases}");
}

/// Cut short, its bound holds, and more runs never make it worse.
#[test]
fn where_runs_end_the_bound_is_above_the_optimum() {
    let station = built_in("paper").unwrap().station(Some(4)).unwrap();
    let station = station.with_belt_speed(0.15).unwrap();
    let patterns = patterns(&station, 4, 60, true);
    let of = |kind, runs| {
        let line = (&station, &patterns[..]);
        search(line, (Objective::PickingRate, Risk::Mean), kind, runs)
    };
    let (best, _) = winners(&of(SearchKind::Exhaustive, MostRuns::Any));
    let mut gaps = Vec::new();
    for runs in [60, 1000, 4000, 16_000] {
        let found = of(SearchKind::Exact, MostRuns::Of(runs));
        let proof = found.proof.clone().unwrap();
        let (value, _) = winners(&found);
        assert!(proof.most >= best && best >= value, "{runs}");
        assert_eq!(proof.gap, proof.most - value);
        assert!(found.runs <= runs, "{} of {runs}", found.runs);
        assert_eq!(found.stop == StopReason::Proven, proof.gap == 0.0);
        gaps.push(proof.gap);
    }
    assert!(gaps[0] > 0.0 && gaps[3] == 0.0, "{gaps:?}");
    assert!(gaps.is_sorted_by(|a, b| a >= b), "{gaps:?}");
}

/// The same bytes with any number of threads, proven or cut short by its runs.
#[test]
fn the_number_of_threads_changes_nothing() {
    let line = "optimize -q --format json --validate 0 --patterns balanced:20 --items 40 --robots 5 \
                --belt-speed 0.15 --search exact --max-runs";
    for (runs, reason) in [("400", "budget"), ("100000", "proven")] {
        let call = |threads| {
            let rest = [runs, "--threads", threads];
            text(&line.split_whitespace().chain(rest).collect::<Vec<_>>())
        };
        let one = call("1");
        assert_eq!(one, call("3"), "{runs}");
        let report: serde_json::Value = serde_json::from_str(&one).unwrap();
        assert_eq!(report["stop_reason"], reason);
        assert_eq!(
            report["proof"]["gap"] == 0.0,
            reason == "proven",
            "{report}"
        );
    }
}

/// Nothing can be picked: whatever the runs are, the bound is the figure of a line that stands still.
#[test]
fn a_pattern_out_of_reach_is_bounded() {
    let station = built_in("paper").unwrap().station(Some(1)).unwrap();
    let robot = &station.robots()[0];
    // Robots stand behind one edge of the belt and do not reach the other.
    let far = -0.5 * robot.base.y.signum();
    let patterns = [Pattern::new(vec![Item::at("far", -0.1, far)]).unwrap()];
    for runs in [MostRuns::Of(1), MostRuns::Of(20), MostRuns::Any] {
        let line = (&station, &patterns[..]);
        let risk = Risk::Mean;
        let found = search(
            line,
            (Objective::PickingRate, risk),
            SearchKind::Exact,
            runs,
        );
        let proof = found.proof.unwrap();
        assert_eq!((proof.most, proof.gap), (0.0, 0.0), "{runs:?}");
    }
}

/// Not even the longest line with spare robots takes long: what is left after a prefix is nothing.
#[test]
fn sixteen_robots_with_nothing_left_to_pick_are_proven() {
    let station = built_in("paper").unwrap().station(Some(16)).unwrap();
    let patterns = patterns(&station, 4, 40, true);
    let line = (&station, &patterns[..]);
    let of = |kind| {
        search(
            line,
            (Objective::PickingRate, Risk::Mean),
            kind,
            MostRuns::Usual,
        )
    };
    let (exact, auto) = (of(SearchKind::Exact), of(SearchKind::Auto));
    for found in [exact, auto] {
        let proof = found.proof.unwrap();
        assert_eq!((found.stop, proof.gap), (StopReason::Proven, 0.0));
        assert!(proof.merged > 0 && proof.passes < 100_000);
        assert_eq!(found.ranking.best().assignment.rules().len(), 16);
    }
}

#[test]
fn lines_on_which_robots_depend_on_each_other_are_refused() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let patterns = patterns(&station, 2, 10, true);
    let failing = Conditions::default()
        .with_disturbances(pickline::sim::Disturbances::default().with_grasp_failures(true));
    let search = Search::default().with_kind(SearchKind::Exact);
    for (objective, conditions, words) in [
        (Objective::PickingRate, failing, "pick independently"),
        (
            Objective::MaxSpeed(Default::default()),
            Conditions::default(),
            "max-speed",
        ),
    ] {
        let evaluator = Evaluator::new(&station, &patterns, objective, &conditions).unwrap();
        let told = find_optimum(&evaluator, &search, &Environment::QUIET).unwrap_err();
        assert!(told.to_string().contains(words), "{told}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Arms that accelerate or follow tables, bins, classes, lines that pick next to nothing: the same best
    /// figure to the bit.
    #[test]
    fn on_any_line_whose_robots_are_independent(
        (station, patterns) in real_lines::stations().prop_flat_map(|station| {
            let width = station.belt().width;
            let patterns = prop::collection::vec(real_lines::patterns(width, 24), 1..4);
            (Just(station), patterns)
        }),
    ) {
        let wanted = Evaluator::new(
            &station, &patterns, Objective::PickingRate, &Conditions::default());
        let independent = wanted.is_ok_and(|of| of.independent_patterns() == of.pattern_count());
        prop_assume!(independent);
        for objective in [Objective::PickingRate, Objective::PickedShare, Objective::WeightedRate] {
            let of = |kind| {
                search((&station, &patterns[..]), (objective, Risk::Mean), kind, MostRuns::Any)
            };
            let (best, all) = winners(&of(SearchKind::Exhaustive));
            let exact = of(SearchKind::Exact);
            let (found, some) = winners(&exact);
            prop_assert_eq!(found, best);
            prop_assert!(some.iter().all(|name| all.contains(name)));
            prop_assert_eq!(exact.proof.unwrap().gap, 0.0);
        }
    }
}
