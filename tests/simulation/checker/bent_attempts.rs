//! Picks and failed attempts: where, when, by whom, and whether anybody else has the item.

use super::bench::{BELT, Bench, Draft, back, front, idle};
use super::{Bent, assert_refuted};
use nalgebra::Point2;
use pickline::checker::check;
use pickline::decision::{FailureCause, MissReason};
use pickline::pattern::{Item, Pattern};
use pickline::station::{Belt, Robot};

/// Where an attempt leads, and whether its times fit.
#[test]
fn missing_movements_are_refuted() {
    let bends: [Bent; 14] = [
        (
            "a robot that is not there",
            |_, d| d.picks[0].robot = 2,
            "robot 2 picking item 0 at t = 4.666666666666667 s: there is no such robot or item",
        ),
        (
            "an item that is not there",
            |_, d| d.picks[4].item = 7,
            "there is no such robot or item",
        ),
        (
            "a failure at an item that is not there",
            |_, d| d.failures[2].attempt.item = 7,
            "there is no such robot or item",
        ),
        (
            "a grasp that never comes",
            |_, d| d.picks[0].grasp = f64::INFINITY,
            "inf, 5.633333333333333] are not possible in a run",
        ),
        (
            "a decision at no time",
            |_, d| d.picks[4].decide = f64::NAN,
            "the times [NaN, 15.66",
        ),
        (
            "too quick a way",
            |_, d| d.picks[0].decide += 1e-6,
            "travelling 0.3 m does not take",
        ),
        (
            "too slow a way",
            |_, d| d.picks[0].decide -= 1e-6,
            "travelling 0.3 m does not take",
        ),
        (
            "too quick a way to a grasp that fails",
            |_, d| d.failures[0].attempt.decide += 1e-6,
            "m does not take",
        ),
        (
            "an early release",
            |_, d| d.picks[0].release -= 1e-6,
            "it returns at 5.63333333333 s, not 5.6333323333",
        ),
        (
            "a late release",
            |_, d| d.picks[0].release += 1e-6,
            "it returns at 5.63333333333 s, not 5.6333343333",
        ),
        (
            "a late release after a grasp that fails",
            |_, d| d.failures[0].attempt.release += 1e-6,
            "it returns at",
        ),
        (
            "a meeting point ahead of the item",
            |b, d| d.picks[0] = b.trip(0, 0, Point2::new(1.51, -0.2), 5.0),
            "it grasps at (1.51, -0.2) while the item is at (1.5, -0.2)",
        ),
        (
            "a meeting point beside the item",
            |b, d| d.picks[0] = b.trip(0, 0, Point2::new(1.5, -0.21), 5.0),
            "it grasps at (1.5, -0.21) while the item is at (1.5, -0.2)",
        ),
        (
            "a grasp beside the item that fails",
            |b, d| {
                let grasp = d.failures[0].attempt.grasp;
                d.failures[0].attempt = b.trip(1, 4, Point2::new(1.1, 0.01), grasp);
            },
            "it grasps at (1.1, 0.01) while the item is at",
        ),
    ];
    assert_refuted(&bends);
}

/// Everything is right but that the robot does not get there.
#[test]
fn meeting_points_past_the_reach_are_refuted() {
    let words = "its meeting point is 0.95";
    let bends: [Bent; 5] = [
        (
            "downstream",
            |b, d| {
                d.picks[0] = b.pick(0, 0, 2.363);
                d.picks.swap(0, 1);
            },
            words,
        ),
        ("upstream", |b, d| d.picks[0] = b.pick(0, 0, 0.637), words),
        (
            "of a grasp that fails",
            |b, d| d.failures[0] = b.failure(1, 4, 0.76),
            words,
        ),
        (
            "infinitely far away",
            |_, d| d.picks[0].meet.y = f64::NEG_INFINITY,
            "its meeting point is inf m from the base",
        ),
        (
            "of a way that led to nothing",
            |b, d| d.failures[2] = b.vain_way(1, 5, 2.3, Point2::new(2.237, 0.0)),
            words,
        ),
    ];
    assert_refuted(&bends);
}

