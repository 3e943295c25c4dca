//! Who is called back, why and how often; what a late `PICKED` means for whoever else is
//! after the item.

use crate::support::three::{Three, config};
use pickline_live::protocol::{Cancel, Outgoing, Rejection, Task};

/// `delta-1` has a task of item `a`, which `scara-2` can reach too.
fn first_task() -> (Three, Task) {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(100.0);
    let task = line.task();
    (line, task)
}

/// A result of the first task with which `delta-1` says that it is away until 1000 s.
fn ends(line: &mut Three, task: u64, result: &str) {
    line.ack(100.01, task);
    line.say(&format!(
        r#""kind":"result","stamp":100.5,"task":{task},"result":"{result}","available_at":1000"#
    ));
}

/// How the first task comes to its end, and when that is [s].
const ENDS: [(&str, f64); 6] = [
    ("MISSED", 100.5),
    ("GRASP_FAIL", 100.5),
    ("REJECTED", 100.5),
    ("CANCELLED", 100.5),
    ("fault", 100.02),
    ("unheard", 166.0),
];

/// The first task has ended so, and `scara-2` has one of the same item.
fn handed_over(end: (&str, f64)) -> (Three, u64, u64) {
    let (mut line, first) = first_task();
    let (how, at) = end;
    match how {
        "fault" => {
            line.ack(100.01, first.id);
            line.robot(at, "delta-1", "fault");
        }
        "unheard" => line.tick(at),
        result => ends(&mut line, first.id, result),
    }
    line.told();
    line.robot(at, "scara-2", "idle");
    line.tick(at + 0.01);
    assert_eq!(line.told(), ["task 2.0 scara-2 a"], "{how}");
    (line, first.id, 2)
}

const TAKEN: &str = "cancel 2 scara-2: another robot has picked the item";

#[test]
fn a_late_pick_calls_the_other_robot_back() {
    for end in ENDS {
        for is_acknowledged in [false, true] {
            for answer in ["CANCELLED", "MISSED", "GRASP_FAIL", "REJECTED", "PICKED"] {
                let case = format!("{end:?} {is_acknowledged} {answer}");
                let (mut line, first, second) = handed_over(end);
                let at = end.1 + 0.02;
                if is_acknowledged {
                    line.ack(at, second);
                }
                assert_eq!(line.status().claimed, 1, "{case}");
                line.result(at + 0.01, first, "PICKED");
                // At once, and to the one that is after the item only.
                assert_eq!(line.told(), [TAKEN], "{case}");
                let status = line.status();
                assert_eq!((status.picked, status.on_belt), (1, 0), "{case}");
                assert_eq!((status.claimed, &status.open_tasks[..]), (0, &[][..]));
                let own = &status.robots[0];
                assert_eq!((own.picked, own.missed, own.failed), (1, 0, 0), "{case}");
                line.result(at + 0.02, second, answer);
                let status = line.status();
                let other = &status.robots[1];
                let expected = match answer {
                    "PICKED" => (1, 0, 0),
                    "MISSED" => (0, 1, 0),
                    "GRASP_FAIL" => (0, 0, 1),
                    _ => (0, 0, 0),
                };
                assert_eq!(
                    (other.picked, other.missed, other.failed),
                    expected,
                    "{case}"
                );
                let twice = u64::from(answer == "PICKED");
                assert_eq!(
                    (status.picked, line.noted("picked_twice")),
                    (1, twice),
                    "{case}"
                );
                // Nobody is sent to it again, and it is counted nowhere else.
                for robot in ["delta-1", "scara-2", "arm-3"] {
                    line.robot(at + 1.0, robot, "idle");
                }
                line.tick(at + 60.0);
                assert_eq!(line.told(), [""; 0], "{case}");
                assert_eq!(line.status().missed.total(), 0, "{case}");
            }
        }
    }
}

