//! The program as its users call it.

use crate::common;
#[cfg(target_os = "linux")]
use crate::terminal::Terminal;
use common::{pickline, text};
use serde_json::Value;
use std::io::Write as _;
use std::process::{Command, Stdio};

/// Assignments of two robots.
fn pairs() -> usize {
    pickline::dispatch::RULES.len().pow(2)
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&text(arguments)).unwrap()
}

#[test]
fn every_verb_runs_without_arguments() {
    for verb in [
        "optimize",
        "compare",
        "sweep",
        "game",
        "bound",
        "simulate",
        "pattern",
        "station",
        "completions",
        "service",
        "man",
    ] {
        let printed = text(&[verb]);
        assert!(printed.lines().count() > 3, "{verb}: {printed}");
    }
    let printed = pickline(&["simulate"]);
    let remark = String::from_utf8(printed.stderr).unwrap();
    assert!(
        remark.contains("built-in grid of 0.15 m, 50 items"),
        "{remark}"
    );
}

#[test]
fn every_help_names_every_strategy() {
    let mut verbs = vec!["simulate", "compare", "sweep", "optimize", "run"];
    if cfg!(feature = "onnx") {
        verbs.push("train");
    }
    for verb in verbs {
        for flag in ["-h", "--help"] {
            let help = text(&[verb, flag]);
            for kind in pickline::strategies::STRATEGIES {
                assert!(help.contains(kind.form), "{verb} {flag}: {}", kind.form);
            }
        }
    }
}

#[test]
fn simulate_prints_the_agreed_json() {
    let run = json(&[
        "simulate",
        "--strategy",
        "rules:SPT,FIFO",
        "--format",
        "json",
        "--check",
    ]);
    assert_eq!(run["items"], 50);
    assert_eq!(run["picked"], 44);
    assert_eq!(run["picked_share"], 0.88);
    assert!((run["end_s"].as_f64().unwrap() - 99.0).abs() < 1e-9);
    assert!((run["picking_rate_per_min"].as_f64().unwrap() - 60.0 * 44.0 / 99.0).abs() < 1e-9);
    assert!((run["weighted_rate_per_min"].as_f64().unwrap() - 30.0 * 44.0 / 99.0).abs() < 1e-9);
    assert_eq!(run["robots"][0]["name"], "r1");
    let picks = run["picks"].as_array().unwrap();
    assert_eq!(picks.len(), 44);
    for pick in picks {
        assert!(pick["item"].is_string() && pick["meet"].as_array().unwrap().len() == 2);
        let at = |name: &str| pick[name].as_f64().unwrap();
        assert!(at("decide_s") < at("grasp_s") && at("grasp_s") < at("release_s"));
    }
    assert_eq!(run["missed"].as_array().unwrap().len(), 6);
    assert_eq!(run["missed"][0]["reason"], "passed_over");
    assert_eq!(run["missed_by_reason"]["passed_over"], 6);
    assert_eq!(run["checked"], true);
}

#[test]
fn miss_reasons_are_distinguished() {
    // One robot reaches y < 0.175 only: the rest is unreachable.
    let run = json(&[
        "simulate",
        "--robots",
        "1",
        "--strategy",
        "FIFO",
        "--format",
        "json",
    ]);
    let reasons = &run["missed_by_reason"];
    assert!(reasons["unreachable"].as_u64().unwrap() > 10, "{reasons}");
    assert!(reasons["passed_over"].as_u64().unwrap() > 0, "{reasons}");
    // A first item that takes long; the second passes meanwhile.
    let folder = tempfile::tempdir().unwrap();
    let station = folder.path().join("s.toml");
    std::fs::write(
        &station,
        "[belt]\nspeed = 0.1\nlength = 3\nwidth = 1\n[[robot]]\nname = \"a\"\nbase = [1, -0.5]\n\
         bin = [1, -0.5]\nreach = 0.3\nspeed = 0.5\ngrasp_time = 30\nrelease_time = 0\n",
    )
    .unwrap();
    let pattern = folder.path().join("p.csv");
    std::fs::write(&pattern, "id,x,y\nfirst,0,-0.4\nsecond,-1,-0.4\n").unwrap();
    let run = json(&[
        "simulate",
        "--station",
        station.to_str().unwrap(),
        "--pattern",
        pattern.to_str().unwrap(),
        "--format",
        "json",
    ]);
    assert_eq!(run["picks"][0]["item"], "first");
    assert_eq!(run["missed"][0]["item"], "second");
    assert_eq!(run["missed"][0]["reason"], "busy");
}

