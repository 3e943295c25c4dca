//! `--camera-x`, `--grasp-success` and `--position-noise` on the command line.

use crate::common;
use common::{pickline, text};
use pickline::dispatch::RuleAssignment;
use pickline::optimize::game::{LineGame, PayoffKind};
use pickline::optimize::{Environment, Evaluator, Objective, Silent};
use pickline::pattern::{Pattern, PatternSource, Recipe};
use pickline::sim::{Conditions, Disturbances, Scene, simulate_rules};
use pickline::station::built_in;
use serde_json::Value;
use std::sync::atomic::AtomicBool;

const DISTURBED: [&str; 6] = [
    "--camera-x",
    "0.3",
    "--grasp-success",
    "0.7",
    "--position-noise",
    "0.02",
];

fn with<'a>(verb: &[&'a str], flags: &[&'a str]) -> Vec<&'a str> {
    [verb, flags].concat()
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&text(arguments)).unwrap()
}

#[test]
fn simulate_shows_what_failed_in_every_form() {
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("trace.csv");
    let trace = trace.to_str().unwrap();
    let verb = ["simulate", "-q", "--check", "--trace", trace];
    let run = json(&with(&with(&verb, &DISTURBED), &["--format", "json"]));
    let failures = run["failures"].as_array().unwrap();
    assert!(!failures.is_empty());
    assert_eq!(run["checked"], true);
    let failed: u64 = run["robots"]
        .as_array()
        .unwrap()
        .iter()
        .map(|robot| robot["failed"].as_u64().unwrap())
        .sum();
    assert_eq!(failed as usize, failures.len());
    for cause in ["grasp", "out_of_reach"] {
        assert!(failures.iter().any(|f| f["cause"] == cause), "{cause}");
    }
    let picked = run["picked"].as_u64().unwrap() as usize;
    let missed: u64 = run["missed_by_reason"]
        .as_object()
        .unwrap()
        .values()
        .map(|count| count.as_u64().unwrap())
        .sum();
    assert_eq!(picked + missed as usize, 50);
    assert_eq!(run["made"]["conditions"].as_array().unwrap().len(), 3);
    let csv = text(&with(&with(&verb, &DISTURBED), &["--format", "csv"]));
    assert_eq!(common::csv_rows(&csv).len(), 1 + picked + failures.len());
    let events = std::fs::read_to_string(trace).unwrap();
    assert_eq!(events.matches(",grasp_failed,").count(), failures.len());
    let table = text(&with(&verb, &DISTURBED));
    let line = format!("failed    {} attempts", failures.len());
    assert!(
        table.contains(&line) && table.contains("\nunder "),
        "{table}"
    );
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_one_different_ones() {
    for verb in [
        &["simulate", "-q", "--format", "csv"][..],
        &[
            "compare",
            "-q",
            "--format",
            "csv",
            "--robust",
            "SPT,FIFO",
            "--replicates",
            "4",
        ],
        &[
            "sweep", "-q", "--format", "csv", "--robust", "SPT,FIFO", "--from", "0.04", "--to",
            "0.05", "--step", "0.005",
        ],
    ] {
        let verb = with(verb, &DISTURBED);
        let once = text(&verb);
        assert_eq!(text(&with(&verb, &["--threads", "1"])), once);
        // Without the last column, the command line that it was made by.
        let figures = |text: &str| -> Vec<String> {
            let cells = |line: &str| line.split(",pickline ").next().unwrap().to_owned();
            text.lines().map(cells).collect()
        };
        let other = text(&with(&verb, &["--seed", "7"]));
        assert_ne!(figures(&other), figures(&once), "{verb:?}");
    }
}

#[test]
fn settings_without_effect_change_no_figure_and_are_noted() {
    let plain = json(&["simulate", "-q", "--format", "json"]);
    let verb = ["simulate", "--format", "json", "--grasp-success"];
    let output = pickline(&verb);
    let mut run: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(run["failures"].as_array().unwrap().is_empty());
    run["made"] = plain["made"].clone();
    assert_eq!(run, plain);
    let remark = String::from_utf8(output.stderr).unwrap();
    assert!(remark.contains("--grasp-success P"), "{remark}");
    // A pattern with probabilities of its own needs no number.
    let folder = tempfile::tempdir().unwrap();
    let pattern = folder.path().join("p.csv");
    let pattern = pattern.to_str().unwrap();
    text(&[
        "pattern",
        "generate",
        "--p-grasp",
        "const:0.5",
        "-o",
        pattern,
    ]);
    let output = pickline(&with(&verb, &["--pattern", pattern, "-q"]));
    let run: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(!run["failures"].as_array().unwrap().is_empty());
    assert!(output.stderr.is_empty());
}

/// A run of the comparison can be simulated alone: its seed is that of its luck.
#[test]
fn a_run_of_compare_is_that_of_simulate() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let flags = ["--grasp-success", "0.8", "--position-noise", "0.01"];
    let compare = [
        "compare",
        "-q",
        "--no-greedy",
        "--no-policy",
        "--robust",
        "SPT,FIFO",
        "--replicates",
        "3",
        "--out",
        out,
    ];
    text(&with(&compare, &flags));
    let runs = std::fs::read_to_string(folder.path().join("runs.csv")).unwrap();
    let rows = common::csv_rows(&runs);
    let column = |name: &str| rows[0].iter().position(|h| h == name).unwrap();
    let (seed, picked) = (column("pattern_seed"), column("picked"));
    let grid: Vec<_> = rows
        .iter()
        .filter(|row| row.iter().any(|cell| cell == "grid 0.15, 50 items"))
        .collect();
    assert_eq!(grid.len(), 3);
    for row in grid {
        let simulate = ["simulate", "-q", "--format", "json", "--seed", &row[seed]];
        let alone = json(&with(&simulate, &flags));
        assert_eq!(
            alone["picked"].to_string(),
            row[picked],
            "seed {}",
            &row[seed]
        );
    }
}

