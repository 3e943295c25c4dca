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

/// The tolerance that is said to do does.
#[test]
fn the_tolerance_that_is_named_is_enough() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(
        path.join("p.csv"),
        printed(path, "pattern generate grid -q --count 20"),
    )
    .unwrap();
    let line = "--pattern p.csv";
    let picks = printed(path, &format!("simulate -q --no-bound --format csv {line}"));
    // Every release is a little early, by unlike times.
    let mut rows = crate::common::csv_rows(&picks);
    let column = rows[0].iter().position(|name| name == "release_s").unwrap();
    for (place, row) in rows.iter_mut().enumerate().skip(1) {
        let release: f64 = row[column].parse().unwrap();
        row[column] = (release - 0.001_234_567 * place as f64).to_string();
    }
    let early: Vec<String> = rows.iter().map(|row| row.join(",")).collect();
    std::fs::write(path.join("early.csv"), early.join("\n") + "\n").unwrap();
    let told = String::from_utf8(call(path, &format!("check -q early.csv {line}")).stdout).unwrap();
    let (_, after) = told.split_once("would be accepted with ").unwrap();
    let (enough, _) = after.split_once(" s").unwrap();
    assert_eq!(enough.len(), "0.0000".len(), "{told}");
    let (report, code) = verdict(path, &format!("early.csv {line} --tolerance {enough}"));
    assert_eq!(
        (&report["confirmed"], code),
        (&Value::Bool(true), 0),
        "{report}"
    );
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

/// Of a row with something that does not exist, times are checked by themselves, and the ways of a robot
/// that exists where the file says where it went.
#[test]
fn times_of_what_is_unknown_are_checked_by_themselves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let write = |name: &str, text: &str| std::fs::write(path.join(name), text).unwrap();
    write("one.toml", STATION);
    write("p.csv", "id,x,y\nA,0,0\n");
    write(
        "picks.csv",
        "item,robot,decide_s,grasp_s,release_s,meet_x_m,meet_y_m\nA,a,4,5,6.5,,\nA,z,14,13,12,,\n\
         D,a,20,19,19.1,,\nD,a,30,35,36.5,0.5,0\nD,a,-40,61,62.5,,\nD,z,70,75,80,,\nA,z,90,60,91,,\n",
    );
    let (report, code) = verdict(path, "picks.csv --station one.toml --pattern p.csv");
    assert_eq!(code, 1);
    let of = |line: u64| {
        let own = report["violations"].as_array().unwrap().iter();
        let own = own.filter(|v| v["line"] == line && v["kind"] != "unknown");
        let own = own.map(|v| {
            (
                v["kind"].as_str().unwrap().to_owned(),
                v["problem"].as_str().unwrap().to_owned(),
                v["accepted_from_s"].as_f64(),
            )
        });
        own.collect::<Vec<_>>()
    };
    let named = |line: u64, kind: &str, words: &str| {
        let found = of(line);
        let own = found.iter().find(|v| v.0 == kind);
        let own = own.unwrap_or_else(|| panic!("{line} {kind}: {found:?}"));
        assert!(own.1.contains(words), "{own:?}");
        own.2
    };
    // Who leaves 40 s too early is busy for a while.
    assert!(of(2).iter().all(|v| v.0 == "busy"), "{:?}", of(2));
    let half = named(3, "travel_time", "grasps at 13 s, before it leaves at 14 s");
    assert!((half.unwrap() - 0.5).abs() < 1e-6);
    named(
        3,
        "return_time",
        "in the bin at 12 s, before the grasp begins at 13 s",
    );
    named(4, "travel_time", "before it leaves at 20 s");
    // 0.2 s of grasp and release, at least.
    named(4, "return_time", "grasp and release alone take");
    // It was at its bin, and is said to have met something at a place that takes 1 s.
    named(5, "travel_time", "does not take 5 s, but 1 s");
    named(6, "times", "leaves at -40 s, before the run begins");
    assert_eq!(of(7), []);
    // No tolerance may be so large.
    assert_eq!(named(8, "travel_time", "before it leaves at 90 s"), None);
    let place = |line: u64| {
        let own = report["violations"].as_array().unwrap().iter();
        own.clone().find(|v| v["line"] == line).unwrap()["place"].clone()
    };
    assert!(place(4).is_null() && place(5)[0] == 0.5);
}

/// Picks come from a pipe as well; a file without picks is doubtful.
#[test]
fn picks_are_read_from_stdin_and_none_are_told() {
    use std::io::Write as _;
    let folder = tempfile::tempdir().unwrap();
    let piped = |text: &str, flags: &[&str]| {
        let mut child = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(["check", "-"])
            .args(flags)
            .current_dir(folder.path())
            .stdin(std::process::Stdio::piped())
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        // It may refuse before it reads.
        let _ = child.stdin.take().unwrap().write_all(text.as_bytes());
        let output = child.wait_with_output().unwrap();
        let told = [output.stdout, output.stderr].map(|t| String::from_utf8(t).unwrap());
        (told, output.status.code().unwrap())
    };
    let picks = printed(folder.path(), "simulate -q --no-bound --format csv");
    let ([verdict, _], code) = piped(&picks, &["-q"]);
    assert!(
        code == 0 && verdict.contains("picks of stdin (hash"),
        "{verdict}"
    );
    let none = "robot,item,decide_s,grasp_s,release_s\n";
    let ([verdict, told], code) = piped(none, &["-q"]);
    assert_eq!(code, 0);
    assert!(
        verdict.contains("there are no picks that could contradict"),
        "{verdict}"
    );
    assert!(
        told.contains("warning: stdin: has a header, but no picks"),
        "{told}"
    );
    let ([_, told], code) = piped(none, &["--strict"]);
    assert!(code != 0 && told.contains("no picks"), "{told}");
    let ([_, told], code) = piped(&picks, &["--pattern", "-"]);
    assert!(
        code == 2 && told.contains("--pattern: stdin is used for the picks"),
        "{told}"
    );
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
