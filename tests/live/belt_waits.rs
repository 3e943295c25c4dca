//! When the belt's drive is asked to stop for an item, and to go on: to the millisecond, for
//! the right item and robot.
//!
//! `delta-1` has its base at (1, 0), its bin at (1, -0.4), a reach of 0.6 m and an arm of 3 m/s;
//! `scara-2` its base at (1.6, 0.35), its bin at (1.6, 0.45), 0.7 m and 2 m/s.

use crate::support::three::{Three, config};
use pickline_live::protocol::Outgoing;
use pickline_live::{Config, Controller, LineState};

const LOST: &str = "an item would leave the last robot's reach";
const CLEAR: &str = "robots take tasks, and no item would be lost";
const NOBODY: &str = "no robot takes tasks";

fn may_stop(lead: &[f64]) -> Config {
    config().with_may_stop_belt(true).with_lead(lead.to_vec())
}

/// When delta-1 has to leave for an item at (`x`, 0) at 100 s at last, at `speed`.
fn last_of_delta(x: f64, speed: f64) -> f64 {
    100.0 + (1.6 - x) / speed - 0.6_f64.hypot(0.4) / 3.0
}

/// The same of scara-2.
fn last_of_scara(x: f64, speed: f64) -> f64 {
    let half = (0.49_f64 - 0.35 * 0.35).sqrt();
    100.0 + (1.6 + half - x) / speed - half.hypot(0.45) / 2.0
}

/// A line whose robots all say `states` at 100 s and which sees items at these x, y = 0.
fn line(config: Config, states: [&str; 3], items: &[f64]) -> Three {
    let mut line = Three::with(config, 0.3);
    for (robot, state) in ["delta-1", "scara-2", "arm-3"].iter().zip(states) {
        if !state.is_empty() {
            line.robot(100.0, robot, state);
        }
    }
    for (number, x) in items.iter().enumerate() {
        line.see(100.0, &format!("i{number}"), *x, 0.0);
    }
    line
}

/// When the first request comes, all on its own, and what it says.
fn first_request(line: &mut Three) -> Option<(f64, f64, String)> {
    line.tick(130.0);
    let request = line.requests().into_iter().next()?;
    Some((request.stamp, request.speed, request.reason))
}

