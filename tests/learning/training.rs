//! What robust GT is found on, and what is said where a policy was trained on other lines.

use crate::common::{pickline, text};
use serde_json::Value;

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&text(&[arguments, &["-q", "--format", "json"]].concat())).unwrap()
}

fn notes(report: &Value) -> String {
    report["notes"].to_string()
}

const SMALL: [&str; 6] = [
    "compare",
    "--no-greedy",
    "--no-policy",
    "--no-bound",
    "--replicates",
    "2",
];

#[test]
fn robust_gt_is_found_on_the_kind_that_is_judged_and_noted() {
    let kind = json(&SMALL);
    assert!(
        notes(&kind).contains("like those of the cases"),
        "{}",
        notes(&kind)
    );
    let paper = json(&[&SMALL[..], &["--paper", "--train-items", "20"]].concat());
    assert!(
        notes(&paper).contains("as in the paper"),
        "{}",
        notes(&paper)
    );
    let named = ["--train-patterns", "poisson:0.2:5", "--train-items", "20"];
    let named = json(&[&SMALL[..], &named].concat());
    assert!(notes(&named).contains("5 Poisson disk patterns of 0.2 m, 20 items"));
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let pattern = file("p.csv");
    text(&["pattern", "generate", "poisson", "-o", &pattern]);
    let cases = file("cases.toml");
    std::fs::write(&cases, "[[case]]\nname = \"mine\"\npattern = \"p.csv\"\n").unwrap();
    let sweep = [
        "sweep",
        "--no-bound",
        "--from",
        "0.05",
        "--to",
        "0.05",
        "--patterns",
        &pattern,
    ];
    for own in [
        json(&[&SMALL[..], &["--cases", &cases]].concat()),
        json(&sweep),
    ] {
        assert!(notes(&own).contains("the very patterns"), "{}", notes(&own));
    }
    for (flags, words) in [
        (
            &["--train-patterns", "gird:0.1"][..],
            &["--train-patterns", "did you mean `grid`"][..],
        ),
        (
            &["--train-patterns", "grid:0.1", "--robust", "SPT,SPT"],
            &["--robust"],
        ),
    ] {
        let output = pickline(&[&SMALL[..], flags].concat());
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(words.iter().all(|word| told.contains(word)), "{told}");
    }
}

/// With each line's own best assignment no line picks less than with SPT for all robots.
#[test]
fn a_sweep_over_robots_has_for_each_line_an_assignment_as_good_as_one_rule_for_all() {
    for robots in ["3", "5"] {
        let spt = vec!["SPT"; robots.parse().unwrap()].join(",");
        let dense = [
            "--patterns",
            "poisson:0.1:6",
            "--items",
            "150",
            "--belt-speed",
            "0.12",
        ];
        let sweep = [
            "sweep",
            "--sweep",
            "robots",
            "--from",
            robots,
            "--to",
            robots,
            "--no-bound",
        ];
        let report = json(&[&sweep[..], &dense, &["--strategy", &spt]].concat());
        let share = |place: usize| report["points"][place]["picked_share"].as_f64().unwrap();
        assert!(
            share(0) > share(1) - 0.01,
            "{robots}: {} {}",
            share(0),
            share(1)
        );
        assert!(notes(&report).contains("found for every line"));
    }
}

#[cfg(feature = "onnx")]
/// The patterns of such a sweep are as long as the steady state takes, and so are those that
/// robust GT is found on.
#[test]
fn a_sweep_of_reach_has_an_assignment_as_good_as_one_rule_for_all() {
    let report = json(&[
        "sweep",
        "--sweep",
        "reach",
        "--from",
        "0.6",
        "--to",
        "0.6",
        "--step",
        "0.1",
        "--strategy",
        "SPT,SPT",
        "--strategy",
        "FIFO,FIFO",
        "--no-bound",
    ]);
    let picked = |place: usize| report["points"][place]["picked_share"].as_f64().unwrap();
    assert!(picked(0) > 0.98 * picked(1).max(picked(2)), "{report}");
    assert!(
        notes(&report).contains("mean picked share"),
        "{}",
        notes(&report)
    );
}

#[test]
fn a_policy_is_left_out_on_lines_far_from_its_training() {
    let compare = [
        "compare",
        "--robust",
        "SPT,FIFO",
        "--no-greedy",
        "--no-bound",
        "--replicates",
        "1",
    ];
    let ids = |report: &Value| -> Vec<String> {
        let methods = report["methods"].as_array().unwrap().iter();
        methods
            .map(|m| m["id"].as_str().unwrap().to_owned())
            .collect()
    };
    let near = json(&compare);
    assert_eq!(ids(&near), ["robust_gt", "onnx"]);
    assert!(!notes(&near).contains("its training"));
    let folder = tempfile::tempdir().unwrap();
    let station = folder.path().join("delta.toml");
    let station = station.to_str().unwrap();
    let shown = text(&["station", "show"]);
    let delta = shown.replace("speed = 0.5\n", "speed = 3.0\n");
    assert_ne!(delta, shown);
    std::fs::write(station, delta).unwrap();
    let far = json(&[&compare[..], &["--station", station]].concat());
    assert_eq!(ids(&far), ["robust_gt"]);
    let words = [
        "left out",
        "arm speed 3 m/s (trained on 0.5 m/s)",
        "--strategy onnx",
    ];
    assert!(
        words.iter().all(|word| notes(&far).contains(word)),
        "{}",
        notes(&far)
    );
    let asked = json(&[&compare[..], &["--station", station, "--strategy", "onnx"]].concat());
    assert_eq!(ids(&asked), ["robust_gt", "onnx"]);
    assert!(notes(&asked).contains("far from its training"));
    // Five robots are a quarter more than four, which is said and no more.
    let five = ["--robots", "5", "--robust", "SPT,SPT,SPT,SPT,FIFO"];
    let five = json(
        &[
            &["compare", "--no-greedy", "--no-bound", "--replicates", "1"][..],
            &five,
        ]
        .concat(),
    );
    assert_eq!(ids(&five), ["robust_gt", "onnx"]);
    assert!(notes(&five).contains("robots 5 (trained on 2 to 4)"));
    let output = pickline(&["simulate", "--strategy", "onnx", "--station", station]);
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.success() && told.contains("far from its training"),
        "{told}"
    );
}

#[test]
fn a_training_set_without_a_flow_is_named_itself() {
    let flags = [
        "sweep",
        "--patterns",
        "random:3",
        "--flow",
        "60",
        "--train-patterns",
        "random:5",
    ];
    let output = pickline(&flags);
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(
        told.contains("--train-patterns random:5: the feed random needs its own flow"),
        "{told}"
    );
    assert!(told.contains("random:60/min:5"), "{told}");
}

#[cfg(feature = "onnx")]
#[test]
fn optimize_says_how_far_a_policy_is_from_its_training() {
    let far = [
        "optimize",
        "--belt-speed",
        "0.4",
        "--strategy",
        "onnx",
        "--no-bound",
    ];
    let small = [
        "--patterns",
        "balanced:2",
        "--items",
        "8",
        "--validate",
        "2",
    ];
    let report = json(&[&far[..], &small].concat());
    assert!(
        notes(&report).contains("onnx: this line is far from its training"),
        "{report}"
    );
}
