//! Neighbours, doubled boxes and pictures of several cameras: one item or two.

use super::{noted, picture, shown};
use crate::support::line::Line;
use pickline::station::built_in;
use pickline::strategies::read_alone;
use pickline_live::{Config, Controller};

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
fn a_duplicate_box_does_not_duplicate_an_item() {
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
    let mut line = Line(Controller::new(station, strategy, Config::default()).unwrap());
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

/// Two cameras need not see the same: one that has never seen an item does not miss it. The one
/// that has seen it does.
#[test]
fn a_camera_misses_only_what_it_has_seen() {
    let mut line = Line::silent(0.0);
    line.say(r#""kind":"belt","stamp":0,"speed":0"#);
    let see = |line: &mut Line, stamp: f64, source: &str, id: &str, x: f64| {
        line.say(&format!(
            r#""kind":"detection","stamp":{stamp},"source":"{source}","id":"{id}","x":{x},"y":0.1"#
        ));
    };
    see(&mut line, 0.0, "north", "a", 1.0);
    see(&mut line, 0.0, "north", "b", 1.006);
    line.tick(0.0);
    for step in 1..=40 {
        let stamp = 0.1 * f64::from(step);
        see(&mut line, stamp, "south", "7", 1.0);
        line.tick(stamp);
        assert_eq!(line.status().seen, 2, "{step}");
    }
    for step in 41..=80 {
        let stamp = 0.1 * f64::from(step);
        see(&mut line, stamp, "north", "a", 1.0);
        line.tick(stamp);
    }
    assert_eq!(line.status().seen, 1);
}
