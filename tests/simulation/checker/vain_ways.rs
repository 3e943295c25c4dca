//! Attempts that find nothing: that they went somewhere, and that the item was indeed where
//! the robot could not have met it.

use super::bench::{BELT, Bench, front, idle};
use super::{Bent, assert_refuted};
use nalgebra::Point2;
use pickline::checker::check;
use pickline::decision::MissReason;
use pickline::station::Robot;

/// In the bench's run `back` goes to item 5 in vain, which is past its reach by then.
fn in_vain(bench: &Bench) -> pickline::decision::Failure {
    bench.vain_way(1, 5, 2.2, Point2::new(2.0, 0.1))
}

#[test]
fn failed_movements_are_checked_against_their_times() {
    let bench = Bench::new();
    let mut draft = bench.run();
    draft.failures[2] = in_vain(&bench);
    check(&bench.station, &bench.pattern, &bench.finish(draft)).unwrap();
    let bends: [Bent; 5] = [
        (
            "a grasp that became a vain way",
            |_, d| d.failures[0].cause = pickline::decision::FailureCause::OutOfReach,
            "robot 1 picking item 4 at t = 12.955",
        ),
        (
            "too quick a way",
            |b, d| {
                d.failures[2] = in_vain(b);
                d.failures[2].attempt.grasp -= 1e-6;
                d.failures[2].attempt.release -= 1e-6;
            },
            "m does not take",
        ),
        (
            "too slow a way",
            |b, d| {
                d.failures[2] = in_vain(b);
                d.failures[2].attempt.grasp += 1e-6;
                d.failures[2].attempt.release += 1e-6;
            },
            "m does not take",
        ),
        (
            "an early return",
            |b, d| {
                d.failures[2] = in_vain(b);
                d.failures[2].attempt.release -= 1e-6;
            },
            "it returns at",
        ),
        (
            "an item that is just in reach",
            |b, d| d.failures[2] = b.vain_way(1, 5, 2.17, Point2::new(2.0, 0.1)),
            "it found nothing, but it could have met the item at (2.1",
        ),
    ];
    assert_refuted(&bends);
}

/// Where the robot could meet the one item, leaving when it did; where it went instead.
struct Way {
    name: &'static str,
    robot: Robot,
    item: (f64, f64),
    meets: f64,
    goes: (f64, f64),
    in_vain: bool,
}

impl Way {
    /// The robot's base and bin are at `x` [m].
    fn of(name: &'static str, x: f64, meets: f64, in_vain: bool) -> Self {
        let robot = Robot {
            base: Point2::new(x, -0.6),
            ..front()
        }
        .with_only_bin(Point2::new(x, -0.5));
        Self {
            name,
            robot,
            item: (-3.0, -0.2),
            meets,
            goes: (x, 0.0),
            in_vain,
        }
    }

    fn bin(mut self, x: f64, y: f64) -> Self {
        self.robot = self.robot.clone().with_only_bin(Point2::new(x, y));
        self
    }
}

/// The item lies 0.4 m from the base across, so the reach of 0.9 m ends 0.80623 m along the
/// belt from the base.
#[test]
fn a_failed_movement_needs_an_item_that_could_not_be_met() {
    let half = (0.9f64 * 0.9 - 0.4 * 0.4).sqrt();
    let near = 1e-6;
    let mut ways = vec![
        Way::of("in the middle", 1.5, 1.5, false),
        Way::of("before the reach", 1.5, 1.5 - half - near, true),
        Way::of("just in reach upstream", 1.5, 1.5 - half + near, false),
        Way::of("just in reach downstream", 1.5, 1.5 + half - near, false),
        Way::of("past the reach", 1.5, 1.5 + half + near, true),
        // From bins that make the way long, one for each direction.
        Way::of("past the reach from upstream", 1.5, 1.5 + half + near, true).bin(0.8, -0.9),
        Way::of("in reach from upstream", 1.5, 1.5 + half - near, false).bin(0.8, -0.9),
        Way::of(
            "past the reach from downstream",
            1.5,
            1.5 + half + near,
            true,
        )
        .bin(2.2, 0.3),
        Way::of("in reach from downstream", 1.5, 1.5 + half - near, false).bin(2.2, 0.3),
        Way::of(
            "before the reach from downstream",
            1.5,
            1.5 - half - near,
            true,
        )
        .bin(2.2, 0.3),
        Way::of(
            "in reach upstream from downstream",
            1.5,
            1.5 - half + near,
            false,
        )
        .bin(2.2, 0.3),
        // Within reach, but off the belt.
        Way::of("upstream of the belt", 0.5, -near, true).bin(0.2, -0.5),
        Way::of("at the belt's start", 0.5, near, false).bin(0.2, -0.5),
        Way::of("behind the belt", 2.5, 3.0 + near, true),
        Way::of("at the belt's end", 2.5, 3.0 - near, false),
    ];
    // Beside the workspace all the way.
    let mut beside = Way::of("out of reach across", 1.5, 1.5, true);
    beside.item.1 = 0.4;
    ways.push(beside);
    for way in ways {
        let bench = Bench::of(BELT, vec![way.robot.clone()], &[way.item]);
        let goes = Point2::new(way.goes.0, way.goes.1);
        let reason = match way.item.1 > 0.3 {
            true => MissReason::Unreachable,
            false => MissReason::GraspFailed,
        };
        let mut draft = idle(&[reason]);
        draft.failures.push(bench.vain_way(0, 0, way.meets, goes));
        let outcome = bench.finish(draft);
        let checked = check(&bench.station, &bench.pattern, &outcome);
        if way.in_vain {
            checked.expect(way.name);
        } else {
            let message = checked.expect_err(way.name).to_string();
            let words = "it found nothing, but it could have met the item at (";
            let (_, place) = message.split_once(words).expect(&message);
            let x: f64 = place.split(',').next().unwrap().parse().unwrap();
            assert!((x - way.meets).abs() < 1e-8, "{}: {message}", way.name);
        }
    }
}
