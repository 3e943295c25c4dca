//! A task under way whose belt or item is not where it was expected: what is sent then, to
//! which place and time, and where the reach ends.
//!
//! What is expected is computed here from the geometry: `delta-1` has its base at (1, 0), its
//! bin at (1, -0.4), a reach of 0.6 m and an arm of 3 m/s, and grasps and releases in 0.05 s.

use crate::support::three::{Three, config, station_of_length, strategy};
use pickline_live::protocol::Task;

const BIN: [f64; 2] = [1.0, -0.4];
const ARM: f64 = 3.0;
const HOLDS: f64 = 0.05;

/// Time until an arm at `arm` meets an item at `item` that moves along x at `speed`.
fn time_to_meet(arm: [f64; 2], item: [f64; 2], speed: f64) -> f64 {
    // |d + (speed t, 0)| = ARM t.
    let (dx, dy) = (item[0] - arm[0], item[1] - arm[1]);
    let (a, b, c) = (
        ARM * ARM - speed * speed,
        -2.0 * speed * dx,
        -(dx * dx + dy * dy),
    );
    (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
}

/// The range of x within the reach along the line `y`, on a belt of this length.
fn reach(y: f64, length: f64) -> (f64, f64) {
    let half = (0.36 - y * y).sqrt();
    (1.0 - half, (1.0 + half).min(length))
}

/// Where the arm is at `now` on its way to where `task` sends it.
fn arm_at(task: &Task, now: f64) -> [f64; 2] {
    let share = ((now - task.start) / (task.meet_at - task.start)).clamp(0.0, 1.0);
    let meet = [task.meet.x, task.meet.y];
    [0, 1].map(|axis| BIN[axis] + (meet[axis] - BIN[axis]) * share)
}

fn near(value: f64, expected: f64, what: &str) {
    assert!(
        (value - expected).abs() < 2e-6,
        "{what}: {value}, not {expected}"
    );
}

/// Checks that `task` is the same as `before` for an arm that turns at `now` to an item that is
/// at `item` then, on a belt of `speed`.
fn turns(task: &Task, before: &Task, now: f64, item: [f64; 2], speed: f64) {
    assert_eq!((task.id, task.revision), (before.id, before.revision + 1));
    assert_eq!((&task.robot, &task.item), (&before.robot, &before.item));
    assert_eq!(
        (task.decided_at, task.start),
        (before.decided_at, before.start)
    );
    let leaves = now.max(before.start);
    let item = [item[0] + speed * (leaves - now), item[1]];
    let travel = time_to_meet(arm_at(before, now), item, speed);
    near(task.meet_at, leaves + travel, "meet_at");
    near(task.meet.x, item[0] + speed * travel, "meet.x");
    near(task.meet.y, item[1], "meet.y");
    let back = (task.meet.x - BIN[0]).hypot(task.meet.y - BIN[1]) / ARM;
    near(task.free_at, task.meet_at + 2.0 * HOLDS + back, "free_at");
    // When a robot in its bin would have to set out.
    let (low, high) = reach(item[1], 4.0);
    let leaves_for = |x: f64| {
        let way = (x - BIN[0]).hypot(item[1] - BIN[1]);
        (now + (x - (item[0] - speed * (leaves - now))) / speed - way / ARM).max(100.0)
    };
    if speed > 0.0 {
        near(task.earliest_start, leaves_for(low), "earliest_start");
        near(task.latest_start, leaves_for(high), "latest_start");
    }
}

/// `delta-1` has acknowledged a task of an item that was at (`x`, `y`) at 100 s.
fn under_way(x: f64, y: f64) -> (Three, Task) {
    let mut line = Three::new(0.3);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", x, y);
    line.tick(100.0);
    let task = line.task();
    assert_eq!(task.start, 100.0);
    line.ack(100.0, task.id);
    (line, task)
}

const BEYOND: &str = "the belt's speed has changed: the item is met outside the reach";
const MOVED: &str = "the item has moved on the belt: it is met outside the reach";

/// Sooner or later on its way the belt gets faster, a little or much: the robot is sent on up
/// to the end of its reach and called back beyond.
#[test]
fn a_faster_belt_turns_the_robot_up_to_its_reach() {
    let (mut inside, mut outside) = (0, 0);
    for hundredth in [2.0, 8.0, 14.0] {
        for step in 0..60 {
            let (mut line, task) = under_way(1.40, 0.2);
            let now = 100.0 + 0.01 * hundredth;
            assert!(now < task.meet_at);
            let speed = 0.32 + 0.013 * f64::from(step);
            line.belt(now, speed);
            let item = [1.40 + 0.3 * (now - 100.0), 0.2];
            let meet = item[0] + speed * time_to_meet(arm_at(&task, now), item, speed);
            let case = format!("{now} {speed}");
            if meet <= reach(0.2, 4.0).1 {
                inside += 1;
                let (tasks, cancels) = line.said();
                assert!(tasks.len() == 1 && cancels.is_empty(), "{case} {cancels:?}");
                turns(&tasks[0], &task, now, item, speed);
            } else {
                outside += 1;
                assert_eq!(
                    line.told(),
                    [format!("cancel 1 delta-1: {BEYOND}")],
                    "{case}"
                );
            }
            // Either way it is the robot's until it answers.
            assert_eq!(line.status().claimed, 1);
        }
    }
    assert!(inside > 30 && outside > 30, "{inside} {outside}");
}

/// An item that comes later than expected is met upstream, and called off where the reach
/// begins.
#[test]
fn a_slower_belt_turns_the_robot_down_to_its_reach() {
    let low = reach(0.2, 4.0).0;
    let (mut inside, mut outside) = (0, 0);
    for step in 0..28 {
        // It would be met 15 mm behind the beginning of the reach.
        let travel = (low + 0.015 - BIN[0]).hypot(0.6) / ARM;
        let x = low + 0.015 - 0.3 * travel;
        let (mut line, task) = under_way(x, 0.2);
        near(task.meet.x, low + 0.015, "meet.x");
        let now = 100.1;
        let speed = 0.01 * f64::from(step);
        line.belt(now, speed);
        let item = [x + 0.3 * 0.1, 0.2];
        let meet = item[0] + speed * time_to_meet(arm_at(&task, now), item, speed);
        if meet >= low {
            inside += 1;
            let (tasks, _) = line.said();
            turns(&tasks[0], &task, now, item, speed);
        } else {
            outside += 1;
            let why = if step == 0 {
                "the belt has stopped before the item came within reach"
            } else {
                BEYOND
            };
            assert_eq!(line.told(), [format!("cancel 1 delta-1: {why}")], "{speed}");
        }
    }
    assert!(inside > 3 && outside > 3, "{inside} {outside}");
}

/// The belt's end is an end of the reach as well.
#[test]
fn nobody_is_turned_past_the_end_of_the_belt() {
    for (speed, is_met) in [(0.32, true), (0.60, false)] {
        let station = station_of_length(1.28);
        let mut line = Three::on(station, strategy(), config(), 0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.2, 0.2);
        line.tick(100.0);
        let task = line.task();
        line.ack(100.0, task.id);
        line.belt(100.05, speed);
        let item = [1.215, 0.2];
        let meet = item[0] + speed * time_to_meet(arm_at(&task, 100.05), item, speed);
        assert_eq!(meet <= 1.28, is_met, "{meet}");
        assert!(meet < reach(0.2, 4.0).1);
        let expected = if is_met {
            "task 1.1 delta-1 a".to_owned()
        } else {
            format!("cancel 1 delta-1: {BEYOND}")
        };
        assert_eq!(line.told(), [expected]);
    }
}

/// The same for an item that a later picture shows elsewhere, along or across.
#[test]
fn an_item_that_has_moved_turns_the_robot_within_its_reach() {
    let high = reach(0.2, 4.0).1;
    // By how much it has moved, and whether that is news.
    for (dx, dy, is_news) in [
        (0.0, 0.0, false),
        (0.0009, 0.0, false),
        (0.0011, 0.0, true),
        (-0.0011, 0.0, true),
        (0.0, 0.0011, true),
        (0.012, 0.0, true),
        (-0.03, 0.0, true),
        (0.0, -0.03, true),
        (0.03, 0.0, true),
        (0.04, 0.0, true),
    ] {
        let (mut line, task) = under_way(1.45, 0.2);
        let item = [1.465 + dx, 0.2 + dy];
        line.see(100.05, "a", item[0], item[1]);
        line.tick(100.05);
        let meet = item[0] + 0.3 * time_to_meet(arm_at(&task, 100.05), item, 0.3);
        if !is_news {
            assert_eq!(line.told(), [""; 0], "{dx} {dy}");
        } else if meet <= high {
            let (tasks, _) = line.said();
            turns(&tasks[0], &task, 100.05, item, 0.3);
        } else {
            assert!(dx >= 0.03, "{dx}");
            assert_eq!(line.told(), [format!("cancel 1 delta-1: {MOVED}")]);
        }
    }
}

/// A robot that has not set out has not moved: it turns from its bin, at its start.
#[test]
fn a_robot_that_waits_for_its_start_turns_from_its_bin() {
    let config = config().with_lead(vec![0.5]);
    let mut line = Three::with(config, 0.3);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.2);
    line.tick(100.0);
    let task = line.task();
    assert_eq!((task.decided_at, task.start), (100.0, 100.5));
    line.ack(100.0, task.id);
    line.belt(100.2, 0.4);
    let (tasks, _) = line.said();
    turns(&tasks[0], &task, 100.2, [1.06, 0.2], 0.4);
}

