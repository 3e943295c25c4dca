//! How long what is waited for, and what follows: acknowledgements, results, robots that
//! cannot be reached, peers that come back, the end of the line.

use crate::support::three::{Three, config};
use pickline_live::protocol::{Outgoing, Task};

/// On a standing belt `delta-1` has a task of item `a`; it takes 0.3667 s.
fn sent() -> (Three, Task) {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    let task = line.task();
    let whole = 2.0 * (0.4 / 3.0 + 0.05);
    assert!((task.free_at - 100.0 - whole).abs() < 1e-6);
    (line, task)
}

fn tell_open(line: &mut Three) -> Vec<String> {
    line.controller.send_open_tasks();
    line.said.extend(line.controller.take_output());
    line.told()
}

fn send_again(line: &mut Three) -> Vec<String> {
    line.controller.send_again();
    line.said.extend(line.controller.take_output());
    line.told()
}

fn send_again_to(line: &mut Three, robot: usize) -> Vec<String> {
    line.controller.send_again_to(robot);
    line.said.extend(line.controller.take_output());
    line.told()
}

#[test]
fn what_nobody_acknowledges_is_sent_sixty_times() {
    let config = config().with_ack_timeout(0.5);
    let mut line = Three::with(config, 0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(129.99);
    let (tasks, cancels) = line.said();
    assert!(cancels.is_empty());
    // Once at first and 59 times again, each half a second after the one before.
    assert_eq!(tasks.len(), 60);
    for (number, task) in tasks.iter().enumerate() {
        assert_eq!((task.id, task.revision), (1, number as u32));
        assert_eq!(task.start, 100.0 + 0.5 * number as f64);
    }
    line.tick(130.0);
    let why = "no acknowledgement has come before the last start";
    assert_eq!(line.told(), [format!("cancel 1 delta-1: {why}")]);
    assert_eq!(line.status().claimed, 1);
    // It may have heard of it: the answer is waited for, 5 s from the cancel on.
    line.tick(134.99);
    assert_eq!((line.status().claimed, line.status().on_belt), (1, 0));
    line.tick(135.01);
    assert_eq!((line.status().claimed, line.status().on_belt), (0, 1));
    assert_eq!(
        (line.noted("ack_timeout"), line.noted("result_timeout")),
        (1, 0)
    );
    assert_eq!(line.status().robots[0].state, "silent");
}

#[test]
fn when_a_result_is_overdue() {
    for timeout in [5.0, 2.0] {
        let config = config().with_result_timeout(timeout);
        let mut line = Three::with(config, 0.0);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.0, 0.0);
        line.tick(100.0);
        let task = line.task();
        line.ack(100.2, task.id);
        let overdue = task.free_at + timeout;
        line.tick(overdue - 0.001);
        assert_eq!(
            (line.status().claimed, line.status().missed.total()),
            (1, 0)
        );
        assert!(line.controller.take_remarks().is_empty());
        line.tick(overdue + 0.001);
        let status = line.status();
        assert_eq!((status.claimed, status.missed.no_result), (0, 1));
        assert_eq!(status.robots[0].state, "silent");
        assert_eq!(line.noted("result_timeout"), 1);
        assert_eq!(
            line.controller.take_remarks(),
            [
                "robot `delta-1` has not reported the result of its task: it gets no further task \
                 until it is heard again"
            ]
        );
        line.see(overdue, "b", 1.1, 0.0);
        line.tick(overdue + 10.0);
        assert_eq!(line.told(), [""; 0]);
        line.robot(overdue + 10.0, "delta-1", "idle");
        line.tick(overdue + 10.0);
        assert_eq!(line.told(), ["task 2.0 delta-1 b"]);
    }
}

