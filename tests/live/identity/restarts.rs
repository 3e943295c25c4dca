//! A node that is started again knows the same items.

use super::{noted, picture, shown};
use crate::support::line::Line;
use crate::support::tracker::{Camera, Mistakes, PERIOD, Tracker, World};
use pickline::pattern::random_stream;
use pickline::station::built_in;
use pickline::strategies::read_alone;
use pickline_live::protocol::Incoming;
use pickline_live::{ClockKind, Config, Controller, LineState, StateChange};

/// The same line after a restart of the node.
fn restore(line: &mut Line) -> Line {
    let mut state = LineState::default();
    let change = serde_json::to_string(&line.0.whole()).unwrap();
    state.apply(serde_json::from_str(&change).unwrap());
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
    let config = Config::default().with_clock(ClockKind::Messages);
    Line(Controller::restore(station, strategy, config, state, None).unwrap())
}

/// What has an id keeps it over a restart of the node, and the tracker may restart meanwhile.
#[test]
fn items_are_known_again_after_a_restart() {
    let mut line = Line::silent(0.0);
    picture(
        &mut line,
        0.0,
        &[(Some("1"), 1.0, 0.1), (Some("2"), 1.5, 0.1)],
    );
    line.say(r#""kind":"detection","stamp":0.1,"id":"1","x":1.005,"y":0.1,"area_cm2":100,"covariance":[1e-4,0,1e-4]"#);
    line.0.close_picture();
    let mut line = restore(&mut line);
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
    assert_eq!(x.len(), 3);
    for (x, expected) in x.iter().zip([1.5505, 1.0505, 0.3005]) {
        assert!((x - expected).abs() < 1e-3, "{x} {expected}");
    }
}

/// A node that is killed and started again every now and then knows the same items, by the
/// same names, as one that is not, whatever the tracker does.
#[test]
fn a_node_that_is_killed_now_and_then_knows_the_same_items() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let strategy = || read_alone("SPT,FIFO", 2).unwrap().make();
    let config = Config::default().with_clock(ClockKind::Messages);
    let through_text = |change: &StateChange| -> StateChange {
        serde_json::from_str(&serde_json::to_string(change).unwrap()).unwrap()
    };
    let world = World::dense(150, 0.03, station.belt().speed, 5);
    let mut tracker = Tracker::new(&world, Camera::Area, Mistakes::BAD_DAY, random_stream(5, 2));
    let mut lines =
        [(); 2].map(|()| Controller::new(station.clone(), strategy(), config.clone()).unwrap());
    let mut state = LineState::default();
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
            let mut at_once = LineState::default();
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
            let mut again = LineState::default();
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

/// How far around a detection its item is looked for follows from the widest item that is
/// known, before a restart as after it.
#[test]
fn an_item_of_an_unsure_camera_is_known_again_after_a_restart() {
    for is_restarted in [false, true] {
        let mut line = Line::silent(0.0);
        // Standard deviations of 20 mm: three of them and the tolerance are 61.8 mm.
        line.say(r#""kind":"detection","stamp":0,"x":1.0,"y":0.1,"covariance":[4e-4,0,4e-4]"#);
        line.tick(0.0);
        if is_restarted {
            line = restore(&mut line);
        }
        picture(&mut line, 0.1, &[(None, 1.005 + 0.055, 0.1)]);
        assert_eq!(line.status().seen, 1, "{is_restarted}");
        picture(&mut line, 0.2, &[(None, 1.01 + 0.2, 0.1)]);
        assert_eq!(line.status().seen, 2, "{is_restarted}");
    }
}
