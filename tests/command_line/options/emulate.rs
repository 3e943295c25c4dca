//! What `emulate` has of its own: an emulated station that is answered by hand.

use super::rig::{Rig, assert_near, number};
use super::{Row, hold, row};
use serde_json::{Value, json};

const EMULATE: [&str; 1] = ["emulate"];
const PLAIN: &str = "emulate -q --clock messages --station one.toml --pattern p.csv";

pub const ROWS: &[Row] = &[
    row(&EMULATE, "--station", |rig, _| {
        assert_eq!(of(&said(rig, PLAIN, ""), "robot")[0]["name"], "a");
    }),
    row(&EMULATE, "--robots", |rig, _| {
        let found = said(rig, "emulate -q --clock messages --robots 3", "");
        let names: Vec<_> = of(&found, "robot")
            .iter()
            .map(|robot| robot["name"].clone())
            .collect();
        assert_eq!(names, ["r1", "r2", "r3"]);
    }),
    row(&EMULATE, "--belt-speed", |rig, _| {
        let found = said(rig, &format!("{PLAIN} --belt-speed 0.2"), "");
        assert_eq!(number(&of(&found, "belt")[0], "/speed"), 0.2);
        assert_near(number(&of(&found, "belt")[1], "/position"), 0.2);
    }),
    row(&EMULATE, "--pattern", |rig, _| {
        let ids = |flags: &str| {
            let call = PLAIN.replace("--pattern p.csv", flags);
            let found = of(&said(rig, &call, ""), "detection");
            found
                .iter()
                .map(|item| item["id"].as_str().unwrap().to_owned())
                .collect::<Vec<_>>()
        };
        assert_eq!(ids("--pattern ab.csv"), ["A", "B"]);
        assert_eq!(ids("").len(), 50);
    }),
    row(&EMULATE, "--true-station", |rig, _| {
        // It is twice as fast and leaves when it is told to: it waits for the item to come into its
        // reach at 5 s, and is back after half a second, with half a second of dwell.
        let done = |flags: &str| done(rig, flags);
        assert_near(done(""), 6.5);
        assert_near(done("--true-station fast.toml"), 6.0);
    }),
    row(&EMULATE, "--time-noise", |rig, _| {
        let done = |flags: &str| done(rig, flags);
        assert_near(done("--time-noise 0"), 6.5);
        let (one, two) = (done("--time-noise 0.01"), done("--time-noise 0.02"));
        assert!(one != 6.5 && (one - 6.5).abs() < 0.08, "{one}");
        assert!(two != one && (two - 6.5).abs() < 0.16, "{two}");
    }),
    row(&EMULATE, "--clock", |rig, _| {
        // Stamps are of now, or begin at 0.
        let first = |clock: &str| {
            let station = rig.program(&PLAIN.replace("--clock messages", clock));
            station.said.wait_for("\"robot\"");
            let first: Value = serde_json::from_str(&station.said.all()[0]).unwrap();
            number(&first, "/stamp")
        };
        assert_eq!(first("--clock messages"), 0.0);
        assert!(first("") > 1e9 && first("--clock system") > 1e9);
    }),
    row(&EMULATE, "--failing-grasps", |rig, _| {
        let result = |flags: &str| {
            let found = said(rig, &format!("{PLAIN} {flags}"), &answers());
            let results = of(&found, "result");
            assert_eq!(results.len(), 1, "{found:?}");
            results[0]["result"].clone()
        };
        assert_eq!(result(""), "PICKED");
        assert_eq!(result("--failing-grasps 1"), "GRASP_FAIL");
    }),
    row(&EMULATE, "--lost-acks", |rig, _| {
        let acks =
            |flags: &str| of(&said(rig, &format!("{PLAIN} {flags}"), &answers()), "ack").len();
        assert_eq!((acks(""), acks("--lost-acks 1")), (1, 0));
    }),
    row(&EMULATE, "--duplicates", |rig, _| {
        let seen = |flags: &str| of(&said(rig, &format!("{PLAIN} {flags}"), ""), "detection").len();
        assert_eq!((seen(""), seen("--duplicates 1")), (1, 2));
    }),
    row(&EMULATE, "--out-of-order", |rig, _| {
        // Up to a second late: behind the tick that is at the item's own stamp.
        let early = |flags: &str| {
            let found = said(rig, &format!("{PLAIN} {flags}"), "");
            let place = |kind: &str| found.iter().position(|message| message["kind"] == kind);
            place("detection") < place("tick")
        };
        assert!(early("") && !early("--out-of-order 1"));
    }),
    row(&EMULATE, "--jitter-ms", |rig, _| {
        let ticks = |flags: &str| late(rig, flags);
        assert_eq!(ticks("")[..3], [0.0, 1.0, 2.0]);
        let late = ticks("--jitter-ms 500");
        let between = late.iter().filter(|stamp| stamp.fract() != 0.0);
        assert!(between.clone().count() > 3, "{late:?}");
        assert!(
            between.clone().all(|stamp| stamp.fract() <= 0.5),
            "{late:?}"
        );
    }),
    row(&EMULATE, "--seed", |rig, _| {
        let late = |flags: &str| late(rig, &format!("--jitter-ms 500 {flags}"));
        assert_eq!(late(""), late("--seed 1"));
        assert_ne!(late(""), late("--seed 2"));
    }),
    row(&EMULATE, "--robot-down", |rig, _| {
        let states = |flags: &str| {
            let found = said(rig, &format!("{PLAIN} {flags}"), "");
            let robots = of(&found, "robot");
            let state = |robot: &Value| {
                (
                    number(robot, "/stamp"),
                    robot["state"].as_str().unwrap().to_owned(),
                )
            };
            robots.iter().map(state).collect::<Vec<_>>()
        };
        let idle = |stamp: f64| (stamp, "idle".to_owned());
        assert_eq!(states(""), [idle(0.0)]);
        let down = states("--robot-down 1,2,3");
        assert_eq!(down, [idle(0.0), (2.0, "fault".to_owned()), idle(5.0)]);
    }),
    row(&EMULATE, "--belt-stop", |rig, _| {
        let position = |flags: &str| {
            let found = of(&said(rig, &format!("{PLAIN} {flags}"), ""), "belt");
            let at = found.iter().find(|belt| number(belt, "/stamp") == 6.0);
            number(at.unwrap(), "/position")
        };
        assert_near(position(""), 0.6);
        assert_near(position("--belt-stop 1,3"), 0.3);
    }),
];