/// A cancel that is under way already is not sent twice at once; its reason stays.
#[test]
fn a_late_pick_frees_a_robot_that_is_being_called_back() {
    let (mut line, first, _) = handed_over(ENDS[0]);
    line.say(r#""kind":"stop","stamp":100.6,"robot":"scara-2""#);
    let stopped = "cancel 2 scara-2: the operator has stopped it";
    assert_eq!(line.told(), [stopped]);
    assert_eq!(line.status().claimed, 1);
    line.result(100.7, first, "PICKED");
    assert_eq!(line.told(), [""; 0]);
    assert_eq!((line.status().picked, line.status().claimed), (1, 0));
    line.tick(101.6);
    assert_eq!(line.told(), [stopped]);
}

#[test]
fn a_robot_that_corrects_itself_is_called_back_from_its_next_task() {
    // What it has dropped it gets again after a second.
    for (result, next) in [
        ("MISSED", 100.5),
        ("GRASP_FAIL", 100.5),
        ("CANCELLED", 101.5),
    ] {
        let (mut line, first) = first_task();
        line.ack(100.01, first.id);
        line.result(100.5, first.id, result);
        if next > 100.5 {
            line.tick(next - 0.001);
            assert_eq!(line.told(), [""; 0]);
        }
        line.tick(next + 0.001);
        assert_eq!(line.told(), ["task 2.0 delta-1 a"]);
        line.ack(next + 0.002, 2);
        line.result(next + 0.01, first.id, "PICKED");
        let reason = "the item is picked, by an earlier task of this robot";
        assert_eq!(line.told(), [format!("cancel 2 delta-1: {reason}")]);
        let status = line.status();
        let own = &status.robots[0];
        assert_eq!((own.picked, own.missed, own.failed), (1, 0, 0), "{result}");
        assert_eq!((status.picked, line.noted("late_result")), (1, 1));
    }
}

/// Of a task that is over only `PICKED` corrects what was said, and nothing corrects a `PICKED`.
#[test]
fn what_a_later_result_of_one_task_changes() {
    // First result, second, and then the robot's picks, misses and failed grasps.
    let cases = [
        ("MISSED", "GRASP_FAIL", (0, 1, 0)),
        ("GRASP_FAIL", "MISSED", (0, 0, 1)),
        ("REJECTED", "MISSED", (0, 0, 0)),
        ("MISSED", "PICKED", (1, 0, 0)),
        ("GRASP_FAIL", "PICKED", (1, 0, 0)),
        ("PICKED", "MISSED", (1, 0, 0)),
        ("PICKED", "PICKED", (1, 0, 0)),
    ];
    for (one, other, expected) in cases {
        let (mut line, first) = first_task();
        ends(&mut line, first.id, one);
        line.result(100.6, first.id, other);
        let status = line.status();
        let own = &status.robots[0];
        let counts = (own.picked, own.missed, own.failed);
        assert_eq!(counts, expected, "{one} {other}");
        assert_eq!((status.picked, line.noted("late_result")), (expected.0, 1));
    }
    // One that was written off has said nothing yet: its first word counts, and only that.
    let (mut line, first) = first_task();
    line.ack(100.01, first.id);
    line.tick(110.0);
    assert_eq!(line.status().missed.no_result, 1);
    line.result(110.0, first.id, "MISSED");
    line.result(110.1, first.id, "GRASP_FAIL");
    let status = line.status();
    assert_eq!((status.robots[0].missed, status.robots[0].failed), (1, 0));
    assert_eq!(status.missed.no_result, 1);
}

/// An item of which one task was picked and is forgotten was picked twice by another.
#[test]
fn a_late_pick_of_an_item_that_is_gone_is_counted_for_its_robot() {
    let mut line = Three::new(0.3);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    let first = line.task();
    ends(&mut line, first.id, "MISSED");
    line.robot(100.5, "scara-2", "idle");
    line.tick(100.51);
    let second = line.task();
    line.ack(100.52, second.id);
    line.result(101.0, second.id, "PICKED");
    line.tick(130.0);
    line.result(130.0, first.id, "PICKED");
    let status = line.status();
    assert_eq!((status.picked, line.noted("picked_twice")), (1, 1));
    assert_eq!((status.robots[0].picked, status.robots[1].picked), (1, 1));
    assert_eq!(line.told(), ["task 2.0 scara-2 a"; 0]);
}

/// A late result is known by its task for a minute after the item has left the belt.
#[test]
fn how_long_a_late_result_is_taken() {
    // 1 m to 4.5 m, at 0.3 m/s.
    let gone = 100.0 + 3.5 / 0.3;
    for (at, is_known) in [(gone + 60.0, true), (gone + 60.1, false)] {
        let mut line = Three::new(0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.0, 0.0);
        line.tick(100.0);
        let task = line.task();
        line.ack(100.01, task.id);
        line.tick(gone + 0.05);
        line.tick(at);
        let late = format!(
            r#""kind":"result","stamp":{at},"task":{},"result":"PICKED""#,
            task.id
        );
        let taken = line.controller.handle(Three::message(&late));
        if is_known {
            taken.unwrap();
            assert_eq!(line.status().picked, 1);
        } else {
            let refused = taken.unwrap_err();
            assert_eq!(refused.reason, Rejection::UnknownTask);
            let expected = "there is no task 1; expected a task that was given recently";
            assert_eq!(refused.message, expected);
            assert_eq!(line.status().missed.no_result, 1);
            assert_eq!(line.status().rejected["unknown_task"], 1);
        }
    }
}

/// As long as a task is open its result counts, however long ago the item has left the belt:
/// one that the robot is at, and one that it was called back from and never answered.
#[test]
fn a_result_of_an_open_task_counts_however_late() {
    let gone = 100.0 + 3.5 / 0.3;
    for is_recalled in [false, true] {
        let config = config().with_result_timeout(500.0);
        let mut line = Three::with(config, 0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.0, 0.0);
        line.tick(100.0);
        let task = line.task();
        if is_recalled {
            line.robot(100.01, "delta-1", "fault");
        } else {
            line.ack(100.01, task.id);
        }
        for after in [0.05, 30.0, 59.0, 61.0, 90.0, 119.0] {
            line.tick(gone + after);
        }
        let lost = u64::from(is_recalled);
        let status = line.status();
        assert_eq!((status.missed.total(), status.claimed), (lost, 1 - lost));
        line.result(gone + 120.0, task.id, "PICKED");
        let status = line.status();
        assert_eq!((status.picked, status.robots[0].picked), (1, 1));
        assert_eq!((status.missed.total(), status.claimed), (0, 0));
    }
}

/// From the meeting on what lies in the item's place is another one, and from the result on
/// if that comes before.
#[test]
fn from_when_on_a_picked_item_is_not_on_the_belt() {
    // It meets the item at 100.133 s, or 0.1333 s after its start.
    for (result, picture, is_another) in [
        (100.5, 100.14, true),
        (100.5, 100.13, false),
        (100.05, 100.06, true),
        (100.05, 100.04, false),
    ] {
        let mut line = Three::new(0.0);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.0, 0.0);
        line.tick(100.0);
        let task = line.task();
        assert!((task.meet_at - 100.0 - 0.4 / 3.0).abs() < 1e-6);
        line.ack(100.01, task.id);
        line.result(result, task.id, "PICKED");
        line.say(&format!(
            r#""kind":"detection","stamp":{picture},"x":1.0,"y":0.0"#
        ));
        line.tick(100.6);
        let seen = 1 + u64::from(is_another);
        assert_eq!(line.status().seen, seen, "{result} {picture}");
    }
    // A pick that is reported late was one when it was reported.
    for (picture, seen) in [(100.69, 1), (100.71, 2)] {
        let (mut line, first) = first_task();
        ends(&mut line, first.id, "MISSED");
        line.result(100.7, first.id, "PICKED");
        line.say(&format!(
            r#""kind":"detection","stamp":{picture},"x":1.2,"y":0.0"#
        ));
        line.tick(100.8);
        assert_eq!(line.status().seen, seen, "{picture}");
    }
}

