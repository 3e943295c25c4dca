//! What a station may be: every value at its limits and past them.

use nalgebra::Point2;
use pickline::error::Result;
use pickline::kinematics::Arm;
use pickline::station::{Belt, Line, Robot, Station};

pub const BELT: Belt = Belt {
    speed: 0.05,
    length: 4.0,
    width: 1.0,
};

pub fn robot(name: &str, x: f64) -> Robot {
    Robot::new(
        name,
        Point2::new(x, -0.6),
        Point2::new(x, -0.5),
        0.8,
        pickline::kinematics::Arm::constant(0.5),
    )
    .with_dwell(0.1, 0.2)
}

fn assert_blamed(made: Result<Station>, words: &[&str], case: &str) {
    let message = made.expect_err(case).to_string();
    for word in words {
        assert!(message.contains(word), "{case}: {word} not in {message}");
    }
}

/// A belt and two robots with one value changed.
fn with(change: impl Fn(&mut Belt, &mut Robot)) -> Result<Station> {
    let (mut belt, mut second) = (BELT, robot("b", 2.0));
    change(&mut belt, &mut second);
    Station::new(belt, vec![robot("a", 1.0), second])
}

#[test]
fn every_value_of_a_station_is_checked_against_its_limits() {
    type Set = fn(&mut Belt, &mut Robot, f64);
    let size = "is not a usable size";
    let place = "is not a valid position";
    let time = "is not a valid dwell time";
    let none = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    // Key, how it is set, values at the limits, values past them, and what is said of those.
    type Limits = (&'static str, Set, [f64; 2], [f64; 2], &'static str);
    let values: [Limits; 9] = [
        (
            "belt.length",
            |b, _, v| b.length = v,
            [1e-6, 1e6],
            [0.9e-6, 1.1e6],
            size,
        ),
        (
            "belt.width",
            |b, _, v| b.width = v,
            [1e-6, 1e6],
            [0.9e-6, 1.1e6],
            size,
        ),
        (
            "robot[1].base",
            |_, r, v| r.base.y = v,
            [-1e6, 1e6],
            [-1.1e6, 1.1e6],
            place,
        ),
        (
            "robot[1].bin[0].at",
            |_, r, v| r.bins[0].at.x = v,
            [-1e6, 1e6],
            [-1.1e6, 1.1e6],
            place,
        ),
        (
            "robot[1].bin[0].at",
            |_, r, v| r.bins[0].at.y = v,
            [-1e6, 1e6],
            [-1.1e6, 1.1e6],
            place,
        ),
        (
            "robot[1].reach",
            |_, r, v| r.reach = v,
            [1e-6, 1e6],
            [0.9e-6, 1.1e6],
            size,
        ),
        (
            "robot[1].speed",
            |_, r, v| r.arm = Arm::constant(v),
            [0.06, 1e6],
            [0.9e-6, 1.1e6],
            size,
        ),
        (
            "robot[1].grasp_time",
            |_, r, v| r.grasp_time = v,
            [0.0, 1e6],
            [-1e-9, 1.1e6],
            time,
        ),
        (
            "robot[1].bin[0].release_time",
            |_, r, v| r.bins[0].release_time = v,
            [0.0, 1e6],
            [-1e-9, 1.1e6],
            time,
        ),
    ];
    for (key, set, good, bad, words) in values {
        for value in good {
            with(|b, r| set(b, r, value)).unwrap_or_else(|e| panic!("{key} = {value}: {e}"));
        }
        for value in bad.into_iter().chain(none) {
            let made = with(|b, r| set(b, r, value));
            assert_blamed(
                made,
                &[&format!("{key}: "), words],
                &format!("{key} = {value}"),
            );
        }
    }
    // A base in order is further downstream than the one before.
    with(|_, r| r.base.x = 1e6).unwrap();
    assert_blamed(
        with(|_, r| r.base.x = 1.1e6),
        &["robot[1].base: ", place],
        "base.x",
    );
    for speed in [1e-6, 0.49] {
        with(|b, _| b.speed = speed).unwrap();
    }
    for speed in [0.9e-6, 0.0, -0.05].into_iter().chain(none) {
        let made = with(|b, _| b.speed = speed);
        assert_blamed(
            made,
            &["belt.speed: ", size],
            &format!("belt.speed = {speed}"),
        );
    }
}

/// An arm is at least a millionth faster than the belt.
#[test]
fn arms_are_faster_than_the_belt() {
    with(|b, r| r.arm = Arm::constant(b.speed * (1.0 + 1e-6))).unwrap();
    let hardly = "not faster by one millionth or more than the belt at 0.05 m/s";
    let slower = "not faster than the belt at 0.05 m/s";
    for (slower, problem) in [(1.0 + 0.9e-6, hardly), (1.0, slower), (0.9, slower)] {
        let words = ["robot[1].speed: ", "the arm of robot `b`", problem];
        let made = with(|b, r| r.arm = Arm::constant(b.speed * slower));
        assert_blamed(made, &words, &format!("{slower}"));
    }
    let station = with(|_, r| r.arm = Arm::constant(0.3)).unwrap();
    assert_eq!(station.slowest_arm(), 0.3);
    assert!(
        station.is_faster_than(0.29)
            && !station.is_faster_than(0.3)
            && !station.is_faster_than(0.4)
    );
}

