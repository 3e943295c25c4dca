//! How near searches come to the proven optimum with a twentieth of the enumeration's robot passes:
//! `cargo bench --bench search`. Each line is enumerated once; then every method runs from 20 seeds
//! until its passes are used up. Passes are counted after merging: all methods keep what the line left
//! after each beginning (`PrefixGraph`).
//!
//! `cargo bench --bench search -- tune` uses other lines and other patterns. Settings are chosen on
//! those. Without `--bench`, as under `cargo test`, one small line and two seeds show that it still runs.

use pickline::RuleAssignment;
use pickline::dispatch::Rule;
use pickline::optimize::{
    Environment, Evaluator, Grasp, Limits, Objective, Search, SearchKind, Stop, find_optimum,
};
use pickline::pattern::{Pattern, PatternSource, Recipe, random_stream};
use pickline::sim::{Conditions, PrefixGraph, Scene};
use pickline::station::{Station, built_in};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::HashMap;

const SEEDS: u64 = 20;
const SEEDS_OF_TEST: u64 = 2;
/// Share of the enumeration's passes that a method has.
const SHARE: f64 = 0.05;
const MEMORY: usize = 1_000_000_000;
/// A method whose assignments are all known uses no passes; it ends after this many in vain.
const IN_VAIN: usize = 10_000;

/// A line on which searches are compared.
struct Line {
    station: &'static str,
    robots: usize,
    /// Belt speed [m/s], at which the robots cannot pick everything of most patterns.
    speed: f64,
    patterns: &'static str,
    seed: u64,
}

const fn line(
    station: &'static str,
    robots: usize,
    speed: f64,
    patterns: &'static str,
    seed: u64,
) -> Line {
    Line {
        station,
        robots,
        speed,
        patterns,
        seed,
    }
}

/// For `cargo test`.
const TESTED: [Line; 1] = [line("paper", 3, 0.1, "balanced:12", 7)];

const REPORTED: [Line; 9] = [
    line("paper", 4, 0.12, "balanced:120", 1),
    line("paper", 5, 0.15, "balanced:120", 1),
    line("paper", 6, 0.18, "balanced:120", 1),
    line("paper-narrow", 4, 0.16, "balanced:120", 1),
    line("paper-narrow", 5, 0.2, "balanced:120", 1),
    line("paper-narrow", 6, 0.24, "balanced:120", 1),
    line("paper", 4, 0.12, "random:200/min:240", 1),
    line("paper", 5, 0.15, "random:250/min:240", 1),
    line("paper", 6, 0.18, "random:300/min:240", 1),
];

const TUNED: [Line; 6] = [
    line("paper", 4, 0.1, "balanced:120", 7),
    line("paper", 5, 0.12, "poisson:0.15:240", 7),
    line("paper", 6, 0.16, "balanced:120", 7),
    line("paper-narrow", 4, 0.14, "random:150/min:240", 7),
    line("paper-narrow", 5, 0.18, "balanced:120", 7),
    line("paper-narrow", 6, 0.2, "clustered:200/min:240", 7),
];

/// Set as soon as an evaluator has used up its passes.
struct Spent<'e, 'a> {
    evaluator: &'e Evaluator<'a>,
    most: u64,
}

impl Stop for Spent<'_, '_> {
    fn is_set(&self) -> bool {
        self.evaluator.passes() >= self.most
    }
}

/// Scores assignments one by one until the passes are used up.
struct Scorer<'a> {
    graphs: Vec<PrefixGraph<'a>>,
    most: u64,
    /// Since the passes last grew.
    in_vain: usize,
    best: Option<(Vec<Rule>, f64)>,
}

impl<'a> Scorer<'a> {
    fn new(scenes: &'a [Scene<'a>], most: u64) -> Self {
        let graph = |scene| PrefixGraph::new(scene, MEMORY / scenes.len());
        Self {
            graphs: scenes.iter().filter_map(graph).collect(),
            most,
            in_vain: 0,
            best: None,
        }
    }

    fn passes(&self) -> u64 {
        self.graphs.iter().map(PrefixGraph::passes).sum()
    }

    /// Mean picking rate; `None` once the passes are used up.
    fn score(&mut self, rules: &[Rule]) -> Option<f64> {
        let before = self.passes();
        if before >= self.most || self.in_vain > IN_VAIN {
            return None;
        }
        let rates = self.graphs.par_iter_mut();
        let rates: Vec<f64> = rates.map(|g| g.figures(rules).picking_rate()).collect();
        let value = rates.iter().sum::<f64>() / rates.len() as f64;
        let known = self.passes() == before;
        self.in_vain = if known { self.in_vain + 1 } else { 0 };
        if self.best.as_ref().is_none_or(|(_, best)| value > *best) {
            self.best = Some((rules.to_vec(), value));
        }
        Some(value)
    }
}

