//! The verbs that run strategies, on the line of which everything is known.

use super::rig::{Rig, number};
use serde_json::Value;

/// Verbs with the options of `Common`, a station and conditions.
pub const SIX: [&str; 6] = ["optimize", "compare", "sweep", "game", "bound", "simulate"];
/// Those that run strategies: the bound of what any can do hardly depends on luck.
pub const RUNNING: [&str; 5] = ["optimize", "compare", "sweep", "game", "simulate"];

/// A quick call of `verb` without a station, and where its JSON has the picking rate.
fn call(verb: &str) -> (&'static str, &'static str) {
    match verb {
        "optimize" => (
            "optimize --patterns p.csv --validate 0 --no-bound",
            "/ranking/0/mean",
        ),
        "compare" => (
            "compare --cases c.toml --robust FIFO --no-policy --no-greedy --no-bound",
            "/cases/0/results/0/picking_rate_per_min",
        ),
        "sweep" => (
            "sweep --patterns p.csv --robust FIFO --no-bound --sweep reach --from 0.5 --to 0.6 \
             --step 0.1",
            "/points/0/picking_rate_per_min",
        ),
        "game" => ("game --patterns p.csv", "/equilibria/0/welfare"),
        "bound" => ("bound --pattern p.csv", "/picking_rate_upper_bound_per_min"),
        "simulate" => (
            "simulate --pattern p.csv --strategy FIFO --no-bound",
            "/picking_rate_per_min",
        ),
        _ => unreachable!("{verb}"),
    }
}

/// A call of `verb` on one item with another station than the usual.
pub fn on(verb: &str, station: &str) -> String {
    format!("{} --station {station}", call(verb).0)
}

/// A call of `verb` on one robot and one item.
pub fn one(verb: &str) -> String {
    on(verb, "one.toml")
}

/// What `verb` reports of one robot and one item with `flags`.
pub fn report(rig: &Rig, verb: &str, flags: &str) -> Value {
    rig.json(&format!("{} -q --format json {flags}", one(verb)))
}

/// Where the report of `verb` has the picking rate.
pub fn rate_in(verb: &str, report: &Value) -> f64 {
    number(report, call(verb).1)
}

/// The picking rate that `verb` reports of one robot and one item with `flags`.
pub fn rate(rig: &Rig, verb: &str, flags: &str) -> f64 {
    rate_in(verb, &report(rig, verb, flags))
}

/// A call of `verb` on patterns that are drawn at random.
pub fn at_random(verb: &str) -> &'static str {
    match verb {
        "optimize" => "optimize --patterns poisson:0.4:2 --items 4 --validate 0 --no-bound",
        "compare" => {
            "compare --cases random.toml --replicates 2 --robust FIFO --no-policy --no-greedy \
             --no-bound"
        }
        "sweep" => {
            "sweep --patterns poisson:0.4:2 --items 4 --robust FIFO --no-bound --sweep reach \
             --from 0.5 --to 0.6 --step 0.1"
        }
        "game" => "game --patterns poisson:0.4:2 --items 4",
        "simulate" => "simulate --pattern p.csv --strategy FIFO --no-bound --position-noise 0.001",
        _ => unreachable!("{verb}"),
    }
}
