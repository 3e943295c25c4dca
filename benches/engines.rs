//! What the engines cost: `cargo bench`. Criterion times each piece; the last lines
//! compare pieces that were run in turn, so that the ratios hold on a busy machine.

use criterion::{BenchmarkId, Criterion, Throughput};
use pickline::dispatch::{Rule, RuleAssignment, RuleStrategy};
use pickline::kinematics::{Arm, TravelLaw};
use pickline::pattern::{Pattern, PatternSource, Recipe, grid, poisson_disk, random_stream};
use pickline::sim::{AssignmentTree, Cascade, Scene, simulate};
use pickline::station::{Station, built_in};
use std::hint::black_box;
use std::time::{Duration, Instant};

fn station(robots: usize) -> Station {
    built_in("paper").unwrap().station(Some(robots)).unwrap()
}

/// A few patterns spread over the balanced set.
fn patterns() -> Vec<Pattern> {
    let recipe = Recipe::new(
        pickline::station::Belt {
            speed: 0.05,
            length: 4.2,
            width: 1.05,
        },
        150,
        1,
    );
    PatternSource::Balanced(3).build(&recipe).unwrap().patterns
}

/// All assignments of four robots on `scene`, sharing what they have in common.
fn by_tree(scene: &Scene, tree: &AssignmentTree) -> usize {
    let mut picked = 0;
    tree.evaluate(scene, |_, figures| picked += figures.picked)
        .unwrap();
    picked
}

/// The same, one by one in the general event loop.
fn one_by_one(scene: &Scene, tree: &AssignmentTree) -> usize {
    let run = |rules: &RuleAssignment| {
        let mut strategy = RuleStrategy(rules.clone());
        simulate(scene, &mut strategy).unwrap().figures.picked
    };
    tree.assignments().iter().map(run).sum()
}

fn enumeration(c: &mut Criterion) {
    let station = station(4);
    let patterns = patterns();
    let scenes: Vec<_> = patterns
        .iter()
        .map(|pattern| Scene::new(&station, pattern).unwrap())
        .collect();
    let tree = AssignmentTree::all(4);
    let mut group = c.benchmark_group("all 1296 assignments of 4 robots, 150 items");
    group.sample_size(10);
    group.bench_function("tree", |b| {
        b.iter(|| scenes.iter().map(|s| by_tree(s, &tree)).sum::<usize>());
    });
    group.bench_function("event loop, one by one", |b| {
        b.iter(|| scenes.iter().map(|s| one_by_one(s, &tree)).sum::<usize>());
    });
    group.finish();
}

fn robot_pass(c: &mut Criterion) {
    let station = station(1);
    let mut group = c.benchmark_group("one robot pass over 150 items");
    for (name, pattern) in [
        ("grid 0.15", grid(1.05, 0.15, 150).unwrap()),
        (
            "poisson 0.15",
            poisson_disk(1.05, 0.15, 150, &mut random_stream(1, 0)).unwrap(),
        ),
        ("grid 0.3", grid(1.05, 0.3, 150).unwrap()),
    ] {
        let scene = Scene::new(&station, &pattern).unwrap();
        let mut cascade = Cascade::new(&scene).unwrap();
        for rule in Rule::all() {
            group.bench_function(BenchmarkId::new(name, rule), |b| {
                b.iter(|| cascade.extend(0, black_box(rule)));
            });
        }
    }
    group.finish();
}

const SIZES: [usize; 4] = [100, 1_000, 10_000, 100_000];

fn cost_per_item(c: &mut Criterion) {
    let station = station(2);
    let rules: RuleAssignment = "SPT,FIFO".parse().unwrap();
    let mut group = c.benchmark_group("scene and event loop, grid 0.15");
    group.sample_size(10);
    for items in SIZES {
        let pattern = grid(1.05, 0.15, items).unwrap();
        group.throughput(Throughput::Elements(items as u64));
        group.bench_with_input(
            BenchmarkId::from_parameter(items),
            &pattern,
            |b, pattern| {
                b.iter(|| run(&station, pattern, &rules));
            },
        );
    }
    group.finish();
}

