//! The keys of real lines in a station file: every one wrong in turn, and what is written is read
//! back.

use pickline::kinematics::TravelLaw;
use pickline::station::{BUILT_INS, Overrides, Station, parse, to_toml};

/// A station with all of it. Line numbers count from here.
const GOOD: &str = r#"[belt]
speed = 0.3
length = 4.0
width = 0.8

[[class]]
name = "pet"
value = 2.0

[[class]]
name = "wood"
wanted = false

[[robot]]
name = "r1"
base = [1.0, -0.5]
reach = 0.8
speed = 3.0
acceleration = 25.0
deceleration = 20.0
lift = 0.05
grasp_time = 0.1
release_time = 0.1
rest = [1.0, -0.5]

[[robot.bin]]
name = "pet"
at = [1.0, -0.6]
classes = ["pet"]
release_time = 0.2

[[robot.bin]]
at = [1.4, -0.6]

[[robot]]
name = "r2"
base = [2.5, 0.5]
bin = [2.5, 0.6]
reach = 0.8
travel = [[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]
grasp_time = 0.1
release_time = 0.1
"#;

fn read(text: &str) -> Station {
    parse(text, "t", Overrides::default()).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[test]
fn everything_is_read_and_read_back() {
    let station = read(GOOD);
    let [first, second] = station.robots() else {
        panic!("two robots")
    };
    assert_eq!(
        first.arm.law,
        TravelLaw::Trapezoid {
            speed: 3.0,
            acceleration: 25.0,
            deceleration: 20.0
        }
    );
    assert_eq!(
        (first.arm.lift, first.bins.len(), first.places()),
        (0.05, 2, 3)
    );
    let names: Vec<_> = first.bins.iter().map(|bin| bin.name.as_str()).collect();
    assert_eq!(names, ["pet", "b2"]);
    let releases: Vec<_> = first.bins.iter().map(|bin| bin.release_time).collect();
    assert_eq!(releases, [0.2, 0.1]);
    assert_eq!(first.bin_for(Some("pet")), Some(0));
    assert_eq!(
        (first.bin_for(Some("glass")), first.bin_for(None)),
        (Some(1), Some(1))
    );
    assert!(second.has_only_bin() && !second.is_plain());
    assert!(!station.takes(station.class_id(Some("wood"))));
    assert_eq!(station.value_of(station.class_id(Some("pet"))), 2.0);
    assert_eq!(read(&to_toml(&station)), station);
    for built_in in BUILT_INS {
        let station = built_in.station(None).unwrap();
        assert_eq!(read(&to_toml(&station)), station);
        assert_eq!(station.is_plain(), built_in.name.starts_with("paper"));
    }
}

/// The same keys in a line, relative to the base and mirrored for the robots on the other side.
#[test]
fn a_line_takes_the_same_keys() {
    let station = read(
        r#"[belt]
speed = 0.3
width = 0.8
[line]
robots = 2
first_base_x = 1.0
spacing = 2.0
base_offset = 0.1
tail = 0.5
reach = 0.8
speed = 3.0
acceleration = 25.0
lift = 0.05
rest = [0.0, 0.05]
grasp_time = 0.1
release_time = 0.1
[[line.bin]]
name = "pet"
offset = [0.2, 0.1]
classes = ["pet"]
[[line.bin]]
offset = [-0.2, 0.1]
"#,
    );
    let places: Vec<_> = station
        .robots()
        .iter()
        .map(|r| (r.bins[0].at.x, r.bins[0].at.y, r.rest.x, r.rest.y))
        .collect();
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    let expected = [(1.2, -0.6, 1.0, -0.55), (3.2, 0.6, 3.0, 0.55)];
    for (got, wanted) in places.iter().zip(expected) {
        let pairs = [
            (got.0, wanted.0),
            (got.1, wanted.1),
            (got.2, wanted.2),
            (got.3, wanted.3),
        ];
        assert!(
            pairs.iter().all(|(a, b)| near(*a, *b)),
            "{got:?} {wanted:?}"
        );
    }
}

#[test]
fn every_key_that_is_wrong_is_named() {
    for (from, to, words) in [
        (
            "acceleration = 25.0",
            "acceleration = 0",
            &["t:19: robot[0].acceleration", "usable size"][..],
        ),
        (
            "acceleration = 25.0",
            "acceleration = nan",
            &["t:19: robot[0].acceleration", "NaN"],
        ),
        (
            "acceleration = 25.0",
            "acceleration = \"25\"",
            &["robot[0].acceleration", "not a number"],
        ),
        (
            "acceleration = 25.0\n",
            "",
            &["robot[0].deceleration", "without an acceleration"],
        ),
        (
            "deceleration = 20.0",
            "deceleration = -1",
            &["t:20: robot[0].deceleration", "-1"],
        ),
        (
            "lift = 0.05",
            "lift = -0.1",
            &["t:21: robot[0].lift", "not a valid length"],
        ),
        ("lift = 0.05", "lift = inf", &["robot[0].lift", "inf"]),
        (
            "lift = 0.05",
            "lft = 0.05",
            &["robot[0].lft", "did you mean `lift`"],
        ),
        (
            "rest = [1.0, -0.5]",
            "rest = [1.0]",
            &["robot[0].rest", "not a position"],
        ),
        (
            "rest = [1.0, -0.5]",
            "rest = [1e9, 0]",
            &["robot[0].rest", "not a valid position"],
        ),
        (
            "at = [1.0, -0.6]",
            "at = [1.0, \"a\"]",
            &["robot[0].bin[0].at", "not a position"],
        ),
        ("at = [1.0, -0.6]\n", "", &["robot[0].bin[0].at", "missing"]),
        (
            "at = [1.4, -0.6]",
            "at = [1e9, 0]",
            &["robot[0].bin[1].at", "not a valid position"],
        ),
        (
            "name = \"pet\"\nat",
            "name = \"\"\nat",
            &["robot[0].bin[0].name", "is empty"],
        ),
        (
            "name = \"pet\"\nat",
            "name = \"b2\"\nat",
            &["robot[0].bin[1].name", "two bins"],
        ),
        (
            "classes = [\"pet\"]",
            "classes = []",
            &["robot[0].bin[0].classes", "takes no class"],
        ),
        (
            "classes = [\"pet\"]",
            "classes = \"pet\"",
            &["robot[0].bin[0].classes", "list of strings"],
        ),
        (
            "classes = [\"pet\"]",
            "classes = [1]",
            &["robot[0].bin[0].classes", "list of strings"],
        ),
        (
            "classes = [\"pet\"]",
            "classes = [\"a\", \"a\"]",
            &["robot[0].bin[0].classes", "class `a`"],
        ),
        (
            "classes = [\"pet\"]\n",
            "",
            &["robot[0].bin[1].classes", "both take every class"],
        ),
        (
            "at = [1.4, -0.6]",
            "at = [1.4, -0.6]\nclasses = [\"pet\"]",
            &["robot[0].bin[1].classes", "class `pet`"],
        ),
        (
            "release_time = 0.2",
            "release_time = -0.2",
            &["robot[0].bin[0].release_time", "dwell"],
        ),
        (
            "release_time = 0.2",
            "size = 3",
            &["robot[0].bin[0].size", "unknown key"],
        ),
        (
            "travel = [[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]",
            "travel = 3",
            &["robot[1].travel", "list of points"],
        ),
        (
            "travel = [[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]",
            "travel = [[0.0, 0.1]]",
            &["robot[1].travel", "1 point"],
        ),
        (
            "[[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]",
            "[[0.1, 0.1], [0.2, 0.2]]",
            &["robot[1].travel", "not at length 0"],
        ),
        (
            "[[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]",
            "[[0.0, 0.1], [0.2, 0.05]]",
            &["robot[1].travel", "less time"],
        ),
        (
            "[[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]",
            "[[0.0, 0.1], [0.2, 0.2], [0.2, 0.3]]",
            &["robot[1].travel", "not longer"],
        ),
        (
            "[[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]",
            "[[0.0, -0.1], [0.2, 0.2]]",
            &["robot[1].travel", "point 1"],
        ),
        (
            "[[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]",
            "[[0.0, 0.1], [0.2, nan]]",
            &["robot[1].travel", "NaN"],
        ),
        (
            "[[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]",
            "[[0.0, 0.1], [0.2, 1.2]]",
            &["robot[1].travel", "too steep", "0.1818 m/s"],
        ),
        (
            "travel = [[0.0",
            "speed = 1\ntravel = [[0.0",
            &["robot[1].travel", "as well"],
        ),
        (
            "travel = [[0.0, 0.1], [0.2, 0.2], [1.0, 0.5]]\n",
            "",
            &["robot[1].speed", "missing"],
        ),
        (
            "value = 2.0",
            "value = -1",
            &["class[0].value", "-1 is not a valid value"],
        ),
        ("value = 2.0", "value = nan", &["class[0].value", "NaN"]),
        (
            "wanted = false",
            "wanted = 0",
            &["class[1].wanted", "neither true nor false"],
        ),
        (
            "wanted = false",
            "wnated = false",
            &["class[1].wnated", "did you mean `wanted`"],
        ),
        (
            "name = \"wood\"",
            "name = \"pet\"",
            &["class[1].name", "two classes"],
        ),
        ("name = \"wood\"\n", "", &["class[1].name", "missing"]),
    ] {
        let text = GOOD.replacen(from, to, 1);
        assert_ne!(text, GOOD, "{from}");
        let message = match parse(&text, "t", Overrides::default()) {
            Ok(_) => panic!("{to} is accepted"),
            Err(error) => error.to_string(),
        };
        for word in words {
            assert!(message.contains(word), "{to}: {word} not in {message}");
        }
    }
}

/// An arm that accelerates is slower than its belt over short paths. What the message says would do
/// does.
#[test]
fn an_arm_that_is_slower_than_its_belt_near_its_bin_is_told_what_would_do() {
    let near = GOOD.replacen("lift = 0.05", "lift = 0.0", 1).replacen(
        "at = [1.0, -0.6]",
        "at = [1.0, -0.401]",
        1,
    );
    let message = parse(&near, "t", Overrides::default())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("`r1`") && message.contains("0.3 m/s"),
        "{message}"
    );
    let number = |after: &str| -> f64 {
        let start = message
            .find(after)
            .unwrap_or_else(|| panic!("{after} not in {message}"));
        let rest = &message[start + after.len()..];
        let end = rest.find(' ').unwrap();
        rest[..end].parse().unwrap()
    };
    let (lift, belt) = (number("a lift of "), number("a belt of "));
    let factor = number("an acceleration of ") / 25.0;
    let ok = |text: String| parse(&text, "t", Overrides::default()).is_ok();
    assert!(ok(near.replacen(
        "lift = 0.0",
        &format!("lift = {lift}"),
        1
    )));
    assert!(ok(near.replacen(
        "speed = 0.3",
        &format!("speed = {belt}"),
        1
    )));
    let stronger = near
        .replacen(
            "acceleration = 25.0",
            &format!("acceleration = {}", 25.0 * factor),
            1,
        )
        .replacen(
            "deceleration = 20.0",
            &format!("deceleration = {}", 20.0 * factor),
            1,
        );
    assert!(ok(stronger));
    // And hardly more than needed.
    assert!(!ok(near.replacen(
        "lift = 0.0",
        &format!("lift = {}", 0.99 * lift),
        1
    )));
    assert!(!ok(near.replacen(
        "speed = 0.3",
        &format!("speed = {}", 1.01 * belt),
        1
    )));
    // At the belt's edge only a lift or another place for the bin helps.
    let edge = near.replacen("at = [1.0, -0.401]", "at = [1.0, -0.4]", 1);
    let message = parse(&edge, "t", Overrides::default())
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("a lift of ") && !message.contains("an acceleration"),
        "{message}"
    );
}
