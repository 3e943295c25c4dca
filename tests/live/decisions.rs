//! Who decides when, on what, and what becomes of each answer of a strategy.

use crate::support::three::{Three, config, station};
use pickline::decision::{Action, Snapshot, Strategy};
use pickline::live::{Config, Controller};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// What a strategy was shown: the time, the robot, the candidates' x at time 0, when each robot
/// is free, and the items in view.
type Shown = (f64, usize, Vec<f64>, Vec<f64>, Vec<f64>);

/// Answers as it is asked to, then picks the first candidate; keeps what it was shown.
struct Scripted {
    answers: VecDeque<Action>,
    shown: Arc<Mutex<Vec<Shown>>>,
    looks: bool,
}

impl Strategy for Scripted {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        self.shown.lock().unwrap().push((
            snapshot.time,
            snapshot.robot,
            snapshot.candidates.iter().map(|c| c.x0).collect(),
            snapshot.free_at.to_vec(),
            snapshot.in_view.iter().map(|item| item.x).collect(),
        ));
        self.answers.pop_front().unwrap_or(Action::Pick(0))
    }

    fn name(&self) -> String {
        "scripted".into()
    }

    fn needs_view(&self) -> bool {
        self.looks
    }

    fn trouble(&self) -> Option<String> {
        Some("it saw nothing that it knows".into())
    }
}

fn scripted(config: Config, answers: &[Action], looks: bool) -> (Three, Arc<Mutex<Vec<Shown>>>) {
    let shown = Arc::new(Mutex::new(Vec::new()));
    let strategy = Scripted {
        answers: answers.iter().copied().collect(),
        shown: Arc::clone(&shown),
        looks,
    };
    (Three::on(station(), Box::new(strategy), config, 0.0), shown)
}

/// Times of the decisions so far, from 100 s on.
fn times(shown: &Mutex<Vec<Shown>>) -> Vec<f64> {
    let shown = shown.lock().unwrap();
    shown.iter().map(|shown| shown.0).collect()
}

#[test]
fn a_strategy_sees_the_line_as_it_is() {
    let config = Config {
        lead: vec![0.0, 0.25],
        view_from: 0.5,
        ..config()
    };
    let (mut line, shown) = scripted(config, &[], true);
    line.robot(100.0, "scara-2", "idle");
    line.say(r#""kind":"robot","stamp":100,"name":"delta-1","state":"busy","available_at":107"#);
    line.robot(100.0, "arm-3", "fault");
    for (id, x) in [("a", 1.2), ("b", 1.7), ("c", 3.9), ("d", 0.6), ("e", 0.4)] {
        line.see(100.0, id, x, 0.0);
    }
    line.tick(102.0);
    let shown = shown.lock().unwrap();
    let (time, robot, candidates, free_at, in_view) = &shown[0];
    // 0.25 s before it can set out, its lead; downstream first, and from 0.5 m on.
    assert_eq!((*time, *robot), (0.25, 1));
    let near = |values: &[f64], expected: &[f64]| {
        values.len() == expected.len()
            && values
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-5)
    };
    assert!(near(candidates, &[1.7, 1.2]), "{candidates:?}");
    assert!(near(in_view, &[3.9, 1.7, 1.2, 0.6]), "{in_view:?}");
    assert_eq!(free_at[..], [7.0, 0.0, f64::INFINITY]);
}

/// One that nobody can reach is not waited for: to a strategy it is never free.
#[test]
fn a_robot_that_is_held_up_is_never_free() {
    let (mut line, shown) = scripted(config(), &[], false);
    for robot in ["delta-1", "scara-2", "arm-3"] {
        line.robot(100.0, robot, "idle");
    }
    line.controller.hold(&[2]);
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(100.0);
    let shown = shown.lock().unwrap();
    let (_, robot, _, free_at, in_view) = &shown[0];
    assert_eq!(free_at[..], [0.0, 0.0, f64::INFINITY]);
    // Ties go to the robot that is listed first; who does not look is shown nothing.
    assert_eq!((*robot, in_view.len(), shown.len()), (0, 0, 1));
}