#[test]
fn a_station_has_1_to_100_robots_in_order_with_names_of_their_own() {
    let many = |count: usize| {
        let robots = (0..count).map(|i| robot(&format!("r{i}"), 0.01 * i as f64));
        Station::new(BELT, robots.collect())
    };
    assert_eq!(many(1).unwrap().robots().len(), 1);
    assert_eq!(many(100).unwrap().robots().len(), 100);
    assert_blamed(
        many(0),
        &["robot: the station has no robots", "give 1 to 100 robots"],
        "none",
    );
    assert_blamed(many(101), &["robot: 101 robots on one line"], "101");
    let three = |names: [&str; 3], x: [f64; 3]| {
        let robots = names.iter().zip(x).map(|(name, x)| robot(name, x));
        Station::new(BELT, robots.collect())
    };
    three(["a", "b", "c"], [1.0, 1.0, 2.0]).unwrap();
    // With the first as well as with the neighbour.
    for names in [["a", "b", "a"], ["a", "b", "b"]] {
        let words = ["robot[2].name: ", "two robots are named"];
        assert_blamed(three(names, [1.0, 1.5, 2.0]), &words, "names");
    }
    let words = ["robot[2].base: ", "is upstream of `b`"];
    assert_blamed(three(["a", "b", "c"], [1.0, 2.0, 1.5]), &words, "order");
    let blank = three(["a", " b", "c"], [1.0, 2.0, 3.0]);
    assert_blamed(blank, &["robot[1].name: "], "blank");
}

/// Bases and bins move along by what their spacing asks for, the belt's end with the last.
#[test]
fn spacing_counts_from_the_first_robot() {
    let robots = vec![robot("a", 0.5), robot("b", 1.5), robot("c", 4.0)];
    let belt = Belt {
        length: 5.0,
        ..BELT
    };
    let station = Station::new(belt, robots).unwrap();
    let spaced = station.with_spacing(0.75).unwrap();
    let places: Vec<_> = spaced
        .robots()
        .iter()
        .map(|r| (r.base.x, r.bins[0].at.x))
        .collect();
    assert_eq!(places, [(0.5, 0.5), (1.25, 1.25), (2.0, 2.0)]);
    let across: Vec<_> = spaced
        .robots()
        .iter()
        .map(|r| (r.base.y, r.bins[0].at.y))
        .collect();
    assert_eq!(across, [(-0.6, -0.5); 3]);
    assert_eq!(spaced.belt().length, 3.0);
    assert_eq!(spaced.belt().width, belt.width);
}

/// Robots of a line alternate, and the belt ends behind the last one's reach.
#[test]
fn a_line_is_placed_as_it_says() {
    let line = Line {
        robots: 3,
        first_base_x: 1.0,
        spacing: 0.5,
        base_offset: 0.25,
        bins: pickline::station::LineBins::AtEdge(0.125),
        rest: None,
        tail: 0.75,
        reach: 0.5,
        arm: Arm::constant(2.0),
        grasp_time: 0.1,
        release_time: 0.2,
    };
    assert_eq!(line.belt_length(), 1.0 + 2.0 * 0.5 + 0.5 + 0.75);
    let belt = line.belt(0.25, 1.5);
    assert_eq!((belt.speed, belt.length, belt.width), (0.25, 3.25, 1.5));
    let placed: Vec<_> = line
        .place(1.5)
        .into_iter()
        .map(|r| {
            assert_eq!(
                (
                    r.reach,
                    r.arm.constant_speed().unwrap(),
                    r.grasp_time,
                    r.bins[0].release_time,
                ),
                (0.5, 2.0, 0.1, 0.2)
            );
            (
                r.name,
                (r.base.x, r.base.y),
                (r.bins[0].at.x, r.bins[0].at.y),
            )
        })
        .collect();
    let expected = [
        ("r1".to_owned(), (1.0, -1.0), (1.0, -0.875)),
        ("r2".to_owned(), (1.5, 1.0), (1.5, 0.875)),
        ("r3".to_owned(), (2.0, -1.0), (2.0, -0.875)),
    ];
    assert_eq!(placed, expected);
}

/// Both ends of a window belong to it; it begins at 0 s at the earliest.
#[test]
fn windows_are_measured_from_the_start_of_the_run() {
    // 1 m/s towards the item, 0.5 m/s behind it: see the events.
    let even = Robot {
        base: Point2::new(1.0, 0.0),
        reach: 0.75,
        arm: pickline::kinematics::Arm::constant(0.75),
        ..robot("a", 1.0)
    }
    .with_only_bin(Point2::new(1.0, 0.0));
    let belt = Belt {
        speed: 0.25,
        ..BELT
    };
    for (x0, window) in [
        (-1.0, Some((4.0, 10.0))),
        (0.0, Some((0.0, 6.0))),
        (1.0, Some((0.0, 2.0))),
        (1.5, Some((0.0, 0.0))),
        (1.625, None),
    ] {
        assert_eq!(even.departure_window(&belt, 0, x0, 0.0), window, "{x0}");
    }
}
