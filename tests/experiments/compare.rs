//! The comparison: what it must show and how it is written.

use crate::common;
#[cfg(all(unix, feature = "onnx"))]
use crate::programs::Program;
use pickline::experiment::{Comparison, Draws, Method, compare_methods, load_cases};
use pickline::optimize::{Environment, Silent};
use pickline::sim::Conditions;
use pickline::station::built_in;
use pickline::strategies;
use std::process::Command;
use std::sync::atomic::AtomicBool;

fn run(station: &str, cases: &str, replicates: usize) -> Comparison {
    let station = built_in(station).unwrap().station(None).unwrap();
    let methods = vec![
        Method::Robust("SPT,FIFO".parse().unwrap()),
        Method::greedy(2).unwrap(),
        Method::Strategy(strategies::read_alone("SPT,SPT", 2).unwrap()),
    ];
    let stop = AtomicBool::new(false);
    let environment = Environment {
        stop: &stop,
        progress: &Silent,
        ..Environment::QUIET
    };
    let cases = load_cases(cases).unwrap();
    let plain = Conditions::default();
    let draws = Draws {
        replicates,
        first_seed: 2,
        conditions: &plain,
    };
    compare_methods(&station, methods, &cases, draws, &environment).unwrap()
}

/// Greedy GT chooses for the pattern itself, so nothing of its kind can beat it there.
#[test]
fn greedy_is_never_below_robust_on_any_pattern() {
    let mut patterns = 0;
    for station in ["paper", "paper-narrow"] {
        for case in run(station, "all", 25).cases {
            let [robust, greedy, fixed] = &case.methods[..] else {
                panic!("three methods");
            };
            for i in 0..greedy.runs.len() {
                let rate =
                    |of: &pickline::experiment::MethodResult| of.runs[i].figures.picking_rate();
                assert!(
                    rate(greedy) >= rate(robust).max(rate(fixed)),
                    "{}",
                    case.case.name
                );
                assert!(greedy.runs[i].chosen.is_some());
                patterns += 1;
            }
            assert!(greedy.benefit >= 0.0);
        }
    }
    assert_eq!(patterns, 2 * (3 + 5 * 25));
}

/// The neighbourhood of the paper's Table 2 in which `docs/model.md` puts the built-in
/// stations, and the dense figures of the rules measured in an independent prototype.
#[test]
fn the_tables_are_reproduced_in_kind() {
    let near = |value: f64, expected: f64, share: f64| (value / expected - 1.0).abs() <= share;
    for (station, cases, expected) in [
        // Robust and greedy picking rates, case by case.
        (
            "paper",
            "paper",
            [(26.7, 27.7), (27.0, 27.2), (23.2, 24.0), (18.8, 18.8)],
        ),
        (
            "paper",
            "dense",
            [(38.2, 45.9), (35.4, 45.5), (37.2, 46.1), (39.4, 45.5)],
        ),
        (
            "paper-narrow",
            "dense",
            [(36.9, 48.8), (35.8, 48.5), (38.7, 50.5), (54.7, 54.8)],
        ),
    ] {
        let comparison = run(station, cases, 40);
        assert_eq!(comparison.cases.len(), expected.len());
        for (case, (robust, greedy)) in comparison.cases.iter().zip(expected) {
            let rates = [0, 1].map(|method| case.methods[method].picking_rate);
            assert!(
                near(rates[0], robust, 0.02),
                "{station} {}: {rates:?}",
                case.case.name
            );
            assert!(
                near(rates[1], greedy, 0.02),
                "{station} {}: {rates:?}",
                case.case.name
            );
        }
    }
}

