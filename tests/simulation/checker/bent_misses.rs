//! The list of missed items: which they are, and why each was missed.

use super::bench::{BELT, Bench, back, front, idle};
use super::{Bent, assert_refuted};
use nalgebra::Point2;
use pickline::checker::check;
use pickline::decision::{Miss, MissReason};
use pickline::station::{Belt, Robot};

const fn miss(item: u32, reason: MissReason) -> Miss {
    Miss { item, reason }
}

#[test]
fn lists_of_different_items_are_refuted() {
    let words = "the missed items do not match: 2 items were not picked, 2 are listed as missed";
    let bends: [Bent; 6] = [
        (
            "a miss left out",
            |_, d| d.missed.truncate(1),
            "2 items were not picked, 1 are listed as missed",
        ),
        (
            "a failed attempt left out",
            |_, d| {
                d.missed.remove(0);
            },
            "2 items were not picked, 1 are listed as missed",
        ),
        (
            "an item that was picked",
            |_, d| d.missed.insert(0, miss(4, MissReason::GraspFailed)),
            "2 items were not picked, 3 are listed as missed",
        ),
        ("another item", |_, d| d.missed[1].item = 3, words),
        ("one of them twice", |_, d| d.missed[1].item = 5, words),
        ("upstream first", |_, d| d.missed.swap(0, 1), words),
    ];
    assert_refuted(&bends);
}

#[test]
fn wrong_reasons_are_refuted() {
    let bends: [Bent; 7] = [
        (
            "an item in reach",
            |_, d| d.missed[1].reason = MissReason::Unreachable,
            "item 6 is listed as unreachable, but a robot can meet it",
        ),
        (
            "an attempted item in reach",
            |_, d| d.missed[0].reason = MissReason::Unreachable,
            "item 5 is listed as unreachable, but a robot can meet it",
        ),
        (
            "failures where there were none",
            |_, d| d.missed[1].reason = MissReason::GraspFailed,
            "item 6 is listed as grasp_failed, but was not attempted",
        ),
        (
            "failures that are not a reason: busy",
            |_, d| d.missed[0].reason = MissReason::Busy,
            "item 5 is listed as busy, but was attempted",
        ),
        (
            "failures that are not a reason: passed over",
            |_, d| d.missed[0].reason = MissReason::PassedOver,
            "item 5 is listed as passed_over, but was attempted",
        ),
        (
            "failures that are not a reason: unseen",
            |_, d| d.missed[0].reason = MissReason::Unseen,
            "item 5 is listed as unseen, but was attempted",
        ),
        (
            "one attempt is enough",
            |_, d| {
                d.failures.truncate(2);
                d.missed[0].reason = MissReason::Busy;
            },
            "item 5 is listed as busy, but was attempted",
        ),
    ];
    assert_refuted(&bends);
    // Of items that nobody left for, what the robots did otherwise is not asked.
    for reason in [MissReason::Busy, MissReason::PassedOver, MissReason::Unseen] {
        let bench = Bench::new();
        let mut draft = bench.run();
        draft.missed[1].reason = reason;
        check(&bench.station, &bench.pattern, &bench.finish(draft)).unwrap();
    }
}

/// Where the one robot stands, and whether it can meet the one item.
struct Place {
    name: &'static str,
    base: (f64, f64),
    bin: (f64, f64),
    reach: f64,
    /// x at time 0 and y of the item.
    item: (f64, f64),
    reachable: bool,
}

/// A belt and an arm whose times come out even: what touches its limit is not rounded.
const EVEN: Belt = Belt {
    speed: 0.25,
    length: 3.0,
    width: 1.0,
};

impl Place {
    const fn plain(name: &'static str, reachable: bool) -> Self {
        Self {
            name,
            base: (1.5, -0.5),
            bin: (1.5, -0.5),
            reach: 0.5,
            item: (0.0, -0.5),
            reachable,
        }
    }

    fn bench(&self) -> Bench {
        let robot = Robot {
            base: Point2::new(self.base.0, self.base.1),
            reach: self.reach,
            arm: pickline::kinematics::Arm::constant(0.5),
            ..front()
        }
        .with_only_bin(Point2::new(self.bin.0, self.bin.1));
        Bench::of(EVEN, vec![robot], &[self.item])
    }
}

