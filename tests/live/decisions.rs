//! Who decides when, on what, and what becomes of each answer of a strategy.

use crate::support::three::{Three, config, station};
use pickline::decision::{Action, Snapshot, Strategy};
use pickline_live::{Config, Controller};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

/// What a strategy was shown: the time, the robot, the candidates' x at time 0, when each robot
/// is free, and the items in view; then the candidates' weights.
type Shown = (f64, usize, Vec<f64>, Vec<f64>, Vec<f64>, Vec<f64>);

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
            snapshot.candidates.iter().map(|c| c.weight).collect(),
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
    let config = config().with_lead(vec![0.0, 0.25]).with_view_from(0.5);
    let (mut line, shown) = scripted(config, &[], true);
    line.robot(100.0, "scara-2", "idle");
    line.say(r#""kind":"robot","stamp":100,"name":"delta-1","state":"busy","available_at":107"#);
    line.robot(100.0, "arm-3", "fault");
    for (id, x) in [("a", 1.2), ("b", 1.7), ("c", 3.9), ("d", 0.6), ("e", 0.4)] {
        line.see(100.0, id, x, 0.0);
    }
    line.tick(102.0);
    let shown = shown.lock().unwrap();
    let (time, robot, candidates, free_at, in_view, _) = &shown[0];
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
    let (_, robot, _, free_at, in_view, _) = &shown[0];
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
fn an_invalid_answer_means_a_wait() {
    let rest = "the robot gets no task and waits; further cases are only counted, as \
                illegal_action in the status";
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
                "the strategy scripted gave no valid answer for robot `delta-1` at t = 0 s: \
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
    .unwrap()
    .with_stopwatch(Box::new(stopwatch));
    let mut line = Three::of(controller);
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

/// Two robots that can decide at once: the one that is listed first does, whatever their leads.
#[test]
fn a_lead_time_gives_no_precedence() {
    let config = config().with_lead(vec![0.0, 0.5]);
    let (mut line, _) = scripted(config, &[], false);
    for robot in ["delta-1", "scara-2"] {
        line.robot(100.0, robot, "idle");
    }
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(100.0);
    assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
}

/// A lead time is taken off the time at which a window opens and added again: the strategy is
/// asked about one that is open, and the start is when it opens.
#[test]
fn a_decision_falls_its_lead_before_a_window_opens() {
    let config = config().with_lead(vec![0.1]);
    for step in 0..60 {
        let shown = Arc::new(Mutex::new(Vec::new()));
        let strategy = Scripted {
            answers: VecDeque::new(),
            shown: Arc::clone(&shown),
            looks: false,
        };
        let mut line = Three::on(station(), Box::new(strategy), config.clone(), 0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", -0.3 - 0.0137 * f64::from(step), 0.1);
        line.tick(108.0);
        let task = line.said().0.remove(0);
        assert!((task.start - task.earliest_start).abs() < 1e-9, "{task:?}");
        assert!(
            (task.start - task.decided_at - 0.1).abs() < 1e-9,
            "{task:?}"
        );
        assert_eq!(line.noted("illegal_action"), 0);
        let shown = shown.lock().unwrap();
        assert!(shown.iter().all(|shown| shown.2.len() == 1), "{shown:?}");
    }
}

/// The next window of an item that is known already counts, too.
#[test]
fn a_robot_that_waits_for_an_item_knows_when_it_comes() {
    let shown = Arc::new(Mutex::new(Vec::new()));
    let strategy = Scripted {
        answers: [Action::WaitForNextWindow, Action::WaitUntil(0.0)].into(),
        shown: Arc::clone(&shown),
        looks: false,
    };
    let mut line = Three::on(station(), Box::new(strategy), config(), 0.3);
    line.robot(100.0, "delta-1", "idle");
    for (id, x) in [("a", 1.0), ("b", 0.1), ("c", -0.05)] {
        line.see(100.0, id, x, 0.0);
    }
    line.tick(102.0);
    // They come within its reach at 0.4 m; it leaves its bin 0.2404 s before. An answer that
    // is none waits for the next one as well.
    let leaves = |x: f64| (0.4 - x) / 0.3 - 0.6_f64.hypot(0.4) / 3.0;
    let times = times(&shown);
    assert_eq!(times.len(), 3);
    assert_eq!(times[0], 0.0);
    assert!((times[1] - leaves(0.1)).abs() < 1e-9, "{times:?}");
    assert!((times[2] - leaves(-0.05)).abs() < 1e-9, "{times:?}");
    assert_eq!(line.noted("illegal_action"), 1);
}

/// A robot that has waited and is at work is not woken.
#[test]
fn a_busy_robot_is_not_woken() {
    let (mut line, shown) = scripted(config(), &[Action::WaitUntil(1.0)], false);
    line.robot(100.0, "delta-1", "idle");
    line.robot(100.0, "arm-3", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    line.see(100.0, "b", 1.3, 0.0);
    line.tick(101.0);
    let task = line.task();
    line.ack(101.0, task.id);
    // It may be free sooner, which is believed from when its task should be done.
    line.robot(101.05, "delta-1", "idle");
    line.robot(101.1, "arm-3", "fault");
    line.tick(102.0);
    let times = times(&shown);
    assert_eq!(times.len(), 3, "{times:?}");
    assert!((times[2] + 100.0 - task.free_at).abs() < 1e-9, "{times:?}");
}

/// Up to the moment at which belt or robot are overdue, that one included, tasks are given.
#[test]
fn until_when_a_silent_source_is_relied_on() {
    let limits = |belt: Option<f64>, robot: Option<f64>| {
        config().with_timeouts(
            pickline_live::Timeouts::default()
                .with_belt(belt)
                .with_robot(robot),
        )
    };
    for config in [limits(Some(2.0), None), limits(None, Some(2.0))] {
        for (free, is_given) in [(101.9, true), (102.0, true), (102.01, false)] {
            let mut line = Three::with(config.clone(), 0.0);
            line.say(&format!(
                r#""kind":"robot","stamp":100,"name":"delta-1","state":"idle","available_at":{free}"#
            ));
            line.see(100.0, "a", 1.0, 0.0);
            line.tick(102.5);
            assert_eq!(line.told().len(), usize::from(is_given), "{free}");
        }
    }
}

/// The view of a moving belt, at the time of the start: from where the strategy looks to the
/// belt's end, both included, without what is taken.
#[test]
fn a_strategy_sees_what_lies_on_the_belt_when_the_robot_sets_out() {
    let config = config().with_lead(vec![0.5]).with_view_from(0.75);
    let shown = Arc::new(Mutex::new(Vec::new()));
    let strategy = Scripted {
        answers: VecDeque::new(),
        shown: Arc::clone(&shown),
        looks: true,
    };
    let mut line = Three::on(station(), Box::new(strategy), config, 0.3);
    line.say(r#""kind":"robot","stamp":100,"name":"delta-1","state":"idle","available_at":102.5"#);
    // The belt goes 0.75 m until then. Two lie a hair within the ends, two a hair beyond.
    let places = [
        3.249_999_5,
        3.250_001_5,
        0.000_000_5,
        -0.000_001_5,
        0.45,
        0.1,
    ];
    for (number, x) in places.iter().enumerate() {
        let y = 0.04 * number as f64;
        line.see(100.0, &format!("i{number}"), *x, y);
    }
    line.tick(102.0);
    let task = line.said().0.remove(0);
    assert_eq!((task.item.as_str(), task.start), ("i4", 102.5));
    line.say(r#""kind":"result","stamp":102,"task":1,"result":"PICKED","available_at":102.5"#);
    line.tick(102.0);
    let shown = shown.lock().unwrap();
    let near = |values: &[f64], expected: &[f64]| {
        values.len() == expected.len()
            && values
                .iter()
                .zip(expected)
                .all(|(a, b)| (a - b).abs() < 1e-9)
    };
    let first = &shown[0].4;
    assert!(
        near(first, &[3.999_999_5, 1.2, 0.85, 0.750_000_5]),
        "{first:?}"
    );
    let second = &shown[1].4;
    assert!(
        near(second, &[3.999_999_5, 0.85, 0.750_000_5]),
        "{second:?}"
    );
    assert_eq!((shown[1].3.len(), shown[1].0), (3, 2.5));
}

/// A robot that rests is free after its rest, to the others.
#[test]
fn a_paused_robot_is_free_afterwards() {
    let (mut line, shown) = scripted(config(), &[], false);
    line.robot(100.0, "delta-1", "idle");
    for item in 0..8 {
        line.see(
            100.0,
            &format!("i{item}"),
            1.1 + 0.03 * f64::from(item),
            0.0,
        );
    }
    for _ in 0..3 {
        line.tick(100.0);
        let task = line.task();
        line.result(100.0, task.id, "CANCELLED");
    }
    line.robot(100.1, "scara-2", "idle");
    line.tick(100.1);
    let shown = shown.lock().unwrap();
    let last = shown.last().unwrap();
    assert_eq!((last.1, last.3[0]), (1, 0.5));
}

/// What a camera says of the weight reaches the strategy: a new weight at once, an old one not,
/// and that of a second box where the first has none.
#[test]
fn weights_reach_the_strategy() {
    let weigh = |stamp: f64, x: f64, weight: &str| {
        format!(r#""kind":"detection","stamp":{stamp},"x":{x},"y":0{weight}"#)
    };
    for (news, expected) in [
        (vec![], 0.5),
        (vec![weigh(100.2, 1.2, r#","weight":3"#)], 3.0),
        (vec![weigh(100.1, 1.2, r#","weight":3"#)], 3.0),
        (
            vec![
                weigh(100.2, 1.2, r#","weight":3"#),
                weigh(100.1, 1.2, r#","weight":2"#),
            ],
            3.0,
        ),
        (
            vec![
                weigh(100.2, 1.2, r#","id":"a","weight":3"#),
                weigh(100.2, 1.2, r#","id":"a","weight":2"#),
            ],
            2.0,
        ),
        (
            vec![weigh(100.2, 1.2, ""), weigh(100.2, 1.203, r#","weight":4"#)],
            4.0,
        ),
        (
            vec![
                weigh(100.2, 1.2, r#","weight":3"#),
                weigh(100.2, 1.203, r#","weight":4"#),
            ],
            3.0,
        ),
    ] {
        let (mut line, shown) = scripted(config(), &[], false);
        line.say(&weigh(100.1, 1.2, r#","id":"a""#));
        line.tick(100.2);
        let is_double = news.iter().any(|text| text.contains("1.203"));
        for text in &news {
            line.say(text);
            if !is_double {
                line.tick(100.2);
            }
        }
        line.tick(100.2);
        line.robot(100.3, "delta-1", "idle");
        line.tick(100.3);
        let shown = shown.lock().unwrap();
        assert_eq!(shown[0].5, [expected], "{news:?}");
        assert_eq!(line.task().priority, expected, "{news:?}");
    }
}

/// What has been offered before is no news to the journal.
#[test]
fn an_offer_is_kept_once() {
    let waits = [Action::WaitUntil(1.0), Action::WaitUntil(2.0)];
    let (mut line, _) = scripted(config(), &waits, false);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    line.controller.close_picture();
    line.controller.whole();
    let mut parts = |stamp: f64| {
        line.tick(stamp);
        let change = line.controller.change(false).unwrap();
        let json = serde_json::to_value(&change).unwrap();
        let keys = json.as_object().unwrap().keys().cloned();
        keys.filter(|key| !["origin", "now"].contains(&key.as_str()))
            .collect::<Vec<String>>()
    };
    assert_eq!(parts(100.0), ["items", "robots"]);
    assert_eq!(parts(101.0), ["robots"]);
}

/// A robot that has announced when it is free is not woken before, whatever it waited for.
#[test]
fn a_robot_that_says_when_it_is_free_waits_no_more() {
    let (mut line, shown) = scripted(config(), &[Action::WaitUntil(50.0)], false);
    line.robot(100.0, "delta-1", "idle");
    line.robot(100.0, "arm-3", "idle");
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(100.5);
    line.say(r#""kind":"robot","stamp":101,"name":"delta-1","state":"idle","available_at":103"#);
    assert_eq!(line.status().robots[0].state, "busy");
    line.robot(101.5, "arm-3", "fault");
    line.tick(104.0);
    assert_eq!(times(&shown), [0.0, 3.0]);
}

/// What is due first is done first, and of what is due at once the deadlines.
#[test]
fn deadlines_come_before_decisions() {
    for (free, order) in [
        (101.5, ["task 1.1 delta-1 a", "task 2.0 scara-2 b"]),
        (101.0, ["task 1.1 delta-1 a", "task 2.0 scara-2 b"]),
        (100.9, ["task 2.0 scara-2 b", "task 1.1 delta-1 a"]),
    ] {
        let (mut line, _) = scripted(config(), &[], false);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 1.0, 0.0);
        line.say(&format!(
            r#""kind":"robot","stamp":100,"name":"scara-2","state":"idle","available_at":{free}"#
        ));
        line.see(100.0, "b", 1.8, 0.0);
        line.tick(100.0);
        assert_eq!(line.told(), ["task 1.0 delta-1 a"]);
        line.tick(101.6);
        let sent = line.said.clone();
        assert_eq!(line.told(), order, "{free}");
        let again = sent.iter().find_map(|message| match message {
            pickline_live::protocol::Outgoing::Task(task) if task.id == 1 => Some(task.start),
            _ => None,
        });
        assert_eq!(again, Some(101.0));
    }
}