#[test]
fn the_comparison_says_what_it_was_run_under() {
    let verb = ["compare", "-q", "--replicates", "2", "--train-items", "5"];
    let table = text(&with(&verb, &["--grasp-success", "--camera-x", "0.5"]));
    for words in [
        "\nunder ",
        "x = 0.5 m",
        "with independent random numbers",
        "--grasp-success P",
    ] {
        assert!(table.contains(words), "{words} not in {table}");
    }
    assert!(!text(&verb).contains("\nunder "));
}

/// The name said the opposite of the number: 0.1 meant that nine grasps in ten fail.
#[test]
fn the_ambiguous_name_is_refused_with_the_new_one() {
    for verb in ["simulate", "compare", "sweep", "optimize", "bound", "game"] {
        for (flags, words) in [
            (&["--grasp-failures", "0.1"][..], "--grasp-success 0.1"),
            (&["--grasp-failures"], "--grasp-success if"),
            (&["--grasp-failures", "-3"], "--grasp-success"),
        ] {
            let output = pickline(&with(&[verb, "-q"], flags));
            let stderr = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(2), "{verb} {flags:?}: {stderr}");
            assert!(stderr.contains(words), "{verb} {flags:?}: {stderr}");
            assert!(output.stdout.is_empty());
        }
        let help = text(&[verb, "--help"]);
        assert!(help.contains("--grasp-success") && !help.contains("--grasp-failures"));
    }
    for verb in ["emulate", "run"] {
        let output = pickline(&[verb, "--grasp-failures", "0.1"]);
        assert_eq!(output.status.code(), Some(2), "{verb}");
    }
}

/// What a search, a game and the certificate of a winner are made of are the very runs of
/// the simulator, each with its own luck.
#[test]
fn searches_and_games_have_the_conditions_of_simulate() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let recipe = Recipe::new(*station.belt(), 40, 3);
    let patterns = PatternSource::Poisson(0.12, 6)
        .build(&recipe)
        .unwrap()
        .patterns;
    let conditions = Conditions::default().with_camera_x(0.3).with_disturbances(
        Disturbances::default()
            .with_grasp_failures(true)
            .with_default_p_grasp(0.7)
            .with_position_noise(0.02)
            .with_seed(11),
    );
    let stop = AtomicBool::new(false);
    let environment = Environment {
        stop: &stop,
        progress: &Silent,
        ..Environment::QUIET
    };
    let objective = Objective::PickingRate;
    let evaluator = Evaluator::new(&station, &patterns, objective, &conditions).unwrap();
    assert_eq!(evaluator.independent_patterns(), 0);
    let all = RuleAssignment::all(2).collect();
    let evaluation = evaluator.evaluate(all, &environment).unwrap();
    let kind = PayoffKind::Total;
    let game = LineGame::new(&station, &patterns, kind, &conditions, &environment).unwrap();
    let mut differs = false;
    for (profile, assignment) in evaluation.assignments.iter().enumerate() {
        let values = &evaluation.scores[profile].values;
        let rate = |(place, pattern): (usize, &Pattern)| {
            let mut luck = conditions.clone();
            luck.disturbances.seed = 11 + place as u64;
            let scene = Scene::under(&station, pattern, luck).unwrap();
            let plain = Scene::new(&station, pattern).unwrap();
            let rate = |scene| {
                simulate_rules(scene, assignment)
                    .unwrap()
                    .figures
                    .picking_rate()
            };
            differs |= rate(&scene) != rate(&plain);
            rate(&scene)
        };
        let rates: Vec<f64> = patterns.iter().enumerate().map(rate).collect();
        assert_eq!(*values, rates, "{assignment}");
        let mean = rates.iter().sum::<f64>() / rates.len() as f64;
        let welfare: f64 = game
            .rates(profile)
            .iter()
            .map(|payoff| payoff.value())
            .sum();
        assert!(
            (welfare - mean).abs() < 1e-8,
            "{assignment}: {welfare} {mean}"
        );
    }
    assert!(differs);
}

