//! What the learned strategy costs: `cargo bench --bench rl`. Decisions of the
//! environment per second with random allowed actions, training steps per second at both
//! presets, time of one decision by the shipped policy; on 1 and 2 threads. And how many
//! of the picks that the look-ahead makes have a slot, by the number of slots.

use pickline::decision::observation::{Encoder, Layout, View};
use pickline::decision::{Action, Snapshot, Strategy};
use pickline::experiment::load_cases;
use pickline::optimize::{Environment as Work, Silent};
use pickline::pattern::{grid, random_stream};
use pickline::rl::domain::{Course, scenes};
use pickline::rl::{Batch, Plan, Reward, Step, Trainer};
use pickline::sim::{Scene, simulate};
use pickline::station::built_in;
use pickline::strategies::read_alone;
use rand::RngExt;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

const LAYOUTS: [(&str, Layout); 2] = [
    (
        "full",
        Layout {
            view: View::Full,
            slots: 16,
            wait: false,
        },
    ),
    ("paper", Layout::PAPER),
];

fn course(items: usize) -> Course {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let pattern = grid(station.belt().width, 0.15, items).unwrap();
    Course {
        station,
        pattern,
        disturbances: pickline::sim::Disturbances::default(),
    }
}

/// Decisions a second of 256 environments, 50 items a pattern.
fn decisions(layout: Layout, rounds: usize) -> f64 {
    let courses = [course(50)];
    let scenes = scenes(&courses).unwrap();
    let count = 256;
    let mut batch = Batch::new(&scenes, layout, Reward::PAPER, count, 1).unwrap();
    let mut observations = vec![0.0; count * layout.observation()];
    let mut masks = vec![false; count * layout.actions()];
    let nothing = Step {
        reward: 0.0,
        ended: None,
    };
    let mut steps = vec![nothing; count];
    let mut actions = vec![0; count];
    let mut rng = random_stream(1, 0);
    batch.reset(&mut observations, &mut masks);
    let start = Instant::now();
    for _ in 0..rounds {
        for (action, mask) in actions.iter_mut().zip(masks.chunks_exact(layout.actions())) {
            // Slots are filled from the first on.
            let filled = mask
                .iter()
                .position(|allowed| !allowed)
                .unwrap_or(mask.len());
            *action = rng.random_range(0..filled);
        }
        batch
            .step(&actions, &mut observations, &mut masks, &mut steps)
            .unwrap();
    }
    (rounds * count) as f64 / start.elapsed().as_secs_f64()
}

/// Training steps a second of a preset, patterns drawn as in earnest.
fn training(preset: &str, updates: usize) -> f64 {
    let mut plan = Plan::preset(preset).unwrap();
    (plan.updates, plan.courses) = (updates, 32);
    plan.domain.curriculum = 0.0;
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let mut trainer = Trainer::new(plan, vec![station], 1).unwrap();
    let stop = AtomicBool::new(false);
    let work = Work {
        stop: &stop,
        progress: &Silent,
        ..Work::QUIET
    };
    let start = Instant::now();
    trainer.phase(&work).unwrap();
    trainer.steps() as f64 / start.elapsed().as_secs_f64()
}

/// Notes how long every decision takes.
struct Timed {
    inner: Box<dyn Strategy>,
    times: Vec<Duration>,
}

impl Strategy for Timed {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        let start = Instant::now();
        let action = self.inner.decide(snapshot);
        self.times.push(start.elapsed());
        action
    }

    fn name(&self) -> String {
        self.inner.name()
    }
}

fn latency(rounds: usize) -> Option<[Duration; 2]> {
    let blueprint = read_alone("onnx", 2).ok()?;
    let course = course(150);
    let scene = course.scene().unwrap();
    let mut timed = Timed {
        inner: blueprint.make(),
        times: Vec::new(),
    };
    for _ in 0..rounds {
        simulate(&scene, &mut timed).unwrap();
    }
    timed.times.sort_unstable();
    let at = |share: f64| timed.times[((timed.times.len() - 1) as f64 * share) as usize];
    Some([at(0.5), at(0.99)])
}

/// Asks a strategy and notes which of its picks have a slot in each layout.
struct Covered {
    inner: Box<dyn Strategy>,
    encoders: Vec<Encoder>,
    picks: usize,
    seen: Vec<usize>,
}

impl Strategy for Covered {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        let action = self.inner.decide(snapshot);
        if matches!(action, Action::Pick(_)) {
            self.picks += 1;
            for (encoder, seen) in self.encoders.iter_mut().zip(&mut self.seen) {
                let layout = encoder.layout();
                let mut observation = vec![0.0; layout.observation()];
                let mut mask = vec![false; layout.actions()];
                encoder.encode(snapshot, &mut observation, &mut mask);
                *seen += usize::from(encoder.index_of(action).is_some());
            }
        }
        action
    }

    fn name(&self) -> String {
        self.inner.name()
    }
}

/// Shares of the look-ahead's picks that have one of 8, 10 and 16 slots, on every dense
/// case of both stations.
fn coverage(replicates: usize) {
    const SLOTS: [usize; 3] = [8, 10, 16];
    for name in ["paper", "paper-narrow"] {
        let station = built_in(name).unwrap().station(Some(2)).unwrap();
        for case in load_cases("dense").unwrap() {
            let patterns = case.patterns(station.belt(), replicates, 1).unwrap();
            let mut covered = Covered {
                inner: read_alone("lookahead", 2).unwrap().make(),
                encoders: Vec::new(),
                picks: 0,
                seen: vec![0; SLOTS.len()],
            };
            covered.encoders.extend(SLOTS.map(|slots| {
                Encoder::new(Layout {
                    view: View::Full,
                    slots,
                    wait: false,
                })
            }));
            for (_, pattern) in &patterns {
                // A plan does not outlive its run.
                covered.inner = read_alone("lookahead", 2).unwrap().make();
                let scene = Scene::new(&station, pattern).unwrap();
                simulate(&scene, &mut covered).unwrap();
            }
            let share = |seen: &usize| 100.0 * *seen as f64 / covered.picks as f64;
            let shares: Vec<String> = covered
                .seen
                .iter()
                .map(|s| format!("{:.1}", share(s)))
                .collect();
            println!(
                "picks of the look-ahead in {SLOTS:?} slots, {name}, {}: {} %",
                case.name,
                shares.join(" / ")
            );
        }
    }
}

fn main() {
    // `cargo test --benches` passes --test: everything runs once then, in little.
    let test = std::env::args().any(|argument| argument == "--test");
    let scale = if test { 1 } else { 100 };
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            for (name, layout) in LAYOUTS {
                let rate = decisions(layout, 40 * scale);
                println!(
                    "environment, {name} observation, {threads} threads: {rate:.0} decisions/s"
                );
            }
            for (preset, updates) in [("paper", 1), ("default", 1)] {
                let rate = training(preset, updates * scale.min(10));
                println!("training, preset {preset}, {threads} threads: {rate:.0} steps/s");
            }
        });
    }
    coverage(scale.min(10));
    if let Some([median, late]) = latency(scale) {
        println!("decision of the shipped policy: median {median:?}, p99 {late:?}");
    }
}
