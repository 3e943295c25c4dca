//! Strategies of any kind in the tables of `pickline optimize`.

use crate::common;
use common::{pickline, text};
use pickline::dispatch::RuleAssignment;
use pickline::pattern::{PatternSource, Recipe};
use pickline::sim::{Scene, simulate_rules};
use pickline::station::built_in;
use serde_json::Value;

const SMALL: [&str; 8] = [
    "optimize",
    "-q",
    "--patterns",
    "balanced:3",
    "--items",
    "30",
    "--validate",
    "12",
];

fn report(flags: &[&str]) -> Value {
    let arguments = [&SMALL, &["--format", "json"][..], flags].concat();
    serde_json::from_str(&text(&arguments)).unwrap()
}

fn rows(report: &Value) -> &Vec<Value> {
    report["beside"]["strategies"].as_array().unwrap()
}

#[test]
fn the_winner_as_a_strategy_is_the_winner_whatever_the_objective() {
    for flags in [
        &["--objective", "picking-rate"][..],
        &["--objective", "weighted-rate", "--area", "uniform:20,200"],
        &["--objective", "max-speed", "--speed-step", "0.01"],
        &["--risk", "cvar:0.3"],
    ] {
        let plain = report(flags);
        assert!(plain.get("beside").is_none());
        let best = plain["best"].as_array().unwrap().iter();
        let best: Vec<&str> = best.map(|rule| rule.as_str().unwrap()).collect();
        let best = best.join(",");
        let with = report(&[flags, &["--strategy", &best, "--strategy", "LD,LD"]].concat());
        assert_eq!(with["ranking"], plain["ranking"]);
        assert_eq!(with["validation"], plain["validation"]);
        let rows = rows(&with);
        assert_eq!(rows.len(), 3);
        assert_eq!(rows[1]["strategy"], format!("rules:{best}"));
        for figure in ["mean", "value", "worst", "picked_share"] {
            assert_eq!(rows[0][figure], plain["validation"][figure], "{figure}");
            assert_eq!(rows[1][figure], rows[0][figure], "{figure}");
        }
        let ends = |row: &Value| [row["diff_low"].as_f64(), row["diff_high"].as_f64()];
        assert_eq!(ends(&rows[0]), [None, None]);
        assert_eq!(ends(&rows[1]), [Some(0.0), Some(0.0)]);
        let [low, high] = ends(&rows[2]).map(Option::unwrap);
        let mean = |row: &Value| row["mean"].as_f64().unwrap();
        let difference = mean(&rows[2]) - mean(&rows[0]);
        assert!(low <= difference && difference <= high, "{with}");
        assert!(difference < 0.0, "LD is no good: {with}");
    }
}

/// The winner is judged on patterns of the next seed, which had no part in choosing it.
#[test]
fn the_winner_is_validated_on_patterns_of_the_next_seed() {
    let arguments = "optimize -q --format json --no-bound --patterns poisson:0.15:6 --items 40 \
                     --validate 8 --seed 3";
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    let report: Value = serde_json::from_str(&text(&arguments)).unwrap();
    let best = report["best"].as_array().unwrap().iter();
    let best: Vec<&str> = best.map(|rule| rule.as_str().unwrap()).collect();
    let best: RuleAssignment = best.join(",").parse().unwrap();
    let station = built_in("paper").unwrap().station(None).unwrap();
    let mean = |seed: u64, count: usize| {
        let recipe = Recipe::new(*station.belt(), 40, seed);
        let set = PatternSource::Poisson(0.15, count).build(&recipe).unwrap();
        let rates = set.patterns.iter().map(|pattern| {
            let scene = Scene::new(&station, pattern).unwrap();
            let figures = simulate_rules(&scene, &best).unwrap().figures;
            60.0 * figures.picked as f64 / figures.end
        });
        rates.sum::<f64>() / count as f64
    };
    let found = |of: &Value| of["mean"].as_f64().unwrap();
    assert!(
        (found(&report["validation"]) - mean(4, 8)).abs() < 1e-9,
        "{report}"
    );
    assert!(
        (found(&report["ranking"][0]) - mean(3, 6)).abs() < 1e-9,
        "{report}"
    );
    assert!((mean(4, 8) - mean(3, 8)).abs() > 1e-3);
}

#[test]
fn where_nothing_is_fresh_it_is_the_set_itself() {
    let arguments = "optimize -q --format json --items 30 --patterns grid:0.15 --strategy \
                     lookahead:budget=50";
    let arguments: Vec<&str> = arguments.split_whitespace().collect();
    let report: Value = serde_json::from_str(&text(&arguments)).unwrap();
    assert!(report["validation"].is_null());
    assert_eq!(report["beside"]["count"], 1);
    let rows = rows(&report);
    assert_eq!(rows[0]["mean"], report["ranking"][0]["mean"]);
    // Of one pattern there is no interval.
    assert!(rows[1].get("diff_low").is_none());
}

#[test]
fn tables_and_files_have_them_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let strategies = ["--strategy", "SD,FIFO", "--strategy", "lookahead:budget=50"];
    let run = |threads: &str| {
        let flags = ["--out", out, "--threads", threads];
        let printed = text(&[&SMALL[..], &strategies, &flags].concat());
        let file = std::fs::read_to_string(folder.path().join("strategies.csv")).unwrap();
        (printed, common::csv_rows(&file))
    };
    let (printed, rows) = run("1");
    assert_eq!(rows.len(), 1 + 3);
    for part in [
        "beside    the winner and other strategies on the same patterns",
        "rules:SD,FIFO",
        "lookahead:budget=50",
    ] {
        assert!(printed.contains(part), "{part} in {printed}");
    }
    assert_eq!(rows, run("2").1);
}

#[cfg(feature = "onnx")]
#[test]
fn a_policy_joins_the_table() {
    let report = report(&["--strategy", "onnx"]);
    let rows = rows(&report);
    assert_eq!(rows[1]["strategy"], "onnx");
    assert!(rows[1]["mean"].as_f64() > rows[0]["mean"].as_f64());
}

#[test]
fn typing_mistakes_are_reported_before_the_search() {
    for (strategy, word) in [
        ("lookahed", "did you mean `lookahead`"),
        ("SPT", "rule"),
        ("onnx:nowhere.onnx", "onnx"),
    ] {
        let output = pickline(&["optimize", "--strategy", strategy]);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(word), "{stderr}");
        assert!(!stderr.contains("optimizing"), "{stderr}");
    }
}
