//! What a decision of the look-ahead strategy costs: `cargo bench --bench lookahead`.
//!
//! Runs whole patterns and notes the wall time of every decision, with about 60 and
//! about 1,000 items in view, under a budget of simulated decisions and under one of
//! time.

use pickline::decision::{Action, Snapshot, Strategy};
use pickline::pattern::grid;
use pickline::planning::{Allowance, Lookahead, LookaheadOptions};
use pickline::sim::{Scene, simulate};
use pickline::station::built_in;
use std::time::Instant;

/// Notes how long each decision takes and how much was in view.
struct Timed {
    inner: Lookahead,
    times_ms: Vec<f64>,
    in_view: usize,
}

impl Strategy for Timed {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        self.in_view = self.in_view.max(snapshot.in_view.len());
        let began = Instant::now();
        let action = self.inner.decide(snapshot);
        self.times_ms.push(began.elapsed().as_secs_f64() * 1e3);
        action
    }

    fn name(&self) -> String {
        self.inner.name()
    }
}

fn main() {
    println!(
        "| station | in view | options | decisions | picked | p50 [ms] | p99 [ms] | max [ms] |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for name in ["paper", "paper-narrow"] {
        let station = built_in(name)
            .and_then(|b| b.station(Some(2)))
            .expect("a built-in station");
        let width = station.belt().width;
        let area = width * station.belt().length;
        // Items that the belt would hold if none were picked, chosen so that of those
        // that are left about 60 or 1,000 are in view at most.
        for (held, items) in [(90.0, 600), (1080.0, 3000)] {
            let spacing = f64::sqrt(area / held);
            let pattern = grid(width, spacing, items).expect("a grid");
            let scene = Scene::new(&station, &pattern).expect("on the belt");
            for text in ["", "budget-ms=10", "budget-ms=2"] {
                let bases = ["SPT,FIFO", "SPT,SPT", "SD,FIFO"].map(|r| r.parse().expect("rules"));
                let mut options =
                    LookaheadOptions::parse(text, 2, Allowance::default()).expect("options");
                options.bases = bases.to_vec();
                let mut timed = Timed {
                    inner: Lookahead::new(options),
                    times_ms: Vec::new(),
                    in_view: 0,
                };
                let outcome = simulate(&scene, &mut timed).expect("legal actions");
                timed.times_ms.sort_by(f64::total_cmp);
                let at = |share: f64| {
                    let last = timed.times_ms.len() - 1;
                    timed.times_ms[(share * last as f64).round() as usize]
                };
                println!(
                    "| {name} | {} | `lookahead{}{text}` | {} | {} | {:.2} | {:.2} | {:.2} |",
                    timed.in_view,
                    if text.is_empty() { "" } else { ":" },
                    timed.times_ms.len(),
                    outcome.picks.len(),
                    at(0.5),
                    at(0.99),
                    at(1.0),
                );
            }
        }
    }
}
