//! The station that a verb works on.

use super::rig::{RATE, Rig, assert_near, number};
use super::runs::{SIX, on, one, rate, rate_in};
use super::{Row, hold, row};
use serde_json::Value;

pub const ROWS: &[Row] = &[
    row(&SIX, "--station", |rig, verb| {
        let call = format!("{} -q --format json", on(verb, "fast.toml"));
        assert_near(rate(rig, verb, ""), RATE);
        assert_near(rate_in(verb, &rig.json(&call)), 60.0 / 6.0);
    }),
    row(&SIX, "--robots", robots),
    // Met at x = 0.5 after 1 s again, in which the item comes 0.2 m: it leaves at x = 0.3, at
    // 1.5 s.
    row(&SIX, "--belt-speed", |rig, verb| {
        assert_near(rate(rig, verb, "--belt-speed 0.2"), 60.0 / 4.0);
    }),
    row(&SIX, "--strict", |rig, verb| {
        strict(
            rig,
            &on(verb, "odd.toml"),
            "--strict",
            "odd.toml: belt.length",
        );
        rig.done(&format!("{} --strict", one(verb)));
    }),
    row(
        &["station show", "run", "emulate"],
        "--strict",
        |rig, verb| {
            let more = if verb == "station show" {
                ""
            } else {
                "--clock messages"
            };
            let call = format!("{verb} {more} --station odd.toml");
            strict(rig, &call, "--strict", "odd.toml: belt.length");
        },
    ),
    row(&["pattern generate"], "--strict", |rig, verb| {
        let call = format!("{verb} grid --count 1 --spacing 0.1 --width 90");
        strict(rig, &call, "--strict", "--width: 90 m");
    }),
    row(&["pattern describe"], "--strict", |rig, verb| {
        rig.write("far.csv", "id,x,y\nA,0,-350\n");
        strict(
            rig,
            &format!("{verb} far.csv"),
            "--strict",
            "far.csv: y: 350 m",
        );
    }),
    row(&["station check"], "--strict", |rig, verb| {
        strict(
            rig,
            &format!("{verb} odd.toml"),
            "--strict",
            "odd.toml: belt.length",
        );
    }),
    row(&["station show"], "--station", |rig, verb| {
        assert_eq!(
            rig.text(&format!("{verb} --station one.toml")),
            rig.read("one.toml")
        );
    }),
    row(&["station show"], "--robots", |rig, verb| {
        let shown = rig.text(&format!("{verb} --robots 3"));
        assert_eq!(shown.matches("[[robot]]").count(), 3, "{shown}");
    }),
    row(&["station show"], "--belt-speed", |rig, verb| {
        let shown = rig.text(&format!("{verb} --station one.toml --belt-speed 0.25"));
        assert_eq!(
            shown,
            rig.read("one.toml").replace("speed = 0.1", "speed = 0.25")
        );
    }),
    row(&["pattern generate"], "--station", |rig, verb| {
        // As wide as the belt.
        let rows = |station: &str| {
            let call = format!("{verb} grid --spacing 0.5 --count 9 -q --station {station}");
            let pattern = rig.text(&call);
            crate::common::csv_column(&pattern, "y")[..3].join(" ")
        };
        assert_eq!(rows("one.toml"), "-0.5 0 0.5");
        assert_eq!(rows("paper-narrow"), "0 0 0");
    }),
    row(&["pattern generate"], "--robots", |rig, verb| {
        // Robots do not change a pattern; one that cannot be given is refused.
        let call = format!("{verb} grid -q --count 2");
        assert_eq!(rig.text(&format!("{call} --robots 3")), rig.text(&call));
        let words = ["--robots: `one.toml` lists its robots one by one"];
        rig.refused(&format!("{call} --robots 3 --station one.toml"), &words);
    }),
    row(&["pattern generate"], "--belt-speed", |rig, verb| {
        // 3 items a minute are 20 s apart.
        let second = |flags: &str| {
            let call = format!("{verb} grid -q --flow 3 --count 2 --station one.toml {flags}");
            crate::common::csv_column(&rig.text(&call), "x")[1].clone()
        };
        assert_eq!(
            (second("").as_str(), second("--belt-speed 0.15").as_str()),
            ("-2", "-3")
        );
    }),
    row(&["pattern describe"], "--station", |rig, verb| {
        let report = rig.json(&format!("{verb} ab.csv --format json --station one.toml"));
        assert_near(number(&report, "/belt_speed"), 0.1);
    }),
    row(&["pattern describe"], "--belt-speed", |rig, verb| {
        // Two items, one a minute later.
        rig.write("two.csv", "id,x,y\nA,0,0\nB,-12,0\n");
        let report = |flags: &str| rig.json(&format!("{verb} two.csv --format json {flags}"));
        assert!(report("")["flow_per_min"].is_null());
        let slow = number(&report("--belt-speed 0.2"), "/flow_per_min");
        let fast = number(&report("--belt-speed 0.4"), "/flow_per_min");
        assert_near(fast, 2.0 * slow);
        // It is also that of a station.
        let both = report("--belt-speed 0.4 --station one.toml");
        assert_near(number(&both, "/flow_per_min"), fast);
    }),
];

#[test]
fn station_options_have_their_effect() {
    hold(ROWS);
}

/// Without `flag` a value that is not plausible is warned of, with it refused.
pub fn strict(rig: &Rig, call: &str, flag: &str, words: &str) {
    let doubtful = rig.done(call);
    let warning = format!("warning: {words}");
    assert!(doubtful.stderr.contains(&warning), "{}", doubtful.stderr);
    let refused = rig.call(&format!("{call} {flag}"));
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    let error = format!("pickline: {words}");
    assert!(refused.stderr.contains(&error), "{}", refused.stderr);
    assert_eq!(refused.stdout, "");
}

/// As many robots as asked for play.
fn robots(rig: &Rig, verb: &str) {
    let call =
        on(verb, "paper").replace("--sweep reach --from 0.5 --to 0.6", "--from 0.04 --to 0.14");
    let call = call.replace("FIFO", "FIFO,FIFO,FIFO");
    let call = format!("{call} -q --format json --robots 3");
    // The default pattern tells how far robots reach.
    if verb == "bound" {
        let reachable = |robots| {
            let call = format!("bound -q --format json --iterations 1 --robots {robots}");
            number(&rig.json(&call), "/reachable")
        };
        // Of 8 rows the first robot reaches 5: all but those from y = 0.175 on. The last
        // column has the two outermost of them.
        assert_eq!((reachable(1), reachable(2)), (6.0 * 5.0 + 2.0, 50.0));
        return;
    }
    let report = rig.json(&call);
    let robots = |pointer: &str| {
        report
            .pointer(pointer)
            .and_then(Value::as_array)
            .map(Vec::len)
    };
    let title = |pointer: &str| {
        report
            .pointer(pointer)
            .and_then(Value::as_str)
            .unwrap_or("")
    };
    match verb {
        "optimize" => assert_eq!(robots("/best"), Some(3)),
        "compare" => assert_eq!(title("/methods/0/title"), "robust GT [FIFO; FIFO; FIFO]"),
        "sweep" => assert_eq!(title("/points/0/title"), "robust GT [FIFO; FIFO; FIFO]"),
        _ => assert_eq!(robots("/robots"), Some(3)),
    }
}
