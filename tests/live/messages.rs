//! What stands in each message from the node, field by field.
//!
//! What is expected is computed here: `scara-2` has its base at (1.6, 0.35), its bin at
//! (1.6, 0.45), a reach of 0.7 m, an arm of 2 m/s, and grasps in 0.1 s and releases in 0.08 s.

use crate::support::three::{Three, config, station, strategy};
use pickline_live::protocol::{
    BeltPoint, BeltRequest, Cancel, Due, Outgoing, RobotCounts, SourceKind, Status, Task,
};
use pickline_live::{Config, Controller};

fn near(value: f64, expected: f64, what: &str) {
    assert!(
        (value - expected).abs() < 1e-9,
        "{what}: {value}, not {expected}"
    );
}

#[test]
fn every_field_of_a_task() {
    let config = config().with_lead(vec![7.0, 0.1, 7.0]);
    let mut line = Three::with(config, 0.3);
    line.say(r#""kind":"robot","stamp":100,"name":"scara-2","state":"busy","available_at":101.5"#);
    line.say(
        r#""kind":"detection","stamp":100,"id":"a","x":0.5,"y":0.1,"weight":2.5,"class":"PET",
           "angle":1.25,"height":0.08,"size":[0.2,0.1],"data":{"lot":7}"#,
    );
    line.tick(101.4);
    let task = line.said().0.remove(0);
    // From within the reach to its end, along y = 0.1.
    let half = (0.49_f64 - 0.25 * 0.25).sqrt();
    let leaves_for = |x: f64| 100.0 + (x - 0.5) / 0.3 - (x - 1.6_f64).hypot(0.35) / 2.0;
    // It sets out at 101.5 s, when the item is at 0.95 m, and meets it 0.3 t further on.
    let (dx, dy) = (0.95 - 1.6, -0.35);
    let (a, b, c) = (4.0 - 0.09, -0.6 * dx, -(dx * dx + dy * dy));
    let travel = (-b + f64::sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
    near(task.decided_at, 101.4, "decided_at");
    near(task.start, 101.5, "start");
    near(
        task.earliest_start,
        leaves_for(1.6 - half),
        "earliest_start",
    );
    near(task.latest_start, leaves_for(1.6 + half), "latest_start");
    assert!(task.earliest_start > 101.0 && task.latest_start > 105.0);
    near(task.meet_at, 101.5 + travel, "meet_at");
    near(task.meet.x, 0.95 + 0.3 * travel, "meet.x");
    near(task.free_at, 101.5 + 2.0 * travel + 0.18, "free_at");
    let expected = Task {
        id: 1,
        revision: 0,
        robot: "scara-2".into(),
        item: "a".into(),
        meet: BeltPoint {
            x: task.meet.x,
            y: 0.1,
        },
        bin: BeltPoint { x: 1.6, y: 0.45 },
        priority: 2.5,
        strategy: "rules:SPT,SPT,SPT".into(),
        class: Some("PET".into()),
        angle: Some(1.25),
        height: Some(0.08),
        size: Some([0.2, 0.1]),
        data: serde_json::from_str(r#"{"lot":7}"#).unwrap(),
        ..task.clone()
    };
    assert_eq!(task, expected);
}

/// A revision has what the camera has said since.
#[test]
fn a_revision_says_what_is_new_of_the_item() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    let first = line.task();
    // The weight of an item of which nobody says how large it is.
    assert_eq!((first.priority, &first.class), (0.5, &None));
    line.say(
        r#""kind":"detection","stamp":100.1,"id":"a","x":1.0,"y":0.0,"weight":3,"class":"PP""#,
    );
    line.tick(101.0);
    let again = line.said().0.remove(0);
    assert_eq!((again.revision, again.priority), (1, 3.0));
    assert_eq!(again.class.as_deref(), Some("PP"));
    assert_eq!(again.decided_at, first.decided_at);
}

#[test]
fn every_field_of_a_cancel_and_of_an_answer_to_a_tick() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "scara-2", "idle");
    line.see(100.0, "a", 1.7, 0.0);
    line.tick(100.0);
    line.said.clear();
    line.robot(100.2, "scara-2", "fault");
    let cancel = Cancel {
        stamp: 100.2,
        task: 1,
        robot: "scara-2".into(),
        reason: "the robot has reported a fault".into(),
    };
    assert_eq!(line.said, [Outgoing::Cancel(cancel)]);
    line.said.clear();
    // The cancel is repeated a second after it was sent.
    line.tick(100.5);
    let due = |stamp: f64, next: Option<f64>| Outgoing::Due(Due { stamp, next });
    assert_eq!(line.said, [due(100.5, Some(101.2))]);
    line.said.clear();
    line.result(100.6, 1, "CANCELLED");
    line.tick(101.0);
    assert_eq!(line.said, [due(101.0, None)]);
}

