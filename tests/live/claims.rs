//! What robots report, in any order: results stay, a fault wins, cancels are repeated, and
//! an item has one claim at most.

use crate::support::three::{ROBOTS, Three, config, station, strategy};
use pickline_live::{Controller, LineState};
use std::collections::BTreeMap;

/// `delta-1` has acknowledged its task of item `a`, 1 m from the belt's start.
fn one_task(speed: f64) -> (Three, u64) {
    let mut line = Three::new(speed);
    line.robot(100.0, "delta-1", "idle");
    line.tick(100.0);
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    let task = line.task();
    assert_eq!(task.robot, "delta-1");
    line.ack(100.01, task.id);
    (line, task.id)
}

/// Lets time pass and asserts that nobody is sent to the item.
fn never_again(line: &mut Three, from: f64) {
    let picked = line.status().picked;
    for step in 1..200 {
        let now = from + 0.25 * f64::from(step);
        for robot in ROBOTS {
            line.robot(now, robot, "idle");
        }
        line.tick(now);
        let (tasks, _) = line.said();
        assert!(tasks.is_empty(), "{tasks:?}");
        assert!(line.status().picked >= picked);
    }
}

#[test]
fn picked_items_are_never_offered_again() {
    // Out of service before it met the item, and had it all the same; the other robot is
    // called back and obeys.
    let (mut line, first) = one_task(0.0);
    line.robot(100.02, "delta-1", "fault");
    line.robot(100.03, "scara-2", "idle");
    line.tick(100.04);
    let second = line.task();
    assert_eq!(
        (second.robot.as_str(), second.item.as_str()),
        ("scara-2", "a")
    );
    line.ack(100.05, second.id);
    line.result(100.06, first, "PICKED");
    line.tick(100.07);
    let (_, cancels) = line.said();
    assert!(
        cancels
            .iter()
            .any(|(task, why)| *task == second.id && why.contains("another robot")),
        "{cancels:?}"
    );
    line.result(100.08, second.id, "CANCELLED");
    assert_eq!(line.status().picked, 1);
    assert_eq!(line.status().robots[0].picked, 1);
    never_again(&mut line, 101.0);
}

#[test]
fn the_other_robot_need_not_answer() {
    let (mut line, first) = one_task(0.0);
    line.robot(100.02, "delta-1", "fault");
    line.robot(100.03, "scara-2", "idle");
    line.tick(100.04);
    let second = line.task();
    line.result(100.06, first, "PICKED");
    // Its claim runs out; it was never acknowledged.
    for step in 1..60 {
        line.tick(100.06 + f64::from(step));
        let (tasks, _) = line.said();
        assert!(tasks.iter().all(|t| t.id == second.id), "{tasks:?}");
    }
    assert!(line.status().open_tasks.is_empty());
    assert_eq!(line.status().picked, 1);
    never_again(&mut line, 161.0);
}

#[test]
fn a_robot_may_correct_itself() {
    let (mut line, first) = one_task(0.0);
    line.result(101.0, first, "MISSED");
    line.robot(101.0, "delta-1", "idle");
    line.tick(101.0);
    let second = line.task();
    let status = line.status();
    assert_eq!((status.robots[0].missed, status.robots[0].failed), (1, 0));
    line.ack(101.01, second.id);
    line.result(101.02, first, "PICKED");
    line.tick(101.03);
    line.result(101.04, second.id, "CANCELLED");
    let status = line.status();
    assert_eq!((status.picked, status.robots[0].missed), (1, 0));
    never_again(&mut line, 102.0);
}

#[test]
fn a_result_counts_after_its_item_has_left_the_belt() {
    let (mut line, first) = one_task(0.3);
    line.tick(130.0);
    let status = line.status();
    assert_eq!((status.missed.no_result, status.on_belt), (1, 0));
    line.result(131.0, first, "PICKED");
    let status = line.status();
    assert_eq!((status.picked, status.missed.total()), (1, 0));
    assert_eq!(status.robots[0].picked, 1);
    // Once more it counts as once.
    line.result(132.0, first, "PICKED");
    assert_eq!(line.status().picked, 1);
}

#[test]
fn two_robots_that_have_both_picked_it_are_seen() {
    let (mut line, first) = one_task(0.0);
    line.robot(100.02, "delta-1", "fault");
    line.robot(100.03, "scara-2", "idle");
    line.tick(100.04);
    let second = line.task();
    line.ack(100.05, second.id);
    line.result(101.0, second.id, "PICKED");
    line.result(101.1, first, "PICKED");
    let status = line.status();
    assert_eq!((status.picked, status.noted["picked_twice"]), (1, 1));
}

#[test]
fn a_late_result_counts_as_a_message_of_a_silent_robot() {
    let (mut line, first) = one_task(0.0);
    line.tick(110.0);
    assert_eq!(line.status().robots[0].state, "silent");
    line.result(110.5, first, "MISSED");
    let status = line.status();
    assert_eq!(
        (status.robots[0].state.as_str(), status.robots[0].missed),
        ("idle", 1)
    );
}