#[test]
fn files_and_formats_agree_and_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let call = |out: &std::path::Path, threads: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args([
                "compare",
                "-q",
                "--no-policy",
                "--paper",
                "--replicates",
                "5",
                "--strategy",
                "SPT,SPT",
                "--format",
                "json",
            ])
            .args(["--threads", threads, "--out"])
            .arg(out)
            .output()
            .unwrap();
        assert!(output.status.success());
        String::from_utf8(output.stdout).unwrap()
    };
    let printed = call(&out("a"), "1");
    assert_eq!(printed, call(&out("b"), "2"));
    let read = |name: &str| {
        let text = std::fs::read_to_string(out("a").join(name)).unwrap();
        assert_eq!(
            text,
            std::fs::read_to_string(out("b").join(name)).unwrap(),
            "{name}"
        );
        text
    };
    assert_eq!(read("compare.json"), printed);
    let rows = |name: &str| common::csv_rows(&read(name)).len();
    assert_eq!(rows("picked_time.csv"), 1 + 4 * 3);
    assert_eq!(rows("runs.csv"), 1 + (2 + 2 * 5) * 3);
    let methods = common::csv_column(&read("picking_rate.csv"), "method");
    assert_eq!(methods.len(), 4 * 3);
    assert_eq!(methods[..3], ["robust_gt", "greedy_gt", "rules:SPT,SPT"]);
    let json: serde_json::Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(json["methods"][0]["title"], "robust GT [SPT; FIFO]");
    assert_eq!(
        json["cases"][0]["results"][0]["paper"]["picked_percent"],
        92.0
    );
    // A single run of the table can be made again from its seed.
    let runs = read("runs.csv");
    let of_seed = |method: &str| {
        let row =
            |line: &&str| line.starts_with("\"poisson 0.2, 29 items\",3,") && line.contains(method);
        runs.lines().find(row).unwrap().to_owned()
    };
    let pattern = out("p.csv");
    let generate = ["pattern", "generate", "poisson", "--seed", "3", "--output"];
    let made = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(generate)
        .arg(&pattern)
        .status();
    assert!(made.unwrap().success());
    let run = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["simulate", "-q", "--format", "json", "--pattern"])
        .arg(&pattern)
        .output()
        .unwrap();
    let run: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    let end = run["end_s"].as_f64().unwrap();
    assert!(
        of_seed("robust_gt").contains(&format!(",{end},")),
        "{}",
        of_seed("robust_gt")
    );
}