#[test]
fn every_field_of_a_belt_request() {
    let config = config().with_may_stop_belt(true);
    let mut line = Three::with(config, 0.3);
    line.said.clear();
    line.robot(101.0, "delta-1", "idle");
    line.robot(102.0, "delta-1", "fault");
    line.tick(102.0);
    line.said.retain(|said| said.kind() != "due");
    let stop = BeltRequest {
        stamp: 102.0,
        speed: 0.0,
        reason: "no robot takes tasks".into(),
    };
    assert_eq!(line.said, [Outgoing::BeltRequest(stop)]);
    line.said.clear();
    line.belt(102.5, 0.0);
    line.robot(103.0, "delta-1", "idle");
    line.tick(103.0);
    line.said.retain(|said| said.kind() != "due");
    let go = BeltRequest {
        stamp: 103.0,
        speed: 0.3,
        reason: "robots take tasks, and no item would be lost".into(),
    };
    assert_eq!(line.said, [Outgoing::BeltRequest(go)]);
}

fn robot(name: &str, state: &str, [picked, failed, missed]: [u64; 3]) -> RobotCounts {
    RobotCounts {
        name: name.into(),
        state: state.into(),
        picked,
        failed,
        missed,
    }
}

#[test]
fn every_field_of_a_status() {
    let mut line = Three::new(0.0);
    line.tick(100.0);
    let empty = line.status();
    let layout = empty.layout.clone();
    assert!(layout.is_some());
    let unknown = ["delta-1", "scara-2", "arm-3"].map(|name| robot(name, "unknown", [0; 3]));
    let expected = Status {
        stamp: 100.0,
        last: false,
        layout: layout.clone(),
        mode: "running".into(),
        robots: unknown.to_vec(),
        sources: empty.sources.clone(),
        ..Status::default()
    };
    assert_eq!(empty, expected);
    assert_eq!(empty.sources.len(), 1);
    let belt = &empty.sources[0];
    assert_eq!((belt.name.as_str(), belt.kind), ("belt", SourceKind::Belt));
    assert_eq!((belt.age, belt.overdue), (0.0, false));

    line.robot(100.0, "delta-1", "idle");
    line.robot(100.0, "scara-2", "idle");
    line.say(r#""kind":"pause","stamp":100,"robot":"arm-3""#);
    // One is picked, one fails, one is open, one waits, one is out of reach of all.
    for (id, x, y) in [
        ("a", 0.5, 0.0),
        ("b", 1.0, 0.0),
        ("c", 2.1, 0.0),
        ("d", 0.45, 0.0),
        ("e", 3.9, 0.0),
    ] {
        line.see(100.0, id, x, y);
    }
    let mut sent = Vec::new();
    for (step, result) in ["PICKED", "GRASP_FAIL", "MISSED"].iter().enumerate() {
        let now = 100.0 + step as f64;
        line.tick(now);
        let (tasks, _) = line.said();
        let own = tasks.iter().find(|task| task.robot == "delta-1").unwrap();
        line.ack(now, own.id);
        line.result(now + 0.6, own.id, result);
        sent.push(own.id);
    }
    line.tick(110.0);
    let open: Vec<u64> = line.status().open_tasks;
    let refused = Three::message(r#""kind":"robot","stamp":110,"name":"r9","state":"idle""#);
    line.controller.handle(refused).unwrap_err();
    let status = line.controller.status(true, 12);
    let expected = Status {
        stamp: 110.0,
        last: true,
        layout,
        mode: "running".into(),
        seen: 5,
        picked: 1,
        picked_share: 0.2,
        // In 10 s.
        picks_per_min: 6.0,
        on_belt: 4 - open.len() as u64,
        claimed: open.len() as u64,
        open_tasks: open,
        queued: 12,
        rejected: [("unknown_robot".to_owned(), 1)].into(),
        robots: vec![
            robot("delta-1", &status.robots[0].state, [1, 1, 1]),
            robot("scara-2", &status.robots[1].state, [0; 3]),
            robot("arm-3", "unknown", [0; 3]),
        ],
        sources: status.sources.clone(),
        noted: status.noted.clone(),
        ..Status::default()
    };
    assert_eq!(status, expected);
    let names: Vec<&str> = status.sources.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(names, ["camera", "belt", "delta-1", "scara-2"]);
    let ages: Vec<f64> = status.sources.iter().map(|s| s.age).collect();
    assert_eq!(ages[..2], [10.0, 10.0]);
    near(ages[2], 110.0 - 102.6, "age");
    near(ages[3], 10.0, "age");
    // A robot that is idle shows what the operator wants of it, one that is not does not.
    for robot in ["arm-3", "delta-1"] {
        line.robot(110.0, robot, "idle");
    }
    assert_eq!(line.status().robots[2].state, "paused");
    line.say(r#""kind":"stop","stamp":110,"robot":"arm-3""#);
    assert_eq!(line.status().robots[2].state, "stopped");
    line.robot(110.1, "arm-3", "busy");
    assert_eq!(line.status().robots[2].state, "busy");
    line.robot(110.2, "arm-3", "fault");
    assert_eq!(line.status().robots[2].state, "fault");
}

/// Each reason to miss an item, in the status and after the item is forgotten.
#[test]
fn every_reason_to_miss_an_item() {
    type Story = fn(&mut Three);
    let stories: [(&str, Story); 6] = [
        ("unreachable", |line| line.see(100.0, "a", 3.5, 0.0)),
        ("busy", |line| line.see(100.0, "a", 1.0, 0.0)),
        ("passed_over", |line| {
            line.robot(100.0, "delta-1", "idle");
            line.see(100.0, "a", 1.0, 0.0);
            line.see(100.0, "b", 1.05, 0.0);
            line.tick(100.0);
            let task = line.task();
            line.ack(100.0, task.id);
            line.say(&format!(
                r#""kind":"result","stamp":100.5,"task":{},"result":"PICKED","available_at":900"#,
                task.id
            ));
        }),
        ("grasp_failed", |line| {
            attempts(line, ["MISSED", "GRASP_FAIL", "MISSED"])
        }),
        ("not_found", |line| attempts(line, ["MISSED"; 3])),
        ("no_result", |line| {
            line.robot(100.0, "delta-1", "idle");
            line.see(100.0, "a", 1.0, 0.0);
            line.tick(100.0);
            line.ack(100.0, 1);
        }),
    ];
    for (reason, story) in stories {
        let mut line = Three::new(0.3);
        story(&mut line);
        // While it is known, and long after.
        for now in [115.0, 200.0] {
            line.tick(now);
            let status = line.status();
            let counts = serde_json::to_value(status.missed).unwrap();
            let counts = counts.as_object().unwrap();
            for (name, count) in counts {
                let expected = u64::from(name == reason);
                assert_eq!(count.as_u64().unwrap(), expected, "{reason} {name} {now}");
            }
            assert_eq!((status.missed.total(), status.on_belt), (1, 0));
            assert!(status.claimed == 0 && status.seen == 1 + status.picked);
        }
    }
}

/// Three attempts at one item, one after another.
fn attempts(line: &mut Three, results: [&str; 3]) {
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 0.6, 0.0);
    for (step, result) in results.iter().enumerate() {
        let now = 100.0 + 0.5 * step as f64;
        line.tick(now);
        let task = line.task();
        line.ack(now, task.id);
        line.result(now + 0.45, task.id, result);
    }
}

/// A robot with a clock of its own is sent stamps of that clock, and everybody else stamps
/// of the machine's, also after it was set.
#[test]
fn stamps_are_those_of_whoever_reads_them() {
    let config = Config::default().with_may_stop_belt(true);
    let start = 1.75e9;
    // By how much the robot's clock is ahead, and that of the machine.
    for (own, ahead) in [(0.0, 0.0), (3.0, 0.0), (3.0, 100.0), (0.0, -5.0)] {
        let mut line = Three::of(Controller::new(station(), strategy(), config.clone()).unwrap());
        let hear = |line: &mut Three, clock: f64, now: f64, fields: &str| {
            let stamp = start + now + clock;
            let message = Three::message(&format!(r#""stamp":{stamp},{fields}"#));
            line.controller.advance(start + now);
            line.controller.hear(message, start + now).unwrap();
            line.controller.advance(start + now);
            line.said.extend(line.controller.take_output());
        };
        line.controller.advance(start);
        let idle = r#""kind":"robot","name":"delta-1","state":"idle""#;
        // Its clock is believed once it has said so three times.
        for step in 0..5 {
            hear(&mut line, own, 0.1 * f64::from(step), idle);
        }
        line.controller.set_clock_ahead(ahead);
        // It follows the machine's clock, unless it says otherwise.
        let clock = own + ahead;
        hear(&mut line, clock, 1.0, idle);
        line.said.clear();
        hear(
            &mut line,
            ahead,
            1.0,
            r#""kind":"detection","id":"a","x":1.0,"y":0.0"#,
        );
        line.controller.advance(start + 1.0);
        line.said.extend(line.controller.take_output());
        let task = line.task();
        let case = format!("{own} {ahead}");
        assert!(
            (task.decided_at - (start + 1.0 + clock)).abs() < 0.02,
            "{case} {task:?}"
        );
        assert!((task.start - task.decided_at).abs() < 1e-6, "{case}");
        let fault = r#""kind":"robot","name":"delta-1","state":"fault""#;
        hear(&mut line, clock, 1.1, fault);
        let stamps: Vec<(&str, f64)> = line.said.iter().map(|m| (m.kind(), m.stamp())).collect();
        let [("cancel", cancel), ("belt_request", request)] = stamps[..] else {
            panic!("{case} {stamps:?}");
        };
        assert!((cancel - (start + 1.1 + clock)).abs() < 0.02, "{case}");
        assert!((request - (start + 1.1 + ahead)).abs() < 1e-6, "{case}");
        assert!(
            (line.status().stamp - (start + 1.1 + ahead)).abs() < 1e-6,
            "{case}"
        );
        let steps = u64::from(ahead != 0.0);
        assert_eq!(line.noted("clock_step"), steps, "{case}");
        let remarks = line.controller.take_remarks().join("\n");
        let way = if ahead < 0.0 {
            "back by 5 s"
        } else {
            "forward by 100 s"
        };
        let told = remarks.contains(&format!("the machine's clock was set {way}: "));
        assert_eq!(told, ahead != 0.0, "{remarks}");
    }
}

#[test]
fn shares_and_rates_are_of_the_whole_run() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    let status = line.status();
    assert_eq!((status.picked_share, status.picks_per_min), (0.0, 0.0));
    line.ack(100.0, 1);
    line.result(100.5, 1, "PICKED");
    let status = line.status();
    assert_eq!((status.picked_share, status.picks_per_min), (1.0, 120.0));
    line.see(101.0, "b", 1.0, 0.0);
    line.tick(101.0);
    line.ack(101.0, 2);
    line.result(101.5, 2, "PICKED");
    line.see(102.0, "c", 1.0, 0.0);
    line.tick(104.0);
    let status = line.status();
    assert!((status.picked_share - 2.0 / 3.0).abs() < 1e-12);
    assert_eq!(status.picks_per_min, 30.0);
}

/// What was read counts in the next report, and what was never read in none.
#[test]
fn a_report_counts_what_was_read() {
    let mut line = Three::new(0.0);
    line.tick(100.0);
    line.see(100.0, "a", 1.0, 0.0);
    assert_eq!(line.status().seen, 0);
    line.controller.report(false, 3);
    let said = line.controller.take_output();
    let Some(Outgoing::Status(status)) = said.last() else {
        panic!("{said:?}");
    };
    assert_eq!((status.seen, status.last, status.queued), (1, false, 3));
    line.see(100.0, "b", 1.2, 0.0);
    line.controller.stop();
    assert_eq!(line.status().seen, 2);
    // Before the first message it is no time at all.
    let controller = Controller::new(station(), strategy(), config()).unwrap();
    assert_eq!(controller.status(false, 0).stamp, 0.0);
}

/// A value that is most likely wrong is counted and told of once, of a message that counts.
#[test]
fn doubtful_values_are_counted_and_reported() {
    let mut line = Three::new(0.3);
    line.tick(100.0);
    assert!(line.controller.take_doubt().is_none());
    line.see(100.0, "a", -40.0, 0.0);
    assert_eq!(line.noted("doubtful_value"), 1);
    let doubt = line.controller.take_doubt().unwrap();
    assert!(doubt.to_string().contains("-40"), "{doubt}");
    assert!(line.controller.take_doubt().is_none());
    line.see(100.0, "b", 1.0, 0.0);
    assert_eq!(line.noted("doubtful_value"), 1);
    // One that is refused is not questioned as well.
    let wrong = r#""kind":"detection","stamp":100,"id":"c","x":-40,"y":0.4"#;
    line.controller.handle(Three::message(wrong)).unwrap_err();
    assert!(line.controller.take_doubt().is_none());
    assert_eq!(line.noted("doubtful_value"), 1);
}
