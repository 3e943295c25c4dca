//! Times in which robots are down: whether they are possible, and that nobody decides then.

use super::bench::Bench;
use pickline::checker::check;
use pickline::decision::{Downtime, MissReason};

/// The run of the bench with these times in which robots are down: robot, from and to [s].
fn checked(downtimes: &[(usize, f64, f64)], reason: MissReason) -> Result<(), String> {
    let bench = Bench::new();
    let mut outcome = bench.finish(bench.run());
    outcome.missed[1].reason = reason;
    let downtimes = downtimes.iter();
    outcome.downtimes = downtimes
        .map(|&(robot, from, to)| Downtime { robot, from, to })
        .collect();
    check(&bench.station, &bench.pattern, &outcome).map_err(|error| error.to_string())
}

#[test]
fn robots_that_are_down_decide_nothing() {
    let bench = Bench::new();
    let run = bench.run();
    let end = bench.finish(bench.run()).figures.end;
    let (pick, failure) = (&run.picks[2], &run.failures[1].attempt);
    for attempt in [pick, failure] {
        let (robot, at) = (attempt.robot, attempt.decide);
        for (from, to) in [(at, at + 0.01), (at - 0.01, at + 1e-6), (0.0, end)] {
            let refuted = checked(&[(robot, from, to)], MissReason::Busy).unwrap_err();
            let words = "the robot is down from";
            assert!(refuted.contains(words), "{from} to {to}: {refuted}");
        }
        // It ends at the decision, or begins after it, when the pick is under way.
        for (from, to) in [(at - 0.01, at), (at + 1e-6, at + 0.01)] {
            checked(&[(robot, from, to)], MissReason::Busy).unwrap();
        }
    }
    // The other robot may decide.
    let (other, at) = (1 - pick.robot, pick.decide);
    checked(&[(other, at, at + 0.01)], MissReason::RobotDown).unwrap();
}

#[test]
fn impossible_times_are_refuted() {
    let bench = Bench::new();
    let end = bench.finish(bench.run()).figures.end;
    let late = bench.run().picks[4].release;
    assert!(late + 0.3 < end);
    for (downtimes, words) in [
        (&[(2, late, late + 0.1)][..], "robot 2 is listed as down"),
        (&[(0, -1.0, 0.0)], "robot 0 is listed as down from -1 s"),
        (&[(0, late + 0.1, late)], "robot 0 is listed as down"),
        (&[(0, late, late)], "robot 0 is listed as down"),
        (&[(0, late, f64::NAN)], "robot 0 is listed as down"),
        (&[(0, late, end + 0.1)], "robot 0 is listed as down"),
        // Times that touch are one.
        (
            &[(1, late, late + 0.1), (1, late + 0.1, late + 0.2)],
            "robot 1 is listed as down",
        ),
    ] {
        let refuted = checked(downtimes, MissReason::Busy).unwrap_err();
        assert!(refuted.contains(words), "{refuted}");
    }
    let two = [(0, late, late + 0.1), (0, late + 0.2, late + 0.3)];
    checked(&two, MissReason::Busy).unwrap();
}

#[test]
fn nothing_is_missed_by_a_robot_that_was_never_down() {
    let refuted = checked(&[], MissReason::RobotDown).unwrap_err();
    let words = "item 6 is listed as robot_down, but no robot was down";
    assert!(refuted.contains(words), "{refuted}");
}