fn run(station: &Station, pattern: &Pattern, rules: &RuleAssignment) -> usize {
    let scene = Scene::new(station, pattern).unwrap();
    let mut strategy = RuleStrategy(rules.clone());
    simulate(&scene, &mut strategy).unwrap().figures.picked
}

fn time(work: impl FnOnce() -> usize) -> Duration {
    let start = Instant::now();
    black_box(work());
    start.elapsed()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Ratios of pieces run in turn; medians of several rounds.
fn ratios() {
    let four = station(4);
    let patterns = patterns();
    let tree = AssignmentTree::all(4);
    let scenes: Vec<_> = patterns
        .iter()
        .map(|pattern| Scene::new(&four, pattern).unwrap())
        .collect();
    let rounds = (0..7).map(|_| {
        let slow = time(|| scenes.iter().map(|s| one_by_one(s, &tree)).sum());
        let fast = time(|| scenes.iter().map(|s| by_tree(s, &tree)).sum());
        slow.as_secs_f64() / fast.as_secs_f64()
    });
    println!(
        "ratio: the tree enumeration of 4 robots is {:.1} times faster than the event loop \
         one by one (one thread)",
        median(rounds.collect())
    );
    let two = station(2);
    let rules: RuleAssignment = "SPT,FIFO".parse().unwrap();
    let belts = SIZES.map(|items| grid(1.05, 0.15, items).unwrap());
    let mut per_item = SIZES.map(|_| Vec::new());
    for _ in 0..7 {
        for ((pattern, items), times) in belts.iter().zip(SIZES).zip(&mut per_item) {
            // Small belts often enough that each measurement is of like length.
            let repeats = SIZES[SIZES.len() - 1] / items;
            let spent = time(|| (0..repeats).map(|_| run(&two, pattern, &rules)).sum());
            times.push(spent.as_secs_f64() / (repeats * items) as f64);
        }
    }
    let per_item = per_item.map(median);
    for (items, time) in SIZES.iter().zip(per_item) {
        println!(
            "ratio: {items} items cost {:.2} times as much per item as {} ({:.0} ns)",
            time / per_item[1],
            SIZES[1],
            1e9 * time
        );
    }
}

/// What a travel-time law costs: passes with an arm that lifts and accelerates, against the arm at
/// constant speed.
fn laws() {
    let constant = station(1);
    let mut robot = constant.robots()[0].clone();
    robot.arm = Arm {
        law: TravelLaw::Trapezoid {
            speed: robot.arm.law.top_speed().unwrap(),
            acceleration: 2.0,
            deceleration: 2.0,
        },
        // The bin is at the belt's edge, and an arm must get ahead of the belt.
        lift: 0.05,
    };
    let accelerating = Station::new(*constant.belt(), vec![robot]).unwrap();
    let pattern = poisson_disk(1.05, 0.15, 150, &mut random_stream(1, 0)).unwrap();
    for rule in Rule::all() {
        let pass = |station: &Station| {
            let scene = Scene::new(station, &pattern).unwrap();
            let mut cascade = Cascade::new(&scene).unwrap();
            let mut pass = || cascade.extend(0, black_box(rule)).picked;
            let spent = time(|| (0..2000).map(|_| pass()).sum());
            (spent.as_secs_f64(), pass())
        };
        let mut picks = (0, 0);
        let rounds = (0..7).map(|_| {
            let (slow, fast) = (pass(&accelerating), pass(&constant));
            picks = (slow.1, fast.1);
            slow.0 / fast.0
        });
        let ratio = median(rounds.collect());
        println!(
            "ratio: a pass of {rule} costs {ratio:.2} times as much with a lift and acceleration \
             ({} picks) as at constant speed ({})",
            picks.0, picks.1
        );
    }
}

fn main() {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    enumeration(&mut criterion);
    robot_pass(&mut criterion);
    cost_per_item(&mut criterion);
    criterion.final_summary();
    // `cargo test --benches` passes --test: everything has run once then.
    if !std::env::args().any(|argument| argument == "--test") {
        ratios();
        laws();
    }
}
