//! What a robot says of itself and of its tasks, and when it gets its next one for it.
//!
//! `delta-1` takes 0.3667 s for its task of item `a`.

use crate::support::three::Three;

const DONE: f64 = 100.0 + 2.0 * (0.4 / 3.0 + 0.05);

/// `delta-1` has a task of item `a`; item `b` waits for it.
fn at_work(ack: Option<f64>) -> Three {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.see(100.0, "b", 1.1, 0.0);
    line.tick(100.0);
    assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
    if let Some(ack) = ack {
        line.ack(ack, 1);
    }
    line
}

/// Says each in its order, at its stamp, and lets time pass until 104 s: when the next task
/// starts, if there is one.
fn next_start(line: &mut Three, says: &[&str]) -> Option<f64> {
    for fields in says {
        let message = match fields.split_once(' ') {
            Some((stamp, rest)) if stamp.parse::<f64>().is_ok() => {
                let (what, rest) = rest.split_once(' ').unwrap_or((rest, ""));
                let rest = rest.replace("free ", r#","available_at":"#);
                let rest = rest.replace("task ", r#","task":"#);
                let result = ["PICKED", "MISSED"].contains(&what);
                if result {
                    format!(r#""kind":"result","stamp":{stamp},"task":1,"result":"{what}"{rest}"#)
                } else {
                    format!(
                        r#""kind":"robot","stamp":{stamp},"name":"delta-1","state":"{what}"{rest}"#
                    )
                }
            }
            _ => panic!("{fields}"),
        };
        line.say(&message);
    }
    line.tick(104.0);
    let (tasks, _) = line.said();
    let mut next = tasks
        .iter()
        .filter(|task| task.id == 2 && task.revision == 0);
    next.next().map(|task| task.start)
}

#[test]
fn when_a_robot_gets_its_next_task() {
    // What it says after its ack at 100.01 s, when its next task starts, and how much of it
    // was late.
    type Case = (&'static [&'static str], Option<f64>, u64);
    let cases: [Case; 35] = [
        (&[], None, 0),
        // An idle without its task may lag behind, until the robot should be done.
        (&["100.1 idle"], Some(DONE), 0),
        (&["100.01 idle"], Some(DONE), 0),
        (&["100.1 idle", "100.2 idle"], Some(DONE), 0),
        (&["100.1 idle", "100.2 busy"], None, 0),
        (&["100.1 idle", "100.2 busy", "100.3 idle"], Some(DONE), 0),
        (&["100.37 idle"], Some(100.37), 0),
        (&["100.5 idle"], Some(100.5), 0),
        // From before its ack it is old news.
        (&["100.005 idle"], None, 0),
        (&["100.005 idle task 1"], None, 0),
        (&["100.005 idle free 100.2"], None, 0),
        // One that knows its task is done with it; one that knows another one is not.
        (&["100.1 idle task 1"], Some(100.1), 0),
        (&["100.1 idle task 7"], None, 0),
        (&["100.5 idle task 7"], None, 0),
        (&["100.1 idle free 100.2"], Some(100.2), 0),
        (&["100.1 idle task 1free 100.25"], Some(100.25), 0),
        (&["100.1 idle free 101.5"], Some(101.5), 0),
        // What it said before it said something newer is over.
        (&["100.3 busy", "100.2 idle task 1"], None, 1),
        (&["100.2 busy", "100.2 idle task 1"], Some(100.2), 0),
        // Busy, it is not free before its result.
        (&["100.1 busy free 100.2"], None, 0),
        (&["100.1 busy free 101", "100.3 PICKED"], Some(100.3), 0),
        (&["100.3 busy free 101", "100.2 PICKED"], Some(101.0), 0),
        (&["100.3 busy free 101", "100.3 PICKED"], Some(100.3), 0),
        // A result frees it, at its stamp or when it says.
        (&["100.2 PICKED"], Some(100.2), 0),
        (&["100.2 PICKED free 100.8"], Some(100.8), 0),
        // What it says since counts, and only that.
        (&["100.2 PICKED free 100.8", "100.25 idle"], Some(100.25), 0),
        (&["100.2 PICKED free 100.8", "100.2 idle"], Some(100.8), 0),
        (&["100.2 PICKED free 100.8", "100.15 idle"], Some(100.8), 1),
        (
            &["100.2 PICKED free 100.8", "100.25 idle free 101.4"],
            Some(101.4),
            0,
        ),
        (&["100.2 PICKED free 100.8", "100.3 busy"], None, 0),
        (
            &["100.2 PICKED free 100.8", "100.3 busy free 101.2"],
            Some(101.2),
            0,
        ),
        (&["100.2 PICKED free 100.8", "100.15 busy"], Some(100.8), 1),
        (
            &["100.2 PICKED free 100.8", "100.3 busy", "101.1 idle"],
            Some(101.1),
            0,
        ),
        // A result before its fault does not end that; a later word does.
        (&["100.2 fault", "100.3 PICKED"], None, 0),
        (&["100.2 fault", "100.2 idle", "100.3 PICKED"], None, 1),
    ];
    for (says, start, late) in cases {
        let mut line = at_work(Some(100.01));
        // A fault at 100.2 s comes after the meeting: the item may be in the gripper.
        let found = next_start(&mut line, says);
        match (found, start) {
            (Some(found), Some(start)) => {
                assert!(
                    (found - start).abs() < 1e-6,
                    "{says:?}: {found}, not {start}"
                );
            }
            _ => assert_eq!(found, start, "{says:?}"),
        }
        assert_eq!(line.noted("late_robot"), late, "{says:?}");
    }
}

#[test]
fn a_fault_ends_with_a_newer_word() {
    for (says, start) in [
        (&["100.05 fault", "100.04 idle"][..], None),
        (&["100.05 fault", "100.05 idle"], None),
        (&["100.05 fault", "100.06 busy"], None),
        (&["100.05 fault", "100.06 idle"], Some(100.06)),
        (&["100.3 fault", "100.1 fault", "100.2 idle"], None),
        (&["100.05 fault", "100.06 idle free 100.5"], Some(100.5)),
        (&["100.05 fault", "100.06 busy free 100.5"], Some(100.5)),
        // A fault that comes late lasts until something is newer than all that was said.
        (&["100.3 busy", "100.05 fault", "100.2 idle"], None),
        (&["100.3 busy", "100.05 fault", "100.3 idle"], None),
        (&["100.3 busy", "100.05 fault", "100.31 idle"], Some(100.31)),
    ] {
        let mut line = at_work(Some(100.01));
        for fields in says {
            let (stamp, rest) = fields.split_once(' ').unwrap();
            let (state, rest) = rest.split_once(' ').unwrap_or((rest, ""));
            let rest = rest.replace("free ", r#","available_at":"#);
            line.say(&format!(
                r#""kind":"robot","stamp":{stamp},"name":"delta-1","state":"{state}"{rest}"#
            ));
        }
        line.tick(104.0);
        let (tasks, _) = line.said();
        let found = tasks
            .iter()
            .find(|task| task.id == 2)
            .map(|task| task.start);
        assert_eq!(found, start, "{says:?}");
    }
}

/// A `busy` with the task that is open acknowledges it, at its stamp; nothing else does.
#[test]
fn what_acknowledges_a_task() {
    for (says, is_ack) in [
        (r#""state":"busy","task":1"#, true),
        (r#""state":"busy","task":2"#, false),
        (r#""state":"busy","task":0"#, false),
        (r#""state":"busy""#, false),
        (r#""state":"idle","task":1"#, false),
        (r#""state":"idle""#, false),
    ] {
        let mut line = at_work(None);
        line.say(&format!(
            r#""kind":"robot","stamp":100.1,"name":"delta-1",{says}"#
        ));
        let stage = line.controller.view(0).claims[0].stage;
        assert_eq!(stage == "acknowledged", is_ack, "{says}");
        line.tick(101.0);
        let sent = line.told();
        let again: &[&str] = if is_ack { &[] } else { &["task 1.1 delta-1 a"] };
        assert_eq!(sent, again, "{says}");
        assert_eq!(line.noted("late_ack"), 0);
    }
    // From that stamp on what it says is of the task.
    let mut line = at_work(None);
    let found = next_start(&mut line, &["100.1 busy task 1", "100.2 idle task 1"]);
    assert_eq!(found, Some(100.2));
    // Said again it is no second ack: the first one counts.
    let mut line = at_work(Some(100.01));
    line.ack(100.3, 1);
    let found = next_start(&mut line, &["100.1 idle task 1"]);
    assert_eq!(found, Some(100.3));
    assert_eq!(line.noted("late_ack"), 0);
}

/// What a status says of a robot, at each step of its work.
#[test]
fn the_state_of_a_robot_is_shown_as_it_is() {
    let mut line = Three::new(0.0);
    let state = |line: &Three| line.status().robots[0].state.clone();
    assert_eq!(state(&line), "unknown");
    line.robot(100.0, "delta-1", "busy");
    assert_eq!(state(&line), "busy");
    line.say(r#""kind":"robot","stamp":100.1,"name":"delta-1","state":"idle","available_at":101"#);
    line.tick(100.5);
    assert_eq!(state(&line), "busy");
    line.tick(101.0);
    assert_eq!(state(&line), "idle");
    line.see(101.0, "a", 1.0, 0.0);
    line.tick(101.0);
    assert_eq!(state(&line), "busy");
    line.ack(101.0, 1);
    line.tick(102.0);
    assert_eq!(state(&line), "busy");
    line.robot(102.0, "delta-1", "idle");
    assert_eq!(state(&line), "idle");
    line.robot(102.0, "delta-1", "fault");
    assert_eq!(state(&line), "fault");
    line.robot(103.0, "delta-1", "idle");
    assert_eq!(state(&line), "idle");
}

/// Three tasks in a row that it drops unasked cost a robot half a second, and each further one
/// twice as much, up to 10 s.
#[test]
fn a_robot_that_drops_its_tasks_rests_longer_and_longer() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    for item in 0..40 {
        let x = 0.7 + 0.02 * f64::from(item % 20);
        let y = 0.1 * f64::from(item / 20);
        line.see(100.0, &format!("i{item}"), x, y);
    }
    let mut now = 100.0;
    for (number, pause) in [0.0, 0.0, 0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 10.0, 10.0]
        .into_iter()
        .enumerate()
    {
        if pause > 0.0 {
            line.tick(now + pause - 0.001);
            assert_eq!(line.told(), [""; 0], "{number}");
        }
        now += pause;
        line.tick(now);
        let task = line.task();
        assert_eq!((task.id, task.start), (number as u64 + 1, now));
        line.result(now, task.id, "CANCELLED");
    }
    assert_eq!(line.noted("task_cancelled"), 10);
    assert_eq!(line.noted("robot_rested"), 1);
    let told = "robot `delta-1` has answered CANCELLED to 3 tasks in a row that were not \
                cancelled; it gets its next ones after increasing pauses\n  check why it drops \
                them; a robot that must not work should report `fault`";
    assert_eq!(line.controller.take_remarks(), [told]);
}

/// `delta-1` is idle, and twenty items wait for it.
fn with_twenty_items() -> Three {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    for item in 0..20 {
        let x = 0.7 + 0.02 * f64::from(item);
        line.see(100.0, &format!("i{item}"), x, 0.0);
    }
    line
}

/// Another result begins the count again, and what it was asked to drop does not count.
#[test]
fn a_robot_that_drops_some_tasks_is_not_paused() {
    for (third, rests) in [("CANCELLED", true), ("PICKED", false), ("REJECTED", false)] {
        let mut line = with_twenty_items();
        for result in ["CANCELLED", "CANCELLED", third, "CANCELLED", "CANCELLED"] {
            line.tick(100.0);
            let Some(task) = line.said().0.pop() else {
                break;
            };
            line.result(100.0, task.id, result);
        }
        assert_eq!(line.noted("robot_rested"), u64::from(rests), "{third}");
        assert_eq!(line.noted("task_rejected"), u64::from(third == "REJECTED"));
    }
    let mut line = with_twenty_items();
    for _ in 0..5 {
        line.tick(100.0);
        let task = line.task();
        line.say(r#""kind":"stop","stamp":100"#);
        line.result(100.0, task.id, "CANCELLED");
        line.say(r#""kind":"resume","stamp":100"#);
        line.said.clear();
    }
    assert_eq!(
        (line.noted("robot_rested"), line.noted("task_cancelled")),
        (0, 5)
    );
}

/// An item that its robot has dropped is offered to it again after 1 s, and twice as long each
/// further time up to a minute; to the others at once.
#[test]
fn a_dropped_item_comes_back_later_and_later() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    let mut now = 100.0;
    for pause in [0.0, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 60.0, 60.0] {
        if pause > 0.0 {
            line.tick(now + pause - 0.001);
            assert_eq!(line.told(), [""; 0], "{pause}");
        }
        now += pause;
        line.tick(now);
        let task = line.task();
        assert!((task.start - now).abs() < 1e-6, "{pause}: {task:?}");
        line.result(now, task.id, "CANCELLED");
    }
    line.robot(now, "scara-2", "idle");
    line.tick(now);
    assert_eq!(line.task().robot, "scara-2");
}

/// What is refused by a robot is not offered to it again, however often it moves.
#[test]
fn a_refused_item_is_not_offered_again() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(100.0);
    line.ack(100.0, 1);
    line.result(100.5, 1, "REJECTED");
    line.told();
    line.see(101.0, "a", 1.21, 0.0);
    line.belt(101.5, 0.01);
    line.tick(102.0);
    assert_eq!((line.told(), line.noted("task_rejected")), (vec![], 1));
    line.robot(102.0, "scara-2", "idle");
    line.tick(102.0);
    assert_eq!(line.told(), ["task 2.0 scara-2 a"]);
}

/// A late word ends the silence of a robot that owed a result, if it is the newest of it.
#[test]
fn a_late_result_ends_a_silence() {
    for (free, next) in [(None, 111.0), (Some(112.5), 112.5)] {
        let mut line = at_work(Some(100.01));
        line.tick(110.0);
        assert_eq!(line.status().robots[0].state, "silent");
        let free = free.map_or(String::new(), |at: f64| format!(r#","available_at":{at}"#));
        line.say(&format!(
            r#""kind":"result","stamp":111,"task":1,"result":"MISSED"{free}"#
        ));
        line.tick(113.0);
        let task = line.said().0.remove(0);
        assert_eq!((task.id, task.item.as_str(), task.start), (2, "b", next));
        assert_eq!(line.noted("late_result"), 1);
    }
}

/// The same for each robot; the others may take it.
#[test]
fn an_item_that_one_robot_drops_is_offered_to_others() {
    for (robot, other, x) in [("scara-2", "delta-1", 1.2), ("arm-3", "scara-2", 2.0)] {
        let mut line = Three::new(0.0);
        line.robot(100.0, robot, "idle");
        line.see(100.0, "a", x, 0.0);
        line.tick(100.0);
        line.ack(100.0, 1);
        line.result(100.5, 1, "REJECTED");
        line.belt(101.5, 0.01);
        line.tick(102.0);
        assert_eq!(line.told(), [format!("task 1.0 {robot} a")]);
        line.robot(102.0, other, "idle");
        line.tick(102.0);
        assert_eq!(line.told(), [format!("task 2.0 {other} a")]);
    }
}

/// An item that is withheld from its robot until after its last start is not due again.
#[test]
fn a_dropped_item_that_leaves_meanwhile_is_not_due() {
    let mut line = Three::new(0.3);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.4, 0.2);
    line.tick(100.0);
    line.result(100.01, 1, "CANCELLED");
    line.said.clear();
    line.tick(100.02);
    let due = pickline_live::protocol::Due {
        stamp: 100.02,
        next: None,
    };
    assert_eq!(line.said, [pickline_live::protocol::Outgoing::Due(due)]);
}

/// A word of being idle counts for one task only.
#[test]
fn an_early_idle_brings_one_task() {
    let mut line = at_work(Some(100.01));
    line.see(100.02, "c", 1.2, 0.0);
    line.robot(100.1, "delta-1", "idle");
    line.tick(100.5);
    let task = line.task();
    assert_eq!((task.id, task.item.as_str()), (2, "b"));
    line.ack(100.5, 2);
    line.tick(103.0);
    assert_eq!(line.told(), [""; 0]);
}

/// However many it drops, its rest is no longer.
#[test]
fn a_robot_that_drops_forty_tasks_rests_as_long() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    for item in 0..20 {
        let (x, y) = (0.7 + 0.03 * f64::from(item), 0.0);
        line.see(100.0, &format!("i{item}"), x, y);
    }
    let mut now = 100.0;
    for _ in 0..40 {
        line.tick(now);
        let task = line.said().0.pop().unwrap();
        line.result(now, task.id, "CANCELLED");
        now += 10.0;
    }
    assert_eq!(line.noted("task_cancelled"), 40);
}

/// Nobody is free or silent by a late word on an earlier task.
#[test]
fn a_late_result_of_an_earlier_task_frees_nobody() {
    let mut line = at_work(Some(100.01));
    line.see(100.02, "c", 1.2, 0.0);
    line.say(r#""kind":"robot","stamp":100.2,"name":"delta-1","state":"idle","task":1"#);
    line.tick(100.2);
    assert_eq!(line.told(), ["task 2.0 delta-1 b"]);
    line.ack(103.0, 2);
    line.tick(105.4);
    line.said.clear();
    assert_eq!(line.status().missed.no_result, 1);
    line.result(105.4, 1, "MISSED");
    line.tick(105.45);
    assert_eq!(
        (line.told(), line.status().robots[0].state.as_str()),
        (vec![], "busy")
    );
    // A fault is not ended by it either.
    let mut line = at_work(Some(100.01));
    line.tick(110.0);
    line.robot(111.0, "delta-1", "fault");
    line.result(112.0, 1, "MISSED");
    assert_eq!(line.status().robots[0].state, "fault");
    // Nor does one from before its last word end a silence: it has said since that it is at
    // work.
    for (stamp, state) in [(103.9, "silent"), (104.1, "idle")] {
        let mut line = at_work(Some(100.01));
        let busy =
            r#""kind":"robot","stamp":104,"name":"delta-1","state":"busy","available_at":108"#;
        line.say(busy);
        line.tick(130.0);
        assert_eq!(line.status().robots[0].state, "silent");
        line.result(stamp, 1, "MISSED");
        assert_eq!(line.status().robots[0].state, state, "{stamp}");
        assert_eq!(line.noted("late_result"), 1);
    }
}

/// A robot that is idle may say that it will be free later.
#[test]
fn an_idle_robot_may_announce_when_it_is_free() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.say(r#""kind":"robot","stamp":101,"name":"delta-1","state":"idle","available_at":103"#);
    line.see(101.5, "a", 1.0, 0.0);
    line.tick(104.0);
    assert_eq!(line.said().0[0].start, 103.0);
}

/// Each robot answers for its own tasks: a fault, or a word on another's task, is its own.
#[test]
fn no_robot_speaks_for_another() {
    let mut line = Three::two_at_work();
    line.robot(100.05, "delta-1", "fault");
    assert_eq!(
        line.told(),
        ["cancel 1 delta-1: the robot has reported a fault"]
    );
    let mut line = Three::two_at_work();
    line.say(r#""kind":"robot","stamp":100.05,"name":"delta-1","state":"busy","task":2"#);
    line.tick(101.0);
    assert_eq!(line.told(), ["task 1.1 delta-1 a", "task 2.1 arm-3 b"]);
    // One that was called back has said already that it had set out.
    let mut line = Three::two_at_work();
    line.ack(100.0, 1);
    line.say(r#""kind":"stop","stamp":100.02,"robot":"delta-1""#);
    line.told();
    line.say(r#""kind":"robot","stamp":100.05,"name":"delta-1","state":"busy","task":1"#);
    line.tick(100.1);
    assert_eq!((line.told(), line.noted("late_ack")), (vec![], 0));
}
