//! Ids that change, return, or stand for another item.

use super::{noted, pick, picture, shown};
use crate::support::line::Line;
use pickline::station::built_in;
use pickline::strategies::read_alone;
use pickline_live::{ClockKind, Config, Controller};

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
fn an_id_switch_does_not_duplicate_an_item() {
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
fn newer_messages_reach_decisions() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let strategy = read_alone("PP,PP", 2).unwrap().make();
    let config = Config::default().with_clock(ClockKind::Messages);
    let mut line = Line(Controller::new(station, strategy, config).unwrap());
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
