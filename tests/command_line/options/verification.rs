//! What `check` judges by, on the one pick of the line of which everything is known.

use super::rig::{Rig, number};
use super::station::strict;
use super::{Row, hold, row};
use serde_json::Value;

const CHECK: [&str; 1] = ["check"];

pub const ROWS: &[Row] = &[
    row(&CHECK, "<picks>", |rig, verb| {
        assert_eq!(kinds(rig, &format!("{verb} right.csv")), "");
        assert_eq!(kinds(rig, &format!("{verb} late.csv")), "return_time");
    }),
    row(&CHECK, "--station", |rig, verb| {
        let call = format!("{verb} right.csv --pattern p.csv --format json --station");
        assert_eq!(reported(rig, &format!("{call} one.toml")), "");
        // Twice as fast: neither the way out nor that back takes a second.
        assert_eq!(
            reported(rig, &format!("{call} fast.toml")),
            "return_time, travel_time"
        );
    }),
    row(&CHECK, "--robots", |rig, verb| {
        // The third robot of the paper's line does not reach the item of the first.
        rig.write("third.csv", &PICKS.replace("a,A", "r3,A"));
        let call = format!("{verb} third.csv --pattern p.csv --format json --station paper");
        assert_eq!(reported(rig, &format!("{call} --robots 2")), "unknown");
        assert!(reported(rig, &format!("{call} --robots 3")).contains("reach"));
    }),
    row(&CHECK, "--belt-speed", |rig, verb| {
        let found = kinds(rig, &format!("{verb} right.csv --belt-speed 0.2"));
        assert!(found.contains("travel_time"), "{found}");
    }),
    row(&CHECK, "--strict", |rig, verb| {
        rig.write("right.csv", PICKS);
        let call = format!("{verb} right.csv -q --pattern p.csv --station odd.toml");
        strict(rig, &call, "--strict", "odd.toml: belt.length");
    }),
    row(&CHECK, "--pattern", |rig, verb| {
        rig.write("moved.csv", "id,x,y\nA,-0.1,0\n");
        let found = |pattern: &str| {
            rig.write("right.csv", PICKS);
            let call = format!("{verb} right.csv --station one.toml --format json");
            reported(rig, &format!("{call} --pattern {pattern}"))
        };
        assert_eq!(found("p.csv"), "");
        // It is met 0.6 m away.
        assert_eq!(found("moved.csv"), "reach, return_time, travel_time");
    }),
    row(&CHECK, "--tolerance", |rig, verb| {
        assert_eq!(
            kinds(rig, &format!("{verb} late.csv --tolerance 0.01")),
            "return_time"
        );
        assert_eq!(kinds(rig, &format!("{verb} late.csv --tolerance 0.05")), "");
        let report = report(rig, &format!("{verb} late.csv --tolerance 0.01"));
        assert_eq!(number(&report, "/tolerance_s"), 0.01);
    }),
    row(&CHECK, "--camera-x", |rig, verb| {
        // The item passes x = 0.4 when the robot leaves.
        assert_eq!(kinds(rig, &format!("{verb} right.csv --camera-x 0.4")), "");
        assert_eq!(
            kinds(rig, &format!("{verb} right.csv --camera-x 0.41")),
            "unseen"
        );
    }),
    row(&CHECK, "--update-hz", |rig, verb| {
        assert_eq!(kinds(rig, &format!("{verb} right.csv --update-hz 0.5")), "");
        assert_eq!(
            kinds(rig, &format!("{verb} right.csv --update-hz 0.3")),
            "off_beat"
        );
    }),
    row(&CHECK, "--format", |rig, verb| {
        rig.write("late.csv", LATE);
        let call = format!("{verb} late.csv -q --station one.toml --pattern p.csv");
        let text = |format: &str| rig.call(&format!("{call} {format}")).stdout;
        let json: Value = serde_json::from_str(&text("--format json")).unwrap();
        assert_eq!(number(&json, "/violations/0/line"), 2.0);
        let rows = crate::common::csv_rows(&text("--format csv"));
        assert_eq!((rows[0][0].as_str(), rows[1][0].as_str()), ("line", "2"));
        assert!(text("--format table").starts_with("| line "));
        assert_eq!(text(""), text("--format table"));
    }),
    row(&CHECK, "--quiet", |rig, verb| {
        rig.write("run.csv", &rig.text("simulate -q --no-bound --format csv"));
        let told = |flags: &str| rig.done(&format!("{verb} run.csv {flags}")).stderr;
        assert!(told("").contains("checking run.csv against the built-in grid"));
        assert_eq!(
            (told("-q"), told("--quiet")),
            (String::new(), String::new())
        );
    }),
];

const PICKS: &str = "robot,item,decide_s,grasp_s,release_s\na,A,4,5,6.5\n";
const LATE: &str = "robot,item,decide_s,grasp_s,release_s\na,A,4,5,6.6\n";

#[test]
fn what_picks_are_judged_by_has_its_effect() {
    hold(ROWS);
}

/// What `call` reports on the one pick, as it is or with another end.
fn report(rig: &Rig, call: &str) -> Value {
    rig.write("right.csv", PICKS);
    rig.write("late.csv", LATE);
    let call = format!("{call} -q --station one.toml --pattern p.csv --format json");
    serde_json::from_str(&rig.call(&call).stdout).unwrap()
}

/// The kinds of violations that `call` reports on the one pick.
fn kinds(rig: &Rig, call: &str) -> String {
    kinds_in(&report(rig, call))
}

/// The kinds of violations that `call` reports.
fn reported(rig: &Rig, call: &str) -> String {
    rig.write("right.csv", PICKS);
    kinds_in(&serde_json::from_str(&rig.call(call).stdout).unwrap())
}

fn kinds_in(report: &Value) -> String {
    let kinds = report["violations_by_kind"].as_object().unwrap();
    kinds.keys().cloned().collect::<Vec<_>>().join(", ")
}