#[test]
fn a_fault_wins_and_stands_until_the_robot_says_otherwise_since() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.robot(100.5, "delta-1", "idle");
    // Stamped before, by another sender, and comes later.
    line.robot(100.3, "delta-1", "fault");
    line.see(100.5, "a", 1.0, 0.0);
    line.tick(100.6);
    assert_eq!(line.said(), (vec![], vec![]));
    assert_eq!(line.status().robots[0].state, "fault");
    // Nothing that is not newer than all of that ends it.
    for (stamp, state) in [(100.4, "idle"), (100.5, "idle"), (100.5, "busy")] {
        line.robot(stamp, "delta-1", state);
        line.tick(100.6);
        assert_eq!(line.status().robots[0].state, "fault", "{stamp} {state}");
    }
    line.robot(100.7, "delta-1", "idle");
    line.tick(100.7);
    assert_eq!(line.task().robot, "delta-1");
}

#[test]
fn a_fault_wins_over_a_task_that_was_given_since() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.2, "a", 1.0, 0.0);
    line.tick(100.2);
    let task = line.task();
    line.ack(100.21, task.id);
    line.robot(100.1, "delta-1", "fault");
    line.tick(100.25);
    let (_, cancels) = line.said();
    assert_eq!(cancels.len(), 1);
    assert_eq!((cancels[0].0, line.status().on_belt), (task.id, 1));
}

#[test]
fn a_cancel_is_repeated_until_it_is_answered() {
    let (mut line, task) = one_task(0.0);
    line.robot(100.02, "delta-1", "fault");
    let mut times = Vec::new();
    for step in 0..400 {
        let now = 100.02 + 0.1 * f64::from(step);
        line.tick(now);
        let (_, cancels) = line.said();
        assert!(
            cancels
                .iter()
                .all(|(of, why)| *of == task && why.contains("fault"))
        );
        times.extend(cancels.iter().map(|_| now - 100.02));
    }
    // At once, and then after pauses that grow.
    assert!(times.len() >= 5 && times[0] == 0.0, "{times:?}");
    let pauses: Vec<f64> = times.windows(2).map(|w| w[1] - w[0]).collect();
    assert!(pauses.is_sorted_by(|a, b| *a <= *b + 0.11), "{pauses:?}");
    // Whoever connects hears of it as well.
    line.controller.send_again();
    line.said.extend(line.controller.take_output());
    assert_eq!(line.said().1.len(), 1);
    line.result(141.0, task, "CANCELLED");
    line.tick(150.0);
    line.controller.send_again();
    line.said.extend(line.controller.take_output());
    assert_eq!(line.said(), (vec![], vec![]));
}

#[test]
fn a_cancel_is_repeated_until_it_is_pointless_and_across_a_restart() {
    let (mut line, task) = one_task(0.3);
    let mut state = LineState::default();
    state.apply(line.controller.whole());
    line.robot(100.02, "delta-1", "fault");
    state.apply(line.controller.change(true).unwrap());
    line.controller = Controller::restore(station(), strategy(), config(), state, None).unwrap();
    line.said.clear();
    line.controller.send_again();
    line.say(r#""kind":"belt","stamp":100.1,"speed":0.3"#);
    assert_eq!(line.said().1.first().map(|(of, _)| *of), Some(task));
    // Its last start is long past in the end, and its item off the belt.
    line.tick(140.0);
    line.said();
    line.tick(300.0);
    assert_eq!(line.said(), (vec![], vec![]));
}

#[test]
fn a_robot_that_drops_its_tasks_gets_fewer_and_others_get_the_item() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.robot(100.0, "scara-2", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    let mut by_robot = BTreeMap::new();
    for step in 0..300 {
        let now = 100.0 + 0.01 * f64::from(step);
        line.tick(now);
        for task in line.said().0 {
            *by_robot.entry(task.robot).or_insert(0) += 1;
            line.ack(now, task.id);
            line.result(now, task.id, "CANCELLED");
        }
    }
    // The item goes to the other one at once, and back only after a pause.
    let total: i32 = by_robot.values().sum();
    assert!(by_robot.len() == 2 && total <= 6, "{by_robot:?}");
    assert_eq!(line.status().noted["task_cancelled"], total as u64);
}

#[test]
fn a_robot_that_drops_all_tasks_is_paused() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    for item in 0..40 {
        line.see(
            100.0,
            &format!("i{item}"),
            0.8 + 0.01 * f64::from(item),
            0.0,
        );
    }
    let mut given = 0;
    for step in 0..300 {
        let now = 100.0 + 0.01 * f64::from(step);
        line.tick(now);
        for task in line.said().0 {
            given += 1;
            line.result(now, task.id, "CANCELLED");
            // A word of being idle does not end the rest.
            line.robot(now, "delta-1", "idle");
        }
    }
    assert!(given <= 6, "{given}");
    assert_eq!(line.status().noted["robot_rested"], 1);
    let remarks = line.controller.take_remarks();
    assert!(
        remarks.iter().any(|remark| remark.contains("CANCELLED")),
        "{remarks:?}"
    );
}

