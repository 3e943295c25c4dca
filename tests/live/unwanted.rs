//! Items that are left on the belt on purpose, on a line that sorts.

use super::support::line::Line;
use pickline::station::built_in;
use pickline::strategies::read_alone;
use pickline_live::{ClockKind, Config, Controller};

/// The built-in station `sorting`, on which wood is not wanted and nobody has a bin for glass. Its
/// first arm is idle; it stands at x = 1.3 m, and the belt is 8 m long at 0.3 m/s.
fn sorting() -> Line {
    let station = built_in("sorting").unwrap().station(None).unwrap();
    let strategy = read_alone("SPT,SPT,SPT,SPT", 4).unwrap().make();
    let config = Config::default().with_clock(ClockKind::Messages);
    let mut line = Line(Controller::new(station, strategy, config).unwrap());
    line.say(r#""kind":"robot","stamp":0,"name":"r1","state":"idle""#);
    line
}

fn see(line: &mut Line, stamp: f64, id: &str, x: f64, class: &str) {
    line.say(&format!(
        r#""kind":"detection","stamp":{stamp},"id":"{id}","x":{x},"y":0.1{class}"#
    ));
}

const WOOD: &str = r#","class":"wood""#;
const PET: &str = r#","class":"pet""#;

/// They are counted apart from the time when they are seen, and do not enter the share.
#[test]
fn unwanted_items_are_neither_missed_nor_on_the_belt() {
    let mut line = sorting();
    assert_eq!(line.status().unwanted, Some(0));
    see(&mut line, 0.0, "pet", 0.9, PET);
    see(&mut line, 0.0, "wood", 0.6, WOOD);
    see(&mut line, 0.0, "glass", 0.3, r#","class":"glass""#);
    see(&mut line, 0.0, "what", 0.0, "");
    let status = line.status();
    assert_eq!((status.unwanted, status.on_belt), (Some(3), 1));
    let task = line.task(0.1);
    assert_eq!(
        (&*task.item, task.bin_name.as_deref()),
        ("pet", Some("pet"))
    );
    line.ack(0.1, task.id);
    line.result(task.free_at, task.id, "PICKED");
    // While they are known, and after they are forgotten.
    for now in [5.0, 100.0] {
        line.idle(now);
        let status = line.status();
        let counts = (
            status.seen,
            status.picked,
            status.missed.total(),
            status.unwanted,
        );
        assert_eq!(counts, (4, 1, 0, Some(3)), "{now}");
        assert_eq!(status.picked_share, 1.0);
    }
}

/// A class may be known only later, and may turn out to be another one.
#[test]
fn an_item_is_unwanted_by_the_class_that_is_known() {
    let mut line = sorting();
    see(&mut line, 0.0, "a", 0.3, "");
    see(&mut line, 0.0, "b", 0.0, PET);
    assert_eq!(
        (line.status().unwanted, line.status().on_belt),
        (Some(1), 1)
    );
    see(&mut line, 0.5, "a", 0.45, PET);
    assert_eq!(
        (line.status().unwanted, line.status().on_belt),
        (Some(0), 2)
    );
    see(&mut line, 0.5, "b", 0.15, WOOD);
    assert_eq!(
        (line.status().unwanted, line.status().on_belt),
        (Some(1), 1)
    );
    assert_eq!(line.task(2.0).item, "a");
}

/// A tracker may become surer of an item, or less sure.
#[test]
fn an_uncertain_item_is_left_until_the_camera_is_surer() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
    let config = Config::default()
        .with_clock(ClockKind::Messages)
        .with_min_detection(0.5);
    let mut line = Line(Controller::new(station, strategy, config).unwrap());
    line.say(r#""kind":"robot","stamp":0,"name":"r1","state":"idle""#);
    let counts = |line: &mut Line| (line.status().unwanted, line.status().on_belt);
    see(&mut line, 0.0, "a", 1.0, r#","p_detection":0.4"#);
    see(&mut line, 0.0, "b", 0.8, r#","p_detection":0.5"#);
    see(&mut line, 0.0, "c", 0.7, "");
    assert_eq!(counts(&mut line), (Some(1), 2));
    see(&mut line, 0.1, "a", 1.005, r#","p_detection":0.6"#);
    see(&mut line, 0.1, "b", 0.805, r#","p_detection":0.1"#);
    assert_eq!(counts(&mut line), (Some(1), 2));
    let task = line.task(0.2);
    assert_eq!(task.item, "a");
    line.ack(0.2, task.id);
    line.result(task.free_at, task.id, "PICKED");
    assert_eq!(line.task(4.0).item, "c");
}

/// The dashboard shows them as what they are, and an idle arm beside the bin that it went to last.
#[test]
fn views_show_what_is_left_and_where_arms_wait() {
    let mut line = sorting();
    see(&mut line, 0.0, "wood", 0.6, WOOD);
    line.idle(0.0);
    let view = line.0.view(0);
    let fates: Vec<_> = view
        .items
        .iter()
        .map(|i| (&*i.id, i.fate, i.reason))
        .collect();
    assert!(fates.contains(&("wood", "left", None)), "{fates:?}");
    let station = built_in("sorting").unwrap().station(None).unwrap();
    let robots = station.robots();
    let rests: Vec<[f64; 2]> = robots.iter().map(|r| [r.rest.x, r.rest.y]).collect();
    assert_eq!(view.places, rests);
    see(&mut line, 0.0, "pet", 0.9, PET);
    see(&mut line, 0.0, "paper", 0.3, r#","class":"paper""#);
    for (item, after) in [("pet", 0.1), ("paper", 0.7)] {
        let stamp = line.0.status(false, 0).stamp + after;
        let task = line.task(stamp);
        assert_eq!(task.item, item);
        line.ack(stamp, task.id);
        line.result(task.free_at, task.id, "PICKED");
        let bin = robots[0].bins.iter().find(|bin| bin.name == item).unwrap();
        let places = line.0.view(0).places;
        assert_eq!(places[0], [bin.at.x, bin.at.y]);
        assert_eq!(places[1..], rests[1..]);
    }
}

/// A line that takes everything says nothing new.
#[test]
fn a_line_that_takes_everything_has_no_unwanted_items() {
    let mut line = Line::new();
    line.see(0.0, "a", 0.5, 0.0);
    let status = serde_json::to_value(line.status()).unwrap();
    assert!(status.get("unwanted").is_none(), "{status}");
    let view = serde_json::to_value(line.0.view(0)).unwrap();
    assert!(view.get("places").is_none(), "{view}");
}
