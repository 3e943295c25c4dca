//! What is shown to whoever watches the line.

use crate::support::three::{Three, config};
use pickline_live::ItemView;

fn near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-9, "{value}, not {expected}");
}

#[test]
fn every_field_of_a_view() {
    let mut line = Three::new(0.3);
    for robot in ["delta-1", "arm-3"] {
        line.robot(100.0, robot, "idle");
    }
    line.say(r#""kind":"detection","stamp":100,"id":"a","x":1.0,"y":0.1,"weight":2,"class":"PET""#);
    // 0.5 m before the belt and past it are shown, and no more.
    for (id, x) in [("b", 3.7), ("c", -0.7), ("d", -0.9), ("e", 3.99)] {
        line.see(100.0, id, x, -0.2);
    }
    line.tick(101.0);
    let view = line.controller.view(9);
    assert_eq!(view.status, line.controller.status(false, 9));
    assert_eq!(
        (view.status.queued, view.steady, view.left_out),
        (9, false, 0)
    );
    near(view.belt_speed, 0.3);
    near(view.belt_travel, 0.3);
    assert_eq!(view.latency, line.controller.latency());
    let item = |id: &str, x: f64, fate: &'static str| {
        let mut item = ItemView::default();
        item.id = id.into();
        (item.x, item.y, item.weight, item.fate) = (x, -0.2, 0.5, fate);
        item
    };
    let mut claimed = item("a", 1.3, "claimed");
    (claimed.y, claimed.weight) = (0.1, 2.0);
    (claimed.class, claimed.robot) = (Some("PET".into()), Some(0));
    let mut missed = item("e", 4.29, "missed");
    missed.reason = Some("unreachable");
    let mut shown = view.items.clone();
    shown.sort_by(|a, b| a.id.cmp(&b.id));
    let expected = [
        claimed,
        // It is on the belt's last millimetres.
        item("b", 4.0, "waiting"),
        item("c", -0.4, "waiting"),
        missed,
    ];
    assert_eq!(shown.len(), expected.len(), "{shown:?}");
    for (shown, expected) in shown.iter().zip(&expected) {
        near(shown.x, expected.x);
        let mut shown = shown.clone();
        shown.x = expected.x;
        assert_eq!(&shown, expected);
    }
    let (mut tasks, _) = line.said();
    let task = tasks.pop().unwrap();
    assert_eq!(view.claims.len(), 1);
    let claim = &view.claims[0];
    assert_eq!((claim.task, claim.robot), (1, 0));
    assert_eq!((claim.item.as_str(), claim.stage), ("a", "sent"));
    assert_eq!(claim.revision, task.revision);
    assert_eq!(claim.meet, [task.meet.x, task.meet.y]);
    near(claim.start, task.start);
    near(claim.meet_at, task.meet_at);
    near(claim.free_at, task.free_at);
}

/// A claim is shown with its stage and times as they are now, and no more once it is recalled.
#[test]
fn a_claim_is_shown_as_it_stands() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "arm-3", "idle");
    line.see(100.0, "a", 2.6, 0.0);
    line.tick(100.0);
    let first = line.task();
    let claim = |line: &Three| line.controller.view(0).claims.first().cloned();
    let shown = claim(&line).unwrap();
    assert_eq!((shown.stage, shown.robot, shown.revision), ("sent", 2, 0));
    near(shown.start, first.start);
    near(shown.meet_at, first.meet_at);
    near(shown.free_at, first.free_at);
    assert_eq!(shown.meet, [first.meet.x, first.meet.y]);
    line.tick(101.0);
    let again = line.said().0.remove(0);
    let shown = claim(&line).unwrap();
    assert_eq!((shown.stage, shown.revision), ("sent", 1));
    near(shown.start, again.start);
    line.ack(101.0, 1);
    assert_eq!(claim(&line).unwrap().stage, "acknowledged");
    line.say(r#""kind":"stop","stamp":101.1"#);
    assert_eq!(claim(&line).unwrap().stage, "cancelling");
    line.robot(101.2, "arm-3", "fault");
    assert_eq!(claim(&line), None);
    assert_eq!(line.controller.view(0).items[0].robot, None);
}

/// What was picked is not shown; what was missed is, with the reason, until it has left.
#[test]
fn picked_items_are_not_shown() {
    let mut line = Three::new(0.0);
    line.robot(100.0, "delta-1", "idle");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    line.ack(100.0, 1);
    line.result(100.5, 1, "PICKED");
    assert_eq!(line.controller.view(0).items, []);
    line.see(101.0, "b", 1.0, 0.1);
    line.tick(101.0);
    line.ack(101.0, 2);
    line.tick(110.0);
    let items = line.controller.view(0).items;
    assert_eq!(
        (items[0].fate, items[0].reason),
        ("missed", Some("no_result"))
    );
}

/// Picks so far and whether each robot is at work, upstream first.
#[test]
fn the_workload_is_that_of_each_robot() {
    let mut line = Three::new(0.0);
    let workload = |line: &Three| line.controller.workload().collect::<Vec<_>>();
    assert_eq!(workload(&line), [(0, false); 3]);
    line.robot(100.0, "delta-1", "idle");
    line.robot(100.0, "arm-3", "busy");
    line.see(100.0, "a", 1.0, 0.0);
    line.tick(100.0);
    assert_eq!(workload(&line), [(0, true), (0, false), (0, true)]);
    line.ack(100.0, 1);
    line.result(100.5, 1, "PICKED");
    assert_eq!(workload(&line), [(1, false), (0, false), (0, true)]);
    line.robot(101.0, "arm-3", "fault");
    assert_eq!(workload(&line), [(1, false), (0, false), (0, false)]);
}

/// With the system clock a view is one of a clock that goes on by itself.
#[test]
fn a_view_says_whose_clock_it_is() {
    let line = Three {
        controller: pickline_live::Controller::new(
            crate::support::three::station(),
            crate::support::three::strategy(),
            config().with_clock(pickline_live::ClockKind::System),
        )
        .unwrap(),
        said: Vec::new(),
    };
    assert!(line.controller.view(0).steady);
}

/// Of a crowd as many are shown as there is room for, the same ones each time, and the rest is
/// counted.
#[test]
fn many_items_are_shown_in_part() {
    for (count, every) in [(2000u32, 1u32), (2001, 2), (4001, 3)] {
        let mut line = Three::new(0.0);
        for i in 0..count {
            let x = 3.9 - 0.015 * f64::from(i / 20);
            let y = -0.29 + 0.03 * f64::from(i % 20);
            line.controller
                .handle(Three::message(&format!(
                    r#""kind":"detection","stamp":100,"id":"{i}","x":{x},"y":{y}"#
                )))
                .unwrap();
        }
        line.tick(100.0);
        let view = line.controller.view(0);
        let shown = count.div_ceil(every) as usize;
        assert_eq!(view.items.len(), shown, "{count}");
        assert_eq!(view.left_out, count as usize - shown, "{count}");
        let is_regular = |item: &ItemView| item.id.parse::<u32>().unwrap() % every == 0;
        assert!(view.items.iter().all(is_regular));
    }
}

/// Half a metre before the belt and past it items are shown.
#[test]
fn how_far_around_the_belt_items_are_shown() {
    for (at, x, is_shown) in [
        (101.65, 3.99, true),
        (101.60, -0.99, false),
        (101.65, -0.99, true),
    ] {
        let mut line = Three::new(0.3);
        line.see(100.0, "a", x, 0.0);
        line.tick(at);
        let shown = line.controller.view(0).items.len();
        assert_eq!(shown, usize::from(is_shown), "{at} {x}");
    }
}
