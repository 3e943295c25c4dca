//! Which item a detection is of: by place first, by the tracker's id second.

use crate::support::line::Line;
use crate::support::tracker::{Camera, Mistakes, PERIOD, Tracker, World};
use pickline::live::protocol::{Detection, Incoming, Status, Task};
use pickline::live::{Change, ClockKind, Config, Controller, State};
use pickline::pattern::random_stream;
use pickline::station::built_in;
use pickline::strategies::read_alone;

/// One picture: ids, where they are at the stamp.
fn picture(line: &mut Line, stamp: f64, shown: &[(Option<&str>, f64, f64)]) {
    for (id, x, y) in shown {
        line.0
            .handle(Incoming::Detection(Detection {
                stamp,
                id: id.map(str::to_owned),
                x: *x,
                y: *y,
                ..Detection::default()
            }))
            .unwrap();
    }
}

fn noted(status: &Status, what: &str) -> u64 {
    status.noted.get(what).copied().unwrap_or(0)
}

/// Has a task acknowledged and done.
fn pick(line: &mut Line, task: &Task) {
    line.ack(task.start, task.id);
    line.result(task.free_at, task.id, "PICKED");
}

/// Items that are shown: name, x at the time now, y.
fn shown(line: &mut Line) -> Vec<(String, f64, f64)> {
    line.0.close_picture();
    let items = line.0.view(0).items.into_iter();
    items.map(|item| (item.id, item.x, item.y)).collect()
}

/// A tracker that restarts counts from 1 again. Its items are none of the old ones, whether
/// those are in a bin or still on the belt.
#[test]
fn a_tracker_that_restarts_hides_no_item() {
    let mut line = Line::new();
    picture(
        &mut line,
        0.0,
        &[(Some("1"), 1.0, -0.2), (Some("2"), 0.5, -0.2)],
    );
    let mut time = 0.0;
    let mut meets = Vec::new();
    for _ in 0..2 {
        let task = line.task(time);
        pick(&mut line, &task);
        time = task.free_at;
        meets.push(task.meet.x);
    }
    // Half a metre from where items 1 and 2 would be, and at another place across the belt.
    let behind = 0.05 * time;
    picture(
        &mut line,
        time,
        &[
            (Some("1"), 0.5 + behind, -0.2),
            (Some("2"), 0.5 + behind, -0.35),
        ],
    );
    for _ in 0..2 {
        let task = line.task(time);
        assert!(["1", "2"].contains(&task.item.as_str()), "{task:?}");
        pick(&mut line, &task);
        time = task.free_at;
    }
    line.idle(time);
    let status = line.status();
    assert_eq!((status.seen, status.picked), (4, 4));
    assert_eq!(noted(&status, "id_reused"), 2);
    assert_eq!(noted(&status, "split"), 0);
    let remarks = line.0.take_remarks();
    let about: Vec<&String> = remarks.iter().filter(|r| r.contains("id `")).collect();
    assert_eq!(about.len(), 1, "{remarks:?}");
    assert!(about[0].contains("id_reused in the status"));
}

/// An id seen far from its item is another item's; the one before keeps its task, under a
/// name of its own.
#[test]
fn an_id_far_from_its_item_is_another_items() {
    let mut line = Line::new();
    line.see(0.0, "1", 1.0, -0.2);
    let first = line.task(0.0);
    assert_eq!(first.item, "1");
    line.ack(0.0, first.id);
    line.see(0.5, "1", 0.7, -0.3);
    line.idle(0.5);
    let status = line.status();
    assert_eq!((status.seen, status.claimed, status.on_belt), (2, 1, 1));
    let names: Vec<String> = shown(&mut line).into_iter().map(|item| item.0).collect();
    assert_eq!(names, ["1~1", "1"]);
    // Whoever hears of the task again hears of it under the new name.
    line.0.send_again();
    let again = line.task(0.5);
    assert_eq!((again.id, again.item.as_str()), (first.id, "1~1"));
    line.result(first.free_at, first.id, "PICKED");
    let second = line.task(first.free_at);
    assert_eq!(second.item, "1");
    assert!((second.meet.x - (0.7 + 0.05 * (second.meet_at - 0.5))).abs() < 1e-9);
    assert_eq!(noted(&line.status(), "id_reused"), 1);
}

