//! What `benchmark` judges, on a benchmark of two lines of which everything is known.

use super::rig::{RATE, Rig, STATION, assert_near, number};
use super::{Row, hold, row};
use serde_json::Value;

const BENCHMARK: [&str; 1] = ["benchmark"];
/// The one pick of the first line.
const PICKS: &str = "robot,item,decide_s,grasp_s,release_s\na,A,4,5,6.5\n";
const CALL: &str = "benchmark --dir bench --format json -q";

pub const ROWS: &[Row] = &[
    row(&BENCHMARK, "--dir", |rig, _| {
        assert_eq!(runs(rig, "").len(), 2);
        rig.refused("benchmark --dir empty", &["--dir: there is no empty"]);
    }),
    row(&BENCHMARK, "--only", |rig, _| {
        let names = |flags: &str| {
            let runs = runs(rig, flags);
            let names = runs.iter().map(|run| run["instance"].as_str().unwrap());
            names.map(str::to_owned).collect::<Vec<_>>()
        };
        assert_eq!(names(""), ["near", "far"]);
        assert_eq!(names("--only n*r"), ["near"]);
        assert_eq!(names("--only far --only near"), ["near", "far"]);
    }),
    row(&BENCHMARK, "--strategy", |rig, _| {
        let run = &runs(rig, "--strategy rules:FIFO")[0];
        assert_eq!(run["entrant"], "rules:FIFO");
        assert_near(number(run, "/picking_rate_per_min"), RATE);
    }),
    row(&BENCHMARK, "--track", |rig, _| {
        // The second robot would leave 0.6 s before its item is on the belt, at 9.4 s.
        let rate = |flags: &str| {
            let run = &runs(rig, &format!("--strategy rules:FIFO {flags}"))[1];
            number(run, "/picking_rate_per_min")
        };
        assert_near(rate("--track clairvoyant"), 60.0 / (9.4 + 1.2 + 0.5));
        // At 10 s the item is 0.3 m away, and comes at the speed of the belt.
        assert_near(rate("--track online"), 60.0 / (10.0 + 1.0 + 0.5));
        assert_near(rate(""), rate("--track online"));
    }),
    row(&BENCHMARK, "--program", |rig, _| {
        program(rig, "cp mine/near.csv \"$3\"");
        let runs = runs(rig, "--program ./run.sh");
        assert_eq!(number(&runs[0], "/picked"), 1.0);
        // The same picks on the other line.
        assert!(!failure(&runs[1]).is_empty(), "{runs:?}");
        for (script, words) in [
            (
                "echo no idea >&2; exit 3",
                "exit status: 3; it said: no idea",
            ),
            ("exit 0", "the program: wrote no picks"),
            (
                "echo robot,item > \"$3\"",
                "its picks:1: the column `decide_s` is missing",
            ),
            (
                "sed s/6.5/6.4/ mine/near.csv > \"$3\"",
                "it returns at 6.5 s, not 6.4 s",
            ),
        ] {
            program(rig, script);
            // A strategy that can do it, so that some run is valid.
            let runs = self::runs(rig, "--program ./run.sh --only near --strategy rules:FIFO");
            let run = &runs[1];
            assert!(run["picked"].is_null(), "{run}");
            assert!(failure(run).contains(words), "{words} not in {run}");
        }
    }),
    row(&BENCHMARK, "--timeout", |rig, _| {
        program(rig, "exec sleep 3");
        // What the program has started is stopped with it.
        let call = "--program ./run.sh --timeout 0.2 --only near";
        let run = &runs(rig, &format!("{call} --strategy rules:FIFO"))[1];
        assert_eq!(failure(run), "the program: took longer than 0.2 s");
        rig.ended(&format!("{CALL} {call}"), 1, &["no run is valid"]);
    }),
    row(&BENCHMARK, "--picks", |rig, _| {
        let runs = runs(rig, "--picks mine");
        assert_eq!(runs[0]["entrant"], "picks in mine");
        assert_eq!(number(&runs[0], "/picked"), 1.0);
        assert_eq!(failure(&runs[1]), "mine/far.csv: does not exist");
        rig.refused(
            "benchmark --dir bench --picks bench",
            &["--picks: bench has no file of picks", "near.csv"],
        );
    }),
    row(&BENCHMARK, "--bounds", |rig, _| {
        let run = &runs(rig, "--bounds")[0];
        assert_eq!(run["entrant"], "schedule of the bound");
        assert_eq!(number(run, "/picked"), 1.0);
    }),
    row(&BENCHMARK, "--update", |rig, _| {
        bench(rig);
        let before = rig.read("bench/instances.csv");
        runs(rig, "--strategy rules:FIFO");
        assert_eq!(rig.read("bench/instances.csv"), before);
        runs(rig, "--bounds --strategy rules:FIFO --update");
        // Whoever reads everything may leave earlier.
        assert_eq!(rig.names("bench/best"), ["far.csv", "near.csv"]);
        assert!(rig.read("bench/instances.csv").contains("\nnear,1,1,1,"));
        // What is known is the best of nobody.
        let run = &runs(rig, "")[0];
        assert_eq!(
            (&run["entrant"], &run["picked"]),
            (&"best known".into(), &1.into())
        );
        assert_eq!(number(run, "/gap_to_bound_percent"), 0.0);
        // The list is held to what is there.
        let list = rig.read("bench/instances.csv");
        for (from, to, code, words) in [
            ("near,1,1,1,", "near,1,1,0,", 1, "1 best known solution"),
            (
                "near,1,1,",
                "near,2,1,",
                2,
                "instances.csv:2: robots: 2, but",
            ),
            (
                "near,1,1,",
                "near,1,3,",
                2,
                "instances.csv:2: items: 3, but",
            ),
        ] {
            rig.write("bench/instances.csv", &list.replace(from, to));
            rig.ended(CALL, code, &[words]);
        }
        // Nothing is lost, and nothing possible is above a bound.
        rig.write(
            "bench/instances.csv",
            &list.replace("near,1,1,1,", "near,1,1,0,"),
        );
        let update = format!("{CALL} --strategy rules:FIFO --update");
        rig.refused(&update, &["near.csv", "correct the list"]);
        rig.write("bench/instances.csv", &format!("# mine\n{list}"));
        rig.refused(&update, &["a comment would be lost"]);
        let bounded = "name,picks_bound,rate_bound_per_min\nnear,,1\n";
        rig.write("bench/instances.csv", bounded);
        rig.ended(
            &update,
            1,
            &["the benchmark: 1 run above a certified bound"],
        );
        assert_eq!(rig.read("bench/instances.csv"), bounded);
        rig.write("bench/instances.csv", &list);
    }),
    row(&BENCHMARK, "--by", |rig, _| {
        runs(rig, "--picks mine --update --by=A.Name");
        let list = rig.read("bench/instances.csv");
        assert!(list.lines().any(|line| line.ends_with(",A.Name")), "{list}");
        rig.refused(
            &format!("{CALL} --strategy SPT --strategy rules:SPT"),
            &["`rules:SPT` is given twice"],
        );
    }),
    row(&BENCHMARK, "--seed", |rig, _| {
        let seed = |flags: &str| number(&report(rig, flags), "/made/seed");
        assert_eq!((seed(""), seed("--seed 7")), (1.0, 7.0));
    }),
    row(&BENCHMARK, "--update-hz", |rig, _| {
        let run = &runs(rig, "--strategy rules:FIFO --update-hz 0.3")[0];
        let end = 20.0 / 3.0 + 10.0 / 9.0 + 0.5;
        assert_near(number(run, "/picking_rate_per_min"), 60.0 / end);
    }),
    row(&BENCHMARK, "--threads", |rig, _| {
        runs(rig, "");
        assert_eq!(
            report_text(rig, "--threads 1"),
            report_text(rig, "--threads 3")
        );
        rig.refused(&format!("{CALL} --threads 0"), &["--threads: 0 "]);
    }),
    row(&BENCHMARK, "--format", |rig, _| {
        bench(rig);
        let text = |flags: &str| rig.text(&format!("benchmark --dir bench -q {flags}"));
        assert!(text("--format json").starts_with("{\n"));
        let csv = text("--format csv");
        assert!(
            csv.starts_with("# pickline ") && csv.contains("\ninstance,entrant,"),
            "{csv}"
        );
        assert!(text("--format table").starts_with("| instance "));
        assert_eq!(text(""), text("--format table"));
    }),
    row(&BENCHMARK, "--out", |rig, _| {
        let printed = report_text(rig, "--out new");
        assert_eq!(
            rig.names("new"),
            ["benchmark.json", "ranking.csv", "runs.csv"]
        );
        assert_eq!(rig.read("new/benchmark.json"), printed);
    }),
    row(&BENCHMARK, "--quiet", |rig, _| {
        bench(rig);
        let call = "benchmark --dir bench --strategy rules:FIFO --update";
        let told = rig.done(call).stderr;
        assert_eq!(told, "bench: 2 better solutions, 0 tighter bounds\n");
        assert_eq!(rig.done(&format!("{call} --quiet")).stderr, "");
    }),
];

