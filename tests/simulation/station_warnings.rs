//! What of a station is allowed and most likely wrong.

use crate::stations::{BELT, robot};
use nalgebra::Point2;
use pickline::station::{Belt, Overrides, Robot, Station, built_in, parse};

/// How far outside the belt a base may stand: its reach, along and across.
#[test]
fn bases_that_reach_no_belt_are_warned_of() {
    let warned = |x: f64, y: f64, reach: f64| {
        let base = Point2::new(x, y);
        let lone = Robot {
            base,
            reach,
            ..robot("a", x)
        }
        .with_only_bin(base);
        let warnings = Station::new(BELT, vec![lone]).unwrap().warnings("s");
        let of_base = |text: &String| text.contains("robot `a`, base");
        warnings.iter().map(|w| w.to_string()).find(of_base)
    };
    // The belt is 4 m long and 1 m wide; 3-4-5 at its corners.
    for (x, y, reach, words) in [
        (2.0, 1.25, 0.76, None),
        (2.0, 1.25, 0.74, Some("its base at (2, 1.25) m")),
        (2.0, -1.25, 0.76, None),
        (2.0, -1.25, 0.74, Some("its reach of 0.74 m")),
        (2.0, 0.0, 0.1, None),
        (-0.75, 0.25, 0.76, None),
        (-0.75, 0.25, 0.74, Some("its base at (-0.75, 0.25) m")),
        (4.75, -0.25, 0.76, None),
        (4.75, -0.25, 0.74, Some("its base at (4.75, -0.25) m")),
        (4.3, 0.9, 0.51, None),
        (
            4.3,
            0.9,
            0.49,
            Some("is farther from the belt than its reach"),
        ),
        (-0.3, -0.9, 0.51, None),
        (
            -0.3,
            -0.9,
            0.49,
            Some("is farther from the belt than its reach"),
        ),
    ] {
        let warning = warned(x, y, reach);
        assert_eq!(
            warning.is_some(),
            words.is_some(),
            "({x}, {y}) {reach}: {warning:?}"
        );
        let fits = warning
            .unwrap_or_default()
            .contains(words.unwrap_or_default());
        assert!(fits, "({x}, {y}) {reach}");
    }
    // In millimetres it would be elsewhere; in metres it is just far away.
    assert!(warned(2000.0, -600.0, 0.8).unwrap().contains("millimetres"));
    assert!(!warned(3.0, 3.0, 0.8).unwrap().contains("millimetres"));
    for (x, y) in [(1300.0, -0.6), (1.3, -600.0)] {
        assert!(
            warned(x, y, 0.8).unwrap().contains("millimetres"),
            "({x}, {y})"
        );
    }
}

/// A bin belongs within reach, rounding aside.
#[test]
fn bins_out_of_reach_are_warned_of() {
    let warned = |bin: (f64, f64)| {
        let with_bin = Robot {
            reach: 0.5,
            ..robot("a", 1.0)
        }
        .with_only_bin(Point2::new(bin.0, bin.1));
        let warnings = Station::new(BELT, vec![with_bin]).unwrap().warnings("s");
        let of_bin = |text: &String| text.contains("robot `a`, bin");
        warnings.iter().map(|w| w.to_string()).find(of_bin)
    };
    // The base is at (1, -0.6).
    for bin in [
        (1.5, -0.6),
        (0.5, -0.6),
        (1.0, -0.1),
        (1.3, -0.2),
        (0.7, -1.0),
    ] {
        assert_eq!(warned(bin), None, "{bin:?}");
    }
    for (bin, away) in [
        ((1.501, -0.6), "its bin is 0.501 m"),
        ((0.499, -0.6), "its bin is 0.501 m"),
        ((1.0, -0.099), "its bin is 0.501 m"),
        ((1.6, 0.2), "its bin is 1.000 m"),
    ] {
        let text = warned(bin).unwrap();
        assert!(
            text.contains(away) && text.contains("its reach of 0.5 m"),
            "{text}"
        );
    }
    assert!(warned((1000.0, -500.0)).unwrap().contains("millimetres"));
    // One coordinate in millimetres, the other in metres.
    assert!(warned((1200.0, -0.5)).unwrap().contains("1200 mm is 1.2 m"));
    assert!(warned((1.0, -500.0)).unwrap().contains("500 mm is 0.5 m"));
}

