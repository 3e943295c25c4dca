//! How long a search may go on, and what it says when that was not enough.

use crate::common::{pickline, text};
use serde_json::Value;

fn json(arguments: &[&str]) -> Value {
    let small = [
        "optimize",
        "-q",
        "--format",
        "json",
        "--no-bound",
        "--validate",
        "20",
    ];
    serde_json::from_str(&text(&[&small[..], arguments].concat())).unwrap()
}

#[test]
fn runs_are_counted_so_the_result_does_not_depend_on_the_machine() {
    let set = ["--patterns", "balanced:10", "--items", "20"];
    for (flags, most) in [
        (
            &[
                "--robots",
                "3",
                "--max-runs",
                "3000",
                "--search",
                "exhaustive",
            ][..],
            3000,
        ),
        (
            &["--robots", "6", "--max-runs", "20000", "--search", "grasp"],
            20_000,
        ),
        (
            &[
                "--robots",
                "6",
                "--max-runs",
                "20000",
                "--search",
                "grasp",
                "--risk",
                "cvar:0.3",
            ],
            20_000,
        ),
    ] {
        let call = |threads: &str| json(&[&set[..], flags, &["--threads", threads]].concat());
        let report = call("1");
        assert_eq!(report, call("3"), "{flags:?}");
        assert_eq!(report["stop_reason"], "budget", "{flags:?}");
        assert_eq!(report["max_runs"], most);
        let runs = report["runs"].as_u64().unwrap();
        assert!(runs > most / 4 && runs <= most, "{flags:?}: {runs}");
        assert!(report["patterns"].as_u64().unwrap() <= 20);
    }
    let table = text(
        &[
            &[
                "optimize",
                "-q",
                "--no-bound",
                "--validate",
                "0",
                "--robots",
                "3",
            ],
            &set[..],
            &["--max-runs", "3000", "--search", "exhaustive"],
        ]
        .concat(),
    );
    assert!(table.contains("fitted to its budget of runs"), "{table}");
}

/// The one exception is the first score, without which there is no result.
#[test]
fn a_search_never_takes_more_runs_than_its_budget() {
    let set = ["--patterns", "balanced:30", "--items", "15"];
    for robots in ["4", "6"] {
        for most in ["1", "7", "500", "20000"] {
            let report = json(&[&set[..], &["--robots", robots, "--max-runs", most]].concat());
            let runs = report["runs"].as_u64().unwrap();
            let most: u64 = most.parse().unwrap();
            assert!(
                (1..=most).contains(&runs),
                "{robots} robots: {runs} of {most}"
            );
            assert_eq!(report["stop_reason"], "budget");
        }
    }
    let flags = [
        "optimize",
        "-q",
        "--max-runs",
        "1",
        "--robots",
        "4",
        "--validate",
        "0",
    ];
    let table = text(&[&flags[..], &set].concat());
    assert!(!table.contains("0 of 0 starts"), "{table}");
    let speed = [
        "--objective",
        "max-speed",
        "--robots",
        "3",
        "--max-runs",
        "6000",
    ];
    let report = json(&[&set[..], &speed].concat());
    assert!(report["runs"].as_u64().unwrap() <= 6000 || report["assignments"] == 1);
    let few = ["optimize", "--max-runs", "5", "--search", "exhaustive"];
    let told = String::from_utf8(pickline(&few).stderr).unwrap();
    assert!(
        told.contains("--max-runs") && told.contains("--search grasp"),
        "{told}"
    );
}

/// A run on a long pattern takes as much longer, so there are fewer.
#[test]
fn a_usual_search_takes_fewer_runs_on_longer_patterns() {
    let runs = |items: &str| {
        let set = ["--patterns", "random:2", "--flow", "60", "--items", items];
        json(&[&set[..], &["--starts", "1"]].concat())["max_runs"].clone()
    };
    assert_eq!(runs("50"), 18_000_000);
    assert_eq!(runs("1500"), 1_800_000);
}

#[test]
fn a_search_that_fits_is_the_one_without_a_budget() {
    let set = ["--patterns", "balanced:10", "--items", "30"];
    let whole = json(&[&set[..], &["--max-runs", "0"]].concat());
    let fits = json(&set);
    assert_eq!(whole["ranking"], fits["ranking"]);
    assert_eq!(whole["stop_reason"], "enumerated");
    assert!(whole["max_runs"].is_null() && fits["max_runs"] == 18_000_000);
}

#[test]
fn a_time_limit_ends_the_search_with_the_best_so_far() {
    let report = json(&[
        "--robots",
        "8",
        "--max-runs",
        "0",
        "--time-limit",
        "2",
        "--starts",
        "1000000",
        "--search",
        "grasp",
        "--patterns",
        "balanced:5",
        "--items",
        "20",
    ]);
    assert_eq!(report["stop_reason"], "time_limit");
    assert_eq!(report["best"].as_array().unwrap().len(), 8);
    assert!(report["validation"]["count"] == 20);
    assert!(
        report["notes"]
            .to_string()
            .contains("--time-limit was reached")
    );
    for (limit, words) in [
        ("0", "--time-limit"),
        ("-1", "--time-limit"),
        ("nan", "--time-limit"),
    ] {
        let output = pickline(&["optimize", "--time-limit", limit]);
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(told.contains(words), "{told}");
    }
}

/// GRASP beside an enumeration only where that adds less than a tenth.
#[test]
fn grasp_runs_beside_an_enumeration_where_it_costs_next_to_nothing() {
    let set = ["--patterns", "balanced:2", "--items", "10"];
    for (robots, beside) in [("1", true), ("2", false), ("3", false), ("4", true)] {
        let report = json(&[&set[..], &["--robots", robots]].concat());
        assert_eq!(report["search"], "exhaustive");
        assert_eq!(report["grasp"].is_object(), beside, "{robots}");
    }
}
