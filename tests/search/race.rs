//! Races of assignments on real simulations, where the true order is known from many patterns.

use pickline::RuleAssignment;
use pickline::optimize::{Environment, Evaluator, Objective};
use pickline::pattern::{PatternSource, Recipe};
use pickline::sim::{AssignmentTree, Conditions};
use pickline::station::{Station, built_in};
use pickline::study::{RaceOptions, RaceStop, ScoredPatterns, race};
use std::collections::HashMap;

const ITEMS: usize = 24;

fn line() -> Station {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    station.with_belt_speed(0.2).unwrap()
}

fn patterns() -> ScoredPatterns {
    let source: PatternSource = "poisson:0.2:10".parse().unwrap();
    ScoredPatterns::from(source).with_items(ITEMS)
}

fn options(delta: f64) -> RaceOptions {
    RaceOptions::new(delta).with_patterns(patterns())
}

/// From other seeds each race selects an assignment that is, over 4,000 other patterns, as good as the
/// best but for the indifference zone.
#[test]
fn races_select_what_is_best_over_many_patterns() {
    let station = line();
    let source = PatternSource::Poisson(0.2, 4000);
    let set = source
        .build(&Recipe::new(*station.belt(), ITEMS, 12_345))
        .unwrap();
    let plain = Conditions::default();
    let evaluator =
        Evaluator::new(&station, &set.patterns, Objective::PickingRate, &plain).unwrap();
    let all = RuleAssignment::all(2).collect();
    let all = evaluator.evaluate(all, &Environment::QUIET).unwrap();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let means = all.scores.iter().map(|score| mean(&score.values));
    let means: HashMap<&RuleAssignment, f64> = all.assignments.iter().zip(means).collect();
    let best = means.values().copied().fold(f64::NEG_INFINITY, f64::max);
    let worst = means.values().copied().fold(f64::INFINITY, f64::min);
    let delta = 0.1;
    // There is something to be told apart.
    assert!(best - worst > 10.0 * delta, "{best} {worst}");
    for seed in 1..=12 {
        let found = race(
            &station,
            &options(delta).with_seed(seed),
            &Environment::QUIET,
        )
        .unwrap();
        assert!(found.stop.is_selected(), "{seed}: {:?}", found.stop);
        assert_eq!(found.probability(), Some(0.95));
        let short = best - means[&found.best().assignment];
        assert!(
            short < delta,
            "{seed}: {} is {short} below",
            found.best().assignment
        );
        assert_eq!(found.survivors.len() + found.dropped.len(), 36);
        // Passes of dropped assignments are spared.
        let most = AssignmentTree::all(2).passes() as u64 * found.patterns as u64;
        assert_eq!(found.enumeration_passes, most);
        assert!(found.passes < most, "{} of {most}", found.passes);
        let order = found.dropped.windows(2);
        assert!(
            order
                .clone()
                .all(|pair| pair[0].patterns >= pair[1].patterns)
        );
        assert!(
            found
                .dropped
                .iter()
                .all(|racer| racer.behind > 0.0 && racer.patterns >= 200)
        );
    }
}

/// The number of threads changes nothing, and the same seed draws the same patterns.
#[test]
fn a_race_is_the_same_on_any_number_of_threads() {
    let station = line();
    let on = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let options = options(0.3).with_seed(seed);
        let found = pool
            .install(|| race(&station, &options, &Environment::QUIET))
            .unwrap();
        (found.survivors, found.dropped, found.patterns, found.passes)
    };
    assert_eq!(on(1, 3), on(3, 3));
    assert_ne!(on(1, 3), on(1, 4));
}

/// A race that runs out of patterns guarantees nothing and says so.
#[test]
fn a_race_without_enough_patterns_guarantees_nothing() {
    let station = line();
    let options = options(1e-4).with_max_patterns(250);
    let found = race(&station, &options, &Environment::QUIET).unwrap();
    assert_eq!((found.stop, found.patterns), (RaceStop::MaxPatterns, 250));
    assert_eq!(found.probability(), None);
    assert!(found.survivors.len() > 1);
    let sorted = found
        .survivors
        .windows(2)
        .all(|pair| pair[0].mean >= pair[1].mean);
    assert!(sorted && found.best().behind == 0.0);
}
