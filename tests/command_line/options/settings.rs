//! What all verbs that compute have in common: seed, threads, the form of the result, its files.

use super::experiments::trained;
use super::rig::{Rig, assert_near, number};
use super::runs::{RUNNING, SIX, at_random, on, one, rate, rate_in, report};
use super::{Row, hold, row};
use serde_json::Value;

pub const ROWS: &[Row] = &[
    row(&RUNNING, "--seed", seed),
    row(&["bound"], "--seed", |rig, verb| {
        // Nothing of it is random, which the report says by the seed.
        let seed = |flags| number(&report(rig, verb, flags), "/made/seed");
        assert_eq!((seed(""), seed("--seed 7")), (1.0, 7.0));
    }),
    row(&RUNNING, "--update-hz", update_hz),
    row(&["bound"], "--update-hz", |rig, verb| {
        // The bound is that of any clock; the schedule beside it decides at its ticks.
        let report = report(rig, verb, "--update-hz 0.3");
        assert_near(
            number(&report, "/schedule/end_s"),
            20.0 / 3.0 + 10.0 / 9.0 + 0.5,
        );
    }),
    row(&RUNNING, "--threads", threads),
    row(&["bound"], "--threads", |rig, verb| {
        // It is found by one thread; what cannot be asked for is refused all the same.
        let text = |flags| rig.text(&format!("{} -q {flags}", one(verb)));
        assert_eq!(text("--threads 1"), text("--threads 3"));
        rig.refused(&format!("{} --threads 0", one(verb)), &["--threads: 0 "]);
    }),
    row(&SIX, "--format", format),
    row(&SIX, "--out", out),
    row(&SIX, "--quiet", quiet),
];

#[test]
fn common_options_have_their_effect() {
    hold(ROWS);
}

/// Another seed draws other patterns or other luck, the same the same.
fn seed(rig: &Rig, verb: &str) {
    let call = format!("{} -q --format json --station one.toml", at_random(verb));
    let report = |flags: &str| rig.json(&format!("{call} {flags}"));
    let rate = |report: &Value| rate_in(verb, report);
    let (first, again) = (report("--seed 1"), report(""));
    let other = report("--seed 7");
    assert_eq!(rate(&first), rate(&again));
    assert!(rate(&first) != rate(&other), "{}", rate(&first));
    assert_eq!(number(&other, "/made/seed"), 7.0);
}

/// The first multiple of 1/0.3 s behind 4 s is 20/3 s: the item is then at x = 2/3, 1/3 m from
/// the robot, which is there after 1/3 m / (0.5 + 0.1) m/s = 5/9 s.
fn update_hz(rig: &Rig, verb: &str) {
    let rate = |flags| rate(rig, verb, flags);
    let end = 20.0 / 3.0 + 10.0 / 9.0 + 0.5;
    assert_near(rate("--update-hz 0.3"), 60.0 / end);
    // One at which 4 s lies, and none at all.
    assert_near(rate("--update-hz 0.5"), super::rig::RATE);
    assert_near(rate("--update-hz 0"), super::rig::RATE);
    // The limit of the speed is under it as well. The last decision that picks the item at the
    // speed v is when it is at x = 1.5 - v; the first one is at 50 s: v = 1.5/51 at most, in
    // steps of 0.001 m/s for `optimize` and of 0.002 m/s for `sweep`.
    let limit = |call: &str, pointer: &str| {
        let call = format!("{call} -q --format json --update-hz 0.02");
        number(&rig.json(&call), pointer)
    };
    match verb {
        "optimize" => assert_near(limit(&one(verb), "/ranking/0/max_speed"), 0.029),
        "sweep" => {
            let call = one(verb).replace("--sweep reach --from 0.5 --to 0.6 --step 0.1", "");
            assert_near(limit(&call, "/limits/0/highest"), 0.028);
        }
        _ => {}
    }
    // With a decision every 10 s all rules pick one item each time: robust GT is the first of
    // them, where it is another otherwise.
    if ["compare", "sweep"].contains(&verb) {
        assert_ne!(trained(rig, verb, ""), "robust GT [FIFO]");
        assert_eq!(trained(rig, verb, "--update-hz 0.1"), "robust GT [FIFO]");
    }
}