#[test]
fn who_can_leave_first_decides_first() {
    let (mut line, shown) = scripted(config(), &[], false);
    line.say(r#""kind":"robot","stamp":100,"name":"delta-1","state":"idle","available_at":100.4"#);
    line.say(r#""kind":"robot","stamp":100,"name":"scara-2","state":"idle","available_at":100.3"#);
    line.see(100.0, "a", 1.2, 0.0);
    line.see(100.0, "b", 1.3, 0.0);
    line.tick(101.0);
    let shown = shown.lock().unwrap();
    let order: Vec<_> = shown.iter().map(|shown| (shown.0, shown.1)).collect();
    assert_eq!(order.len(), 2);
    assert!(
        (order[0].0 - 0.3).abs() < 1e-9 && order[0].1 == 1,
        "{order:?}"
    );
    assert!(
        (order[1].0 - 0.4).abs() < 1e-9 && order[1].1 == 0,
        "{order:?}"
    );
    assert_eq!(line.told(), ["task 1.0 scara-2 b", "task 2.0 delta-1 a"]);
}

#[test]
fn a_robot_that_waits_decides_when_it_said() {
    let (mut line, shown) = scripted(config(), &[Action::WaitUntil(2.5)], false);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(100.0);
    // It is idle, and its next decision is known.
    assert_eq!(line.status().robots[0].state, "idle");
    line.tick(102.4);
    assert_eq!(line.told(), [""; 0]);
    line.tick(110.0);
    assert_eq!(line.told()[0], "task 1.0 delta-1 a");
    assert_eq!(times(&shown), [0.0, 2.5]);
    assert!(line.controller.take_remarks().is_empty());
}

#[test]
fn a_robot_that_waits_for_an_item_decides_when_one_comes() {
    let (mut line, shown) = scripted(config(), &[Action::WaitForNextWindow], false);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(103.0);
    assert_eq!(line.told(), [""; 0]);
    assert_eq!(line.status().robots[0].state, "idle");
    line.see(103.0, "b", 1.3, 0.0);
    line.tick(103.5);
    assert_eq!(line.told(), ["task 1.0 delta-1 b"]);
    assert_eq!(times(&shown), [0.0, 3.0]);
}

/// An answer that is none gives no task, is told of once and counted, and the line goes on
/// with the next window.
#[test]
fn an_answer_that_is_none_costs_a_wait() {
    let rest = "the robot gets no task and waits; further ones are only counted, as illegal_action \
                in the status";
    for (answer, problem) in [
        (Action::Pick(1), "Pick(1) among 1 candidate"),
        (Action::WaitUntil(0.0), "WaitUntil(0.0) among 1 candidate"),
        (Action::NoAnswer, "it saw nothing that it knows"),
    ] {
        let (mut line, shown) = scripted(config(), &[answer, answer], false);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.2, 0.0);
        line.tick(103.0);
        assert_eq!((line.told(), line.noted("illegal_action")), (vec![], 1));
        let remarks = line.controller.take_remarks();
        assert_eq!(
            remarks,
            [format!(
                "the strategy scripted has no usable answer for robot `delta-1` at t = 0 s: \
                 {problem}\n  {rest}"
            )]
        );
        line.see(103.0, "b", 1.3, 0.0);
        line.see(103.0, "c", 1.1, 0.0);
        line.tick(103.0);
        assert_eq!(times(&shown)[1], 3.0);
        // The first of them opened first: the other one is the next window.
        line.tick(104.0);
        assert!(line.noted("illegal_action") <= 2);
        assert!(line.controller.take_remarks().is_empty());
    }
    // One that is exactly in range is picked.
    let (mut line, _) = scripted(config(), &[Action::Pick(1)], false);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    line.see(100.0, "b", 1.3, 0.0);
    line.tick(100.0);
    assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
}

/// Whoever waited by a plan that is void decides again, from then on.
#[test]
fn what_wakes_a_robot_that_waits() {
    // What scara-2 said at first, what is heard then, and whether it wakes delta-1.
    let cases = [
        ("idle", r#""kind":"tick","stamp":101"#, false),
        (
            "idle",
            r#""kind":"robot","stamp":101,"name":"scara-2","state":"fault""#,
            true,
        ),
        (
            "fault",
            r#""kind":"robot","stamp":101,"name":"scara-2","state":"fault""#,
            false,
        ),
        (
            "idle",
            r#""kind":"robot","stamp":101,"name":"delta-1","state":"idle""#,
            false,
        ),
        ("idle", r#""kind":"belt","stamp":101,"speed":0.01"#, true),
        ("idle", r#""kind":"belt","stamp":101,"speed":0"#, false),
        (
            "idle",
            r#""kind":"pause","stamp":101,"robot":"arm-3""#,
            true,
        ),
        // A picture of an item that is no news, and one that is.
        (
            "idle",
            r#""kind":"detection","stamp":101,"id":"a","x":1.2,"y":0"#,
            false,
        ),
    ];
    for (before, news, wakes) in cases {
        let (mut line, shown) = scripted(config(), &[Action::WaitUntil(50.0)], false);
        line.robot(100.0, "scara-2", before);
        line.controller.hold(&[1]);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.2, 0.0);
        line.tick(100.5);
        assert_eq!(times(&shown), [0.0], "{news}");
        line.say(news);
        line.tick(102.0);
        let expected: &[f64] = if wakes { &[0.0, 1.0] } else { &[0.0] };
        assert_eq!(times(&shown), expected, "{news}");
    }
}

/// Decisions are timed where a stopwatch is given, and shown with the system clock.
#[test]
fn decisions_are_timed() {
    let mut reading = 0.0;
    let stopwatch = move || {
        reading += 0.004;
        reading
    };
    let controller = Controller::new(
        station(),
        crate::support::three::strategy(),
        Config::default(),
    )
    .with_stopwatch(Box::new(stopwatch));
    let mut line = Three {
        controller,
        said: Vec::new(),
    };
    let start = 1.75e9;
    line.controller.advance(start);
    line.robot(start, "delta-1", "idle");
    line.see(start, "a", 1.0, 0.0);
    line.controller.advance(start);
    let latency = line.status().latency.unwrap();
    assert_eq!(latency.decisions, 1);
    assert!((latency.max_ms - 4.0).abs() < 0.1, "{latency:?}");
    assert_eq!(line.controller.latency(), latency);
    // With message time the output depends on the messages only.
    assert_eq!(Three::new(0.0).status().latency, None);
}