fn places() -> Vec<Place> {
    let plain = Place::plain;
    vec![
        plain("in the workspace", true),
        Place {
            item: (0.0, 0.0),
            ..plain("touches the workspace in a point", true)
        },
        Place {
            item: (0.0, 1e-3),
            ..plain("passes on the left", false)
        },
        Place {
            base: (1.5, 0.5),
            item: (0.0, -1e-3),
            ..plain("passes on the right", false)
        },
        Place {
            base: (-0.5, -0.5),
            item: (-9.0, -0.5),
            ..plain("the workspace ends at the belt's start", true)
        },
        Place {
            base: (-0.501, -0.5),
            item: (-9.0, -0.5),
            ..plain("the workspace ends before the belt's start", false)
        },
        Place {
            base: (3.5, -0.5),
            ..plain("the workspace begins at the belt's end", true)
        },
        Place {
            base: (3.501, -0.5),
            ..plain("the workspace begins behind the belt's end", false)
        },
        // At x = 2 after 8 s, the belt's end after 12 s.
        Place {
            bin: (2.0, -4.5),
            ..plain("there in time from far across", true)
        },
        Place {
            bin: (2.0, -4.501),
            ..plain("too late from far across", false)
        },
        Place {
            bin: (6.0, -0.5),
            ..plain("there in time from far downstream", true)
        },
        Place {
            bin: (6.001, -0.5),
            ..plain("too late from far downstream", false)
        },
        Place {
            bin: (-2.001, -0.5),
            ..plain("too late from far upstream", false)
        },
        Place {
            bin: (2.0, -6.5),
            item: (-1.0, -0.5),
            ..plain("there in time for an item that comes later", true)
        },
        Place {
            bin: (2.0, -6.501),
            item: (-1.0, -0.5),
            ..plain("too late for an item that comes later", false)
        },
        Place {
            base: (3.25, -0.5),
            bin: (3.0, -6.5),
            ..plain("there in time for the belt's end", true)
        },
        Place {
            base: (3.25, -0.5),
            bin: (3.0, -6.501),
            ..plain("too late for the belt's end", false)
        },
        Place {
            base: (1.5, -0.75),
            reach: 1.25,
            bin: (2.5, -5.0),
            item: (0.0, 0.0),
            ..plain("in time where the circle is left", true)
        },
        Place {
            base: (1.5, -0.75),
            reach: 1.25,
            bin: (2.5, -5.001),
            item: (0.0, 0.0),
            ..plain("too late where the circle is left", false)
        },
    ]
}

/// An item is unreachable exactly if the robot, leaving at the start or later, cannot meet it
/// within its reach and on the belt.
#[test]
fn unreachable_is_what_no_robot_can_meet() {
    for place in places() {
        let bench = place.bench();
        let listed = |reason| {
            let outcome = bench.finish(idle(&[reason]));
            check(&bench.station, &bench.pattern, &outcome)
        };
        let (right, wrong, words) = match place.reachable {
            true => (
                listed(MissReason::Busy),
                listed(MissReason::Unreachable),
                "item 0 is listed as unreachable, but a robot can meet it",
            ),
            false => (
                listed(MissReason::Unreachable),
                listed(MissReason::Busy),
                "item 0 is listed as busy, but no robot can meet it",
            ),
        };
        right.expect(place.name);
        let message = wrong.expect_err(place.name).to_string();
        assert!(message.contains(words), "{}: {message}", place.name);
    }
}

/// One robot that can meet it is enough, whichever it is.
#[test]
fn an_item_is_reachable_by_any_robot() {
    for y in [-0.5, 0.5] {
        let bench = Bench::of(BELT, vec![front(), back()], &[(0.0, y)]);
        let listed = |reason| {
            let outcome = bench.finish(idle(&[reason]));
            check(&bench.station, &bench.pattern, &outcome)
        };
        listed(MissReason::Busy).unwrap();
        let message = listed(MissReason::Unreachable).unwrap_err().to_string();
        assert!(message.contains("a robot can meet it"), "{message}");
    }
}

/// An item that no robot can meet where it is, though one left for it where it was reported.
#[test]
fn what_nobody_can_meet_is_unreachable_even_if_attempted() {
    let bench = Bench::of(BELT, vec![front()], &[(0.0, 0.5)]);
    let listed = |reason| {
        let mut draft = idle(&[reason]);
        let way = bench.vain_way(0, 0, 1.5, Point2::new(1.5, 0.2));
        draft.failures.push(way);
        check(&bench.station, &bench.pattern, &bench.finish(draft))
    };
    listed(MissReason::Unreachable).unwrap();
    let message = listed(MissReason::GraspFailed).unwrap_err().to_string();
    assert!(
        message.contains("item 0 is listed as grasp_failed, but no robot can meet it"),
        "{message}"
    );
}