#[test]
fn the_trace_has_every_event_in_order_of_time() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("trace.csv");
    text(&["simulate", "-q", "--trace", file.to_str().unwrap()]);
    let trace = std::fs::read_to_string(&file).unwrap();
    assert!(trace.starts_with("# pickline simulate\n"), "{trace}");
    let rows = common::csv_rows(&trace)[1..].to_vec();
    let count = |event: &str| rows.iter().filter(|row| row[1] == event).count();
    assert_eq!(count("decide"), 44);
    assert_eq!(count("grasp"), 44);
    assert_eq!(count("release"), 44);
    assert_eq!(count("left_belt"), 6);
    assert_eq!(rows.len(), 3 * 44 + 6);
    let times: Vec<f64> = rows.iter().map(|row| row[0].parse().unwrap()).collect();
    assert!(times.is_sorted());
}

#[test]
fn the_replay_is_one_file_and_leaves_the_result_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("replay.html");
    let plain = text(&["simulate", "-q", "--format", "json"]);
    let path = file.to_str().unwrap();
    let printed = text(&["simulate", "-q", "--format", "json", "--html", path]);
    assert_eq!(plain, printed);
    let page = std::fs::read_to_string(&file).unwrap();
    assert!(page.starts_with("<!doctype html>"));
    assert!(!page.contains("src=") && !page.contains("href=") && !page.contains("://"));
    let data = page.split_once("type=\"application/json\">").unwrap().1;
    let data: Value = serde_json::from_str(data.split_once("</script>").unwrap().0).unwrap();
    let report: Value = serde_json::from_str(&plain).unwrap();
    assert_eq!(data["report"], report);
    assert_eq!(data["items"].as_array().unwrap().len(), 50);
    assert_eq!(data["items"][0]["windows"][0]["robot"], 0);
}

const SMALL: [&str; 6] = [
    "optimize",
    "--patterns",
    "balanced:8",
    "--items",
    "60",
    "-q",
];

#[test]
fn optimize_prints_the_agreed_json() {
    let more = ["--format", "json", "--validate", "50", "--search", "both"];
    let report = json(&[&SMALL[..], &more].concat());
    assert_eq!(report["objective"], "picking-rate");
    assert_eq!(report["search"], "exhaustive");
    assert_eq!(report["grasp"]["gap"], 0.0);
    let ranking = report["ranking"].as_array().unwrap();
    assert_eq!(ranking.len(), pairs());
    assert_eq!(ranking[0]["assignment"], report["best"]);
    let best = ranking[0]["mean"].as_f64().unwrap();
    for line in ranking {
        let at = |name: &str| line[name].as_f64().unwrap();
        let difference = best - at("mean");
        assert!(at("diff_low") - 1e-9 <= difference && difference <= at("diff_high") + 1e-9);
        let holds_zero = at("diff_low") <= 0.0 && 0.0 <= at("diff_high");
        assert_eq!(line["tied"], holds_zero, "{line}");
    }
    assert_eq!(report["validation"]["count"], 50);
    assert_eq!(report["made"]["seed"], 1);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    for verb in [
        &[&SMALL[..], &["--robots", "3"]].concat()[..],
        &[
            &SMALL[..],
            &["--robots", "3", "--search", "grasp", "--risk", "cvar:0.2"],
        ]
        .concat(),
        &[
            &SMALL[..],
            &["--objective", "max-speed", "--speed-step", "0.01"],
        ]
        .concat(),
    ] {
        for format in ["table", "json", "csv"] {
            let few = ["--validate", "100", "--format", format, "--threads"];
            let run = |threads| text(&[verb, &few, &[threads]].concat());
            let one = run("1");
            assert_eq!(one, run("2"));
            assert_eq!(one, run("7"));
        }
    }
}

#[test]
fn result_files_are_written_and_equal_the_output() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("deep/er");
    let printed = text(
        &[
            &SMALL[..],
            &["--format", "json", "--out", out.to_str().unwrap()],
        ]
        .concat(),
    );
    assert_eq!(
        std::fs::read_to_string(out.join("optimize.json")).unwrap(),
        printed
    );
    let ranking = std::fs::read_to_string(out.join("ranking.csv")).unwrap();
    assert_eq!(common::csv_rows(&ranking).len(), 1 + pairs());
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 2);
}

