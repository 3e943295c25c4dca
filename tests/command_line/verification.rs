//! `pickline check` on what `simulate` writes, and on what other programs write.

use super::options::STATION;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn call(folder: &Path, line: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(line.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap()
}

fn printed(folder: &Path, line: &str) -> String {
    let output = call(folder, line);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{line}: {errors}");
    String::from_utf8(output.stdout).unwrap()
}

/// The report on `line`, and the exit code.
fn verdict(folder: &Path, line: &str) -> (Value, i32) {
    let output = call(folder, &format!("check -q --format json {line}"));
    let told = String::from_utf8_lossy(&output.stderr);
    let report = serde_json::from_slice(&output.stdout).unwrap_or_else(|e| panic!("{e}: {told}"));
    (report, output.status.code().unwrap())
}

/// Whatever `simulate` writes is confirmed, without any tolerance.
#[test]
fn what_simulate_writes_is_confirmed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let file = |name: &str| path.join(name);
    let classes = "pet:0.4,hdpe:0.3,wood:0.2";
    let pattern =
        format!("pattern generate poisson -q --count 150 --width 0.5 --classes {classes}");
    std::fs::write(file("p.csv"), printed(path, &pattern)).unwrap();
    for (station, conditions, terms) in [
        ("paper", "", ""),
        ("delta", "--grasp-success 0.7", ""),
        ("sorting", "--camera-x 0.1", "--camera-x 0.1"),
        (
            "sorting",
            "--update-hz 20 --strategy lookahead",
            "--update-hz 20",
        ),
        ("delta", "--grasp-success 0.8 --position-noise 0.02", ""),
    ] {
        let line = format!("--station {station} --pattern p.csv");
        let run = format!("simulate -q --no-bound --format csv {line} {conditions}");
        let picks = printed(path, &run);
        std::fs::write(file("picks.csv"), &picks).unwrap();
        let (report, code) = verdict(path, &format!("picks.csv {line} {terms}"));
        assert_eq!(
            (&report["confirmed"], code),
            (&Value::Bool(true), 0),
            "{report}"
        );
        let rows = crate::common::csv_rows(&picks).len() - 1;
        let count = |key: &str| report[key].as_u64().unwrap() as usize;
        assert_eq!(count("picks") + count("failures"), rows, "{station}");
        assert_eq!(count("failures") > 0, conditions.contains("success"));
        assert_eq!(report["items"], 150);
        // Only a station that sorts has the column; the class decides as well.
        let header = picks.lines().find(|line| !line.starts_with('#')).unwrap();
        assert_eq!(header.contains(",bin,"), station == "sorting", "{header}");
    }
}

/// A row with something that does not exist is a violation; the rest of it counts nevertheless.
#[test]
fn what_is_unknown_is_told_and_the_rest_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let write = |name: &str, text: &str| std::fs::write(path.join(name), text).unwrap();
    write("one.toml", STATION);
    write("p.csv", "id,x,y\nA,0,0\nB,-1,0\nC,-2,0\n");
    write(
        "picks.csv",
        "item,robot,decide_s,grasp_s,release_s,bin\nA,a,4,5,6.5,\nB,a,14,15,16.4,nowhere\n\
         D,a,18,19,24.2,\nC,a,24,25,26.5,\nC,z,24,25,26.5,\n",
    );
    let (report, code) = verdict(path, "picks.csv --station one.toml --pattern p.csv");
    assert_eq!(code, 1);
    let found: Vec<_> = report["violations"].as_array().unwrap().iter().collect();
    let kinds = |line: u64| {
        let own = found.iter().filter(|v| v["line"] == line);
        let mut kinds: Vec<_> = own.map(|v| v["kind"].as_str().unwrap()).collect();
        kinds.sort_unstable();
        kinds
    };
    assert_eq!(kinds(2), [""; 0]);
    assert_eq!(kinds(3), ["return_time", "unknown"]);
    assert_eq!(kinds(4), ["unknown"]);
    // The robot is busy with what is unknown, and another one has the item.
    assert_eq!(kinds(5), ["busy"]);
    assert_eq!(kinds(6), ["claimed", "unknown"]);
    assert_eq!(report["picks"], 5);
}

/// Every line with something wrong is named, with the place and what would be right.
#[test]
fn other_programs_are_told_what_is_wrong_where() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let write = |name: &str, text: &str| std::fs::write(path.join(name), text).unwrap();
    write("one.toml", STATION);
    write("p.csv", "id,x,y\nA,0,0\nB,-1,0\nC,-2,0\n");
    // Met at x = 0.5 after 1 s, done 1.5 s later; B is said to take 1.4 s, C is unknown by its name.
    write(
        "picks.csv",
        "# by a controller\nitem;robot;release_s;decide_s;grasp_s\n\
         A;a;6,5;4;5\n\nB;1;16,4;14;15\nD;a;26,5;24;25\n",
    );
    let line = "picks.csv --station one.toml --pattern p.csv";
    let (report, code) = verdict(path, line);
    assert_eq!((&report["confirmed"], code), (&Value::Bool(false), 1));
    let found = report["violations"].as_array().unwrap();
    assert_eq!(found.len(), 2, "{report}");
    let late = &found[0];
    assert_eq!(
        (&late["line"], &late["robot"], &late["item"]),
        (&5.into(), &"a".into(), &"B".into())
    );
    assert_eq!(late["kind"], "return_time");
    let place = late["place"].as_array().unwrap();
    assert!((place[0].as_f64().unwrap() - 0.5).abs() < 1e-12 && place[1] == 0.0);
    assert!(
        late["problem"]
            .as_str()
            .unwrap()
            .contains("16.5 s, not 16.4 s"),
        "{late}"
    );
    assert!((late["accepted_from_s"].as_f64().unwrap() - 0.1 / 2.2).abs() < 1e-6);
    assert_eq!(
        (&found[1]["line"], &found[1]["kind"]),
        (&6.into(), &"unknown".into())
    );
    assert!(
        found[1]["problem"]
            .as_str()
            .unwrap()
            .contains("no item `D`")
    );
    // The same for people and for programs.
    let output = call(path, &format!("check -q {line}"));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("rejected: 2 violations of the model (1 return_time, 1 unknown)"),
        "{text}"
    );
    assert!(
        text.contains("1 of the violations would be accepted with 0.0455 s"),
        "{text}"
    );
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(
        told.contains("the checker rejects this run: 2 violations, the first in line 5"),
        "{told}"
    );
    let output = call(path, &format!("check -q --format csv {line}"));
    assert_eq!(output.status.code(), Some(1));
    let rows = crate::common::csv_rows(&String::from_utf8(output.stdout).unwrap());
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[1][..4], ["5", "a", "B", "14"]);
    let (report, code) = verdict(path, &format!("{line} --tolerance 0.05"));
    assert_eq!(
        (report["violations"].as_array().unwrap().len(), code),
        (1, 1)
    );
}
