//! The flow is a property of the pattern alone: throughput never exceeds it, and equals it
//! where everything is picked, whatever the line.

use pickline::experiment::{Method, Setting, Sweep, sweep_settings};
use pickline::optimize::{Environment, Silent};
use pickline::pattern::{Item, Pattern, PatternSource, Recipe, random_stream};
use pickline::sim::{Conditions, Scene, simulate_rules};
use pickline::station::{Station, built_in};
use pickline::throughput::{SteadyState, Unsteady, steady_state};
use rand::RngExt;
use std::sync::atomic::AtomicBool;

fn paper(robots: usize) -> Station {
    built_in("paper").unwrap().station(Some(robots)).unwrap()
}

fn patterns(source: &str, items: usize, seed: u64) -> Vec<Pattern> {
    let recipe = Recipe::new(*paper(1).belt(), items, seed);
    let source: PatternSource = source.parse().unwrap();
    source.build(&recipe).unwrap().patterns
}

fn swept(stations: Vec<(f64, Station)>, patterns: &[Pattern]) -> Sweep {
    let setting = |(value, station): (f64, Station)| {
        let method = |rule: &str| {
            let rules = vec![rule; station.robots().len()].join(",");
            Method::Robust(rules.parse().unwrap())
        };
        Setting {
            value,
            min_detection: None,
            methods: vec![method("SPT"), method("FIFO")],
            station,
        }
    };
    let settings: Vec<Setting> = stations.into_iter().map(setting).collect();
    let stop = AtomicBool::new(false);
    let environment = Environment {
        stop: &stop,
        progress: &Silent,
        ..Environment::QUIET
    };
    let conditions = Conditions::default();
    sweep_settings(&settings, patterns, &conditions, false, &environment).unwrap()
}

/// Of every random feed and several seeds: lines that pick everything have the flow as their
/// throughput, to the bit, none has more, and the interval is possible.
#[test]
fn lines_that_pick_everything_have_the_flow_as_their_throughput() {
    let mut complete = 0;
    for feed in ["poisson", "random", "clustered", "gaps"] {
        for seed in 1..4 {
            let patterns = patterns(&format!("{feed}:40/min:3"), 500, seed);
            let robots = (1..=5).map(|robots| (robots as f64, paper(robots)));
            let swept = swept(robots.collect(), &patterns);
            let mut flow = None;
            for point in swept.values.iter().flat_map(|at| &at.methods) {
                let of = &point.throughput;
                let (Some(throughput), Some(interval)) = (of.mean, of.interval) else {
                    continue;
                };
                let this = of.flow.unwrap();
                assert_eq!(*flow.get_or_insert(this), this, "{feed} {seed}");
                assert!(
                    0.0 <= interval.low && interval.low <= throughput,
                    "{feed} {seed}: {of:?}"
                );
                assert!(throughput <= interval.high && interval.high <= this * (1.0 + 1e-12));
                let shares = point.picked_share_interval.unwrap();
                assert!(0.0 <= shares.low && shares.high <= 1.0);
                if point.picked_share == 1.0 {
                    assert_eq!(throughput, this, "{feed} {seed}");
                    complete += 1;
                }
            }
            // No robot takes anything away.
            let first = swept.methods().next().unwrap();
            let shares: Vec<f64> = first
                .points()
                .filter_map(|(_, point)| point.throughput.share())
                .collect();
            assert!(
                shares.len() > 1 && shares.windows(2).all(|pair| pair[1] >= pair[0] - 0.01),
                "{feed} {seed}: {shares:?}"
            );
        }
    }
    assert!(complete > 30, "{complete}");
}

/// From some reach on everything is picked, and the least such reach is recommended or one
/// that is as good.
#[test]
fn the_recommended_reach_is_no_matter_of_chance() {
    let patterns = patterns("random:20/min:3", 500, 2);
    let reaches = (14..=24).map(|k| 0.05 * f64::from(k));
    let stations = reaches.map(|reach| (reach, paper(3).with_reach(reach).unwrap()));
    let swept = swept(stations.collect(), &patterns);
    let first = swept.methods().next().unwrap();
    let mut good = first
        .points()
        .filter(|(_, point)| point.picked_share > 0.999);
    let (least, _) = good.next().unwrap();
    let recommended = first.recommended().unwrap();
    assert!(
        recommended <= least,
        "{recommended}, everything from {least}"
    );
}

fn run(pattern: &Pattern, robots: usize) -> Result<SteadyState, Unsteady> {
    let station = paper(robots);
    let scene = Scene::new(&station, pattern).unwrap();
    let rules = vec!["SPT"; robots].join(",").parse().unwrap();
    let outcome = simulate_rules(&scene, &rules).unwrap();
    steady_state(&scene, &outcome)
}

/// A Poisson process whose flow [1/min] is `flow` of the share of the pattern that has passed.
fn changing(minutes: f64, seed: u64, flow: impl Fn(f64) -> f64) -> Pattern {
    let mut random = random_stream(seed, 0);
    let speed = paper(1).belt().speed;
    let step = 0.01;
    let mut items = Vec::new();
    for k in 0..(60.0 * minutes / step) as usize {
        let seconds = k as f64 * step;
        if random.random::<f64>() < flow(seconds / (60.0 * minutes)) * step / 60.0 {
            let y = random.random_range(-0.5..0.5);
            items.push(Item::at(items.len().to_string(), -seconds * speed, y));
        }
    }
    Pattern::new(items).unwrap()
}

/// A shift with a rush, a ramp, a shift that ends slowly: the throughput is the mean over it,
/// near the picked share times the mean flow, whatever the seed, and said to be one.
#[test]
fn a_flow_that_changes_gives_the_mean_over_the_pattern() {
    let profiles: [&dyn Fn(f64) -> f64; 3] = [
        &|at| {
            if (0.4..0.6).contains(&at) {
                160.0
            } else {
                20.0
            }
        },
        &|at| 5.0 + 90.0 * at,
        &|at| if at < 0.5 { 90.0 } else { 15.0 },
    ];
    for (place, profile) in profiles.into_iter().enumerate() {
        for seed in 1..4 {
            let pattern = changing(60.0, seed, profile);
            let steady = run(&pattern, 2).unwrap();
            assert!(steady.flow_changes, "{place} {seed}");
            let scene_share = {
                let station = paper(2);
                let scene = Scene::new(&station, &pattern).unwrap();
                let rules = "SPT,SPT".parse().unwrap();
                simulate_rules(&scene, &rules)
                    .unwrap()
                    .figures
                    .picked_share()
            };
            let mean = pattern.len() as f64 / 60.0;
            assert!((steady.flow / mean - 1.0).abs() < 0.02, "{place} {seed}");
            let ratio = steady.throughput / (scene_share * mean);
            assert!((ratio - 1.0).abs() < 0.03, "{place} {seed}: {ratio}");
        }
    }
    // Nor is what does not change said to.
    for seed in 1..20 {
        let steady = run(&changing(60.0, seed, |_| 60.0), 2).unwrap();
        assert!(!steady.flow_changes, "{seed}");
    }
}

/// Nobody is asked for more items of a shift that is what it is.
#[test]
fn a_changing_flow_is_not_asked_for_more_items() {
    for seed in 1..6 {
        let steps = |at: f64| [10.0, 120.0][(at * 31.0) as usize % 2];
        let pattern = changing(30.0, seed, steps);
        let steady = run(&pattern, 1);
        assert!(steady.is_ok(), "{seed}: {steady:?}");
    }
}