/// So many threads need more room for their stacks than this process may have: the number
/// reaches those who make them. What is computed does not depend on it. The stacks are large, so
/// that the one that is refused leaves room for everything else.
fn threads(rig: &Rig, verb: &str) {
    let call = one(verb);
    let text = |flags: &str| rig.text(&format!("{call} -q --format json {flags}"));
    assert_eq!(text("--threads 1"), text("--threads 3"));
    assert_eq!(text("--threads 1"), text(""));
    for number in ["0", "1025"] {
        let words = format!("--threads: {number} is not a number of threads");
        rig.refused(&format!("{call} --threads {number}"), &[&words]);
    }
    #[cfg(target_os = "linux")]
    for (number, code) in [("1", Some(0)), ("1024", Some(1))] {
        let script = format!(
            "ulimit -v 1048576; exec {} {call} -q --threads {number}",
            env!("CARGO_BIN_EXE_pickline")
        );
        let mut shell = std::process::Command::new("sh");
        shell.args(["-c", &script]).current_dir(rig.at(""));
        let output = shell.env("RUST_MIN_STACK", "200000000").output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), code, "{number}: {told}");
        assert_eq!(told.contains("--threads"), code == Some(1), "{told}");
    }
}

fn format(rig: &Rig, verb: &str) {
    let text = |format: &str| rig.text(&format!("{} -q --format {format}", one(verb)));
    let json: Value = serde_json::from_str(&text("json")).unwrap();
    assert!(json["made"]["station_hash"].is_string());
    let csv = text("csv");
    // Each row has as many cells as the header.
    let rows = crate::common::csv_rows(&csv);
    assert!(csv.starts_with("# pickline ") && rows.len() > 1, "{csv}");
    assert!(
        rows.iter()
            .all(|row| row.len() == rows[0].len() && row.len() > 1)
    );
    let table = text("table");
    assert!(table.starts_with("| ") || table.contains("\n| "), "{table}");
    assert_eq!(table, rig.text(&format!("{} -q", one(verb))));
}

/// The result files of the verb stand in the folder, the whole report as it is printed.
fn out(rig: &Rig, verb: &str) {
    let files: &[&str] = match verb {
        "optimize" => &["optimize.json", "ranking.csv"],
        "compare" => &[
            "compare.json",
            "picked_time.csv",
            "picking_rate.csv",
            "runs.csv",
            "throughput.csv",
        ],
        "sweep" => &["sweep.csv", "sweep.json"],
        "game" => &["game.json", "game.nfg", "payoffs.csv"],
        "bound" => &["bound.json", "prices.csv"],
        _ => &["picks.csv", "run.json"],
    };
    let before = rig.names("");
    let printed = rig.text(&format!("{} -q --format json --out new/deep", one(verb)));
    assert_eq!(rig.names("new/deep"), files);
    let whole = files.iter().find(|name| name.ends_with(".json")).unwrap();
    assert_eq!(rig.read(&format!("new/deep/{whole}")), printed);
    // Without it nothing is written.
    std::fs::remove_dir_all(rig.at("new")).unwrap();
    rig.text(&format!("{} -q", one(verb)));
    assert_eq!(rig.names(""), before);
}

/// Remarks go, warnings stay: nothing may be wrong in silence.
fn quiet(rig: &Rig, verb: &str) {
    // Where everything is said in the call, `simulate` and `bound` have nothing to remark.
    let call = match verb {
        "simulate" => "simulate --no-bound --station paper".to_owned(),
        "bound" => "bound --iterations 1 --station paper".to_owned(),
        _ => one(verb),
    };
    let loud = rig.done(&call);
    assert!(loud.stderr.contains("station"), "{}", loud.stderr);
    for flag in ["-q", "--quiet"] {
        let silent = rig.done(&format!("{call} {flag}"));
        assert_eq!((silent.stderr.as_str(), &silent.stdout), ("", &loud.stdout));
    }
    let doubtful = rig.done(&format!("{} -q", on(verb, "odd.toml")));
    assert!(
        doubtful.stderr.starts_with("warning: odd.toml: "),
        "{}",
        doubtful.stderr
    );
}