fn any_rule(rng: &mut ChaCha8Rng) -> Rule {
    let rules: Vec<Rule> = Rule::all().collect();
    rules[rng.random_range(0..rules.len())]
}

fn any_rules(robots: usize, rng: &mut ChaCha8Rng) -> Vec<Rule> {
    (0..robots).map(|_| any_rule(rng)).collect()
}

/// Random search (Brooks 1958, DOI 10.1287/opre.6.2.244).
fn random(scorer: &mut Scorer, robots: usize, rng: &mut ChaCha8Rng) -> Option<()> {
    loop {
        scorer.score(&any_rules(robots, rng))?;
    }
}

/// A genetic algorithm (Reeves 2010, DOI 10.1007/978-1-4419-1665-5_5): tournaments of two, uniform
/// crossover, each rule mutated with probability 1/N, the best survives.
fn genetic(scorer: &mut Scorer, robots: usize, rng: &mut ChaCha8Rng) -> Option<()> {
    const POPULATION: usize = 12;
    let mut people = Vec::new();
    for _ in 0..POPULATION {
        let rules = any_rules(robots, rng);
        people.push((scorer.score(&rules)?, rules));
    }
    loop {
        let best = people.iter().cloned();
        let best = best.reduce(|a, b| if b.0 > a.0 { b } else { a })?;
        let mut children = vec![best];
        while children.len() < POPULATION {
            let mut parent = || {
                let [a, b] = [0, 0].map(|_| &people[rng.random_range(0..POPULATION)]);
                if b.0 > a.0 { b.1.clone() } else { a.1.clone() }
            };
            let (mother, father) = (parent(), parent());
            let mut child = Vec::with_capacity(robots);
            for robot in 0..robots {
                let rule = if rng.random_bool(0.5) {
                    mother[robot]
                } else {
                    father[robot]
                };
                let mutates = rng.random_bool(1.0 / robots as f64);
                child.push(if mutates { any_rule(rng) } else { rule });
            }
            children.push((scorer.score(&child)?, child));
        }
        people = children;
    }
}

/// Iterated best response: from a random assignment, robots take turns to change to the rule that is
/// best for the line, until none changes; then from another one.
fn responses(scorer: &mut Scorer, robots: usize, rng: &mut ChaCha8Rng) -> Option<()> {
    loop {
        let mut at = any_rules(robots, rng);
        let mut value = scorer.score(&at)?;
        let (mut robot, mut content) = (0, 0);
        while content < robots {
            content += 1;
            for rule in Rule::all() {
                let mut other = at.clone();
                other[robot] = rule;
                let found = scorer.score(&other)?;
                if found > value {
                    (at, value, content) = (other, found, 1);
                }
            }
            robot = (robot + 1) % robots;
        }
    }
}

type Method = fn(&mut Scorer, usize, &mut ChaCha8Rng) -> Option<()>;

const OTHERS: [(&str, Method); 3] = [
    ("random search", random),
    ("genetic algorithm", genetic),
    ("best response", responses),
];

/// What GRASP finds within `most` passes, and the passes it used.
fn grasp(
    station: &Station,
    patterns: &[Pattern],
    most: u64,
    seed: u64,
) -> Option<(RuleAssignment, u64)> {
    let plain = Conditions::default();
    let evaluator = Evaluator::new(station, patterns, Objective::PickingRate, &plain).ok()?;
    let spent = Spent {
        evaluator: &evaluator,
        most,
    };
    let environment = Environment {
        stop: &spent,
        ..Environment::QUIET
    };
    let search = Search::default()
        .with_kind(SearchKind::Grasp)
        .with_grasp(Grasp::default().with_seed(seed))
        .with_scan(None)
        .with_limits(Limits::NONE);
    let found = find_optimum(&evaluator, &search, &environment).ok()?;
    Some((found.ranking.leader, evaluator.passes()))
}

