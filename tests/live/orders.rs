//! What the operator's orders do, to whom, and what becomes of the items.

use crate::support::line::Line;
use crate::support::three::Three;

/// Two robots at work on a standing belt, each with a task that it has acknowledged or not.
fn at_work(acknowledged: bool) -> Three {
    let mut line = Three::two_at_work();
    if acknowledged {
        line.ack(100.0, 1);
        line.ack(100.0, 2);
    }
    line
}

const STOPPED: [&str; 2] = [
    "cancel 1 delta-1: the operator has stopped it",
    "cancel 2 arm-3: the operator has stopped it",
];

/// delta-1 meets its item after 0.1491 s, arm-3 after 0.375 s.
#[test]
fn a_stop_cancels_what_has_not_been_met() {
    // When, whom, whether they have acknowledged, and who is called back.
    type Case = (f64, &'static str, bool, &'static [&'static str]);
    let cases: [Case; 9] = [
        (100.1, "", true, &STOPPED),
        (100.149, "", true, &STOPPED),
        (100.1491, "", true, &STOPPED[1..]),
        (100.4, "", true, &[]),
        // Who has acknowledged nothing is not thought to have met anything.
        (100.4, "", false, &STOPPED),
        (100.1, r#","robot":"arm-3""#, true, &STOPPED[1..]),
        (100.1, r#","robot":"delta-1""#, true, &STOPPED[..1]),
        (100.1, r#","robot":"scara-2""#, true, &[]),
        (100.4, r#","robot":"arm-3""#, false, &STOPPED[1..]),
    ];
    for (at, whom, acknowledged, expected) in cases {
        let mut line = at_work(acknowledged);
        line.say(&format!(r#""kind":"stop","stamp":{at}{whom}"#));
        assert_eq!(line.told(), expected, "{at} {whom}");
        // The items are their robots' until they answer.
        assert_eq!(line.status().claimed, 2);
    }
    for order in ["pause", "drain", "resume"] {
        let mut line = at_work(true);
        line.say(&format!(r#""kind":"{order}","stamp":100.1"#));
        assert_eq!(line.told(), [""; 0], "{order}");
    }
}

/// What was cancelled is not cancelled again by the next order.
#[test]
fn a_second_stop_says_nothing_new() {
    let mut line = at_work(true);
    line.say(r#""kind":"stop","stamp":100.1"#);
    line.told();
    line.say(r#""kind":"stop","stamp":100.12"#);
    line.say(r#""kind":"stop","stamp":100.12,"robot":"arm-3""#);
    assert_eq!(line.told(), [""; 0]);
}

/// Each mode of the line and of a robot: whether the robot gets the next task.
#[test]
fn both_orders_have_to_allow_a_task() {
    for line_order in ["resume", "pause", "drain", "stop"] {
        for robot_order in ["resume", "pause", "drain", "stop"] {
            let mut line = Three::new(0.0);
            line.robot(100.0, "delta-1", "idle");
            line.see(100.0, "a", 1.0, 0.0);
            line.say(&format!(
                r#""kind":"{robot_order}","stamp":100,"robot":"delta-1""#
            ));
            line.say(&format!(r#""kind":"{line_order}","stamp":100"#));
            line.tick(100.0);
            let works = ["resume", "drain"].contains(&line_order) && robot_order == "resume";
            let expected = if works {
                vec!["task 1.0 delta-1 a"]
            } else {
                vec![]
            };
            assert_eq!(line.told(), expected, "{line_order} {robot_order}");
            let mode = match line_order {
                "resume" => "running",
                "pause" => "paused",
                "drain" => "draining",
                _ => "stopped",
            };
            let status = line.status();
            assert_eq!(status.mode, mode);
            let state = match robot_order {
                "resume" if works => "busy",
                "resume" => "idle",
                "stop" => "stopped",
                _ => "paused",
            };
            assert_eq!(status.robots[0].state, state, "{line_order} {robot_order}");
        }
    }
}

/// A line is drained once no item that it knew is on the belt or with a robot.
#[test]
fn when_a_line_is_drained() {
    let mut line = Three::new(0.3);
    line.robot(100.0, "delta-1", "busy");
    // Within the belt at 4 m until 110 s.
    line.see(100.0, "a", 1.0, 0.0);
    line.say(r#""kind":"drain","stamp":100"#);
    line.see(100.0, "b", 0.9, 0.0);
    line.tick(109.999);
    assert_eq!(line.status().mode, "draining");
    // The one that came later does not count.
    line.tick(110.001);
    assert_eq!(line.status().mode, "drained");
    // One that a robot is after counts, wherever it is.
    let mut line = Three::new(0.3);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    line.ack(100.0, 1);
    line.say(r#""kind":"drain","stamp":100.1"#);
    line.tick(100.2);
    assert_eq!(line.status().mode, "draining");
    line.result(100.5, 1, "PICKED");
    assert_eq!(line.status().mode, "drained");
}

/// What was let pass is let pass until the line no longer drains, whatever ends that.
#[test]
fn items_skipped_while_draining_may_be_taken_afterwards() {
    let drained = || {
        let mut line = Three::new(0.0);
        line.robot(100.0, "delta-1", "idle");
        line.say(r#""kind":"drain","stamp":100"#);
        line.see(100.0, "a", 1.0, 0.0);
        line.tick(101.0);
        assert_eq!(line.told(), [""; 0]);
        assert_eq!(line.status().on_belt, 1);
        line
    };
    for order in ["resume", "pause", "stop"] {
        let mut line = drained();
        line.say(&format!(r#""kind":"{order}","stamp":101"#));
        line.say(r#""kind":"resume","stamp":101.5"#);
        line.tick(101.5);
        assert_eq!(line.told(), ["task 1.0 delta-1 a"], "{order}");
    }
    // An order of a robot, or the same one again, changes nothing for the line.
    for order in [
        r#""kind":"drain","stamp":101"#,
        r#""kind":"resume","stamp":101,"robot":"delta-1""#,
    ] {
        let mut line = drained();
        line.say(order);
        line.tick(102.0);
        assert_eq!(line.told(), [""; 0], "{order}");
    }
    // An item that is let pass is one that a robot could have had.
    let mut line = Three::new(0.3);
    line.robot(100.0, "delta-1", "idle");
    line.say(r#""kind":"drain","stamp":100"#);
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(120.0);
    assert_eq!(line.status().missed.busy, 1);
}

#[test]
fn an_order_for_nobody_is_refused() {
    let mut line = Three::new(0.0);
    for kind in ["pause", "resume", "drain", "stop"] {
        let order = Three::message(&format!(r#""kind":"{kind}","stamp":100,"robot":"r9""#));
        let refused = line.controller.handle(order).unwrap_err();
        assert_eq!(refused.reason.name(), "unknown_robot");
        assert_eq!(
            refused.message,
            "there is no robot `r9`; expected one of delta-1, scara-2, arm-3"
        );
    }
    assert_eq!(line.status().mode, "running");
    assert_eq!(line.status().rejected["unknown_robot"], 4);
}

/// Whose message it is: by the robot's name, or by the robot of the task, open or over.
#[test]
fn whose_message_it_is() {
    let mut line = at_work(true);
    line.result(100.5, 1, "PICKED");
    let cases = [
        (
            r#""kind":"robot","stamp":1,"name":"scara-2","state":"idle""#,
            Some(1),
        ),
        (
            r#""kind":"robot","stamp":1,"name":"r9","state":"idle""#,
            None,
        ),
        (r#""kind":"ack","stamp":1,"task":2"#, Some(2)),
        (r#""kind":"ack","stamp":1,"task":1"#, Some(0)),
        (r#""kind":"ack","stamp":1,"task":9"#, None),
        (
            r#""kind":"result","stamp":1,"task":2,"result":"PICKED""#,
            Some(2),
        ),
        (
            r#""kind":"result","stamp":1,"task":1,"result":"PICKED""#,
            Some(0),
        ),
        (
            r#""kind":"result","stamp":1,"task":9,"result":"PICKED""#,
            None,
        ),
        (r#""kind":"pause","stamp":1,"robot":"arm-3""#, Some(2)),
        (r#""kind":"stop","stamp":1,"robot":"r9""#, None),
        (r#""kind":"resume","stamp":1"#, None),
        (r#""kind":"belt","stamp":1,"speed":0"#, None),
        (r#""kind":"tick","stamp":1"#, None),
        (r#""kind":"detection","stamp":1,"x":0,"y":0"#, None),
    ];
    for (message, robot) in cases {
        assert_eq!(
            line.controller.robot_of(&Three::message(message)),
            robot,
            "{message}"
        );
    }
}

/// What is due at the stamp of an order is decided with it, what is due before without.
#[test]
fn an_order_counts_from_its_stamp_on() {
    for (stamp, is_given) in [(104.999, false), (105.0, false), (105.001, true)] {
        let mut line = Three::new(0.0);
        line.say(
            r#""kind":"robot","stamp":100,"name":"delta-1","state":"idle","available_at":105"#,
        );
        line.see(100.0, "a", 1.0, 0.0);
        line.say(&format!(r#""kind":"pause","stamp":{stamp}"#));
        line.tick(106.0);
        assert_eq!(!line.told().is_empty(), is_given, "{stamp}");
    }
}

/// At its meeting, to the moment, a robot has its item: time there begins at 0, so nothing is
/// rounded.
#[test]
fn at_its_meeting_a_robot_has_its_item() {
    let at_meeting = |what: &str| {
        let mut line = Line::new();
        line.see(0.0, "a", 1.0, -0.2);
        let task = line.task(0.0);
        line.ack(0.0, task.id);
        let stamp = task.meet_at;
        line.say(&what.replace("STAMP", &format!("{stamp:?}")));
        let (tasks, cancels) = line.tick(stamp);
        (tasks.len(), cancels.len(), line.status().missed.no_result)
    };
    assert_eq!(at_meeting(r#""kind":"stop","stamp":STAMP"#), (0, 0, 0));
    let fault = r#""kind":"robot","stamp":STAMP,"name":"r1","state":"fault""#;
    assert_eq!(at_meeting(fault), (0, 1, 1));
    assert_eq!(
        at_meeting(r#""kind":"belt","stamp":STAMP,"speed":0.02"#),
        (0, 0, 0)
    );
    // An item at the end of the belt is on it.
    let mut line = Line::new();
    line.see(0.0, "a", 4.2, 0.0);
    line.say(r#""kind":"drain","stamp":0"#);
    assert_eq!(line.status().mode, "draining");
}
