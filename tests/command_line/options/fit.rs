//! What `station fit` has of its own, on moves that follow a law exactly.

use super::rig::{Rig, number};
use super::station::strict;
use super::{Row, hold, row};
use serde_json::Value;

const FIT: [&str; 1] = ["station fit"];

pub const ROWS: &[Row] = &[
    row(&FIT, "<moves>", |rig, verb| {
        rig.write("m.csv", &moves(0.5));
        rig.write("other.csv", &moves(0.8));
        let speed = |file: &str| parameter(&rig.json(&call(verb, file)), "speed");
        assert!((speed("m.csv") - 0.5).abs() < 1e-4, "{}", speed("m.csv"));
        assert!((speed("other.csv") - 0.8).abs() < 1e-4);
    }),
    row(&FIT, "--station", |rig, verb| {
        // The robots of the usual station have other names.
        rig.write("m.csv", &moves(0.5));
        rig.done(&call(verb, "m.csv"));
        rig.refused(
            &format!("{verb} m.csv"),
            &[
                "warning: --station: not given: m.csv is taken for moves of the built-in station paper",
                "m.csv:2: robot",
                "`a`",
                "known: r1, r2",
            ],
        );
        // By number they are taken for those of the usual station, but its bins are elsewhere.
        rig.write("numbers.csv", &moves(0.5).replace("a,", "1,"));
        rig.refused(
            &format!("{verb} numbers.csv"),
            &["robot `r1`: line 2: releases at (1, 0)", "--station"],
        );
        let own = rig.done(&call(verb, "numbers.csv"));
        assert_eq!(own.stderr, "");
    }),
    row(&FIT, "--law", |rig, verb| {
        let law = |flags: &str| {
            let report = fitted(rig, verb, flags);
            report["robots"][0]["law"].as_str().unwrap().to_owned()
        };
        assert_eq!(
            (law(""), law("--law auto")),
            ("speed".into(), "speed".into())
        );
        assert_eq!(law("--law table"), "table");
        assert_eq!(law("--law trapezoid"), "trapezoid");
    }),
    row(&FIT, "--lift", |rig, verb| {
        let lift = |flags: &str| parameter(&fitted(rig, verb, flags), "lift");
        assert!(lift("") < 1e-4);
        assert_eq!(lift("--lift 0.01"), 0.01);
    }),
    row(&FIT, "--resamples", |rig, verb| {
        let interval = |flags: &str| {
            let report = fitted(rig, verb, flags);
            report["robots"][0]["parameters"][0]["interval"].clone()
        };
        assert!(interval("").is_object() && interval("--resamples 100").is_object());
        assert!(interval("--resamples 0").is_null());
    }),
    row(&FIT, "--seed", |rig, verb| {
        let report = |flags: &str| {
            rig.write("noisy.csv", &noisy());
            // A law's intervals may be those of its profile, which nothing is drawn for.
            rig.json(&format!("{} --law table {flags}", call(verb, "noisy.csv")))
        };
        let intervals = |report: &Value| report["robots"][0].clone();
        assert_eq!(intervals(&report("")), intervals(&report("--seed 1")));
        assert_ne!(intervals(&report("")), intervals(&report("--seed 7")));
        assert_eq!(number(&report("--seed 7"), "/made/seed"), 7.0);
    }),
    row(&FIT, "--threads", |rig, verb| {
        rig.write("noisy.csv", &noisy());
        let call = call(verb, "noisy.csv");
        let text = |flags: &str| rig.text(&format!("{call} {flags}"));
        assert_eq!(text("--threads 1"), text("--threads 3"));
        rig.refused(&format!("{call} --threads 0"), &["--threads: 0 "]);
    }),
    row(&FIT, "--format", |rig, verb| {
        rig.write("m.csv", &moves(0.5));
        let call = format!("{verb} m.csv --station one.toml");
        let text = |format: &str| rig.text(&format!("{call} {format}"));
        let json: Value = serde_json::from_str(&text("--format json")).unwrap();
        assert_eq!(number(&json, "/robots/0/moves"), 40.0);
        let rows = crate::common::csv_rows(&text("--format csv"));
        assert_eq!(
            (rows[0][2].as_str(), rows[1][2].as_str()),
            ("parameter", "speed")
        );
        let table = text("--format table");
        assert!(table.starts_with("| robot | law "));
        assert!(table.contains("| error, median [ms] | 95 % [ms] | outliers [%] |"));
        assert!(
            table.contains("note      a: all stamps are multiples of 2 ms"),
            "{table}"
        );
        assert_eq!(number(&json, "/robots/0/stamp_step_s"), 0.002);
        assert_eq!(number(&json, "/robots/0/outlier_share"), 0.0);
        let points = text("--format csv --law table");
        let first = points
            .lines()
            .find(|line| line.contains(",travel,"))
            .unwrap();
        assert!(first.contains(",s,0,0,,,\"extrapolated"), "{first}");
        assert_eq!(text(""), text("--format table"));
    }),
    row(&FIT, "--out", |rig, verb| {
        fitted(rig, verb, "--out as-built.toml");
        let file = rig.read("as-built.toml");
        assert!(file.starts_with("# pickline "), "{file}");
        let shown = rig.text("station show --station as-built.toml");
        assert!(
            shown.contains("grasp_time = 0.3") && shown.contains("reach = 0.5"),
            "{shown}"
        );
    }),
    row(&FIT, "--svg", |rig, verb| {
        fitted(rig, verb, "--svg r.svg");
        assert!(rig.read("r.svg").contains("Residuals of the fitted laws"));
    }),
    row(&FIT, "--chart", |rig, verb| {
        fitted(rig, verb, "--svg r.svg --chart times");
        assert!(rig.read("r.svg").contains("Recorded times"));
        rig.refused(
            &format!("{} --svg r.svg --chart time", call(verb, "m.csv")),
            &[
                "--chart: this report has no chart `time`",
                "did you mean `times`?",
            ],
        );
    }),
    row(&FIT, "--force", |rig, verb| {
        rig.write("mine.toml", "mine");
        rig.write("m.csv", &moves(0.5));
        let call = format!("{} --out mine.toml", call(verb, "m.csv"));
        rig.refused(&call, &["--out: mine.toml exists", "--force"]);
        assert_eq!(rig.read("mine.toml"), "mine");
        rig.done(&format!("{call} --force"));
        assert!(rig.read("mine.toml").contains("[belt]"));
    }),
    row(&FIT, "--strict", |rig, verb| {
        rig.write("m.csv", &moves(0.5));
        let call = format!("{verb} m.csv --station odd.toml");
        strict(rig, &call, "--strict", "odd.toml: belt.length");
    }),
];