/// Prints how often `found` is the optimum, and how far from it otherwise.
fn row(name: &str, best: f64, enumeration: u64, found: &[(Option<f64>, u64)]) {
    let gaps: Vec<f64> = found
        .iter()
        .map(|(value, _)| best - value.unwrap_or(0.0))
        .collect();
    let optimal = gaps.iter().filter(|gap| **gap < 1e-9).count();
    let mean = gaps.iter().sum::<f64>() / gaps.len() as f64;
    let worst = gaps.iter().copied().fold(0.0, f64::max);
    let passes = found.iter().map(|(_, passes)| *passes).sum::<u64>() as f64;
    let share = 100.0 * passes / found.len() as f64 / enumeration as f64;
    println!(
        "| | {name} | {optimal} of {} | {mean:.4} | {worst:.4} | {share:.2} |",
        found.len()
    );
}

fn compare(line: &Line, seeds: u64, others: bool) {
    let station = built_in(line.station).and_then(|s| s.station(Some(line.robots)));
    let station = station.and_then(|s| s.with_belt_speed(line.speed)).unwrap();
    let source: PatternSource = line.patterns.parse().unwrap();
    let set = source
        .build(&Recipe::new(*station.belt(), 150, line.seed))
        .unwrap();
    let plain = Conditions::default();
    let evaluator =
        Evaluator::new(&station, &set.patterns, Objective::PickingRate, &plain).unwrap();
    assert_eq!(evaluator.independent_patterns(), evaluator.pattern_count());
    let all = RuleAssignment::all(line.robots).collect();
    let all = evaluator.evaluate(all, &Environment::QUIET).unwrap();
    let enumeration = evaluator.passes();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let values: HashMap<&RuleAssignment, f64> = all
        .assignments
        .iter()
        .zip(all.scores.iter().map(|score| mean(&score.values)))
        .collect();
    let best = values.values().copied().fold(f64::NEG_INFINITY, f64::max);
    let equal = values
        .values()
        .filter(|value| best - **value < 1e-9)
        .count();
    let picked = all
        .scores
        .iter()
        .map(|s| s.picked_share)
        .fold(0.0, f64::max);
    println!(
        "| {} x {} at {} m/s, {} | optimum {best:.4} 1/min ({equal} assignments, {:.0} % picked) | | | | {:.0} a pattern |",
        line.station,
        line.robots,
        line.speed,
        line.patterns,
        100.0 * picked,
        enumeration as f64 / set.patterns.len() as f64
    );
    let most = (SHARE * enumeration as f64) as u64;
    let found: Vec<_> = (1..=seeds)
        .map(|seed| {
            let found = grasp(&station, &set.patterns, most, seed);
            let passes = found.as_ref().map_or(most, |(_, passes)| *passes);
            (found.map(|(assignment, _)| values[&assignment]), passes)
        })
        .collect();
    row("GRASP", best, enumeration, &found);
    let scenes: Vec<Scene> = set
        .patterns
        .iter()
        .map(|pattern| Scene::new(&station, pattern).unwrap())
        .collect();
    for (name, method) in OTHERS.iter().filter(|_| others) {
        let run = |seed| {
            let mut scorer = Scorer::new(&scenes, most);
            method(&mut scorer, line.robots, &mut random_stream(seed, 0));
            let value = scorer
                .best
                .as_ref()
                .map(|(rules, _)| values[&RuleAssignment::new(rules.clone())]);
            (value, scorer.passes())
        };
        let found: Vec<_> = (1..=seeds).map(run).collect();
        row(name, best, enumeration, &found);
    }
}

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).collect();
    let asks = |word: &str| asked.iter().any(|arg| arg == word);
    let (lines, seeds) = match (asks("--bench"), asks("tune")) {
        (false, _) => (&TESTED[..], SEEDS_OF_TEST),
        (true, false) => (&REPORTED[..], SEEDS),
        (true, true) => (&TUNED[..], SEEDS),
    };
    println!("| line | method | in the optimum | mean gap [1/min] | worst | passes [%] |");
    println!("|---|---|---|---|---|---|");
    let robots = |line: &&Line| match asked.iter().find_map(|arg| arg.parse::<usize>().ok()) {
        Some(robots) => line.robots == robots,
        None => true,
    };
    for line in lines.iter().filter(robots) {
        compare(line, seeds, !asks("grasp"));
    }
}
