//! The examples of the library print what the same call of the program finds.

use crate::common::text;
use serde_json::Value;
use std::error::Error;

#[path = "../../examples/compare.rs"]
#[allow(dead_code)]
mod compare_example;
#[path = "../../examples/optimize.rs"]
#[allow(dead_code)]
mod optimize_example;
#[path = "../../examples/sweep.rs"]
#[allow(dead_code)]
mod sweep_example;

/// Lines of an example, which are few enough to read.
fn printed(name: &str, run: impl Fn(&mut Vec<u8>) -> Result<(), Box<dyn Error>>) -> Vec<String> {
    let path = format!("{}/../../examples/{name}.rs", env!("CARGO_MANIFEST_DIR"));
    let source = std::fs::read_to_string(path).unwrap();
    assert!(source.lines().count() < 40, "{name}");
    let mut out = Vec::new();
    run(&mut out).unwrap();
    let text = String::from_utf8(out).unwrap();
    text.lines().map(str::to_owned).collect()
}

/// What the program reports for these arguments.
fn report(arguments: &str) -> Value {
    let arguments = format!("{arguments} --format json -q");
    let words: Vec<&str> = arguments.split(' ').collect();
    serde_json::from_str(&text(&words)).unwrap()
}

fn array<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value[name].as_array().unwrap()
}

#[test]
fn optimize_prints_the_ranking_and_the_validation() {
    let lines = printed("optimize", optimize_example::run);
    let report = report("optimize --robots 2 --patterns poisson:0.15:6 --validate 10");
    let mut expected: Vec<String> = array(&report, "ranking")[..3]
        .iter()
        .map(|ranked| {
            let rules: Vec<&str> = array(ranked, "assignment")
                .iter()
                .map(|rule| rule.as_str().unwrap())
                .collect();
            let rules = format!("[{}]", rules.join("; "));
            format!(
                "{rules:<12} {:.2} picks/min",
                ranked["mean"].as_f64().unwrap()
            )
        })
        .collect();
    let validation = &report["validation"];
    expected.push(format!(
        "the best again: {:.2} picks/min on {}",
        validation["mean"].as_f64().unwrap(),
        validation["patterns"].as_str().unwrap()
    ));
    assert_eq!(lines, expected);
}

#[test]
fn compare_prints_every_method_on_every_case() {
    let lines = printed("compare", compare_example::run);
    let report =
        report("compare --robots 2 --replicates 2 --no-bound --strategy lookahead:depth=2");
    let mut expected = Vec::new();
    for case in array(&report, "cases") {
        expected.push(case["name"].as_str().unwrap().to_owned());
        let methods = array(case, "results").iter();
        for (result, method) in methods.zip(array(&report, "methods")) {
            let title = method["title"].as_str().unwrap();
            let rate = result["picking_rate_per_min"].as_f64().unwrap();
            expected.push(format!("  {title:<24} {rate:.2} picks/min"));
        }
    }
    let count = expected.len();
    assert_eq!(lines[..count], expected);
    // The program adds notes on its tables, and spells options as flags.
    let notes: Vec<&str> = array(&report, "notes")
        .iter()
        .map(|note| note.as_str().unwrap())
        .collect();
    for line in &lines[count..] {
        let note = line.strip_prefix("note: ").unwrap();
        assert!(notes.contains(&note), "{note} is not in {notes:#?}");
    }
    assert!(lines.len() > count);
}

#[test]
fn sweep_prints_what_every_number_of_robots_picks() {
    let lines = printed("sweep", sweep_example::run);
    let report =
        report("sweep --sweep robots --robots 2 --to 3 --no-bound --patterns poisson:0.15:2");
    let points = array(&report, "points").iter();
    let points = points.filter(|point| point["method"] == "robust_gt");
    let mut expected: Vec<String> = points
        .map(|point| {
            format!(
                "{} robots: {:.1} % picked by {}",
                point["value"].as_f64().unwrap(),
                100.0 * point["picked_share"].as_f64().unwrap(),
                point["title"].as_str().unwrap()
            )
        })
        .collect();
    assert_eq!(lines[..expected.len()], expected);
    let robots = &array(&report, "limits")[0]["recommended"];
    expected.push(format!("{} robots are enough", robots.as_f64().unwrap()));
    assert_eq!(lines, expected);
}
