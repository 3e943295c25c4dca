//! What the bound costs: `cargo bench --bench bound`. Criterion times each piece; the last
//! lines compare pieces that were run in turn, so that the ratios hold on a busy machine.

use criterion::{BenchmarkId, Criterion};
use pickline::pattern::{Pattern, grid};
use pickline::planning::bound::{BoundObjective, BoundOptions, upper_bound};
use pickline::sim::Scene;
use pickline::station::{Station, built_in};
use std::hint::black_box;
use std::time::{Duration, Instant};

fn station() -> Station {
    built_in("paper").unwrap().station(Some(2)).unwrap()
}

fn belt(items: usize) -> Pattern {
    grid(1.05, 0.15, items).unwrap()
}

/// Picks only, at slots of `slot` seconds.
fn picks(slot: f64) -> BoundOptions {
    BoundOptions::default()
        .with_slot_s(slot)
        .with_ends(false)
        .with_schedule(false)
}

fn run(station: &Station, pattern: &Pattern, options: &BoundOptions) -> f64 {
    let scene = Scene::new(station, pattern).unwrap();
    upper_bound(&scene, options, &mut |_, _| true)
        .unwrap()
        .relaxed
}

fn slots(c: &mut Criterion) {
    let (station, pattern) = (station(), belt(150));
    let mut group = c.benchmark_group("bound, grid 0.15, 150 items");
    group.sample_size(10);
    for slot in [0.1, 0.05, 0.02] {
        group.bench_function(BenchmarkId::new("picks, slots of", slot), |b| {
            b.iter(|| run(&station, &pattern, black_box(&picks(slot))));
        });
    }
    for (name, options) in [
        ("as `pickline bound`", BoundOptions::default()),
        ("as in reports", BoundOptions::quick(BoundObjective::Picks)),
    ] {
        group.bench_function(name, |b| {
            b.iter(|| run(&station, &pattern, black_box(&options)));
        });
    }
    group.finish();
}

const SIZES: [usize; 5] = [125, 250, 500, 1_000, 2_000];

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Cost an item against that on a belt of 1,000, of sizes run in turn.
fn ratios(name: &str, options: &BoundOptions) {
    let station = station();
    let belts = SIZES.map(belt);
    let mut per_item = SIZES.map(|_| Vec::new());
    for _ in 0..7 {
        for ((pattern, items), times) in belts.iter().zip(SIZES).zip(&mut per_item) {
            // Small belts often enough that each measurement is of like length.
            let repeats = SIZES[SIZES.len() - 1] / items;
            let start = Instant::now();
            for _ in 0..repeats {
                black_box(run(&station, pattern, options));
            }
            times.push(start.elapsed().as_secs_f64() / (repeats * items) as f64);
        }
    }
    let per_item = per_item.map(median);
    for (items, time) in SIZES.iter().zip(per_item) {
        println!(
            "ratio: {name}, {items} items cost {:.2} times as much per item as 1000 ({:.0} us)",
            time / per_item[3],
            1e6 * time
        );
    }
}

fn main() {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(2))
        .configure_from_args();
    slots(&mut criterion);
    criterion.final_summary();
    // `cargo test --benches` passes --test: everything has run once then.
    if !std::env::args().any(|argument| argument == "--test") {
        ratios("picks at 0.1 s", &picks(0.1));
        let whole = BoundOptions::default().with_slot_s(0.05);
        ratios("everything at 0.05 s", &whole);
    }
}