/// Warnings name the first robot that each kind concerns.
#[test]
fn warnings_name_the_first_robot_of_their_kind() {
    let mut robots = built_in("paper")
        .unwrap()
        .station(Some(3))
        .unwrap()
        .robots()
        .to_vec();
    let belt = *built_in("paper").unwrap().station(Some(3)).unwrap().belt();
    robots[1].grasp_time = 100.0;
    robots[2].grasp_time = 200.0;
    robots[2].bins[0].release_time = 300.0;
    let warnings = Station::new(belt, robots).unwrap().warnings("s");
    let texts: Vec<_> = warnings.iter().map(|w| w.to_string()).collect();
    assert_eq!(texts.len(), 2, "{texts:?}");
    assert!(texts[0].contains("s: robot `r2`, grasp_time"), "{texts:?}");
    assert!(
        texts[1].contains("s: robot `r3`, release_time"),
        "{texts:?}"
    );
}

#[test]
fn wide_gaps_between_bases_are_warned_of() {
    let apart = |gap: f64| {
        let belt = Belt {
            length: 100.0,
            ..BELT
        };
        let robots = vec![robot("a", 1.0), robot("b", 30.0 - gap), robot("c", 30.0)];
        let warnings = Station::new(belt, robots).unwrap().warnings("s");
        let of_gap = |text: &String| text.contains("bases along the belt");
        warnings.iter().map(|w| w.to_string()).find(of_gap)
    };
    assert_eq!(apart(19.0), None);
    assert!(apart(21.0).unwrap().contains("21"));
    // The widest counts, whichever it is.
    assert!(apart(1.0).unwrap().contains("28"));
}

/// A camera that is nowhere is refused elsewhere.
#[test]
fn only_places_of_a_camera_are_warned_of() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -25.0, 4.2] {
        assert_eq!(station.check_camera("--camera-x", x), None, "{x}");
    }
    for x in [-25.1, 4.3] {
        assert!(station.check_camera("--camera-x", x).is_some(), "{x}");
    }
}

/// Classes that nobody takes are all named, each once; what an unwanted class says besides is told, and
/// so is a bin that nothing goes into.
#[test]
fn classes_and_bins_without_use_are_warned_of() {
    let warned = |text: &str| {
        let robot = "[[robot]]\nname = \"a\"\nbase = [1, -0.5]\nreach = 1\nspeed = 2\ngrasp_time = 0.1\nrelease_time = 0.1\n";
        let belt = "[belt]\nspeed = 0.2\nlength = 2\nwidth = 0.5\n";
        let text = format!("{belt}{robot}{text}");
        let station = parse(&text, "s", Overrides::default()).unwrap();
        let warnings = station.warnings("s");
        warnings.iter().map(|w| w.to_string()).collect::<Vec<_>>()
    };
    let bin = |name: &str, classes: &str| {
        format!("[[robot.bin]]\nname = \"{name}\"\nat = [1, -0.6]\nclasses = [{classes}]\n")
    };
    let class = |name: &str, more: &str| format!("[[class]]\nname = \"{name}\"\n{more}\n");
    let used = bin("one", "\"pet\"") + &bin("two", "\"wood\"");
    assert_eq!(
        warned(&(used.clone() + &class("pet", "value = 2"))),
        [""; 0]
    );
    let told = warned(&(used.clone() + &class("tin", "") + &class("iron", "")));
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains("the classes `tin` and `iron`"), "{told:?}");
    let told = warned(&(used.clone() + &class("tin", "")));
    assert!(told[0].contains("for class `tin`, whose items"), "{told:?}");
    assert!(told[0].contains("known: pet, wood)"), "{told:?}");
    let told = warned(&(used + &class("wood", "wanted = false\nvalue = 3")));
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(
        told[0].contains("`wood` has a value, but is not wanted"),
        "{told:?}"
    );
    assert!(told[1].contains("nothing goes into bin `two`"), "{told:?}");
}

/// A table of times is judged by the speed that it comes to.
#[test]
fn a_table_without_times_is_warned_of() {
    let warned = |travel: &str| {
        let text = format!(
            "[belt]\nspeed = 0.2\nlength = 2\nwidth = 0.5\n[[robot]]\nname = \"a\"\nbase = [1, -0.5]\nbin = [1, -0.6]\n\
             reach = 1\ntravel = {travel}\ngrasp_time = 0.1\nrelease_time = 0.1\n"
        );
        let station = parse(&text, "s", Overrides::default()).unwrap();
        let warnings = station.warnings("s");
        warnings.iter().map(|w| w.to_string()).collect::<Vec<_>>()
    };
    assert_eq!(warned("[[0, 0.1], [0.5, 0.3], [1, 0.5]]"), [""; 0]);
    let told = warned("[[0, 0], [1, 0]]");
    assert!(told.len() == 1 && told[0].contains("travel"), "{told:?}");
    // The cure is for lengths and times, not for a speed.
    let told = warned("[[0, 0.001], [1, 0.002]]");
    let words = [
        "a move of 1 m takes 0.002 s by the table",
        "lengths in metres and times in seconds",
    ];
    for word in words {
        assert!(told.iter().any(|told| told.contains(word)), "{told:?}");
    }
}
