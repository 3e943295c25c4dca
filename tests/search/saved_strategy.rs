//! `optimize --save`, and what the other verbs make of the station file's strategy.

use crate::common::{pickline, text};
use serde_json::Value;
use std::path::Path;

const SMALL: [&str; 9] = [
    "optimize",
    "--patterns",
    "grid:0.2",
    "--items",
    "30",
    "--validate",
    "0",
    "--no-bound",
    "--save",
];

fn told(arguments: &[&str]) -> (Option<i32>, String) {
    let output = pickline(arguments);
    let told = String::from_utf8(output.stderr).unwrap();
    (output.status.code(), told)
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&text(&[arguments, &["-q", "--format", "json"]].concat())).unwrap()
}

fn init(file: &Path) -> String {
    text(&["station", "init", file.to_str().unwrap()]);
    std::fs::read_to_string(file).unwrap()
}

#[test]
fn the_winner_is_saved_and_used_and_nothing_else_of_the_file_changes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.toml");
    let before = init(&path);
    let file = path.to_str().unwrap();
    let station = ["--station", file];
    let (code, said) = told(&[&SMALL[..], &station].concat());
    assert_eq!(code, Some(0), "{said}");
    let best = json(&[&SMALL[..8], &station].concat());
    let best: Vec<&str> = best["best"]
        .as_array()
        .unwrap()
        .iter()
        .map(|r| r.as_str().unwrap())
        .collect();
    let strategy = format!("rules:{}", best.join(","));
    assert!(said.contains(&format!("saved {strategy}")), "{said}");
    let after = std::fs::read_to_string(&path).unwrap();
    let line = format!("strategy = \"{strategy}\"");
    let kept: Vec<&str> = after.lines().filter(|l| *l != line).collect();
    let old: Vec<&str> = before.lines().collect();
    assert!(
        old.iter().all(|l| kept.contains(l)) && after.contains(&line),
        "{after}"
    );
    // Each of them says so.
    let run = json(&[&["simulate"], &station[..]].concat());
    assert_eq!(run["strategy"], strategy);
    assert_eq!(
        run["made"]["station_hash"],
        json(&["simulate"])["made"]["station_hash"]
    );
    let (_, said) = told(&[&["simulate"], &station[..]].concat());
    assert!(
        said.contains(&strategy) && said.contains("strategy of the station file"),
        "{said}"
    );
    let given = json(&[&["simulate", "--strategy", "LD,LD"], &station[..]].concat());
    assert_eq!(given["strategy"], "rules:LD,LD");
    let output = pickline(&[&["run", "--clock", "messages"], &station[..]].concat());
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains(&format!("running {strategy}, the strategy")),
        "{said}"
    );
    let compare = [
        "compare",
        "--robust",
        "SPT,FIFO",
        "--replicates",
        "1",
        "--no-policy",
        "--no-bound",
    ];
    let report = json(&[&compare[..], &station].concat());
    assert_eq!(report["methods"][2]["id"], strategy);
    let sweep = [
        "sweep",
        "--robust",
        "SPT,FIFO",
        "--from",
        "0.05",
        "--to",
        "0.05",
        "--no-bound",
    ];
    let report = json(&[&sweep[..], &station].concat());
    assert!(report.to_string().contains("strategy of the station file"));
    assert!(text(&[&["station", "show"], &station[..]].concat()).starts_with(&line));
    // Given as well, it is compared once.
    let twice = [&compare[..], &station, &["--strategy", &strategy]].concat();
    let methods = json(&twice)["methods"].as_array().unwrap().clone();
    let ids: Vec<&Value> = methods.iter().map(|method| &method["id"]).collect();
    assert_eq!(ids, ["robust_gt", "greedy_gt", &strategy]);
    // Saved again, it is replaced by the winner under the other objective, which is another.
    let share = ["--objective", "picked-share"];
    let (code, said) = told(&[&SMALL[..], &station, &share].concat());
    assert_eq!(code, Some(0), "{said}");
    let other = json(&[&SMALL[..8], &station, &share].concat());
    let other = other["best"].as_array().unwrap().iter();
    let other: Vec<&str> = other.map(|rule| rule.as_str().unwrap()).collect();
    assert_ne!(other, best);
    let replaced = after.replace(&line, &format!("strategy = \"rules:{}\"", other.join(",")));
    assert_eq!(std::fs::read_to_string(&path).unwrap(), replaced);
}

