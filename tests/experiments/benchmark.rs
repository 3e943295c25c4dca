//! The committed benchmark: its files are those that its script writes, and what is known of it holds.

use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

const PICKLINE: &str = env!("CARGO_BIN_EXE_pickline");

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../patterns/benchmark")
}

fn names(folder: &Path) -> BTreeSet<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let name = |entry: std::fs::DirEntry| entry.file_name().into_string().unwrap();
    entries.map(|entry| name(entry.unwrap())).collect()
}

#[test]
fn the_committed_instances_are_what_the_script_writes() {
    let made = tempfile::tempdir().unwrap();
    let script = folder().join("make.py");
    let mut python = Command::new("python3");
    let status = python.arg(script).arg(PICKLINE).arg(made.path()).status();
    assert!(status.unwrap().success());
    for part in ["stations", "patterns"] {
        let (committed, made) = (folder().join(part), made.path().join(part));
        assert_eq!(names(&committed), names(&made));
        assert_eq!(names(&made).len(), 100);
        for name in names(&made) {
            let read = |folder: &Path| std::fs::read_to_string(folder.join(&name)).unwrap();
            assert!(read(&committed) == read(&made), "{part}/{name} is another");
        }
    }
    let listed = |list: &Path| {
        let text = std::fs::read_to_string(list.join("instances.csv")).unwrap();
        let name = |line: &str| line.split(',').next().unwrap().to_owned();
        text.lines().map(name).collect::<Vec<String>>()
    };
    assert_eq!(listed(&folder()), listed(made.path()));
}

/// The checker confirms every best known solution, and none is above what is certified.
#[test]
fn the_best_known_solutions_are_what_the_list_says() {
    let call = ["benchmark", "--quiet", "--format", "json", "--dir"];
    let output = Command::new(PICKLINE).args(call).arg(folder()).output();
    let report: Value = serde_json::from_slice(&output.unwrap().stdout).unwrap();
    let runs = report["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 100);
    for run in runs {
        let number = |field: &str| {
            run[field]
                .as_f64()
                .unwrap_or_else(|| panic!("{field}: {run}"))
        };
        assert!(run["failure"].is_null(), "{run}");
        assert_eq!(number("picked"), number("best_known"), "{run}");
        assert!(number("picked") <= number("picks_upper_bound"), "{run}");
        let most = number("picking_rate_upper_bound_per_min");
        assert!(number("picking_rate_per_min") <= most, "{run}");
    }
    assert_eq!(names(&folder().join("best")).len(), 100);
    // The rates of the list are those of the solutions.
    let list = std::fs::read(folder().join("instances.csv")).unwrap();
    let mut list = csv::Reader::from_reader(list.as_slice());
    for (row, run) in list.records().zip(runs) {
        let row = row.unwrap();
        assert_eq!(&row[0], run["instance"].as_str().unwrap());
        let (listed, found) = (row[4].parse::<f64>().unwrap(), &run["picking_rate_per_min"]);
        assert!(
            (listed / found.as_f64().unwrap() - 1.0).abs() < 1e-9,
            "{run}"
        );
        assert!(!row[7].is_empty(), "{run}");
    }
}