#[test]
fn options_of_the_benchmark_have_their_effect() {
    hold(ROWS);
}

/// Two lines with an item each, and a file of picks for the first.
fn bench(rig: &Rig) {
    for folder in ["bench/stations", "bench/patterns", "mine", "empty"] {
        std::fs::create_dir_all(rig.at(folder)).unwrap();
    }
    rig.write("bench/instances.csv", "name\nnear\nfar\n");
    rig.write("bench/stations/near.toml", STATION);
    rig.write("bench/patterns/near.csv", "id,x,y\nA,0,0\n");
    // The robot reaches beyond the beginning of the belt, where its item is met at the earliest.
    let place = "base = [0.3, 0.0]\nbin = [0.3, 0.0]";
    let moved = STATION.replace("base = [1.0, 0.0]\nbin = [1.0, 0.0]", place);
    rig.write("bench/stations/far.toml", &moved);
    rig.write("bench/patterns/far.csv", "id,x,y\nB,-1,0\n");
    rig.write("mine/near.csv", PICKS);
}

fn report_text(rig: &Rig, flags: &str) -> String {
    bench(rig);
    rig.text(&format!("{CALL} {flags}"))
}

fn report(rig: &Rig, flags: &str) -> Value {
    serde_json::from_str(&report_text(rig, flags)).unwrap()
}

/// The runs that are reported of a new benchmark, or of the one that was updated.
fn runs(rig: &Rig, flags: &str) -> Vec<Value> {
    if !rig.at("bench").exists() {
        bench(rig);
    }
    let report = rig.json(&format!("{CALL} {flags}"));
    report["runs"].as_array().unwrap().clone()
}

fn failure(run: &Value) -> &str {
    run["failure"].as_str().unwrap_or_default()
}

/// A program that does what `script` says.
fn program(rig: &Rig, script: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    if !rig.at("bench").exists() {
        bench(rig);
    }
    rig.write("run.sh", &format!("#!/bin/sh\n{script}\n"));
    let mode = std::fs::Permissions::from_mode(0o755);
    std::fs::set_permissions(rig.at("run.sh"), mode).unwrap();
}
