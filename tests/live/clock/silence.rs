//! Sources that fall silent.

use super::World;
use crate::support::line::Line;
use pickline_live::protocol::{Outgoing, SourceKind};
use pickline_live::{Config, Timeouts};

#[test]
fn a_belt_that_falls_silent_stops_new_tasks_until_it_is_heard() {
    for (belt, last) in [(None, 1.0), (Some(3.0), 3.0), (Some(0.0), f64::INFINITY)] {
        let config =
            Config::default().with_timeouts(Timeouts::default().with_belt(belt).with_robot(None));
        let mut world = World::new(config);
        world.encoder_until = 6.0;
        world.play(20.0, &[]);
        let given = world.given.last().unwrap().0;
        if last.is_infinite() {
            assert!(given > 18.0, "{given}");
            assert!(world.remarks.is_empty() && !world.source("belt").overdue);
            continue;
        }
        assert!((6.0..=6.02 + last).contains(&given), "{belt:?}: {given}");
        assert!(world.source("belt").overdue);
        assert!((world.source("belt").age - 14.0).abs() < 0.02);
        assert!(
            world.remarks.len() == 1 && world.remarks[0].contains("'belt_timeout'"),
            "{:?}",
            world.remarks
        );
        world.encoder_until = f64::INFINITY;
        world.play(25.0, &[]);
        assert!(world.given.last().unwrap().0 > 24.0);
        assert!(world.remarks[1].contains("`belt` is heard again"));
        assert!(!world.source("belt").overdue);
    }
}

#[test]
fn a_robot_that_falls_silent_gets_no_task_until_it_is_heard() {
    let mut line = Line::silent(0.0);
    let idle = |stamp: f64, name: &str| {
        format!(r#""kind":"robot","stamp":{stamp},"name":"{name}","state":"idle""#)
    };
    // One that reports all the time, and one that says how it is once.
    for i in 0..60 {
        line.say(&idle(0.1 * f64::from(i), "r1"));
    }
    line.say(&idle(5.9, "r2"));
    line.see(6.0, "a", 1.0, -0.2);
    assert_eq!(line.task(6.0).robot, "r1");
    line.result(6.1, 1, "PICKED");
    line.see(8.0, "b", 1.0, -0.3);
    line.see(8.0, "c", 2.6, 0.3);
    let task = line.task(8.0);
    assert_eq!((task.robot.as_str(), task.item.as_str()), ("r2", "c"));
    let sources = line.0.status(false, 0).sources;
    let overdue: Vec<_> = sources
        .iter()
        .map(|s| (s.name.as_str(), s.overdue))
        .collect();
    assert_eq!(overdue, [("camera", false), ("r1", true), ("r2", false)]);
    assert!(line.0.take_remarks()[0].contains("robot `r1` has been silent for 1.9 s"));
    line.say(&idle(9.0, "r1"));
    let (tasks, _) = line.tick(9.0);
    assert!(
        tasks
            .iter()
            .any(|task| task.item == "b" && task.robot == "r1")
    );
}

/// What is not overdue with ticks of one size is not with ticks of another.
#[test]
fn with_message_time_silence_is_measured_by_the_stamps() {
    let play = |ticks: &[f64]| {
        let mut line = Line::silent(1.0);
        for i in 0..=60 {
            let stamp = 0.1 * f64::from(i);
            line.say(&format!(r#""kind":"belt","stamp":{stamp},"speed":0.05"#));
        }
        line.say(r#""kind":"robot","stamp":6,"name":"r1","state":"idle""#);
        // It reaches the robot while the belt is silent.
        line.see(6.0, "a", 0.3, -0.2);
        let mut said = Vec::new();
        for tick in ticks {
            line.say(&format!(r#""kind":"tick","stamp":{tick}"#));
            said.append(&mut line.0.take_output());
        }
        said.retain(|message| !matches!(message, Outgoing::Due(_)));
        said
    };
    let said = play(&[30.0]);
    assert!(!said.is_empty() && said.iter().all(|message| message.kind() == "status"));
    assert_eq!(said, play(&[8.0, 8.1, 9.7, 20.0, 30.0]));
}

/// A drive and an encoder may both tell of the belt: while one of them speaks it is known.
#[test]
fn a_belt_is_known_as_long_as_one_of_its_sources_speaks() {
    let mut line = Line::silent(0.0);
    for i in 0..=120 {
        let stamp = 0.1 * f64::from(i);
        for source in ["drive", "encoder"] {
            if source == "encoder" || i <= 60 {
                line.say(&format!(
                    r#""kind":"belt","stamp":{stamp},"speed":0.05,"source":"{source}""#
                ));
            }
        }
    }
    line.say(r#""kind":"robot","stamp":12,"name":"r1","state":"idle""#);
    line.say(r#""kind":"robot","stamp":12,"name":"r2","state":"idle""#);
    line.see(12.0, "a", 1.0, -0.2);
    let task = line.task(12.0);
    line.ack(12.0, task.id);
    let overdue = |line: &Line| {
        let sources = line.0.status(false, 0).sources.into_iter();
        let belts = sources.filter(|source| source.kind == SourceKind::Belt);
        belts.map(|source| source.overdue).collect::<Vec<bool>>()
    };
    assert_eq!(overdue(&line), [true, false]);
    // Ten of its periods later the other one is silent too.
    line.see(13.1, "b", 2.6, 0.3);
    let (tasks, _) = line.tick(13.1);
    assert_eq!(overdue(&line), [true, true]);
    assert!(tasks.iter().all(|task| task.item != "b"), "{tasks:?}");
}

/// The table of docs/protocol.md: ten periods, and at least a second; for a camera ten.
#[test]
fn who_is_silent_for_how_long() {
    let belt = r#""kind":"belt","speed":0.05"#;
    let robot = r#""kind":"robot","name":"r1","state":"idle""#;
    let camera = r#""kind":"detection","id":"a","x":0,"y":0"#;
    for (fields, period, silence) in [
        (belt, 0.05, 1.0),
        (belt, 0.5, 5.0),
        (robot, 0.05, 1.0),
        (robot, 0.5, 5.0),
        (camera, 0.05, 10.0),
        (camera, 0.5, 10.0),
        (camera, 2.0, 20.0),
    ] {
        let case = format!("{fields} every {period} s");
        let mut line = Line::silent(0.0);
        let mut stamp = 0.0;
        // The second time a camera is not told of.
        for remarks in [1, usize::from(fields != camera)] {
            for _ in 0..60 {
                stamp += period;
                line.say(&format!(r#""stamp":{stamp},{fields}"#));
            }
            let mut after = |silence: f64| {
                line.say(&format!(r#""kind":"tick","stamp":{}"#, stamp + silence));
                let told = line.0.take_remarks().into_iter();
                let told = told.filter(|remark| remark.contains(" has been silent for "));
                (told.count(), line.0.status(false, 0).sources[0].overdue)
            };
            assert_eq!(after(silence - 0.01), (0, false), "{case}");
            assert_eq!(after(silence + 0.01), (remarks, true), "{case}");
            stamp += silence + 0.01;
        }
    }
}