/// From its meeting on a robot has the item, and is left alone; until then it is not. One that
/// has acknowledged nothing is not thought to have it.
#[test]
fn a_robot_that_has_met_its_item_is_left_alone() {
    for (early, is_turned) in [(0.001, true), (-0.001, false)] {
        let (mut line, task) = under_way(1.0, 0.2);
        line.belt(task.meet_at - early, 0.35);
        assert_eq!(line.said().0.len(), usize::from(is_turned), "{early}");
    }
    let mut line = Three::new(0.3);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.2);
    line.tick(100.0);
    let task = line.task();
    let now = task.meet_at + 0.001;
    line.belt(now, 0.35);
    let again = line.said().0.remove(0);
    // It sets out now, for all the node knows.
    assert_eq!((again.revision, again.decided_at), (1, task.decided_at));
    near(again.start, now, "start");
    let item = [1.0 + 0.3 * (now - 100.0), 0.2];
    let travel = time_to_meet(BIN, item, 0.35);
    near(again.meet_at, now + travel, "meet_at");
    near(again.meet.x, item[0] + 0.35 * travel, "meet.x");
    near(again.free_at, now + 2.0 * (travel + HOLDS), "free_at");
}

/// A cancelled task is not sent again, whatever the belt does.
#[test]
fn a_robot_that_was_called_back_is_not_turned() {
    let (mut line, _) = under_way(1.0, 0.2);
    line.say(r#""kind":"stop","stamp":100.01"#);
    line.told();
    line.belt(100.02, 0.2);
    line.belt(100.03, 1.1);
    assert_eq!(line.told(), [""; 0]);
}

/// The robot's next task begins when it is back from where it was turned to.
#[test]
fn a_robot_that_was_turned_is_free_later() {
    let (mut line, task) = under_way(1.2, 0.2);
    // A state without the task's id counts from when the robot should be done.
    line.robot(100.05, "delta-1", "idle");
    line.belt(100.1, 1.1);
    let turned = line.said().0.remove(0);
    assert!(turned.free_at > task.free_at + 0.01);
    line.see(100.1, "b", 0.6, 0.2);
    line.tick(101.0);
    let next = line.task();
    assert_eq!(next.item, "b");
    near(next.start, turned.free_at, "start");
    // Its result is overdue 5 s after that.
    line.ack(101.0, next.id);
    let open = |line: &Three| line.status().open_tasks;
    line.tick(turned.free_at + 4.99);
    assert_eq!(open(&line), [1, 2]);
    line.tick(turned.free_at + 5.01);
    assert_eq!(open(&line), [2]);
}

/// What was not acknowledged is planned from now on: at its start if that is to come, at the
/// last one at most, and not for an item that comes in an hour.
#[test]
fn what_was_not_acknowledged_is_planned_again() {
    let lead = 0.3;
    let waiting = |x: f64| {
        let config = config().with_lead(vec![lead]);
        let mut line = Three::with(config, 0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", x, 0.2);
        line.tick(100.0);
        let task = line.task();
        assert_eq!((task.start, task.robot.as_str()), (100.3, "delta-1"));
        (line, task)
    };
    // Slower: it is decided for its lead from now.
    let (mut line, _) = waiting(1.0);
    line.belt(100.1, 0.2);
    let task = line.said().0.remove(0);
    near(task.start, 100.1 + lead, "start");
    near(task.decided_at, 100.0, "decided_at");
    let item = [1.03 + 0.2 * lead, 0.2];
    let travel = time_to_meet(BIN, item, 0.2);
    near(task.meet_at, 100.1 + lead + travel, "meet_at");
    near(task.meet.x, item[0] + 0.2 * travel, "meet.x");
    // Faster, and past its last start by then: 0.5657 m of reach at this y.
    let high = reach(0.2, 4.0).1;
    for step in 0..40 {
        let x = 1.3;
        let speed = 0.35 + 0.02 * f64::from(step);
        let (mut line, _) = waiting(x);
        line.belt(100.1, speed);
        let last = 100.1 + (high - x - 0.03) / speed - (high - BIN[0]).hypot(0.6) / ARM;
        let expected = if 100.1 + lead <= last {
            "task 1.1 delta-1 a".to_owned()
        } else {
            format!("cancel 1 delta-1: {BEYOND}")
        };
        assert_eq!(line.told(), [expected], "{speed}");
    }
    // A belt so slow that the item comes within reach much later: 5 s after the robot could
    // set out, and no more. It is decided 0.1725 m before the reach, at 101.09 s.
    let low = reach(0.2, 4.0).0;
    for (speed, is_kept) in [(0.031, true), (0.030, false)] {
        let config = config().with_lead(vec![lead]);
        let mut line = Three::with(config, 0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", low - 0.5, 0.2);
        line.tick(101.095);
        assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
        let now = 101.1;
        line.belt(now, speed);
        let open = now + 0.17 / speed - (low - BIN[0]).hypot(0.6) / ARM;
        assert_eq!(open <= now + lead + 5.0, is_kept, "{open}");
        if is_kept {
            let task = line.said().0.remove(0);
            assert_eq!(task.revision, 1);
            near(task.start, open, "start");
            near(task.earliest_start, open, "earliest_start");
        } else {
            assert_eq!(line.told(), [format!("cancel 1 delta-1: {BEYOND}")]);
        }
    }
}

/// What is called off keeps its times: it is waited for as long as before.
#[test]
fn a_task_that_is_called_off_keeps_its_plan() {
    for is_acknowledged in [false, true] {
        let mut line = Three::new(0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.45, 0.2);
        line.tick(100.0);
        let task = line.task();
        if is_acknowledged {
            line.ack(100.0, 1);
        }
        line.belt(100.05, 1.1);
        assert_eq!(line.told(), [format!("cancel 1 delta-1: {BEYOND}")]);
        let claim = &line.controller.view(0).claims[0];
        assert_eq!((claim.stage, claim.revision), ("cancelling", 0));
        assert_eq!(claim.meet, [task.meet.x, task.meet.y]);
        near(claim.free_at, task.free_at, "free_at");
        line.tick(task.free_at + 4.999);
        assert_eq!(line.status().claimed, 1);
        line.tick(task.free_at + 5.001);
        assert_eq!(line.status().claimed, 0);
    }
}

/// The same an hour into the run: where the arm is follows from the task's own start.
#[test]
fn a_robot_turns_from_where_it_is() {
    let mut line = Three::new(0.3);
    line.tick(3700.0);
    line.robot(3700.0, "delta-1", "idle");
    line.see(3700.0, "a", 1.0, 0.2);
    line.tick(3700.0);
    let task = line.task();
    line.ack(3700.0, 1);
    for (now, speed) in [(3700.05, 0.4), (3700.15, 0.4)] {
        let mut line = Three::new(0.3);
        line.tick(3700.0);
        line.robot(3700.0, "delta-1", "idle");
        line.see(3700.0, "a", 1.0, 0.2);
        line.tick(3700.0);
        line.ack(3700.0, 1);
        line.said.clear();
        line.belt(now, speed);
        let (tasks, _) = line.said();
        let item = [1.0 + 0.3 * (now - 3700.0), 0.2];
        let travel = time_to_meet(arm_at(&task, now), item, speed);
        near(tasks[0].meet_at, now + travel, "meet_at");
        near(tasks[0].meet.x, item[0] + speed * travel, "meet.x");
    }
}
