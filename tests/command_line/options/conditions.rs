//! What the camera sees and what goes wrong.

use super::experiments::trained;
use super::rig::{RATE, Rig, assert_near};
use super::runs::{RUNNING, SIX, one, rate, report};
use super::{Row, hold, row};

/// Verbs that say what went into the bins.
const BINS: [&str; 3] = ["simulate", "compare", "sweep"];

pub const ROWS: &[Row] = &[
    // Known when it is at x = 0.7, at 7 s and 0.3 m from the robot, which is there in 0.5 s.
    row(&SIX, "--camera-x", |rig, verb| {
        assert_near(rate(rig, verb, "--camera-x 0.7"), 60.0 / 8.5);
        trained_under(rig, verb, "--camera-x 1.4");
    }),
    row(&RUNNING, "--grasp-success", |rig, verb| {
        let quick = quick(verb);
        assert_near(rate(rig, verb, &format!("{quick} --grasp-success 0")), 0.0);
        assert_near(rate(rig, verb, &format!("{quick} --grasp-success")), RATE);
        // Of an item that says it itself its own figure counts.
        let slippery = one(verb).replace("p.csv", "slippery.csv");
        rig.write(
            "c.toml",
            &rig.read("c.toml").replace("p.csv", "slippery.csv"),
        );
        let rate = |flags: &str| {
            let report = rig.json(&format!("{slippery} -q --format json {quick} {flags}"));
            super::runs::rate_in(verb, &report)
        };
        assert_near(rate(""), RATE);
        assert_near(rate("--grasp-success"), 0.0);
        assert_near(rate("--grasp-success 1"), 0.0);
        trained_under(rig, verb, "--grasp-success 0");
    }),
    row(&RUNNING, "--position-noise", |rig, verb| {
        let off = |sd: &str| (rate(rig, verb, &format!("--position-noise {sd}")) - RATE).abs();
        // At the edge of the reach a millionth of a metre decides whether the item is met.
        let (little, more) = (off("0.000001"), off("0.01"));
        assert!(
            little > 1e-9 && more > 1e-9 && little != more,
            "{little} {more}"
        );
        assert_near(off("0"), 0.0);
    }),
    // At the threshold the item is picked, below it there is nothing to pick.
    row(&RUNNING, "--min-detection", |rig, verb| {
        rig.write("p.csv", "id,x,y,p_detection\nA,0,0,0.6\n");
        let rate = |least: &str| {
            let quick = quick(verb);
            rate(rig, verb, &format!("{quick} --min-detection {least}"))
        };
        assert_near(rate("0.6"), RATE);
        assert_near(rate("0.61"), 0.0);
        if ["compare", "sweep"].contains(&verb) {
            // On items that are all left, all rules are one, and the first of them is taken.
            let grid = "--p-detection const:0.5";
            assert_ne!(trained(rig, verb, grid), "robust GT [FIFO]");
            let left = format!("{grid} --min-detection 0.6");
            assert_eq!(trained(rig, verb, &left), "robust GT [FIFO]");
        }
    }),
    row(&["bound"], "--min-detection", |rig, verb| {
        rig.write("p.csv", "id,x,y,p_detection\nA,0,0,0.6\n");
        let most = |least: &str| report(rig, verb, least)["picks_upper_bound"].clone();
        assert_eq!(
            [most("--min-detection 0.6"), most("--min-detection 0.61")],
            [1, 0]
        );
    }),
    row(&BINS, "--misdetections", |rig, verb| {
        // One item is what it is taken for, the other is not.
        rig.write(
            "p.csv",
            "id,x,y,class,true_class\nA,0,0,pet,pet\nB,0,0.1,pet,-\n",
        );
        let place = match verb {
            "compare" => "/cases/0/results/0/sorting",
            "sweep" => "/points/0/sorting",
            _ => "/sorting",
        };
        let sorting = |flags: &str| report(rig, verb, flags).pointer(place).cloned();
        assert_eq!(sorting(""), None);
        let found = sorting("--misdetections").unwrap();
        let figures = ["binned", "rightly_binned", "due"].map(|name| found[name].as_f64());
        assert_eq!(figures, [Some(2.0), Some(1.0), Some(1.0)]);
        assert_eq!(
            (&found["purity"], &found["recovery"]),
            (&0.5.into(), &1.0.into())
        );
    }),
    // The bound holds for any luck; a schedule, that might fail, is none to hold against it.
    row(&["bound"], "--grasp-success", proven_for_any_luck),
    row(&["bound"], "--position-noise", proven_for_any_luck),
    row(&SIX, "--grasp-failures", |rig, verb| {
        let words = [
            "--grasp-failures: has been renamed to --grasp-success",
            "use --grasp-success 0.9",
        ];
        rig.refused(&format!("{} --grasp-failures 0.9", one(verb)), &words);
    }),
];

#[test]
fn conditions_have_their_effect() {
    hold(ROWS);
}

/// Robust GT is found under the conditions, too. Where nothing is held, or nothing known before
/// it leaves the reach, all rules pick alike, and the first of them is taken.
fn trained_under(rig: &Rig, verb: &str, flags: &str) {
    if ["compare", "sweep"].contains(&verb) {
        assert_ne!(trained(rig, verb, ""), "robust GT [FIFO]");
        assert_eq!(trained(rig, verb, flags), "robust GT [FIFO]");
    }
}

/// Speed limits are looked for in few steps where each is of many runs.
fn quick(verb: &str) -> &'static str {
    match verb {
        "optimize" => "--speed-step 0.1",
        _ => "",
    }
}

fn proven_for_any_luck(rig: &Rig, verb: &str) {
    assert!(report(rig, verb, "")["schedule"].is_object());
    for flags in ["--grasp-success 0.5", "--position-noise 0.01"] {
        let report = report(rig, verb, flags);
        assert!(report["schedule"].is_null(), "{flags}: {report}");
        let note = report["notes"][0].as_str().unwrap();
        assert!(
            note.starts_with("proven for every outcome of the random events"),
            "{note}"
        );
    }
}