/// After an id switch the same object is the same item: nobody is sent to it twice.
#[test]
fn an_id_switch_makes_no_second_item() {
    let mut line = Line::new();
    line.see(0.0, "a", 1.6, 0.0);
    let task = line.task(0.0);
    line.ack(0.0, task.id);
    for (stamp, id) in [(0.05, "b"), (0.1, "c"), (0.15, "a"), (0.2, "b")] {
        line.see(stamp, id, 1.6 + 0.05 * stamp + 0.003, 0.002);
        let (tasks, cancelled) = line.tick(stamp);
        assert!(tasks.iter().all(|t| t.id == task.id && t.item == "a"));
        assert!(cancelled.is_empty());
    }
    // And without any.
    picture(&mut line, 0.25, &[(None, 1.6 + 0.05 * 0.25, 0.0)]);
    line.tick(0.25);
    let status = line.status();
    assert_eq!((status.seen, status.claimed), (1, 1));
    assert_eq!(noted(&status, "renumbered"), 2);
    line.result(task.free_at, task.id, "PICKED");
    let (tasks, _) = line.tick(task.free_at + 20.0);
    assert_eq!(tasks, []);
    assert_eq!(line.status().picked, 1);
}

/// Every field of a newer detection counts; what it does not say stays.
#[test]
fn newer_news_reach_decisions() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let strategy = read_alone("PP,PP", 2).unwrap().make();
    let config = Config {
        clock: ClockKind::Messages,
        ..Config::default()
    };
    let mut line = Line(Controller::new(station, strategy, config));
    let see = |line: &mut Line, stamp: f64, id: &str, rest: &str| {
        let x = if id == "a" { 1.0 } else { 0.9 } + 0.05 * stamp;
        line.say(&format!(
            r#""kind":"detection","stamp":{stamp},"id":"{id}","x":{x},"y":-0.2,{rest}"#
        ));
    };
    see(&mut line, 0.0, "a", r#""area_cm2":100,"class":"pet""#);
    see(&mut line, 0.0, "b", r#""area_cm2":50"#);
    see(&mut line, 0.1, "a", r#""p_detection":0.5"#);
    see(&mut line, 0.2, "a", r#""p_grasp":0.5,"class":"hdpe""#);
    // Late: nothing of it counts that is known, and it moves nothing.
    see(&mut line, 0.15, "a", r#""p_detection":1,"class":"glass""#);
    line.say(r#""kind":"detection","stamp":0.15,"id":"a","x":1.02,"y":-0.2"#);
    line.0.close_picture();
    let view = line.0.view(0);
    let a = view.items.iter().find(|item| item.id == "a").unwrap();
    assert_eq!(a.class.as_deref(), Some("hdpe"));
    assert!((a.x - (1.0 + 0.05 * 0.2)).abs() < 1e-9, "{a:?}");
    let sigmoid = |area: f64| 1.0 / (1.0 + (-area / 100.0f64).exp());
    assert!((a.weight - 0.25 * sigmoid(100.0)).abs() < 1e-12, "{a:?}");
    // The other one is worth more now.
    line.say(r#""kind":"robot","stamp":0.3,"name":"r1","state":"idle""#);
    let task = line.task(0.3);
    assert_eq!(task.item, "b");
    line.ack(0.3, task.id);
    line.result(task.free_at, task.id, "PICKED");
    let task = line.task(task.free_at);
    assert!((task.priority - 0.25 * sigmoid(100.0)).abs() < 1e-12);
}

/// True neighbours stay two, whatever the tracker calls them, in one picture or in several.
#[test]
fn neighbours_a_few_centimetres_apart_stay_two() {
    let ids: [[Option<&str>; 2]; 5] = [
        [Some("1"), Some("2")],
        [None, None],
        [Some("2"), Some("1")],
        [Some("7"), None],
        [Some("1"), Some("1")],
    ];
    for apart in [0.02, 0.03, 0.05] {
        let mut line = Line::silent(0.0);
        for step in 0..50usize {
            let stamp = 0.05 * step as f64;
            let x = 1.0 + 0.05 * stamp;
            let wobble = 0.002 * (step as f64).sin();
            let [a, b] = ids[step / 7 % ids.len()];
            let two = [(a, x + wobble, 0.1), (b, x + apart, 0.1 + wobble)];
            // Sometimes only one of them is seen.
            let seen = match step % 10 {
                8 => &two[..1],
                9 => &two[1..],
                _ => &two[..],
            };
            picture(&mut line, stamp, seen);
        }
        let items = shown(&mut line);
        let status = line.status();
        assert_eq!((status.seen, items.len()), (2, 2), "{apart}: {items:?}");
        let way = (items[0].1 - items[1].1).abs();
        assert!((way - apart).abs() < 0.005, "{apart}: {items:?}");
    }
}

/// Neighbours are two as well where each detection has a stamp of its own.
#[test]
fn neighbours_stay_two_when_each_is_a_picture_of_its_own() {
    let mut line = Line::silent(0.0);
    for step in 0..100 {
        let stamp = 0.05 * f64::from(step);
        let wobble = 0.002 * f64::from(step).sin();
        let x = 1.0 + 0.05 * stamp + wobble;
        picture(&mut line, stamp, &[(None, x, 0.1)]);
        let later = stamp + 0.001;
        let x = 1.0 + 0.05 * later - wobble;
        picture(&mut line, later, &[(None, x + 0.02, 0.1)]);
    }
    let status = line.status();
    assert_eq!((status.seen, noted(&status, "fused")), (2, 0));
}

/// Two boxes around one item are one item, whatever their ids.
#[test]
fn a_doubled_box_is_no_second_item() {
    let doubles: [[Option<&str>; 2]; 4] = [
        [Some("1"), Some("2")],
        [Some("1"), None],
        [None, None],
        [Some("1"), Some("1")],
    ];
    for [a, b] in doubles {
        let mut line = Line::silent(0.0);
        for step in 0..10 {
            let stamp = 0.05 * f64::from(step);
            let x = -1.0 + 0.05 * stamp;
            picture(&mut line, stamp, &[(a, x, 0.1), (b, x + 0.003, 0.102)]);
        }
        assert_eq!(line.status().seen, 1);
        let what = if a == b && a.is_some() {
            "repeated_detection"
        } else {
            "doubled"
        };
        assert!(noted(&line.status(), what) >= 10);
        assert_eq!(noted(&line.status(), "split"), 0);
    }
}

/// What lies where an item was picked before is another one, and what was picked stays so.
#[test]
fn what_was_picked_stays_picked() {
    for (id, dx, new) in [
        // The tracker still shows it.
        (Some("a"), 0.001, false),
        // Another one, by its number or its place.
        (Some("b"), 0.001, true),
        (None, 0.001, true),
        (Some("a"), 0.5, true),
        (Some("a"), -0.045, true),
    ] {
        let mut line = Line::new();
        line.see(0.0, "a", 1.0, -0.2);
        let task = line.task(0.0);
        pick(&mut line, &task);
        let stamp = task.free_at;
        let x = 1.0 + 0.05 * stamp + dx;
        picture(&mut line, stamp, &[(id, x, -0.2)]);
        let (tasks, _) = line.tick(stamp);
        assert_eq!(tasks.len(), usize::from(new), "{id:?} {dx}");
        let status = line.status();
        assert_eq!((status.picked, status.seen), (1, 1 + u64::from(new)));
        // Old news are of the old item.
        picture(&mut line, 0.1, &[(None, 1.005, -0.2)]);
        assert_eq!(line.status().seen, 1 + u64::from(new));
    }
}

/// An item that has moved a little on the belt is still the same under its id.
#[test]
fn an_item_may_move_a_little_under_its_id() {
    let mut line = Line::silent(0.0);
    line.see(0.0, "a", 1.0, 0.1);
    line.see(1.0, "a", 1.05 + 0.04, 0.1);
    let items = shown(&mut line);
    assert_eq!(items.len(), 1);
    assert!((items[0].1 - 1.09).abs() < 1e-9);
    // Not under another, which is another item then.
    line.see(2.0, "b", 1.14 + 0.04, 0.1);
    assert_eq!(line.status().seen, 2);
}

/// Swapped ids swap no items: each stays where it is, with its claim and its weight.
#[test]
fn swapped_ids_swap_no_items() {
    let mut line = Line::silent(0.0);
    picture(
        &mut line,
        0.0,
        &[(Some("a"), 1.0, 0.1), (Some("b"), 0.97, 0.1)],
    );
    for step in 1..6 {
        let x = 0.0025 * f64::from(step);
        let stamp = 0.05 * f64::from(step);
        let swapped = [(Some("b"), 1.0 + x, 0.1), (Some("a"), 0.97 + x, 0.1)];
        picture(&mut line, stamp, &swapped);
    }
    let items = shown(&mut line);
    assert_eq!(items.len(), 2);
    assert_eq!(items[0].0, "a");
    assert!((items[0].1 - 1.0125).abs() < 1e-9, "{items:?}");
}

/// One id twice in a picture, far apart, is two items.
#[test]
fn one_id_twice_in_a_picture_is_two_items() {
    let mut line = Line::silent(0.0);
    picture(
        &mut line,
        0.0,
        &[(Some("a"), -1.0, 0.1), (Some("a"), -0.5, 0.1)],
    );
    assert_eq!(line.status().seen, 2);
}

/// Items that the tracker made two of, and that no picture shows both of, become one again.
#[test]
fn an_item_that_is_never_seen_beside_its_neighbour_is_its_neighbour() {
    let mut line = Line::silent(0.0);
    picture(
        &mut line,
        0.0,
        &[(Some("a"), -1.0, 0.1), (Some("b"), -0.993, 0.1)],
    );
    assert_eq!(line.status().seen, 2);
    for step in 1..20 {
        let stamp = 0.05 * f64::from(step);
        line.see(stamp, "a", -1.0 + 0.05 * stamp, 0.1);
    }
    let status = line.status();
    assert_eq!((status.seen, status.on_belt), (1, 1));
    assert_eq!(noted(&status, "fused"), 1);
    // If they are two after all, they are so again.
    picture(
        &mut line,
        1.0,
        &[(Some("a"), -0.95, 0.1), (Some("b"), -0.943, 0.1)],
    );
    let status = line.status();
    assert_eq!((status.seen, noted(&status, "split")), (2, 1));
}

/// What has an id keeps it over a restart of the node, and the tracker may restart meanwhile.
#[test]
fn items_are_known_again_after_a_restart() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let mut line = Line::silent(0.0);
    picture(
        &mut line,
        0.0,
        &[(Some("1"), 1.0, 0.1), (Some("2"), 1.5, 0.1)],
    );
    line.say(r#""kind":"detection","stamp":0.1,"id":"1","x":1.005,"y":0.1,"area_cm2":100,"covariance":[1e-4,0,1e-4]"#);
    line.0.close_picture();
    let mut state = State::default();
    let change = serde_json::to_string(&line.0.whole()).unwrap();
    state.apply(serde_json::from_str(&change).unwrap());
    let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
    let config = Config {
        clock: ClockKind::Messages,
        ..Config::default()
    };
    let made = Controller::restore(station, strategy, config, state, None);
    let mut line = Line(made.unwrap());
    // Its id holds for what has moved, and its fields are still known.
    line.say(r#""kind":"detection","stamp":0.2,"id":"1","x":1.05,"y":0.1,"p_detection":0.5"#);
    // The tracker has restarted: 2 is item 1 seen again, and 1 another one.
    picture(
        &mut line,
        0.3,
        &[(Some("2"), 1.055, 0.1), (Some("1"), 0.2, 0.1)],
    );
    let status = line.status();
    assert_eq!(status.seen, 3, "{status:?}");
    assert_eq!(noted(&status, "renumbered"), 1);
    assert_eq!(noted(&status, "id_reused"), 1);
    let view = line.0.view(0);
    let expected = 0.5 / (1.0 + (-1.0f64).exp());
    let old = view.items.iter().find(|item| item.id == "1~1").unwrap();
    assert!((old.weight - expected).abs() < 1e-12, "{old:?}");
}

/// What is seen after a restart before the belt is heard can be placed only then: it may have
/// stood.
#[test]
fn what_is_seen_before_the_belt_is_heard_waits_for_it() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let restore = |line: &mut Line| {
        let mut state = State::default();
        let change = serde_json::to_string(&line.0.whole()).unwrap();
        state.apply(serde_json::from_str(&change).unwrap());
        let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
        let config = Config {
            clock: ClockKind::Messages,
            ..Config::default()
        };
        let made = Controller::restore(station.clone(), strategy, config, state, None);
        Line(made.unwrap())
    };
    let mut line = Line::silent(0.0);
    line.say(r#""kind":"belt","stamp":0,"speed":0.05,"position":0"#);
    picture(
        &mut line,
        0.0,
        &[(Some("1"), 1.0, 0.1), (Some("2"), 1.5, 0.1)],
    );
    line.0.close_picture();
    let mut line = restore(&mut line);
    // It stood after 1 s, for 9 s. One more restart loses nothing of what was seen.
    picture(&mut line, 10.0, &[(Some("1"), 1.05, 0.1)]);
    let mut line = restore(&mut line);
    picture(
        &mut line,
        10.0,
        &[(Some("5"), 1.55, 0.1), (Some("6"), 0.3, 0.1)],
    );
    line.say(r#""kind":"belt","stamp":10.01,"speed":0.05,"position":0.0505"#);
    let status = line.status();
    assert_eq!(status.seen, 3, "{status:?}");
    assert_eq!(
        (noted(&status, "renumbered"), noted(&status, "id_reused")),
        (1, 0)
    );
    let x = shown(&mut line).into_iter().map(|item| item.1);
    let x: Vec<f64> = x.collect();
    for (x, expected) in x.iter().zip([1.5505, 1.0505, 0.3005]) {
        assert!((x - expected).abs() < 1e-3, "{x} {expected}");
    }
}

/// Each camera counts for itself; what two see in one place is one item.
#[test]
fn two_cameras_see_the_same_items() {
    let mut line = Line::silent(0.0);
    for step in 0..20 {
        let stamp = 0.05 * f64::from(step);
        let x = 0.05 * stamp;
        let mut say = |source: &str, id: &str, x: f64| {
            line.say(&format!(
                r#""kind":"detection","stamp":{stamp},"source":"{source}","id":"{id}","x":{x},"y":0.1"#
            ));
        };
        // Both at the same time, in whichever order they come.
        say("left", "1", 1.0 + x);
        say("right", "1", 1.3 + x);
        say("left", "2", 1.3 + x - 0.002);
        say("right", "2", 1.002 + x);
        say("right", "3", 1.05 + x);
    }
    let names: Vec<String> = shown(&mut line).into_iter().map(|item| item.0).collect();
    assert_eq!(names, ["1~1", "3", "1"]);
    let status = line.status();
    assert_eq!((status.seen, noted(&status, "fused")), (3, 2));
    assert_eq!(
        (noted(&status, "renumbered"), noted(&status, "id_reused")),
        (0, 0)
    );
}

/// With the system clock a picture may come in parts; they are one picture.
#[test]
fn a_picture_in_parts_is_one_picture() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
    let mut line = Line(Controller::new(station, strategy, Config::default()));
    line.0.advance(1000.0);
    for stamp in [1000.0, 1000.5] {
        let x = -1.0 + 0.05 * (stamp - 1000.0);
        picture(&mut line, stamp, &[(None, x, 0.1)]);
        line.0.advance(stamp + 0.01);
        picture(&mut line, stamp, &[(None, x + 0.012, 0.1)]);
        line.0.advance(stamp + 0.02);
        // The first one said again.
        picture(&mut line, stamp, &[(None, x, 0.1)]);
        line.0.advance(stamp + 0.03);
    }
    assert_eq!(line.status().seen, 2);
}

/// A detection in the gate is of the item, one beyond it is not: the tolerance, the
/// covariances, and 1 % of the way since it was seen.
#[test]
fn the_gate_is_as_the_protocol_says() {
    let see = |line: &mut Line, stamp: f64, dx: f64, rest: &str| {
        let x = -1.0 + 0.05 * stamp + dx;
        line.say(&format!(
            r#""kind":"detection","stamp":{stamp},"x":{x},"y":0.1{rest}"#
        ));
        line.status().seen
    };
    let tolerance = Config::default().tolerance;
    for (factor, seen) in [(0.99, 1), (1.01, 2)] {
        let mut line = Line::silent(0.0);
        see(&mut line, 0.0, 0.0, "");
        assert_eq!(see(&mut line, 0.1, factor * tolerance, ""), seen);
        // With a standard deviation as large as a third of the tolerance.
        let mut line = Line::silent(0.0);
        see(&mut line, 0.0, 0.0, "");
        let variance = (tolerance / 3.0).powi(2);
        let covariance = format!(r#","covariance":[{variance},0,0]"#);
        let gate = 2f64.sqrt() * tolerance;
        assert_eq!(see(&mut line, 0.1, factor * gate, &covariance), seen);
        // A metre later.
        let mut line = Line::silent(0.0);
        see(&mut line, 0.0, 0.0, "");
        let gate = tolerance.hypot(0.01);
        line.say(r#""kind":"tick","stamp":20"#);
        assert_eq!(see(&mut line, 20.0, factor * gate, ""), seen);
    }
}

/// A node that is killed and started again every now and then knows the same items, by the
/// same names, as one that is not, whatever the tracker does.
#[test]
fn a_node_that_is_killed_now_and_then_knows_the_same_items() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let strategy = || read_alone("SPT,FIFO", 2).unwrap().make();
    let config = Config {
        clock: ClockKind::Messages,
        ..Config::default()
    };
    let through_text = |change: &Change| -> Change {
        serde_json::from_str(&serde_json::to_string(change).unwrap()).unwrap()
    };
    let world = World::dense(150, 0.03, station.belt().speed, 5);
    let mut tracker = Tracker::new(&world, Camera::Area, Mistakes::BAD_DAY, random_stream(5, 2));
    let mut lines = [(); 2].map(|()| Controller::new(station.clone(), strategy(), config.clone()));
    let mut state = State::default();
    state.apply(through_text(&lines[1].whole()));
    let mut kills = 0;
    for number in 0..(world.end() / PERIOD) as usize {
        let stamp = number as f64 * PERIOD;
        let seen = tracker.picture(&world, stamp);
        for line in &mut lines {
            for message in &seen {
                line.handle(message.clone()).unwrap();
            }
            line.handle(Incoming::Tick { stamp }).unwrap();
        }
        if let Some(change) = lines[1].change(true) {
            state.apply(through_text(&change));
        }
        if number % 20 == 7 {
            kills += 1;
            let whole = lines[1].whole();
            let mut at_once = State::default();
            at_once.apply(whole);
            assert_eq!(at_once, state, "{number}");
            lines[1] = Controller::restore(
                station.clone(),
                strategy(),
                config.clone(),
                state.clone(),
                None,
            )
            .unwrap();
            let mut again = State::default();
            again.apply(lines[1].whole());
            assert_eq!(again, state, "{number}");
        }
        let [a, b] = [&lines[0], &lines[1]].map(|line| {
            let mut status = line.status(false, 0);
            // How the sources are is learned again.
            status.sources.clear();
            status
        });
        assert_eq!(a, b, "{number}");
        let sum = a.picked + a.missed.total() + a.on_belt + a.claimed;
        assert_eq!(a.seen, sum);
    }
    let [a, b] = [&lines[0], &lines[1]].map(|line| line.view(0));
    assert_eq!(a.items, b.items);
    assert!(
        kills > 10 && noted(&a.status, "renumbered") > 100,
        "{:?}",
        a.status
    );
    assert!(noted(&a.status, "id_reused") + noted(&a.status, "split") > 0);
    assert!(noted(&a.status, "fused") > 0 && noted(&a.status, "doubled") > 10);
}

#[test]
fn every_item_of_a_ring_that_swaps_ids_is_renumbered() {
    let mut line = Line::new();
    let places = [-1.0, -1.2, -1.4];
    let shown = |ids: [&'static str; 3]| -> Vec<(Option<&'static str>, f64, f64)> {
        let places = places.iter().zip(ids);
        places.map(|(x, id)| (Some(id), *x, 0.0)).collect()
    };
    line.say(r#""kind":"belt","stamp":0,"speed":0"#);
    picture(&mut line, 1.0, &shown(["7", "8", "9"]));
    picture(&mut line, 2.0, &shown(["8", "9", "7"]));
    line.idle(3.0);
    let status = line.status();
    assert_eq!((status.seen, noted(&status, "renumbered")), (3, 3));
}