#[test]
fn patterns_flow_from_verb_to_verb() {
    let pattern = text(&[
        "pattern",
        "generate",
        "poisson",
        "--area",
        "lognormal:80,0.5",
    ]);
    assert!(pattern.starts_with("id,x,y,area_cm2\n"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args([
            "simulate",
            "-q",
            "--pattern",
            "-",
            "--check",
            "--format",
            "json",
        ])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(pattern.as_bytes())
        .unwrap();
    let output = child.wait_with_output().unwrap();
    let run: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(run["items"], 29);
    assert!(
        run["weighted_rate_per_min"].as_f64()
            > run["picking_rate_per_min"].as_f64().map(|r| r / 2.0)
    );
}

/// From a tracker's recording to the rule for each robot.
#[test]
fn an_imported_recording_is_optimised_for() {
    let folder = tempfile::tempdir().unwrap();
    let pattern = folder.path().join("recorded.csv");
    let pattern = pattern.to_str().unwrap();
    let recording = concat!(env!("CARGO_MANIFEST_DIR"), "/../../patterns/tracker.txt");
    let import = pickline(&[
        "pattern",
        "import",
        "mot",
        recording,
        "--fps",
        "10",
        "--scale",
        "0.0015",
        "--axis",
        "x",
        "--belt-speed",
        "0.078",
        "--output",
        pattern,
    ]);
    let told = String::from_utf8(import.stderr).unwrap();
    assert!(import.status.success(), "{told}");
    assert!(told.contains("dropped"), "{told}");
    let committed = include_str!("../../patterns/recorded.csv");
    // Behind the call that each comes from.
    let rows = |text: &str| text.split_once('\n').unwrap().1.to_owned();
    let imported = std::fs::read_to_string(pattern).unwrap();
    assert!(imported.starts_with("# pickline ") && committed.starts_with("# pickline "));
    assert_eq!(rows(&imported), rows(committed), "import it again");
    let report = json(&[
        "optimize",
        "-q",
        "--station",
        "paper-narrow",
        "--patterns",
        pattern,
        "--format",
        "json",
    ]);
    assert_eq!(report["patterns"], 1);
    assert_eq!(report["ranking"].as_array().unwrap().len(), pairs());
    assert!(report["ranking"][0]["mean"].as_f64().unwrap() > 0.0);
    assert!(report["notes"].to_string().contains("no validation"));
}

#[test]
fn station_files_round_trip() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("line.toml");
    let file = file.to_str().unwrap();
    text(&["station", "init", file]);
    assert_eq!(pickline(&["station", "init", file]).status.code(), Some(2));
    assert!(text(&["station", "check", file]).contains("ok "));
    let shown = text(&["station", "show", "--station", file]);
    assert_eq!(shown, text(&["station", "show"]));
    let svg = folder.path().join("s.svg");
    text(&["station", "show", "--svg", svg.to_str().unwrap()]);
    assert!(std::fs::read_to_string(svg).unwrap().contains("</svg>"));
}

#[test]
fn the_readme_picture_is_what_the_program_draws() {
    let folder = tempfile::tempdir().unwrap();
    let svg = folder.path().join("s.svg");
    text(&["station", "show", "--svg", svg.to_str().unwrap()]);
    let committed = include_str!("../../docs/station.svg");
    assert_eq!(
        std::fs::read_to_string(svg).unwrap(),
        committed,
        "draw docs/station.svg again"
    );
}

/// Ctrl-C during a search returns the best so far.
#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_search_returns_the_incumbent() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.json");
    let search = "optimize --robots 6 --search exhaustive --items 2000 --format json";
    let mut terminal = Terminal::pickline(search, &file);
    terminal.wait_for_more_than(0, "enumerating");
    terminal.press_ctrl_c();
    assert_eq!(terminal.finish(), Some(130), "{}", terminal.shown());
    let printed = std::fs::read_to_string(file).unwrap();
    let report: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(report["stop_reason"], "interrupted");
    let patterns = report["patterns"].as_u64().unwrap();
    assert!(0 < patterns && patterns < 240, "{patterns}");
    let best = report["best"].as_array().unwrap();
    assert_eq!(best.len(), 6);
    assert_eq!(report["ranking"][0]["assignment"], report["best"]);
}

#[test]
fn pattern_generate_reports_its_assumptions_unless_quiet() {
    let told = |flags: &[&str]| {
        let output = pickline(&[&["pattern", "generate"], flags].concat());
        assert!(output.status.success());
        (output.stdout, String::from_utf8(output.stderr).unwrap())
    };
    let (pattern, remark) = told(&["poisson"]);
    assert!(
        remark.contains("a Poisson disk pattern of 0.2 m, 29 items"),
        "{remark}"
    );
    assert_eq!(told(&["poisson", "-q"]), (pattern.clone(), String::new()));
    let given = ["poisson", "--radius", "0.2", "--count", "29"];
    assert_eq!(told(&given), (pattern, String::new()));
}
