//! What an integrator needs on day one: item data reach the robot, tasks come in time, the
//! line can be paused, drained and stopped, and the belt is asked to wait.

use crate::support::three::{Three, config, station, strategy};
use pickline_live::protocol::{BeltRequest, Outgoing};
use pickline_live::{Controller, LineState};

#[test]
fn item_data_reach_the_robot() {
    let mut line = Three::new(0.0);
    line.say(
        r#""kind":"detection","stamp":100,"id":"a","x":1.0,"y":0.0,"angle":1.25,"height":0.08,
           "size":[0.2,0.1],"class":"PET","data":{"grip":{"width":0.05},"lot":[1,2]}"#,
    );
    // What was said last counts, and what is not said stays.
    line.say(r#""kind":"detection","stamp":100.1,"id":"a","x":1.0,"y":0.0,"angle":0.5"#);
    line.robot(100.2, "delta-1", "idle");
    line.tick(100.2);
    let task = line.task();
    assert_eq!(
        (task.angle, task.height, task.size),
        (Some(0.5), Some(0.08), Some([0.2, 0.1]))
    );
    assert_eq!(task.class.as_deref(), Some("PET"));
    let data = serde_json::to_string(&task.data.unwrap()).unwrap();
    assert_eq!(data, r#"{"grip":{"width":0.05},"lot":[1,2]}"#);
}

#[test]
fn impossible_data_are_refused() {
    let refused = |fields: &str| {
        let line = format!(r#"{{"kind":"detection","stamp":1,"x":1.0,"y":0.0,{fields}}}"#);
        pickline_live::protocol::decode(line.as_bytes())
            .unwrap_err()
            .message
    };
    assert!(
        refused(r#""angle":90"#).contains("deg"),
        "{}",
        refused(r#""angle":90"#)
    );
    assert!(refused(r#""height":80"#).contains("mm"));
    assert!(refused(r#""size":[200,0.1]"#).contains("mm"));
    assert!(refused(r#""size":[0.1]"#).contains("size") || !refused(r#""size":[0.1]"#).is_empty());
    assert!(
        refused(r#""data":7"#).contains("map"),
        "{}",
        refused(r#""data":7"#)
    );
    let long = format!(r#""data":{{"a":"{}"}}"#, "x".repeat(5000));
    assert!(refused(&long).contains("at most 4096"));
}

#[test]
fn a_task_comes_its_lead_time_before_its_start() {
    for lead in [0.0, 0.12] {
        let mut line = Three::with(config().with_lead(vec![lead]), 0.3);
        line.robot(100.0, "delta-1", "idle");
        line.see(100.0, "a", 0.0, 0.1);
        line.see(100.0, "b", -0.3, 0.1);
        let mut free = 0.0;
        for step in 0..800 {
            let now = 100.0 + 0.01 * f64::from(step);
            line.tick(now);
            for task in line.said().0 {
                let ahead = task.start - task.decided_at;
                assert!((ahead - lead).abs() < 1e-9, "{ahead}");
                // It is planned for its start, and the robot is not asked twice at once.
                assert!(task.start >= free && task.start >= task.earliest_start - 1e-9);
                let x = [("a", 0.0), ("b", -0.3)]
                    .iter()
                    .find(|i| i.0 == task.item)
                    .unwrap()
                    .1;
                let meets = x + 0.3 * (task.meet_at - 100.0);
                assert!((task.meet.x - meets).abs() < 1e-9);
                free = task.free_at;
                line.ack(now, task.id);
                line.tick(task.free_at);
                line.result(task.free_at, task.id, "PICKED");
            }
        }
        assert_eq!(line.status().picked, 2);
    }
}

#[test]
fn a_paused_line_gives_no_task_until_it_is_resumed() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.robot(100.0, "scara-2", "idle");
    line.say(r#""kind":"pause","stamp":100"#);
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(101.0);
    assert_eq!(
        (line.said(), line.status().mode.as_str()),
        ((vec![], vec![]), "paused")
    );
    // It stays so over a restart.
    let mut state = LineState::default();
    state.apply(line.controller.whole());
    line.controller = Controller::restore(station(), strategy(), config(), state, None).unwrap();
    line.say(r#""kind":"belt","stamp":102,"speed":0"#);
    line.tick(102.0);
    assert_eq!(line.said(), (vec![], vec![]));
    line.say(r#""kind":"resume","stamp":103"#);
    line.tick(103.0);
    let task = line.task();
    line.ack(103.0, task.id);
    // Open tasks are carried out.
    line.say(r#""kind":"pause","stamp":103.1"#);
    line.tick(103.2);
    assert_eq!(line.said(), (vec![], vec![]));
    line.result(104.0, task.id, "PICKED");
    assert_eq!(line.status().picked, 1);
}

#[test]
fn one_robot_is_paused_and_the_others_work() {
    let mut line = Three::new(0.0);
    for robot in ["delta-1", "scara-2"] {
        line.robot(100.0, robot, "idle");
    }
    line.say(r#""kind":"pause","stamp":100,"robot":"delta-1""#);
    line.see(100.0, "a", 1.2, 0.0);
    line.tick(100.0);
    assert_eq!(line.task().robot, "scara-2");
    assert_eq!(line.status().robots[0].state, "paused");
    let unknown = Three::message(r#""kind":"pause","stamp":100,"robot":"r9""#);
    let refused = line.controller.handle(unknown).unwrap_err();
    assert!(refused.message.contains("delta-1"), "{refused:?}");
}

#[test]
fn a_line_that_drains_picks_what_it_knows_and_lets_the_rest_pass() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.say(r#""kind":"drain","stamp":100"#);
    line.see(100.1, "b", 1.2, 0.0);
    line.tick(100.1);
    assert_eq!(line.status().mode, "draining");
    let task = line.task();
    assert_eq!(task.item, "a");
    line.ack(100.1, task.id);
    line.result(101.0, task.id, "PICKED");
    line.tick(110.0);
    assert_eq!(
        (line.said(), line.status().mode.as_str()),
        ((vec![], vec![]), "drained")
    );
    // Resumed, what is still there is picked.
    line.say(r#""kind":"resume","stamp":110"#);
    line.tick(110.0);
    assert_eq!(
        (line.task().item.as_str(), line.status().mode.as_str()),
        ("b", "running")
    );
}

#[test]
fn a_line_that_is_stopped_cancels_what_has_not_been_met() {
    let mut line = Three::two_with_tasks();
    let (tasks, _) = line.said();
    assert_eq!(tasks.len(), 2);
    for task in &tasks {
        line.ack(100.0, task.id);
    }
    let met = tasks
        .iter()
        .min_by(|a, b| a.meet_at.total_cmp(&b.meet_at))
        .unwrap();
    let other = tasks.iter().find(|task| task.id != met.id).unwrap();
    let now = 0.5 * (met.meet_at + other.meet_at);
    line.say(&format!(r#""kind":"stop","stamp":{now}"#));
    line.tick(now);
    let (_, cancels) = line.said();
    assert_eq!(cancels.len(), 1);
    assert!(
        cancels[0].0 == other.id && cancels[0].1.contains("stopped"),
        "{cancels:?}"
    );
    line.result(now + 0.1, other.id, "CANCELLED");
    line.result(now + 0.2, met.id, "PICKED");
    line.tick(now + 5.0);
    assert_eq!(
        (line.said(), line.status().mode.as_str()),
        ((vec![], vec![]), "stopped")
    );
    line.say(&format!(r#""kind":"resume","stamp":{}"#, now + 6.0));
    line.tick(now + 6.0);
    assert_eq!(line.task().item, other.item);
}

#[test]
fn the_belt_is_asked_to_stop_while_no_robot_works() {
    let stopping = config().with_may_stop_belt(true);
    let mut line = Three::with(stopping, 0.3);
    // Before any robot was heard of, the line starts up.
    line.tick(101.0);
    assert_eq!(line.requests(), []);
    line.robot(101.0, "delta-1", "idle");
    line.robot(102.0, "delta-1", "fault");
    line.tick(102.0);
    let asked = line.requests();
    assert_eq!((asked.len(), asked[0].speed), (1, 0.0));
    // It does not follow: asked again, and not more than once a second.
    line.tick(104.5);
    assert_eq!(line.requests().len(), 2);
    line.say(r#""kind":"belt","stamp":104.6,"speed":0"#);
    line.tick(110.0);
    assert_eq!(line.requests(), []);
    line.robot(111.0, "delta-1", "idle");
    line.tick(111.0);
    let asked = line.requests();
    assert_eq!((asked.len(), asked[0].speed), (1, 0.3));
    // Without the flag nothing is asked.
    let mut line = Three::new(0.3);
    line.robot(101.0, "delta-1", "fault");
    line.tick(105.0);
    assert_eq!(line.requests(), []);
}

#[test]
fn a_robot_that_falls_silent_does_not_take_tasks() {
    let stopping = config()
        .with_may_stop_belt(true)
        .with_timeouts(pickline_live::Timeouts::default().with_robot(Some(0.2)));
    let mut line = Three::with(stopping, 0.3);
    line.robot(101.0, "delta-1", "idle");
    line.tick(101.1);
    assert_eq!(line.requests(), []);
    line.tick(102.0);
    let asked = line.requests();
    assert!(
        asked[0].speed == 0.0 && asked[0].reason.contains("no robot"),
        "{asked:?}"
    );
}

#[test]
fn a_belt_that_waits_for_an_item_waits_until_it_is_met() {
    let stopping = config().with_may_stop_belt(true).with_lead(vec![0.6]);
    let mut line = Three::with(stopping, 0.3);
    line.robot(100.0, "delta-1", "busy");
    line.see(100.0, "a", 1.0, 0.0);
    let (mut speed, mut asked, mut tasks, mut cancels) = (0.3, 0, 0, 0);
    let mut free: Option<(f64, u64)> = None;
    for step in 1..1000 {
        let now = 100.0 + 0.01 * f64::from(step);
        if step == 400 {
            line.robot(now, "delta-1", "idle");
        }
        line.say(&format!(r#""kind":"belt","stamp":{now},"speed":{speed}"#));
        if let Some((at, task)) = free.filter(|(at, _)| *at <= now) {
            line.result(at, task, "PICKED");
            free = None;
        }
        line.tick(now);
        for message in std::mem::take(&mut line.said) {
            match message {
                // The drive follows at once.
                Outgoing::BeltRequest(request) => (speed, asked) = (request.speed, asked + 1),
                Outgoing::Task(task) => {
                    tasks += u32::from(task.revision == 0);
                    line.ack(now, task.id);
                    free = Some((task.free_at, task.id));
                }
                Outgoing::Cancel(_) => cancels += 1,
                _ => {}
            }
        }
    }
    assert_eq!((tasks, cancels, line.status().picked), (1, 0, 1));
    // One stop, one request to go on.
    assert_eq!((asked, speed), (2, 0.3));
}

#[test]
fn the_belt_is_asked_to_stop_before_an_item_is_lost() {
    let stopping = config().with_may_stop_belt(true);
    let mut line = Three::with(stopping, 0.3);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.see(100.0, "b", 1.1, 0.0);
    line.tick(100.0);
    let first = line.task();
    line.ack(100.0, first.id);
    // The robot is held up with its first item; the second is about to leave its reach.
    let mut stopped = None;
    for step in 0..400 {
        let now = 100.0 + 0.01 * f64::from(step);
        line.tick(now);
        if let Some(request) = line.requests().first() {
            stopped = Some(request.clone());
            break;
        }
    }
    let stopped = stopped.expect("a request");
    assert!(
        stopped.speed == 0.0 && stopped.reason.contains("reach"),
        "{stopped:?}"
    );
    let now = stopped.stamp + 0.1;
    line.say(&format!(r#""kind":"belt","stamp":{now},"speed":0"#));
    line.result(now + 1.0, first.id, "PICKED");
    line.tick(now + 1.0);
    let second = line.task();
    line.ack(now + 1.0, second.id);
    // While a robot is after it, it is not lost.
    line.tick(now + 1.1);
    let end = second.free_at;
    line.tick(end);
    let go: Vec<BeltRequest> = line.requests();
    line.result(end, second.id, "PICKED");
    line.tick(end + 0.1);
    let all: Vec<f64> = go.iter().chain(&line.requests()).map(|r| r.speed).collect();
    assert_eq!(all, [0.3]);
    assert_eq!(line.status().picked, 2);
}
