//! What the live node does with news, one behaviour at a time, message by message.

use crate::support::line::Line;
use pickline_live::protocol::{Rejection, Task};

#[test]
fn positions_follow_from_stamps_not_from_arrival() {
    let mut line = Line::new();
    line.idle(10.0);
    line.see(2.0, "a", 0.8, -0.2);
    let task = line.task(10.0);
    assert_eq!((task.item.as_str(), task.robot.as_str()), ("a", "r1"));
    let expected = 0.8 + 0.05 * (task.meet_at - 2.0);
    assert!((task.meet.x - expected).abs() < 1e-12);
}

#[test]
fn detections_with_and_without_id_are_put_together() {
    let mut line = Line::new();
    line.see(0.0, "a", -3.0, 0.1);
    line.see(1.0, "a", -2.95, 0.1);
    let anonymous =
        |stamp: f64, x: f64| format!(r#""kind":"detection","stamp":{stamp},"x":{x},"y":0.1"#);
    line.say(&anonymous(2.0, -2.905));
    assert_eq!(line.status().seen, 1);
    // Two in one picture are two, however near; said again they are the same.
    line.say(&anonymous(3.0, -4.0));
    line.say(&anonymous(3.0, -3.99));
    line.say(&anonymous(3.0, -3.99));
    assert_eq!(line.status().seen, 3);
    // Older than what is known: it changes nothing.
    line.see(0.5, "a", -2.97, 0.1);
    let status = line.status();
    assert_eq!((status.seen, status.noted["late_detection"]), (3, 1));
    let off = line.refused(&anonymous(3.0, 5.0));
    assert_eq!(off, Rejection::OffBelt);
    let robot = line.refused(r#""kind":"robot","stamp":3,"name":"r7","state":"idle""#);
    assert_eq!(robot, Rejection::UnknownRobot);
    let task = line.refused(r#""kind":"result","stamp":3,"task":9,"result":"PICKED""#);
    assert_eq!(task, Rejection::UnknownTask);
}

#[test]
fn a_task_without_ack_is_sent_again_and_never_twice_given() {
    let mut line = Line::new();
    line.see(0.0, "a", 1.0, -0.2);
    let first = line.task(0.0);
    let again = line.task(1.0);
    assert_eq!((again.id, again.revision), (first.id, 1));
    assert!(again.start == 1.0 && again.meet.x > first.meet.x);
    // Until it is too late for it; then the robot is told, and its answer awaited.
    let (tasks, cancelled) = line.tick(first.latest_start + 1.0);
    assert!(!tasks.is_empty() && tasks.iter().all(|task| task.id == first.id));
    assert_eq!(cancelled, [first.id]);
    assert_eq!(line.status().claimed, 1);
    // It had it all the time.
    line.result(first.latest_start + 1.5, first.id, "PICKED");
    assert_eq!(line.status().picked, 1);
}

/// Every sending has a whole ack timeout, and the last one before `latest_start` is no
/// exception: a robot that sets out at the last moment has an answer under way by then.
#[test]
fn a_task_is_sent_again_until_its_last_start_and_cancelled_at_the_end_of_a_timeout() {
    let mut line = Line::new();
    line.see(0.0, "a", 1.775, -0.2);
    let first = line.task(0.0);
    let last = first.latest_start;
    assert!(
        last > 1.0 && last.fract() > 0.1 && last.fract() < 0.9,
        "{first:?}"
    );
    let (tasks, cancelled) = line.tick(last);
    let sent: Vec<(u32, f64)> = tasks.iter().map(|t| (t.revision, t.start)).collect();
    let expected: Vec<(u32, f64)> = (1..=last as u32).map(|n| (n, f64::from(n))).collect();
    assert_eq!((sent, cancelled), (expected, vec![]));
    // Its last start has passed; the ack of the last sending may still come.
    let next = last.ceil();
    line.idle(next - 0.01);
    let mut heard = Line::new();
    heard.see(0.0, "a", 1.775, -0.2);
    heard.tick(next - 0.01);
    heard.ack(next - 0.01, first.id);
    heard.idle(next + 1.0);
    heard.result(next + 1.0, first.id, "PICKED");
    assert_eq!(heard.status().picked, 1);
    // Or not.
    assert_eq!(line.tick(next), (vec![], vec![first.id]));
    line.result(next + 0.1, first.id, "CANCELLED");
    let status = line.status();
    assert_eq!((status.claimed, status.on_belt), (0, 1));
}

#[test]
fn what_was_never_acknowledged_returns_and_its_robot_is_left_alone() {
    let mut line = Line::new();
    // Both robots can reach the middle of the belt.
    line.see(0.0, "a", 1.7, 0.0);
    let first = line.task(0.0);
    assert_eq!(first.robot, "r1");
    let (tasks, _) = line.tick(60.0);
    let others: Vec<&Task> = tasks.iter().filter(|task| task.id != first.id).collect();
    assert!(
        !others.is_empty() && others.iter().all(|task| task.robot == "r2"),
        "{tasks:?}"
    );
    let status = line.status();
    assert_eq!(
        (status.robots[0].state.as_str(), status.noted["ack_timeout"]),
        ("silent", 2)
    );
    line.say(r#""kind":"robot","stamp":60,"name":"r1","state":"idle""#);
    line.see(60.0, "b", 1.3, -0.3);
    assert!(
        line.tick(60.0)
            .0
            .iter()
            .any(|task| task.item == "b" && task.robot == "r1")
    );
}

#[test]
fn a_result_that_never_comes_is_written_off_and_still_counts_late() {
    let mut line = Line::new();
    line.see(0.0, "a", 1.0, -0.2);
    let task = line.task(0.0);
    line.ack(0.0, task.id);
    line.idle(task.free_at + 4.9);
    assert_eq!(line.status().claimed, 1);
    line.idle(task.free_at + 5.1);
    assert_eq!(line.status().missed.no_result, 1);
    line.result(task.free_at + 6.0, task.id, "PICKED");
    let status = line.status();
    assert_eq!((status.picked, status.missed.total()), (1, 0));
}

#[test]
fn failed_grasps_return_until_the_item_is_given_up() {
    let mut line = Line::new();
    line.see(0.0, "a", 0.8, -0.2);
    let mut time = 0.0;
    for _ in 0..3 {
        let task = line.task(time);
        line.ack(time, task.id);
        time = task.free_at;
        line.result(time, task.id, "GRASP_FAIL");
    }
    line.idle(time);
    assert_eq!(line.status().missed.grasp_failed, 1);
    line.see(time, "b", 1.0, -0.2);
    let task = line.task(time);
    line.result(time, task.id, "REJECTED");
    // Not offered to r1 again, and out of r2's reach.
    line.idle(time + 70.0);
    assert_eq!(line.status().missed.passed_over, 1);
}

#[test]
fn a_fault_returns_the_claim_and_recovery_puts_back_to_work() {
    let mut line = Line::new();
    line.see(0.0, "a", 1.0, -0.2);
    let task = line.task(0.0);
    line.ack(0.0, task.id);
    line.say(r#""kind":"robot","stamp":0.5,"name":"r1","state":"fault""#);
    assert_eq!(line.tick(0.5), (vec![], vec![task.id]));
    assert_eq!(line.status().on_belt, 1);
    // It has not answered, so it is asked again.
    let (tasks, cancelled) = line.tick(5.0);
    assert_eq!((tasks, cancelled), (vec![], vec![task.id, task.id]));
    line.result(5.0, task.id, "CANCELLED");
    line.say(r#""kind":"robot","stamp":6,"name":"r1","state":"idle""#);
    let again = line.task(6.0);
    assert_eq!((again.item.as_str(), again.id), ("a", task.id + 1));
    // From the meeting on the item may be in the gripper.
    line.ack(6.0, again.id);
    let late = again.meet_at + 0.01;
    line.say(&format!(
        r#""kind":"robot","stamp":{late},"name":"r1","state":"fault""#
    ));
    assert_eq!(line.status().missed.no_result, 1);
}

#[test]
fn a_belt_that_stops_moves_the_meeting_point() {
    let mut line = Line::new();
    line.say(r#""kind":"belt","stamp":0,"speed":0.05,"position":7"#);
    line.see(0.0, "a", 1.0, 0.0);
    line.see(0.0, "b", -1.0, -0.2);
    let task = line.task(0.0);
    line.ack(0.0, task.id);
    line.say(r#""kind":"belt","stamp":0.5,"speed":0,"position":7.025"#);
    let moved = line.task(0.5);
    assert_eq!((moved.id, moved.revision), (task.id, 1));
    assert!((moved.meet.x - 1.025).abs() < 1e-5, "{moved:?}");
    line.result(moved.free_at, task.id, "PICKED");
    // What is out of reach stays there while the belt stands, and comes when it moves.
    line.idle(300.0);
    line.say(r#""kind":"belt","stamp":300,"speed":0.05,"position":7.025"#);
    line.idle(330.0);
    assert_eq!(line.task(331.0).item, "b");
    // Backwards, or faster than the arms, nothing is given.
    for speed in ["-0.05", "0.6"] {
        let mut line = Line::new();
        line.say(&format!(r#""kind":"belt","stamp":0,"speed":{speed}"#));
        line.see(0.0, "a", 1.0, -0.2);
        line.idle(0.5);
    }
}

#[test]
fn robots_free_sooner_or_later_than_expected() {
    let mut line = Line::new();
    line.see(0.0, "a", 1.0, -0.2);
    line.see(0.0, "b", 0.9, -0.2);
    let first = line.task(0.0);
    // Before it has heard of its task, `idle` is old news.
    line.say(r#""kind":"robot","stamp":0.1,"name":"r1","state":"idle""#);
    line.idle(0.1);
    line.ack(0.2, first.id);
    line.say(&format!(
        r#""kind":"robot","stamp":0.5,"name":"r1","state":"idle","task":{}"#,
        first.id
    ));
    let second = line.task(0.5);
    assert_ne!(second.item, first.item);
    line.ack(0.5, second.id);
    line.result(0.6, first.id, "PICKED");
    line.see(0.6, "c", 0.9, -0.3);
    line.idle(second.free_at + 3.0);
    line.result(second.free_at + 3.0, second.id, "PICKED");
    assert_eq!(line.task(second.free_at + 3.0).item, "c");
    assert_eq!(line.status().picked, 2);
}

/// A robot at fault gets no task because word of its better days came late. A fault counts
/// even if it comes late.
#[test]
fn old_messages_of_a_robot_do_not_count() {
    let mut line = Line::new();
    line.say(r#""kind":"robot","stamp":10,"name":"r1","state":"fault""#);
    line.see(10.0, "a", 1.0, -0.2);
    line.say(r#""kind":"robot","stamp":9.9,"name":"r1","state":"idle""#);
    line.idle(10.5);
    assert_eq!(line.status().noted["late_robot"], 1);
    line.say(r#""kind":"robot","stamp":11,"name":"r1","state":"idle""#);
    line.say(r#""kind":"robot","stamp":10.8,"name":"r1","state":"fault""#);
    line.idle(11.0);
    line.say(r#""kind":"robot","stamp":11.1,"name":"r1","state":"idle""#);
    assert_eq!(line.task(11.1).item, "a");
}

/// What a result has announced holds until the robot says something newer.
#[test]
fn an_idle_after_a_result_ends_the_wait_that_it_announced() {
    let tries = [
        // When the robot says that it is idle, from when on, and when it gets its next task.
        (2.5, None, 2.6),
        (2.5, Some(4.0), 4.0),
        (2.0, None, 10.0),
        (1.9, None, 10.0),
        (1.9, Some(1.9), 10.0),
    ];
    for (stamp, available, next) in tries {
        let mut line = Line::new();
        line.see(0.0, "a", 1.0, -0.2);
        let first = line.task(0.0);
        line.ack(0.0, first.id);
        line.see(0.0, "b", 0.9, -0.2);
        line.say(&format!(
            r#""kind":"result","stamp":2,"task":{},"result":"PICKED","available_at":10"#,
            first.id
        ));
        line.idle(2.6);
        let available =
            available.map_or(String::new(), |at: f64| format!(r#","available_at":{at}"#));
        line.say(&format!(
            r#""kind":"robot","stamp":{stamp},"name":"r1","state":"idle"{available}"#
        ));
        let (tasks, _) = line.tick(10.0);
        let task = &tasks[0];
        assert_eq!((task.item.as_str(), task.start), ("b", next), "{stamp}");
        let late = u64::from(stamp < 2.0);
        assert_eq!(
            line.status().noted.get("late_robot").copied().unwrap_or(0),
            late
        );
    }
    // In whichever order the two come: an older result does not undo what was said since.
    let mut line = Line::new();
    line.see(0.0, "a", 1.0, -0.2);
    let first = line.task(0.0);
    line.ack(0.0, first.id);
    line.see(0.0, "b", 0.9, -0.2);
    line.say(r#""kind":"robot","stamp":2.1,"name":"r1","state":"busy","available_at":3"#);
    line.say(&format!(
        r#""kind":"result","stamp":2,"task":{},"result":"PICKED","available_at":10"#,
        first.id
    ));
    assert_eq!(line.tick(10.0).0[0].start, 3.0);
}

/// A robot that is busy before its result is not busy after it.
#[test]
fn an_old_busy_does_not_take_a_robot_out_of_work() {
    let mut line = Line::new();
    line.see(0.0, "a", 1.0, -0.2);
    let first = line.task(0.0);
    line.ack(0.0, first.id);
    line.see(0.0, "b", 0.9, -0.2);
    line.result(2.0, first.id, "PICKED");
    line.say(r#""kind":"robot","stamp":1.9,"name":"r1","state":"busy""#);
    assert_eq!(line.task(2.0).item, "b");
}

/// A robot that is free sooner than it had said still has the items whose windows would have
/// closed by then.
#[test]
fn a_robot_that_is_free_early_has_lost_no_item() {
    let mut line = Line::new();
    line.say(r#""kind":"robot","stamp":0,"name":"r1","state":"busy","available_at":30"#);
    line.see(0.0, "a", 0.7, -0.2);
    line.idle(4.0);
    line.say(r#""kind":"robot","stamp":5,"name":"r1","state":"idle","available_at":5"#);
    assert_eq!(line.task(5.0).item, "a");
}

#[test]
fn memory_is_flat_over_many_items() {
    let mut line = Line::new();
    line.say(r#""kind":"belt","stamp":0,"speed":0.4"#);
    for i in 0..100_000u32 {
        let stamp = 0.01 * f64::from(i);
        line.see(stamp, &i.to_string(), 0.0, 0.4 - 0.1 * f64::from(i % 9));
        if i % 100 == 0 {
            line.tick(stamp);
            let status = line.status();
            // 10.5 s on the belt and 1.25 s past its end, 100 items a second.
            let gone = status.picked + status.missed.total();
            assert!(status.on_belt + status.claimed <= 1100 && gone + 1100 >= status.seen);
        }
    }
    line.tick(1100.0);
    let status = line.status();
    assert_eq!((status.seen, status.on_belt), (100_000, 0));
}