/// A robot that reaches past both ends of a belt of 3 m.
fn at_an_end(x: f64) -> Bench {
    let robot = Robot {
        base: Point2::new(x, -0.6),
        ..front()
    }
    .with_only_bin(Point2::new(x, -0.5));
    Bench::of(BELT, vec![robot], &[(0.0, -0.2), (-0.6, -0.2)])
}

#[test]
fn meeting_points_off_the_belt_are_refuted() {
    for (base, x, words) in [
        (
            0.0,
            -0.01,
            "its meeting point at x = -0.01 m is off the belt",
        ),
        (3.0, 3.01, "its meeting point at x = 3.01 m is off the belt"),
    ] {
        let bench = at_an_end(base);
        let mut draft = idle(&[MissReason::Busy; 2]);
        draft.missed.remove(1);
        draft.picks.push(bench.pick(0, 1, x));
        let refuted = check(&bench.station, &bench.pattern, &bench.finish(draft));
        let message = refuted.unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}

/// The item can be met in time only by who left before the run began.
#[test]
fn a_decision_before_the_start_is_refuted() {
    let far = Robot {
        base: Point2::new(0.5, -0.6),
        ..front()
    }
    .with_only_bin(Point2::new(0.5, -1.4));
    let bench = Bench::of(BELT, vec![far], &[(0.0, -0.2)]);
    let with = |x: f64| {
        let mut draft = idle(&[]);
        draft.picks.push(bench.pick(0, 0, x));
        check(&bench.station, &bench.pattern, &bench.finish(draft))
    };
    with(0.41).unwrap();
    let message = with(0.2).unwrap_err().to_string();
    assert!(
        message.contains("before the run begins at 0 s"),
        "{message}"
    );
}

/// Infinite times would be within any tolerance.
#[test]
fn a_release_that_never_comes_is_refuted() {
    let bench = Bench::new();
    let mut outcome = bench.finish(bench.run());
    outcome.failures[2].attempt.release = f64::INFINITY;
    let message = check(&bench.station, &bench.pattern, &outcome);
    let message = message.unwrap_err().to_string();
    assert!(
        message.contains("inf] are not possible in a run"),
        "{message}"
    );
}

#[test]
fn items_that_somebody_else_has_are_refuted() {
    let by_front = "the item was already claimed by robot `front`";
    let bends: [Bent; 5] = [
        (
            "an item that another robot has picked",
            |b, d| d.picks.push(b.pick(1, 4, 2.0)),
            by_front,
        ),
        (
            "an item that the robot has picked itself",
            |b, d| {
                d.picks[2] = b.pick(0, 2, 0.8);
                d.picks.insert(4, b.pick(0, 2, 2.0));
            },
            by_front,
        ),
        (
            "an item that another robot is on its way to, in vain",
            |b, d| d.failures[2] = b.failure(1, 5, 1.45),
            by_front,
        ),
        (
            "an item that another robot is just grasping, in vain",
            |b, d| d.failures[2] = b.failure(1, 5, 1.5),
            by_front,
        ),
        (
            "an item that another robot fails at and this one picks",
            |b, d| d.picks[4] = b.pick(0, 4, 1.2),
            "the item was already claimed by robot `back`",
        ),
    ];
    assert_refuted(&bends);
}

#[test]
fn robots_in_two_places_at_once_are_refuted() {
    // Out for item 0 from 6.49 s on, at the item at 7.33 s, free at 8.479 s.
    fn long_pick(bench: &Bench, draft: &mut Draft, next: f64) {
        draft.picks[0] = bench.pick(0, 0, 2.2);
        draft.picks[2] = bench.pick(0, 2, next);
        draft.picks.swap(0, 1);
    }
    let bends: [Bent; 4] = [
        (
            "leaving on the way out",
            |b, d| long_pick(b, d, 0.9),
            "robot 0 picking item 2 at t = 7.25464400750007 s: the robot is busy until 8.479",
        ),
        (
            "leaving on the way back",
            |b, d| long_pick(b, d, 1.1),
            "the robot is busy until 8.479",
        ),
        (
            "leaving on the way back from a grasp that failed",
            |b, d| d.picks[4] = b.pick(1, 4, 1.5),
            "robot 1 picking item 4 at t = 14.444444444444445 s: the robot is busy until 14.67",
        ),
        (
            "failing while busy",
            |b, d| {
                d.picks[4] = b.pick(0, 4, 2.1);
                d.failures[1] = b.failure(0, 5, 1.01);
            },
            "the robot is busy until 18.16",
        ),
    ];
    assert_refuted(&bends);
}

/// In order of decision, ties in robot order, picks and failures each.
#[test]
fn attempts_out_of_order_are_refuted() {
    let words = "attempts are not in order of decision, then robot";
    let bends: [Bent; 3] = [
        ("picks", |_, d| d.picks.swap(0, 1), words),
        ("failures", |_, d| d.failures.swap(1, 2), words),
        (
            "picks of two robots at once",
            |b, d| {
                d.picks[1] = b.leave(1, 1, d.picks[0].decide);
                d.picks.swap(0, 1);
            },
            words,
        ),
    ];
    assert_refuted(&bends);
    let bench = Bench::new();
    let mut draft = bench.run();
    draft.picks[1] = bench.leave(1, 1, draft.picks[0].decide);
    check(&bench.station, &bench.pattern, &bench.finish(draft)).unwrap();
}

/// A failure that takes no time, at an item that another robot leaves for at once.
#[test]
fn at_equal_times_failures_and_picks_go_by_robot() {
    let belt = Belt { speed: 0.5, ..BELT };
    let at_once = Robot {
        grasp_time: 0.0,
        ..front()
    };
    let bench = Bench::of(belt, vec![at_once, back()], &[(0.0, -0.5)]);
    let mut draft = idle(&[]);
    draft.failures.push(bench.failure(0, 0, 1.5));
    assert_eq!(draft.failures[0].attempt.grasp, 3.0);
    draft.picks.push(bench.leave(1, 0, 3.0));
    // `back` gets there.
    let longer = bench.station.with_reach(2.0).unwrap();
    check(&longer, &bench.pattern, &bench.finish(draft)).unwrap();
}

/// Where the pattern says that grasps of an item always succeed, none fails; a robot may still
/// find nothing.
#[test]
fn failed_grasps_of_a_sure_item_are_refuted() {
    let bench = Bench::new();
    let sure = |p_grasp: f64| {
        let items = bench.pattern.items().iter().map(|item| Item {
            p_grasp: Some(p_grasp),
            ..item.clone()
        });
        Pattern::new(items.collect()).unwrap()
    };
    let outcome = bench.finish(bench.run());
    check(&bench.station, &sure(0.999), &outcome).unwrap();
    let message = check(&bench.station, &sure(1.0), &outcome);
    let message = message.unwrap_err().to_string();
    assert!(
        message.contains("robot 1 picking item 4 at t = 12.95")
            && message.contains("no grasp of this item fails"),
        "{message}"
    );
    let mut draft = idle(&[MissReason::GraspFailed, MissReason::Busy]);
    draft.missed[0].item = 5;
    draft.missed[1].item = 6;
    draft.picks = bench.run().picks;
    // Past the reach of `back` the item was never there for it.
    draft.failures = vec![bench.vain_way(1, 5, 2.5, Point2::new(1.9, 0.0))];
    assert_eq!(draft.failures[0].cause, FailureCause::OutOfReach);
    check(&bench.station, &sure(1.0), &bench.finish(draft)).unwrap();
}