#[test]
fn wrong_input_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "[[case]]\nname = \"a\"\ngrid = 0.2\nitms = 3\n").unwrap();
    let file = file.to_str().unwrap();
    let below = format!("{file}/below");
    for (arguments, words) in [
        (
            &["--cases", "papr"][..],
            &["--cases", "did you mean `paper`"][..],
        ),
        (
            &["--cases", file],
            &["file:4: case[0].itms", "did you mean `items`"],
        ),
        (&["--strategy", "lokahead"], &["lokahead"]),
        (&["--strategy", "rules:SPT"], &["1 rule for 2 robots"]),
        (
            &["--robust", "SPT,FOFI"],
            &["--robust", "did you mean `FIFO`"],
        ),
        (&["--replicates", "0"], &["--replicates", "0 patterns"]),
        (&["--out", &below], &["cannot write", "below"]),
        (&["--update-hz", "-1"], &["--update-hz", "-1"]),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .arg("compare")
            .args(arguments)
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(output.stdout.is_empty());
        for word in words {
            assert!(told.contains(word), "{arguments:?}: {word} not in {told}");
        }
        assert!(!told.contains("panicked"), "{told}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// The paper compares robust GT, greedy GT and its policy; so does the default.
#[cfg(feature = "onnx")]
#[test]
fn the_policy_that_ships_is_the_third_column() {
    let run = |flags: &[&str]| -> serde_json::Value {
        let small = ["compare", "-q", "--robust", "SPT,FIFO", "--replicates", "3"];
        let json = ["--paper", "--format", "json"];
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args([&small[..], &json, flags].concat())
            .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
            .output()
            .unwrap();
        assert!(output.status.success());
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let ids = |report: &serde_json::Value| -> Vec<String> {
        let methods = report["methods"].as_array().unwrap().iter();
        methods
            .map(|m| m["id"].as_str().unwrap().to_owned())
            .collect()
    };
    let report = run(&[]);
    assert_eq!(ids(&report), ["robust_gt", "greedy_gt", "onnx"]);
    let policy = &report["cases"][0]["results"][2];
    assert_eq!(policy["paper"]["picking_rate_per_min"], 31.1);
    // More than the paper's margin of 11 %.
    assert!(
        policy["benefit_percent"].as_f64().unwrap() > 40.0,
        "{policy}"
    );
    assert_eq!(ids(&run(&["--no-policy"])), ["robust_gt", "greedy_gt"]);
    let other = ["--strategy", "onnx:policies/pickline.onnx"];
    assert_eq!(
        ids(&run(&other)),
        ["robust_gt", "greedy_gt", "onnx:policies/pickline.onnx"]
    );
}

/// One pattern says nothing of how others scatter: no interval, in whatever format.
/// What would take minutes is left out with a remark, not begun.
#[test]
fn greedy_rules_of_long_lines_are_left_out_with_a_remark() {
    let rules = ["SPT"; 8].join(",");
    let few = ["--robots", "8", "--replicates", "2", "--no-bound", "-q"];
    let call = ["compare", "--no-policy", "--robust", &rules];
    let table = common::text(&[&call[..], &few].concat());
    assert!(
        table.contains("note      greedy GT (game theory) is left out: trying 6^8 assignments")
    );
    assert!(!table.lines().any(|line| line.contains("| greedy GT")));
}

#[test]
fn a_single_pattern_has_no_interval() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let call = |arguments: &[&str]| common::text(&[arguments, &["-q", "--out", out]].concat());
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let json = |name: &str| -> serde_json::Value { serde_json::from_str(&read(name)).unwrap() };
    let small = ["--robust", "SPT,FIFO", "--replicates", "3", "--no-policy"];
    let table = call(&[&["compare"][..], &small].concat());
    let grids: Vec<&str> = table.lines().filter(|l| l.contains("greedy GT")).collect();
    let cells = |line: &str| -> Vec<String> {
        line.split('|').map(|cell| cell.trim().to_owned()).collect()
    };
    let differences: Vec<String> = grids.iter().map(|line| cells(line)[6].clone()).collect();
    assert_eq!(differences[..2], ["-", "-"]);
    assert!(
        differences.len() == 4 && differences[2..].iter().all(|d| d.contains(" to ")),
        "{table}"
    );
    let report = json("compare.json");
    let cases = report["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 4);
    for case in cases {
        let single = case["patterns"] == 1;
        for result in case["results"].as_array().unwrap() {
            for field in ["picked_share", "picking_rate", "diff"] {
                for end in ["low", "high"] {
                    let name = format!("{field}_{end}");
                    assert_eq!(result[&name].is_null(), single, "{name} in {case}");
                }
            }
        }
        assert_eq!(case["bound"]["difference"].is_null(), single);
    }
    let rates = read("picking_rate.csv");
    let low = |row: usize| common::csv_column(&rates, "diff_low_per_min")[row].is_empty();
    // The first method of each case, which has nothing to differ from, then the second.
    assert_eq!([0, 2, 4, 6].map(low), [true; 4]);
    assert_eq!([1, 3, 5, 7].map(low), [true, true, false, false]);

    call(&[
        "sweep", "--robust", "SPT,FIFO", "--from", "0.05", "--to", "0.05",
    ]);
    let point = &json("sweep.json")["points"][0];
    assert!(point["picking_rate_low"].is_null() && point["picked_share_high"].is_null());
    // A column that would be empty throughout is left out.
    let columns = common::csv_rows(&read("sweep.csv"))[0].clone();
    assert!(columns.iter().any(|name| name == "picking_rate_per_min"));
    assert!(
        !columns
            .iter()
            .any(|name| name == "picking_rate_low_per_min")
    );

    let single = [
        "optimize",
        "--patterns",
        "grid:0.2",
        "--items",
        "40",
        "--validate",
        "0",
    ];
    let table = call(&single);
    assert!(table.contains("a single pattern: differences without intervals"));
    assert!(
        table
            .lines()
            .filter(|l| l.starts_with('|'))
            .all(|l| !l.contains(" to "))
    );
    let report = json("optimize.json");
    let line = &report["ranking"][35];
    assert!(line["diff_low"].is_null() && line["mean"].is_number() && line["tied"] == false);
    let columns = common::csv_rows(&read("ranking.csv"))[0].clone();
    assert!(
        columns
            .iter()
            .any(|name| name == "picking_rate_mean_per_min")
    );
    assert!(!columns.iter().any(|name| name == "diff_low_per_min"));
    let validated = ["optimize", "--patterns", "poisson:0.2:3", "--validate", "1"];
    let table = call(&validated);
    let line = table
        .lines()
        .find(|l| l.starts_with("validated mean"))
        .unwrap();
    assert!(!line.contains("interval"), "{line}");
    assert!(json("optimize.json")["validation"]["mean_low"].is_null());
}

/// A policy comes out of its file once: what was checked is what is run. From a pipe a
/// second reading would wait for ever.
#[cfg(all(unix, feature = "onnx"))]
#[test]
fn a_policys_file_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    let range = ["--from", "0.05", "--to", "0.052"];
    for (verb, flags) in [("compare", &["--no-bound"][..]), ("sweep", &range[..])] {
        let pipe = folder.path().join(verb);
        let made = Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        let writer = {
            let pipe = pipe.clone();
            let policy = concat!(env!("CARGO_MANIFEST_DIR"), "/../../policies/pickline.onnx");
            std::thread::spawn(move || std::fs::write(pipe, std::fs::read(policy).unwrap()))
        };
        let strategy = format!("onnx:{}", pipe.display());
        let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
        command
            .args([verb, "-q", "--robust", "SPT,FIFO", "--strategy", &strategy])
            .args(flags)
            .args(
                (verb == "compare")
                    .then_some(["--replicates", "2"])
                    .into_iter()
                    .flatten(),
            );
        // It would wait for ever for what it reads a second time.
        let (code, remarks) = Program::start(&mut command).finish();
        assert_eq!(code, Some(0), "{verb}: {remarks}");
        writer.join().unwrap().unwrap();
    }
}
