//! `--camera-x`, `--grasp-failures` and `--position-noise` on the command line.

mod common;

use common::{pickline, text};
use serde_json::Value;

const DISTURBED: [&str; 6] = [
    "--camera-x",
    "0.3",
    "--grasp-failures",
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
fn the_same_seed_gives_the_same_bytes_and_another_one_other_luck() {
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
fn what_cannot_go_wrong_changes_no_figure_and_is_said() {
    let plain = json(&["simulate", "-q", "--format", "json"]);
    let verb = ["simulate", "--format", "json", "--grasp-failures"];
    let output = pickline(&verb);
    let mut run: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(run["failures"].as_array().unwrap().is_empty());
    run["made"] = plain["made"].clone();
    assert_eq!(run, plain);
    let remark = String::from_utf8(output.stderr).unwrap();
    assert!(remark.contains("--grasp-failures P"), "{remark}");
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
    let flags = ["--grasp-failures", "0.8", "--position-noise", "0.01"];
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
    let table = text(&with(&verb, &["--grasp-failures", "--camera-x", "0.5"]));
    for words in [
        "\nunder ",
        "x = 0.5 m",
        "nothing going wrong",
        "--grasp-failures P",
    ] {
        assert!(table.contains(words), "{words} not in {table}");
    }
    assert!(!text(&verb).contains("\nunder "));
}

#[test]
fn bad_conditions_end_with_exit_code_2() {
    for verb in ["simulate", "compare", "sweep"] {
        for (flags, words) in [
            (["--camera-x", "nan"], "--camera-x"),
            (["--camera-x", "1e7"], "--camera-x"),
            (["--grasp-failures", "-0.1"], "--grasp-failures"),
            (["--grasp-failures", "1.5"], "--grasp-failures"),
            (["--grasp-failures", "often"], "--grasp-failures"),
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
    // The verbs that need the plain model have no such flags.
    for verb in ["optimize", "game"] {
        let output = pickline(&[verb, "--position-noise", "0.01"]);
        assert_eq!(output.status.code(), Some(2));
    }
}