#[test]
fn options_of_an_emulated_station_have_their_effect() {
    hold(ROWS);
}

/// The station's messages, answered by `answers`.
fn said(rig: &Rig, call: &str, answers: &str) -> Vec<Value> {
    let called = rig.feed(call, answers);
    assert_eq!(called.code, Some(0), "{call}: {}", called.stderr);
    let lines = called.stdout.lines();
    lines
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn of(messages: &[Value], kind: &str) -> Vec<Value> {
    let found = messages.iter().filter(|message| message["kind"] == kind);
    found.cloned().collect()
}

/// When the item is in the bin [s].
fn done(rig: &Rig, flags: &str) -> f64 {
    let found = said(rig, &format!("{PLAIN} {flags}"), &answers());
    let results = of(&found, "result");
    assert_eq!(results[0]["result"], "PICKED", "{found:?}");
    number(&results[0], "/stamp")
}

/// The stamps of the ticks.
fn late(rig: &Rig, flags: &str) -> Vec<f64> {
    let found = said(rig, &format!("{PLAIN} {flags}"), "");
    of(&found, "tick")
        .iter()
        .map(|tick| number(tick, "/stamp"))
        .collect()
}

/// A node that gives its robot the item at 4 s.
fn answers() -> String {
    let task = json!({
        "v": 1, "kind": "task", "id": 1, "revision": 0, "robot": "a", "item": "A",
        "decided_at": 4.0, "start": 4.0, "earliest_start": 4.0, "latest_start": 14.0,
        "meet_at": 5.0, "meet": {"x": 0.5, "y": 0.0}, "bin": {"x": 1.0, "y": 0.0},
        "free_at": 6.5, "priority": 0.5, "strategy": "rules:FIFO",
    });
    let due = |stamp: u32| {
        let next = stamp + 1;
        format!("{{\"v\":1,\"kind\":\"due\",\"stamp\":{stamp}.0,\"next\":{next}.0}}\n")
    };
    let early: String = (0..4).map(due).collect();
    let late: String = (4..11).map(due).collect();
    format!("{early}{task}\n{late}")
}