/// The stamps of the cancels of a task, with their reason and robot.
fn cancels(line: &mut Three) -> Vec<Cancel> {
    let said = std::mem::take(&mut line.said).into_iter();
    let cancels = said.filter_map(|message| match message {
        Outgoing::Cancel(cancel) => Some(cancel),
        _ => None,
    });
    cancels.collect()
}

#[test]
fn a_cancel_is_repeated_after_pauses_that_double_up_to_half_a_minute() {
    let pauses = |ack_timeout: f64, until: f64| {
        let config = config().with_ack_timeout(ack_timeout);
        let mut line = Three::with(config, 0.0);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.0, 0.0);
        line.tick(100.0);
        line.said();
        line.ack(100.0, 1);
        line.robot(100.0, "delta-1", "fault");
        line.tick(until);
        let cancels = cancels(&mut line);
        assert!(cancels.iter().all(|cancel| cancel.task == 1
            && cancel.robot == "delta-1"
            && cancel.reason == "the robot has reported a fault"));
        let stamps = cancels.iter().map(|cancel| cancel.stamp - 100.0);
        stamps.collect::<Vec<f64>>()
    };
    let doubled = [0.0, 1.0, 3.0, 7.0, 15.0, 31.0, 61.0, 91.0];
    assert_eq!(pauses(1.0, 200.0), doubled);
    assert_eq!(pauses(0.25, 104.0), [0.0, 0.25, 0.75, 1.75, 3.75]);
    // A longer timeout is kept.
    assert_eq!(pauses(40.0, 200.0), [0.0, 40.0, 80.0]);
}