#[test]
fn the_belt_is_to_stop_its_margin_before_the_last_robot_loses_an_item() {
    let margin = |stop_margin: f64, lead: &[f64]| may_stop(lead).with_stop_margin(stop_margin);
    // Which robots work, each with a busy state that never ends; items; when the belt has to
    // stop.
    type Case = (Config, [&'static str; 3], &'static [f64], f64);
    let cases: [Case; 9] = [
        (
            may_stop(&[]),
            ["busy", "", ""],
            &[0.5],
            last_of_delta(0.5, 0.3) - 0.5,
        ),
        (
            margin(0.2, &[]),
            ["busy", "", ""],
            &[0.5],
            last_of_delta(0.5, 0.3) - 0.2,
        ),
        // A task is decided its lead time before.
        (
            may_stop(&[0.3]),
            ["busy", "", ""],
            &[0.5],
            last_of_delta(0.5, 0.3) - 0.8,
        ),
        // The one that loses it last counts, with its own lead,
        (
            may_stop(&[]),
            ["busy", "busy", ""],
            &[0.5],
            last_of_scara(0.5, 0.3) - 0.5,
        ),
        (
            may_stop(&[9.0, 0.4]),
            ["busy", "busy", ""],
            &[0.5],
            last_of_scara(0.5, 0.3) - 0.9,
        ),
        // if it works,
        (
            may_stop(&[]),
            ["busy", "fault", ""],
            &[0.5],
            last_of_delta(0.5, 0.3) - 0.5,
        ),
        (
            may_stop(&[]),
            ["busy", "", ""],
            &[0.5, 0.3],
            last_of_delta(0.5, 0.3) - 0.5,
        ),
        // and the first item.
        (
            may_stop(&[]),
            ["busy", "", ""],
            &[0.3, 0.5],
            last_of_delta(0.5, 0.3) - 0.5,
        ),
        // What it has lost already, and what it never reaches, does not count.
        (
            may_stop(&[]),
            ["busy", "", ""],
            &[1.9, 0.5],
            last_of_delta(0.5, 0.3) - 0.5,
        ),
    ];
    for (number, (config, states, items, at)) in cases.into_iter().enumerate() {
        let mut line = line(config, states, items);
        let (stamp, speed, reason) = first_request(&mut line).unwrap();
        assert!((stamp - at).abs() < 1e-6, "{number}: {stamp}, not {at}");
        assert_eq!((speed, reason.as_str()), (0.0, LOST), "{number}");
    }
    // Nobody is asked where the flag is not given, where nobody can reach anything, or where
    // somebody can take it in time.
    let not = may_stop(&[]).with_may_stop_belt(false);
    assert_eq!(
        first_request(&mut line(not, ["busy", "", ""], &[0.5])),
        None
    );
    assert_eq!(
        first_request(&mut line(may_stop(&[]), ["busy", "", ""], &[1.9])),
        None
    );
    assert_eq!(
        first_request(&mut line(may_stop(&[]), ["busy", "", ""], &[])),
        None
    );
    assert_eq!(
        first_request(&mut line(may_stop(&[]), ["", "", ""], &[0.5])),
        None
    );
}

/// What nobody may take does not hold the belt: refused, given up, paused or let pass.
#[test]
fn what_nobody_may_take_does_not_stop_the_belt() {
    let mut refused = line(may_stop(&[]), ["idle", "", ""], &[1.0]);
    refused.tick(100.0);
    let task = refused.task();
    refused.result(100.1, task.id, "REJECTED");
    assert_eq!(first_request(&mut refused), None);
    // A paused robot takes none: then nobody takes any.
    let mut paused = line(may_stop(&[]), ["busy", "busy", ""], &[0.5]);
    paused.say(r#""kind":"pause","stamp":100,"robot":"scara-2""#);
    let (stamp, _, reason) = first_request(&mut paused).unwrap();
    assert!(
        (stamp - last_of_delta(0.5, 0.3) + 0.5).abs() < 1e-6,
        "{stamp}"
    );
    assert_eq!(reason, LOST);
    let mut paused = line(may_stop(&[]), ["busy", "", ""], &[0.5]);
    paused.say(r#""kind":"pause","stamp":100"#);
    assert_eq!(
        first_request(&mut paused),
        Some((100.0, 0.0, NOBODY.to_owned()))
    );
    // While the line drains, what comes is let pass.
    let mut drained = line(may_stop(&[]), ["busy", "", ""], &[]);
    drained.say(r#""kind":"drain","stamp":100"#);
    drained.see(100.0, "a", 0.5, 0.0);
    assert_eq!(first_request(&mut drained), None);
}

#[test]
fn a_robot_that_has_a_task_saves_its_item() {
    // It has the item in time, and there is no other one.
    let mut line = line(may_stop(&[]), ["idle", "", ""], &[0.9]);
    line.tick(100.0);
    let task = line.task();
    line.ack(100.0, task.id);
    line.tick(task.free_at);
    line.result(task.free_at, task.id, "PICKED");
    line.tick(110.0);
    assert_eq!(line.requests(), []);
}

/// The belt stands for an item until its robot has met it, to the moment.
#[test]
fn the_belt_goes_on_when_the_item_is_met() {
    let mut line = line(may_stop(&[]), ["busy", "", ""], &[0.5]);
    let at = last_of_delta(0.5, 0.3) - 0.5;
    line.tick(at + 0.01);
    assert_eq!(line.requests().len(), 1);
    line.belt(at + 0.1, 0.0);
    line.tick(at + 3.0);
    assert_eq!(line.requests(), []);
    line.robot(at + 3.0, "delta-1", "idle");
    line.tick(at + 3.0);
    let task = line.task();
    line.ack(at + 3.0, task.id);
    line.tick(task.meet_at + 0.2);
    let asked = line.requests();
    assert_eq!(asked.len(), 1, "{asked:?}");
    assert!((asked[0].stamp - task.meet_at).abs() < 1e-6, "{asked:?}");
    assert_eq!((asked[0].speed, asked[0].reason.as_str()), (0.3, CLEAR));
}

/// It goes on at once when the robot that it waited for takes no tasks any more, if another
/// one does.
#[test]
fn the_belt_does_not_wait_for_a_robot_that_breaks_down() {
    let mut line = line(may_stop(&[]), ["busy", "busy", ""], &[0.5]);
    let at = last_of_scara(0.5, 0.3) - 0.5;
    line.tick(at + 0.01);
    assert_eq!(line.requests()[0].reason, LOST);
    line.belt(at + 0.1, 0.0);
    line.robot(at + 1.0, "scara-2", "fault");
    line.tick(at + 1.0);
    let asked = line.requests();
    assert_eq!(asked.len(), 1);
    assert_eq!((asked[0].stamp, asked[0].speed), (at + 1.0, 0.3));
    // And where nobody is left it stands.
    line.belt(at + 1.1, 0.3);
    line.tick(at + 1.2);
    line.robot(at + 2.0, "delta-1", "fault");
    line.tick(at + 2.0);
    let asked = line.requests();
    assert_eq!((asked[0].speed, asked[0].reason.as_str()), (0.0, NOBODY));
}

/// Each state of a robot, and whether the belt runs for it.
#[test]
fn who_takes_tasks() {
    for (state, works) in [("idle", true), ("busy", true), ("fault", false)] {
        let mut line = line(may_stop(&[]), [state, "", ""], &[]);
        line.tick(100.5);
        assert_eq!(line.requests().is_empty(), works, "{state}");
    }
    for order in ["pause", "stop", "drain"] {
        for robot in ["", r#","robot":"delta-1""#] {
            let mut line = line(may_stop(&[]), ["idle", "", ""], &[]);
            line.say(&format!(r#""kind":"{order}","stamp":100{robot}"#));
            line.tick(100.5);
            let asked = line.requests();
            // To drain, the line works on; a robot by itself does not.
            let works = order == "drain" && robot.is_empty();
            assert_eq!(asked.is_empty(), works, "{order} {robot}");
            line.say(&format!(r#""kind":"resume","stamp":100.9{robot}"#));
            line.tick(100.9);
            let asked = line.requests();
            assert_eq!(asked.len(), usize::from(!works), "{order} {robot}");
            assert!(asked.iter().all(|request| request.speed == 0.3));
        }
    }
    // One that owes a result.
    let mut line = line(may_stop(&[]), ["idle", "", ""], &[0.9]);
    line.tick(100.0);
    let task = line.task();
    line.ack(100.0, task.id);
    line.tick(110.0);
    let asked = line.requests();
    assert!(
        (asked[0].stamp - task.free_at - 5.0).abs() < 1e-6,
        "{asked:?}"
    );
    assert_eq!(asked[0].reason, NOBODY);
    // It is asked again each second, ten times.
    line.tick(140.0);
    let stamps: Vec<f64> = line.requests().iter().map(|r| r.stamp).collect();
    let all: Vec<f64> = asked.iter().map(|r| r.stamp).chain(stamps).collect();
    let gaps: Vec<f64> = all.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert_eq!(gaps.len(), 10);
    assert!(gaps.iter().all(|gap| (gap - 1.0).abs() < 1e-9), "{gaps:?}");
}

/// The moment at which the last robot falls silent is such a reason as well.
#[test]
fn the_belt_is_asked_to_stop_at_the_moment_of_silence() {
    let config =
        may_stop(&[]).with_timeouts(pickline_live::Timeouts::default().with_robot(Some(2.0)));
    let mut line = line(config, ["idle", "", ""], &[]);
    line.robot(101.0, "scara-2", "idle");
    line.tick(110.0);
    let asked = line.requests();
    assert!((asked[0].stamp - 103.0).abs() < 1e-6, "{asked:?}");
    assert_eq!(asked[0].reason, NOBODY);
}

/// After a restart nothing is asked for until the belt is heard; then what stood is taken up.
#[test]
fn a_belt_that_waits_is_remembered_over_a_restart() {
    let mut line = line(may_stop(&[]), ["fault", "", ""], &[]);
    line.tick(100.1);
    assert_eq!(line.requests().len(), 1);
    line.belt(100.2, 0.0);
    line.tick(100.3);
    let mut state = LineState::default();
    state.apply(line.controller.whole());
    line.controller = Controller::restore(
        crate::support::three::station(),
        crate::support::three::strategy(),
        may_stop(&[]),
        state,
        None,
    )
    .unwrap();
    line.robot(101.0, "delta-1", "idle");
    line.tick(102.0);
    assert_eq!(line.requests(), []);
    line.belt(102.5, 0.0);
    line.tick(102.5);
    let asked = line.requests();
    assert_eq!(asked.len(), 1);
    assert_eq!((asked[0].stamp, asked[0].speed), (102.5, 0.3));
}

fn next_due(line: &mut Three, stamp: f64) -> Option<f64> {
    line.said.clear();
    line.tick(stamp);
    let due = line.said.iter().find_map(|message| match message {
        Outgoing::Due(due) => Some(due.next),
        _ => None,
    });
    due.unwrap()
}

/// The next request is due where there may be one, and nothing is due where there is none.
#[test]
fn when_a_request_is_due() {
    let at = last_of_delta(0.5, 0.3) - 0.5;
    let mut asks = line(may_stop(&[]), ["busy", "", ""], &[0.5]);
    let next = next_due(&mut asks, 100.0).unwrap();
    assert!((next - at).abs() < 1e-6, "{next}");
    // Without an item, and without the flag.
    let mut asks = line(may_stop(&[]), ["busy", "", ""], &[]);
    assert_eq!(next_due(&mut asks, 100.0), None);
    let mut never = line(config(), ["busy", "", ""], &[0.5]);
    assert_eq!(next_due(&mut never, 100.0), None);
    // After a restart nothing is due before the belt is heard.
    let mut before = line(may_stop(&[]), ["busy", "", ""], &[0.5]);
    before.tick(100.0);
    let mut state = LineState::default();
    state.apply(before.controller.whole());
    let (station, strategy) = (
        crate::support::three::station(),
        crate::support::three::strategy(),
    );
    before.controller = Controller::restore(station, strategy, may_stop(&[]), state, None).unwrap();
    assert_eq!(next_due(&mut before, 100.1), None);
}

/// Each robot's silence counts, from the moment on at which it is overdue.
#[test]
fn the_silence_of_each_robot_counts() {
    for silent in 0..3 {
        let config =
            may_stop(&[]).with_timeouts(pickline_live::Timeouts::default().with_robot(Some(2.0)));
        let mut states = [""; 3];
        states[silent] = "idle";
        let mut line = line(config, states, &[]);
        line.tick(102.0);
        assert_eq!(line.requests(), [], "{silent}");
        line.tick(102.5);
        let asked = line.requests();
        assert_eq!(asked.len(), 1, "{silent}");
        assert!((asked[0].stamp - 102.0).abs() < 1e-6, "{asked:?}");
    }
}

/// What is due before a request is done before it.
#[test]
fn a_request_overtakes_nothing() {
    let config =
        may_stop(&[]).with_timeouts(pickline_live::Timeouts::default().with_robot(Some(2.5)));
    let mut line = Three::with(config, 0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(103.0);
    let starts: Vec<f64> = line.said().0.iter().map(|task| task.start).collect();
    assert_eq!(starts, [100.0, 101.0, 102.0, 103.0]);
}

/// Two messages of one stamp are heard together.
#[test]
fn a_robot_that_takes_over_at_once_keeps_the_belt_going() {
    let mut line = line(may_stop(&[]), ["idle", "", ""], &[]);
    line.tick(101.0);
    line.robot(102.0, "delta-1", "fault");
    line.robot(102.0, "scara-2", "idle");
    line.tick(103.0);
    assert_eq!(line.requests(), []);
}
