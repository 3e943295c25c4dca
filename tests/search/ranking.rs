//! How assignments are ranked under risk, on part of the patterns and beside GRASP, worked out
//! from single runs.

use super::scores::{GO_ON, enumeration, environment, evaluate, figures, patterns, rate, station};
use pickline::dispatch::RuleAssignment;
use pickline::optimize::{
    Evaluator, Grasp, Objective, Ranked, Ranking, Risk, SearchKind, TieBreak, find_optimum,
};
use pickline::pattern::{Pattern, PatternSource, Recipe, poisson_disk, random_stream};
use pickline::sim::Conditions;
use pickline::station::built_in;

/// Ties are broken by the worst pattern, without speed limits.
const WITHOUT: TieBreak = TieBreak {
    scan: None,
    runs: u64::MAX,
};

/// Under risk those that are proven worse follow by their aggregate, not by their mean.
#[test]
fn the_proven_worse_are_ranked_by_their_aggregate() {
    let station = station();
    let disk = |seed| poisson_disk(1.05, 0.18, 40, &mut random_stream(seed, 0)).unwrap();
    let patterns: Vec<Pattern> = (1..=5).map(disk).collect();
    let plain = Conditions::default();
    let evaluator = Evaluator::new(&station, &patterns, Objective::PickingRate, &plain).unwrap();
    let evaluation = evaluate(&evaluator);
    let environment = environment(&GO_ON);
    let mut otherwise = 0;
    // The lowest of five values, and the mean of the two lowest.
    for (risk, count) in [(Risk::Worst, 1), (Risk::Cvar(0.4), 2)] {
        let ranking = Ranking::new(&evaluation, &evaluator, risk, WITHOUT, &environment);
        let ranking = ranking.unwrap().unwrap();
        let worse = &ranking.entries[ranking.contenders..];
        let lowest = |entry: &Ranked| {
            let rate = |pattern| rate(&figures(&station, pattern, &plain, &entry.assignment));
            let mut rates: Vec<f64> = patterns.iter().map(rate).collect();
            rates.sort_by(f64::total_cmp);
            rates[..count].iter().sum::<f64>() / count as f64
        };
        let values: Vec<f64> = worse.iter().map(lowest).collect();
        let falls = |pair: &[f64]| pair[1] <= pair[0] + 1e-9;
        assert!(values.windows(2).all(falls), "{risk}: {values:?}");
        otherwise += usize::from(!worse.is_sorted_by(|a, b| b.mean <= a.mean));
    }
    assert!(otherwise > 0);
}

/// On part of the patterns the worst of them is still told by its place among all.
#[test]
fn the_worst_pattern_of_a_sample_has_its_index_in_the_set() {
    let (station, patterns) = (station(), patterns());
    let plain = Conditions::default();
    let evaluator = Evaluator::new(&station, &patterns, Objective::PickingRate, &plain).unwrap();
    let sample = evaluator.sample(2);
    let evaluation = evaluate(&sample);
    assert_ne!(evaluation.patterns, [0, 1]);
    let environment = environment(&GO_ON);
    let ranking = Ranking::new(&evaluation, &sample, Risk::Mean, WITHOUT, &environment);
    for entry in ranking.unwrap().unwrap().entries {
        assert!(evaluation.patterns.contains(&entry.worst_pattern));
        let worst = &patterns[entry.worst_pattern];
        let worst = rate(&figures(&station, worst, &plain, &entry.assignment));
        assert!((entry.worst - worst).abs() < 1e-12, "{entry:?}");
        assert!(entry.worst <= entry.mean);
    }
}

/// The gap is what the best of all has more than what GRASP found, also where a single start at random
/// climbs to a local optimum and no further.
#[test]
fn the_gap_says_what_grasp_missed() {
    let line = built_in("paper").unwrap().station(Some(4)).unwrap();
    let line = line.with_belt_speed(0.12).unwrap();
    let plain = Conditions::default();
    let dense: PatternSource = "poisson:0.12:3".parse().unwrap();
    let mut missed = 0;
    for seed in 1..=12 {
        let recipe = Recipe::new(*line.belt(), 60, seed);
        let patterns = dense.build(&recipe).unwrap().patterns;
        let evaluator = Evaluator::new(&line, &patterns, Objective::PickingRate, &plain).unwrap();
        let how = enumeration()
            .with_kind(SearchKind::Both)
            .with_grasp(Grasp::default().with_starts(1).with_alpha(1.0));
        let found = find_optimum(&evaluator, &how, &environment(&GO_ON)).unwrap();
        let reached = found.grasp.unwrap().best.unwrap();
        let mean = |rules: &RuleAssignment| {
            let rates = patterns
                .iter()
                .map(|p| rate(&figures(&line, p, &plain, rules)));
            rates.sum::<f64>() / 3.0
        };
        let highest = RuleAssignment::all(4).map(|rules| mean(&rules));
        let gap = highest.fold(0.0, f64::max) - mean(&reached);
        assert!((found.grasp_gap.unwrap() - gap).abs() < 1e-9, "seed {seed}");
        if gap > 0.01 {
            missed += 1;
        }
    }
    assert!(missed > 0, "one start never misses the best");
}