/// An `ack` that crosses the cancel brings it again at once.
#[test]
fn a_late_ack_is_answered_by_the_cancel() {
    let (mut line, first) = first_task();
    line.robot(100.02, "delta-1", "fault");
    let cancel = "cancel 1 delta-1: the robot has reported a fault";
    assert_eq!(line.told(), [cancel]);
    line.tick(100.3);
    assert_eq!(line.told(), [""; 0]);
    line.ack(100.3, first.id);
    line.tick(100.3);
    assert_eq!(
        (line.told(), line.noted("late_ack")),
        (vec![cancel.to_owned()], 1)
    );
    line.result(100.4, first.id, "CANCELLED");
    assert_eq!(line.noted("late_result"), 1);
    // Of a task that is over it is counted only.
    line.ack(100.5, first.id);
    line.tick(110.0);
    assert_eq!((line.told(), line.noted("late_ack")), (vec![], 2));
    let unknown = line
        .controller
        .handle(Three::message(r#""kind":"ack","stamp":110,"task":9"#))
        .unwrap_err();
    assert_eq!(unknown.reason, Rejection::UnknownTask);
    assert_eq!(line.noted("late_ack"), 2);
}

/// An `ack` that comes after the cancel says that the robot has set out: what became of the
/// item is not known if nothing else comes.
#[test]
fn what_was_acknowledged_late_is_written_off_in_the_end() {
    for is_late in [false, true] {
        let (mut line, first) = first_task();
        line.say(r#""kind":"stop","stamp":100.05"#);
        if is_late {
            line.ack(100.06, first.id);
        }
        // The answer is overdue 5 s after the robot should be back.
        line.tick(first.free_at + 4.99);
        assert_eq!(line.status().claimed, 1);
        line.tick(first.free_at + 5.01);
        let status = line.status();
        let (lost, free) = (status.missed.no_result, status.on_belt);
        let late = u64::from(is_late);
        assert_eq!((status.claimed, lost, free), (0, late, 1 - late));
        assert_eq!(line.noted("result_timeout"), late);
        assert_eq!(line.noted("ack_timeout"), 1 - late);
        assert_eq!(status.robots[0].state, "silent");
        let owes = if is_late {
            "has not reported the result of its task"
        } else {
            "has not acknowledged its task"
        };
        let remark =
            format!("robot `delta-1` {owes}: it gets no further task until it is heard again");
        assert_eq!(line.controller.take_remarks(), [remark]);
    }
}

/// What was recalled is moot `--result-timeout` after its last start, or its end if that is
/// later.
#[test]
fn until_when_a_cancel_is_repeated() {
    // The item leaves the reach of `delta-1`, 0.5657 m from its base at y = 0.2, at 1.5657 m.
    let close = |x: f64| (1.565_685 - x) / 0.3 - 0.565_685_f64.hypot(0.6) / 3.0;
    for (x, early, is_open) in [
        (1.2, 0.01, true),
        (1.2, -0.01, false),
        (1.45, 0.01, true),
        (1.45, -0.01, false),
    ] {
        let mut line = Three::new(0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", x, 0.2);
        line.tick(100.0);
        let task = line.task();
        assert!((task.latest_start - 100.0 - close(x)).abs() < 1e-4);
        assert_eq!(task.free_at > task.latest_start, x > 1.4);
        let moot = task.latest_start.max(task.free_at) + 5.0;
        line.ack(100.01, task.id);
        line.robot(100.02, "delta-1", "fault");
        line.tick(moot - early);
        line.told();
        line.controller.send_open_tasks();
        let said = line.controller.take_output();
        assert_eq!(said.len(), usize::from(is_open));
        // Its result counts even so.
        line.result(moot + 0.1, task.id, "PICKED");
        assert_eq!(line.status().picked, 1);
    }
}

/// A correction takes one miss back, not all.
#[test]
fn a_correction_takes_one_miss_back() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    for (id, x) in [("a", 0.9), ("b", 1.0), ("c", 1.1)] {
        line.see(100.0, id, x, 0.0);
    }
    let mut tasks = Vec::new();
    for _ in 0..3 {
        line.tick(100.0);
        let task = line.task();
        line.result(100.0, task.id, "MISSED");
        tasks.push(task.id);
    }
    line.result(100.1, tasks[0], "PICKED");
    let status = line.status();
    assert_eq!((status.robots[0].picked, status.robots[0].missed), (1, 2));
}

/// An item that is free again and was picked after all is offered to nobody.
#[test]
fn a_free_item_that_was_picked_after_all_is_offered_to_nobody() {
    for result in ["MISSED", "GRASP_FAIL", "REJECTED", "CANCELLED"] {
        let (mut line, first) = first_task();
        ends(&mut line, first.id, result);
        line.result(100.6, first.id, "PICKED");
        line.robot(100.7, "scara-2", "idle");
        line.tick(103.0);
        assert_eq!(line.told(), [""; 0], "{result}");
        assert_eq!(line.status().robots[1].state, "idle", "{result}");
        assert_eq!(line.noted("illegal_action"), 0);
    }
}