#[test]
fn other_lines_are_saved_as_new_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (line, new, three) = (path("line.toml"), path("new.toml"), path("three.toml"));
    let (line, new, three) = (line.as_str(), new.as_str(), three.as_str());
    let nowhere = path("no/new.toml");
    init(Path::new(line));
    let before = std::fs::read(line).unwrap();
    let (code, said) = told(&[&SMALL[..], &[new]].concat());
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(
        json(&["simulate", "--station", new])["made"]["station_hash"],
        json(&["simulate"])["made"]["station_hash"]
    );
    let (code, said) = told(&[&SMALL[..], &[three, "--station", line, "--robots", "3"]].concat());
    assert_eq!(code, Some(0), "{said}");
    let run = json(&["simulate", "--station", three]);
    assert_eq!(run["robots"].as_array().unwrap().len(), 3);
    assert_eq!(run["strategy"].as_str().unwrap().split(',').count(), 3);
    for (flags, words) in [
        (&[][..], &["--save", "built-in", "--save my-line.toml"][..]),
        (&[new], &["--save", "exists"]),
        (
            &["--station", line, "--robots", "3"],
            &["--save", "--robots"],
        ),
        (
            &["--station", line, "--belt-speed", "0.06"],
            &["--save", "--belt-speed"],
        ),
        (&[&nowhere], &["cannot write"]),
    ] {
        let (code, said) = told(&[&SMALL[..], flags].concat());
        assert_eq!(code, Some(2), "{flags:?}: {said}");
        assert!(!said.contains("optimizing"), "{said}");
        for word in words {
            assert!(said.contains(word), "{flags:?}: {word} not in {said}");
        }
    }
    assert_eq!(std::fs::read(line).unwrap(), before);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
}

#[test]
fn a_strategy_that_does_not_fit_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.toml");
    let text = init(&path);
    let file = path.to_str().unwrap();
    for (value, words) in [
        ("\"rules:SPT\"", &["strategy", "1 rule for 2 robots"][..]),
        ("\"rules:SPT,FOFI\"", &["strategy", "did you mean `FIFO`"]),
        ("\"lokahead\"", &["strategy", "did you mean `lookahead`"]),
        ("7", &["strategy", "not a string"]),
    ] {
        std::fs::write(&path, format!("strategy = {value}\n{text}")).unwrap();
        for verb in [
            &["simulate", "--station"][..],
            &["station", "check"],
            &["emulate", "--station"],
        ] {
            let (code, said) = told(&[verb, &[file]].concat());
            assert_eq!(code, Some(2), "{value} {verb:?}: {said}");
            assert!(said.contains(&format!("{file}:1: strategy")), "{said}");
            for word in words {
                assert!(said.contains(word), "{word} not in {said}");
            }
        }
    }
    std::fs::write(&path, format!("strategy = \"rules:LD,LD\"\n{text}")).unwrap();
    let (code, said) = told(&["simulate", "--station", file, "--robots", "3"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("does not fit --robots 3") && said.contains("SPT,SPT,FIFO"),
        "{said}"
    );
}

#[cfg(unix)]
#[test]
fn a_read_only_station_file_is_refused_before_the_search() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.toml");
    let before = init(&path);
    let mut rights = std::fs::metadata(&path).unwrap().permissions();
    rights.set_readonly(true);
    std::fs::set_permissions(&path, rights).unwrap();
    let (code, said) = told(&[&SMALL[..], &["--station", path.to_str().unwrap()]].concat());
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("is read-only") && !said.contains("optimizing"),
        "{said}"
    );
    assert_eq!(std::fs::read_to_string(&path).unwrap(), before);
}

/// A station file and its policy can be moved together.
#[cfg(feature = "onnx")]
#[test]
fn a_policy_is_looked_for_beside_the_station_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("line.toml");
    let before = init(&path);
    std::fs::write(&path, format!("strategy = \"onnx:pol.onnx\"\n{before}")).unwrap();
    let file = path.to_str().unwrap();
    let (code, said) = told(&["simulate", "--station", file]);
    let policy = folder.path().join("pol.onnx");
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains(policy.to_str().unwrap()), "{said}");
    let ships = concat!(env!("CARGO_MANIFEST_DIR"), "/../../policies/pickline.onnx");
    std::fs::copy(ships, &policy).unwrap();
    let run = json(&["simulate", "--station", file]);
    assert!(
        run["strategy"].as_str().unwrap().ends_with("pol.onnx"),
        "{run}"
    );
}