/// One that has begun its next task meanwhile is not silent: only the result of the first one is
/// not waited for.
#[test]
fn an_overdue_result_of_an_earlier_task_costs_no_robot_its_work() {
    let (mut line, first) = sent();
    line.ack(100.0, first.id);
    line.see(100.0, "b", 1.1, 0.0);
    line.say(r#""kind":"robot","stamp":100.2,"name":"delta-1","state":"idle","task":1"#);
    line.tick(100.2);
    assert_eq!(line.told(), ["task 2.0 delta-1 b"]);
    line.ack(104.0, 2);
    line.tick(105.4);
    let status = line.status();
    assert_eq!(
        (status.missed.no_result, &status.open_tasks[..]),
        (1, &[2][..])
    );
    assert_eq!(status.robots[0].state, "busy");
    assert!(line.controller.take_remarks().is_empty());
    assert_eq!(line.noted("result_timeout"), 1);
}

#[test]
fn nothing_is_sent_to_a_robot_that_cannot_be_reached() {
    let (mut line, _) = sent();
    line.see(100.0, "b", 1.1, 0.0);
    line.controller.hold(&[0]);
    line.tick(110.0);
    assert_eq!(line.told(), [""; 0]);
    // What was due meanwhile is sent when it is back, and only once.
    line.controller.hold(&[]);
    line.tick(110.0);
    assert_eq!(line.told(), ["task 1.1 delta-1 a"]);
    // Others work on.
    line.controller.hold(&[0]);
    line.robot(110.0, "scara-2", "idle");
    line.tick(110.0);
    assert_eq!(line.told(), ["task 2.0 scara-2 b"]);
    // A cancel is not repeated either.
    line.ack(110.0, 2);
    line.result(110.5, 2, "PICKED");
    line.say(r#""kind":"stop","stamp":110.6"#);
    assert_eq!(
        line.told(),
        ["cancel 1 delta-1: the operator has stopped it"]
    );
    line.tick(114.0);
    assert_eq!(line.told(), [""; 0]);
    // What follows from its silence follows all the same.
    line.tick(120.0);
    assert_eq!(line.noted("ack_timeout"), 1);
    assert_eq!(line.status().on_belt, 1);
}

/// A robot that cannot be reached gets nothing new, and nothing is left to it by the others.
#[test]
fn a_robot_that_cannot_be_reached_gets_no_task() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.controller.hold(&[0, 2]);
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    assert_eq!(line.told(), [""; 0]);
    line.controller.hold(&[2]);
    line.tick(100.0);
    assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
}

#[test]
fn a_new_peer_receives_open_tasks_as_they_are() {
    let (mut line, first) = sent();
    assert_eq!(tell_open(&mut line), ["task 1.0 delta-1 a"]);
    line.ack(100.1, first.id);
    assert_eq!(tell_open(&mut line), ["task 1.0 delta-1 a"]);
    line.say(r#""kind":"stop","stamp":100.1"#);
    let cancel = "cancel 1 delta-1: the operator has stopped it";
    assert_eq!(line.told(), [cancel]);
    assert_eq!(tell_open(&mut line), [cancel]);
    // It changes nothing: neither when the cancel is repeated nor for how long it is waited.
    line.tick(101.09);
    assert_eq!(line.told(), [""; 0]);
    line.tick(101.1);
    assert_eq!(line.told(), [cancel]);
    // Recalled, it holds no item and is told of all the same.
    line.robot(101.2, "delta-1", "fault");
    assert_eq!(line.status().open_tasks, [0; 0]);
    assert_eq!(tell_open(&mut line), [cancel]);
    line.result(101.3, first.id, "CANCELLED");
    assert_eq!(tell_open(&mut line), [""; 0]);
}

/// Whoever speaks for all robots is another one: what was not acknowledged is sent as things
/// are now, the rest as it stands, and cancels.
#[test]
fn a_peer_for_all_robots_receives_all_again() {
    let (mut line, first) = sent();
    line.robot(100.1, "scara-2", "idle");
    line.see(100.1, "b", 1.7, 0.0);
    line.tick(100.1);
    line.told();
    line.ack(100.2, 2);
    // The one that was not acknowledged comes with the next step of time.
    assert_eq!(send_again(&mut line), ["task 2.0 scara-2 b"]);
    line.tick(100.2);
    assert_eq!(line.told(), ["task 1.1 delta-1 a"]);
    line.say(r#""kind":"stop","stamp":100.3,"robot":"delta-1""#);
    let cancel = "cancel 1 delta-1: the operator has stopped it";
    assert_eq!(line.told(), [cancel]);
    assert_eq!(send_again(&mut line), [cancel, "task 2.0 scara-2 b"]);
    // A sending counts as a cancel: the next one is two ack timeouts later.
    line.tick(102.29);
    assert_eq!(line.told(), [""; 0]);
    line.tick(102.3);
    assert_eq!(line.told(), [cancel]);
    line.result(102.4, first.id, "CANCELLED");
    line.result(102.4, 2, "PICKED");
    assert_eq!(send_again(&mut line), [""; 0]);
}

/// One that speaks for one robot is sent what is that robot's, but for what it has
/// acknowledged.
#[test]
fn a_peer_for_one_robot_receives_only_its_messages() {
    for (robot, acknowledged) in [(0, false), (0, true), (1, false), (1, true)] {
        let (mut line, first) = sent();
        line.robot(100.1, "scara-2", "idle");
        line.see(100.1, "b", 1.7, 0.0);
        line.tick(100.1);
        line.told();
        if acknowledged {
            line.ack(100.1, first.id);
            line.ack(100.1, 2);
        }
        assert_eq!(send_again_to(&mut line, robot), [""; 0]);
        line.tick(100.2);
        let expected = match (robot, acknowledged) {
            (_, true) => vec![],
            (0, _) => vec!["task 1.1 delta-1 a"],
            _ => vec!["task 2.1 scara-2 b"],
        };
        assert_eq!(line.told(), expected, "{robot} {acknowledged}");
        if acknowledged {
            continue;
        }
        line.say(r#""kind":"stop","stamp":100.2"#);
        line.told();
        let cancel = if robot == 0 {
            "cancel 1 delta-1: the operator has stopped it"
        } else {
            "cancel 2 scara-2: the operator has stopped it"
        };
        assert_eq!(send_again_to(&mut line, robot), [cancel]);
    }
}

/// Somebody is there again to hear it: sixty sendings are counted from then on.
#[test]
fn sendings_are_counted_once_a_peer_is_connected() {
    let (mut line, _) = sent();
    line.tick(150.5);
    assert_eq!(line.said().0.len(), 50);
    send_again(&mut line);
    line.tick(200.0);
    let (tasks, cancels) = line.said();
    assert!(cancels.is_empty());
    assert_eq!(tasks.last().unwrap().revision, 100);
    line.tick(209.4);
    assert_eq!(line.said().1, []);
    line.tick(209.5);
    assert_eq!(line.said().1.len(), 1);
}

/// A peer that is back has a whole result timeout for the results that it owes; however often
/// it comes, it is twelve at most.
#[test]
fn results_are_waited_for_again_when_a_peer_is_back() {
    let back = |line: &mut Three, whom: Option<usize>| match whom {
        None => line.controller.send_again(),
        Some(robot) => line.controller.send_again_to(robot),
    };
    // Whose peer is back, and whether that is for this robot.
    for (whom, waits) in [(None, true), (Some(0), true), (Some(1), false)] {
        let (mut line, task) = sent();
        line.ack(100.0, task.id);
        line.tick(103.0);
        back(&mut line, whom);
        let overdue = if waits { 108.0 } else { task.free_at + 5.0 };
        line.tick(overdue - 0.01);
        assert_eq!(line.status().claimed, 1, "{whom:?}");
        line.tick(overdue + 0.01);
        assert_eq!(line.status().missed.no_result, 1, "{whom:?}");
    }
    // It is never less than it was before.
    let (mut line, task) = sent();
    line.ack(100.0, task.id);
    line.controller.send_again();
    line.tick(task.free_at + 4.99);
    assert_eq!(line.status().claimed, 1);
    line.tick(task.free_at + 5.01);
    assert_eq!(line.status().claimed, 0);
    // A connection of which nothing was heard is told, and nothing is waited for.
    let (mut line, task) = sent();
    line.ack(100.0, task.id);
    line.tick(103.0);
    line.controller.repeat();
    line.said.extend(line.controller.take_output());
    assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
    line.tick(task.free_at + 5.01);
    assert_eq!(line.status().claimed, 0);
    // Every second for ever.
    let (mut line, task) = sent();
    line.ack(100.0, task.id);
    let latest = task.free_at + 60.0;
    for second in 101..170 {
        line.tick(f64::from(second));
        line.controller.send_again();
        let is_open = line.status().claimed == 1;
        assert_eq!(is_open, f64::from(second) < latest, "{second}");
    }
}

/// When the line ends, no task is given.
#[test]
fn a_line_that_ends_gives_nothing_new() {
    let (mut line, task) = sent();
    line.see(100.1, "b", 1.1, 0.0);
    line.robot(100.1, "scara-2", "idle");
    line.controller.stop();
    line.said.extend(line.controller.take_output());
    assert_eq!(line.told(), [""; 0]);
    line.tick(100.9);
    assert_eq!(line.told(), [""; 0]);
    line.result(100.9, task.id, "PICKED");
    line.controller.report(true, 7);
    line.said.extend(line.controller.take_output());
    let Some(Outgoing::Status(status)) = line.said.pop() else {
        panic!("no status");
    };
    assert!(status.last);
    assert_eq!((status.picked, status.on_belt, status.queued), (1, 1, 7));
}
