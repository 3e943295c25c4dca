//! Figures of the run and of every robot.

use super::bench::{BELT, Bench, Draft, back, front, idle};
use pickline::checker::check;
use pickline::decision::{MissReason, Outcome, RobotFigures};

type BentFigures = (&'static str, fn(&mut Outcome), &'static str);

#[test]
fn wrong_figures_are_refuted() {
    let bench = Bench::new();
    let outcome = bench.finish(bench.run());
    check(&bench.station, &bench.pattern, &outcome).unwrap();
    // What the run is like, reckoned by hand: weights 0.25, 0.5, 0.75, 1 and 1.25; the last
    // item leaves after 9 m of 0.3 m/s.
    let figures = &outcome.figures;
    assert_eq!(
        (figures.items, figures.picked, figures.weight),
        (7, 5, 3.75)
    );
    assert!((figures.end - 30.0).abs() < 1e-12);
    let did = |robot: usize| {
        let did: &RobotFigures = &outcome.robots[robot];
        (did.picked, did.failed, did.weight)
    };
    assert_eq!((did(0), did(1)), ((3, 1, 2.25), (2, 2, 1.5)));

    let bends: [BentFigures; 25] = [
        (
            "an item more",
            |o| o.figures.items += 1,
            "items is reported as 8, but is 7",
        ),
        (
            "an item less",
            |o| o.figures.items -= 1,
            "items is reported as 6, but is 7",
        ),
        (
            "a pick more",
            |o| o.figures.picked += 1,
            "picked is reported as 6, but is 5",
        ),
        (
            "a pick less",
            |o| o.figures.picked -= 1,
            "picked is reported as 4, but is 5",
        ),
        (
            "more weight",
            |o| o.figures.weight += 1e-6,
            "weight is reported as 3.750001, but is 3.75",
        ),
        (
            "less weight",
            |o| o.figures.weight -= 1e-6,
            "weight is reported as 3.749999, but is 3.75",
        ),
        (
            "no weight",
            |o| o.figures.weight = f64::NAN,
            "weight is reported as NaN, but is 3.75",
        ),
        (
            "a late end",
            |o| o.figures.end += 1e-6,
            "end is reported as 30.000001, but is 30",
        ),
        (
            "an early end",
            |o| o.figures.end -= 1e-6,
            "end is reported as 29.999999, but is 30",
        ),
        (
            "no end",
            |o| o.figures.end = f64::NAN,
            "end is reported as NaN, but is 30",
        ),
        (
            "a robot less",
            |o| o.robots.truncate(1),
            "there are figures for 1 robot, but the station has 2",
        ),
        (
            "a robot more",
            |o| o.robots.push(RobotFigures::default()),
            "there are figures for 3 robots, but the station has 2",
        ),
        // The sums stay as they are.
        (
            "a pick of the other robot",
            |o| {
                o.robots[0].picked -= 1;
                o.robots[1].picked += 1;
            },
            "picks of robot 0 is reported as 2, but is 3",
        ),
        (
            "a failure of the other robot",
            |o| {
                o.robots[0].failed += 1;
                o.robots[1].failed -= 1;
            },
            "failed attempts of robot 0 is reported as 2, but is 1",
        ),
        (
            "a weight of the other robot",
            |o| {
                o.robots[0].weight += 0.5;
                o.robots[1].weight -= 0.5;
            },
            "weight of robot 0 is reported as 2.75, but is 2.25",
        ),
        (
            "time of the other robot",
            |o| {
                o.robots[0].busy += 0.5;
                o.robots[1].busy -= 0.5;
            },
            "busy time of robot 0 is reported as",
        ),
        (
            "all swapped",
            |o| o.robots.swap(0, 1),
            "picks of robot 0 is reported as 2, but is 3",
        ),
        // Each robot's, the last too.
        (
            "picks",
            |o| o.robots[1].picked -= 1,
            "picks of robot 1 is reported as 1, but is 2",
        ),
        (
            "failures",
            |o| o.robots[1].failed -= 1,
            "failed attempts of robot 1 is reported as 1, but is 2",
        ),
        (
            "weight",
            |o| o.robots[1].weight -= 0.5,
            "weight of robot 1 is reported as 1, but is 1.5",
        ),
        (
            "weight that is not a number",
            |o| o.robots[1].weight = f64::NAN,
            "weight of robot 1 is reported as NaN, but is 1.5",
        ),
        (
            "more busy",
            |o| o.robots[1].busy += 1e-6,
            "busy time of robot 1 is reported as",
        ),
        (
            "less busy",
            |o| o.robots[1].busy -= 1e-6,
            "busy time of robot 1 is reported as",
        ),
        (
            "never free",
            |o| o.robots[1].busy = f64::INFINITY,
            "busy time of robot 1 is reported as inf, but is",
        ),
        (
            "without the failed attempts",
            |o| {
                for failure in &o.failures {
                    let of = &failure.attempt;
                    o.robots[of.robot].busy -= of.release - of.decide;
                }
            },
            "busy time of robot 0 is reported as",
        ),
    ];
    for (name, bend, words) in bends {
        let mut bent = outcome.clone();
        bend(&mut bent);
        let refuted = check(&bench.station, &bench.pattern, &bent);
        let message = refuted.expect_err(name).to_string();
        assert!(message.contains(words), "{name}: {message}");
    }
}

/// A run ends with what comes last: an item that leaves, a pick, or the return from a failure.
#[test]
fn the_end_is_that_of_the_last_event() {
    let slow = back().with_dwell(back().grasp_time, 100.0);
    let bench = Bench::of(BELT, vec![front(), slow], &[(0.0, 0.0), (-1.0, 0.0)]);
    let pick = |robot, item| bench.pick(robot, item, 1.5);
    let leaves = idle(&[MissReason::Busy; 2]);
    let picked = Draft {
        picks: vec![pick(0, 0), pick(1, 1)],
        missed: Vec::new(),
        ..leaves.clone()
    };
    let failed = Draft {
        failures: vec![bench.failure(1, 0, 1.2)],
        picks: vec![bench.pick(0, 0, 2.0), pick(0, 1)],
        missed: Vec::new(),
    };
    // The last item leaves at (3 + 1) / 0.3 s, and the bins are 0.5 m from the items.
    let (out, dwell) = (0.5 / 0.9, 0.2 + 100.0);
    let back_home = |meets: f64, out: f64| meets + dwell + out;
    for (name, draft, end) in [
        ("an item leaves", leaves, 4.0 / 0.3),
        ("a pick", picked, back_home(2.5 / 0.3, out)),
        (
            "a failure",
            failed,
            back_home(1.2 / 0.3, 0.3f64.hypot(0.5) / 0.9),
        ),
    ] {
        let outcome = bench.finish(draft);
        assert!((outcome.figures.end - end).abs() < 1e-9, "{name}");
        check(&bench.station, &bench.pattern, &outcome).expect(name);
        for bent in [-1e-6, 1e-6] {
            let mut outcome = outcome.clone();
            outcome.figures.end += bent;
            let refuted = check(&bench.station, &bench.pattern, &outcome);
            let message = refuted.expect_err(name).to_string();
            assert!(message.contains("end is reported as"), "{name}: {message}");
        }
    }
}