#[test]
fn a_state_that_lags_behind_gets_no_second_task() {
    // Lags of less and of more than a task takes.
    for lag in [0.02, 0.06, 0.2, 0.5] {
        let mut line = Three::new(0.0);
        for item in 0..60 {
            line.see(
                100.0,
                &format!("i{item}"),
                0.8 + 0.01 * f64::from(item),
                -0.1,
            );
        }
        let mut history = vec![(0.0, "idle")];
        let mut open: Option<(u64, f64)> = None;
        let mut given = 0;
        for step in 0..500 {
            let now = 100.0 + 0.02 * f64::from(step);
            if let Some((task, until)) = open
                && now >= until
            {
                line.result(now, task, "PICKED");
                open = None;
                history.push((now, "idle"));
            }
            let state = history.iter().rev().find(|(since, _)| since + lag <= now);
            line.robot(now, "delta-1", state.map_or("idle", |(_, state)| state));
            line.tick(now);
            for task in line.said().0.iter().filter(|task| task.revision == 0) {
                assert_eq!(open, None, "lag {lag}, {now}");
                given += 1;
                line.ack(now, task.id);
                history.push((now, "busy"));
                open = Some((task.id, task.free_at));
            }
        }
        assert!(given > 8, "lag {lag}: {given}");
    }
}

#[test]
fn an_idle_with_the_task_is_believed_and_one_with_another_is_not() {
    let idle = |line: &mut Three, task: u64, stamp: f64| {
        line.say(&format!(
            r#""kind":"robot","stamp":{stamp},"name":"delta-1","state":"idle","task":{task}"#
        ));
    };
    let (mut line, task) = one_task(0.0);
    line.see(100.02, "b", 1.1, 0.0);
    idle(&mut line, 0, 100.03);
    line.tick(100.04);
    assert_eq!(line.said(), (vec![], vec![]));
    idle(&mut line, task, 100.05);
    line.tick(100.06);
    assert_eq!(line.task().item, "b");
    // What names its task while at work has understood it.
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    let task = line.task().id;
    line.say(&format!(
        r#""kind":"robot","stamp":100.1,"name":"delta-1","state":"busy","task":{task}"#
    ));
    line.tick(104.0);
    let (tasks, _) = line.said();
    assert!(tasks.is_empty(), "{tasks:?}");
}

#[test]
fn an_early_idle_counts_once_the_robot_should_be_done() {
    let (mut line, _) = one_task(0.0);
    line.see(100.02, "b", 1.1, 0.0);
    // Said once, and its result is lost.
    line.robot(100.1, "delta-1", "idle");
    line.tick(100.15);
    assert_eq!(line.said(), (vec![], vec![]));
    line.tick(102.0);
    assert_eq!(line.task().item, "b");
}

#[test]
fn a_task_that_nobody_acknowledges_is_not_kept_for_ever() {
    // On a standing belt its last start is days away.
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(100.0);
    let first = line.task();
    assert_eq!(first.robot, "delta-1");
    line.robot(100.5, "scara-2", "idle");
    let mut others = Vec::new();
    for step in 1..200 {
        line.tick(100.0 + f64::from(step));
        let tasks = line.said().0.into_iter();
        others.extend(
            tasks
                .filter(|task| task.id != first.id)
                .map(|task| task.robot),
        );
    }
    assert_eq!(others.first().map(String::as_str), Some("scara-2"));
    let remarks = line.controller.take_remarks().join("; ");
    assert!(
        remarks.contains("`delta-1` has not acknowledged"),
        "{remarks}"
    );
}

#[test]
fn a_miss_is_not_a_failed_grasp() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    for attempt in 0..3 {
        let now = 100.0 + f64::from(attempt);
        line.tick(now);
        let task = line.task();
        line.ack(now, task.id);
        line.result(now + 0.5, task.id, "MISSED");
    }
    let status = line.status();
    assert_eq!(
        (status.missed.not_found, status.missed.grasp_failed),
        (1, 0)
    );
    assert_eq!((status.robots[0].missed, status.robots[0].failed), (3, 0));
}

#[test]
fn a_cancel_says_what_happened() {
    let reason = |change: &str| {
        let mut line = Three::new(0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 0.2, 0.2);
        // Its window opens a while before it is within reach.
        line.tick(100.6);
        let task = line.task();
        assert!(task.decided_at > 100.4);
        line.ack(task.decided_at, task.id);
        line.say(change);
        line.tick(100.65);
        let (_, cancels) = line.said();
        assert_eq!(cancels.len(), 1, "{change}");
        cancels[0].1.clone()
    };
    let belt = |speed: f64| format!(r#""kind":"belt","stamp":100.6,"speed":{speed}"#);
    assert!(reason(&belt(0.0)).contains("stopped"));
    assert!(reason(&belt(-0.1)).contains("backwards"));
    assert!(reason(&belt(5.0)).contains("as fast as an arm"));
}