#[test]
fn options_of_a_fit_have_their_effect() {
    hold(ROWS);
}

fn call(verb: &str, file: &str) -> String {
    format!("{verb} {file} --station one.toml --format json")
}

fn fitted(rig: &Rig, verb: &str, flags: &str) -> Value {
    rig.write("m.csv", &moves(0.5));
    rig.json(&format!("{} {flags}", call(verb, "m.csv")))
}

/// Forty moves of the robot over all ways up to its reach, at this speed [m/s].
fn moves(speed: f64) -> String {
    rows(speed, |_| 0.0)
}

/// The same, up to 1 ms too long or too short, and no multiple of any step.
fn noisy() -> String {
    rows(0.5, |i| 0.001 * f64::from(i * i).sin())
}

fn rows(speed: f64, off: impl Fn(u32) -> f64) -> String {
    let mut text =
        "robot,from_x,from_y,meet_x,meet_y,depart_s,grasp_s,bin_x,bin_y,release_s\n".to_owned();
    for i in 0..40 {
        let way = 0.05 + 0.011 * f64::from(i);
        let (depart, travel) = (10.0 * f64::from(i), way / speed + off(i));
        let grasp = depart + travel;
        let release = grasp + 0.3 + way / speed + off(i + 40) + 0.2;
        text += &format!("a,1,0,{},0,{depart},{grasp},1,0,{release}\n", 1.0 - way);
    }
    text
}

fn parameter(report: &Value, name: &str) -> f64 {
    let parameters = report["robots"][0]["parameters"].as_array().unwrap();
    let found = parameters
        .iter()
        .find(|parameter| parameter["name"] == name);
    found.unwrap()["value"].as_f64().unwrap()
}