/// On one grid robust means robust to luck: the search judges on many draws of it.
#[test]
fn optimize_and_game_are_run_under_the_conditions() {
    let small = [
        "--patterns",
        "grid:0.15",
        "--items",
        "30",
        "-q",
        "--format",
        "json",
    ];
    let plain = json(&with(&["optimize"], &small));
    assert_eq!(plain["patterns"], 1);
    let report = json(&with(
        &with(&["optimize", "--validate", "50"], &small),
        &DISTURBED,
    ));
    assert_eq!(report["patterns"], 100);
    assert_eq!(report["validation"]["count"], 50);
    assert_eq!(report["made"]["conditions"].as_array().unwrap().len(), 3);
    assert!(
        report["ranking"][0]["diff_low"].is_null() || report["ranking"][1]["diff_low"].is_number()
    );
    let rate = |report: &Value| report["ranking"][0]["mean"].as_f64().unwrap();
    assert!(
        rate(&report) < 0.9 * rate(&plain),
        "{} {}",
        rate(&report),
        rate(&plain)
    );
    let game = json(&with(&with(&["game"], &small), &DISTURBED));
    assert_eq!(game["patterns"], 100);
    assert_eq!(game["made"]["conditions"].as_array().unwrap().len(), 3);
}

/// The bound holds for any luck, and says what it is of.
#[test]
fn the_bound_is_proven_under_the_conditions() {
    let verb = ["bound", "-q", "--format", "json"];
    let most = |flags: &[&str]| {
        let report = json(&with(&verb, flags));
        (report["picks_upper_bound"].as_u64().unwrap(), report)
    };
    let folder = tempfile::tempdir().unwrap();
    let pattern = folder.path().join("p.csv");
    let pattern = pattern.to_str().unwrap();
    text(&[
        "pattern", "generate", "grid", "--count", "150", "-o", pattern,
    ]);
    let (plain, report) = most(&["--pattern", pattern]);
    assert!(report.get("notes").is_none());
    let (late, _) = most(&["--pattern", pattern, "--camera-x", "2.4"]);
    assert!(late < plain, "{late} {plain}");
    let flags = with(&["--pattern", pattern], &DISTURBED);
    let (disturbed, report) = most(&flags);
    assert!(report["schedule"].is_null());
    assert!(
        report["notes"][0]
            .as_str()
            .unwrap()
            .contains("every outcome of the random events")
    );
    assert_eq!(report["made"]["conditions"].as_array().unwrap().len(), 3);
    let simulate = [
        "simulate",
        "-q",
        "--format",
        "json",
        "--strategy",
        "lookahead",
    ];
    for seed in ["1", "2", "3"] {
        let run = json(&with(&with(&simulate, &flags), &["--seed", seed]));
        assert!(run["picked"].as_u64().unwrap() <= disturbed);
    }
}

#[test]
fn bad_conditions_end_with_exit_code_2() {
    for verb in ["simulate", "compare", "sweep", "optimize", "game", "bound"] {
        for (flags, words) in [
            (["--camera-x", "nan"], "--camera-x"),
            (["--camera-x", "1e7"], "--camera-x"),
            (["--grasp-success", "-0.1"], "--grasp-success"),
            (["--grasp-success", "1.5"], "--grasp-success"),
            (["--grasp-success", "often"], "--grasp-success"),
            (["--position-noise", "-0.001"], "--position-noise"),
            (["--position-noise", "NaN"], "--position-noise"),
            (["--position-noise", "inf"], "--position-noise"),
            (["--position-noise", "11"], "--position-noise"),
        ] {
            let output = pickline(&with(&[verb, "-q"], &flags));
            assert_eq!(output.status.code(), Some(2), "{verb} {flags:?}");
            let stderr = String::from_utf8(output.stderr).unwrap();
            assert!(stderr.contains(words), "{verb} {flags:?}: {stderr}");
        }
    }
}
