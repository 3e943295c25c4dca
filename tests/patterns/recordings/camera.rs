//! How the camera stands and how the belt runs: noticed where it differs from what was given.

use super::film::{Film, STRAIGHT, detections, moving_film};
use super::{apart, options, read, warned};
use pickline::pattern::tracking::{ImageAxis, ImportOptions};
use std::fmt::Write as _;

#[test]
fn an_aligned_camera_gives_true_values_without_warnings() {
    let (text, truth) = STRAIGHT.shoot();
    let found = read(&text, &options()).unwrap();
    assert!(apart(&found.pattern, &truth) < 0.002, "{:?}", found.report);
    assert!(
        found.report.warnings.is_empty(),
        "{:?}",
        found.report.warnings
    );
    let motion = found.report.motion.unwrap();
    assert!(
        motion.angle_deg.abs() < 0.02 && (motion.speed - 0.25).abs() < 1e-3,
        "{motion:?}"
    );
    assert_eq!(motion.bent_off_m, 0.0);
}

#[test]
fn a_turned_camera_is_noticed_measured_and_put_right() {
    for angle in [4.0, -7.0] {
        let film = Film { angle, ..STRAIGHT };
        let (text, truth) = film.shoot();
        let message = read(&text, &options()).unwrap_err();
        assert!(message.contains("degrees off 'axis'"), "{message}");
        let said = message.split("'angle_deg' ").nth(1).unwrap();
        let said: f64 = said.split([';', ' ']).next().unwrap().parse().unwrap();
        assert!((said - angle).abs() < 0.1, "{message}");
        let mut turned = options();
        turned.angle_deg = said;
        let found = read(&text, &turned).unwrap();
        assert!(
            apart(&found.pattern, &truth) < 0.003,
            "{angle}: {:?}",
            found.report.warnings
        );
        assert!(
            found.report.warnings.is_empty(),
            "{:?}",
            found.report.warnings
        );
        // The other way round it is twice as wrong.
        turned.angle_deg = -said;
        let message = read(&text, &turned).unwrap_err();
        assert!(
            message.contains(&format!("give 'angle_deg' {said}")),
            "{message}"
        );
        let mut accepted = options();
        accepted.accept_mismatch = true;
        let found = read(&text, &accepted).unwrap();
        assert!(warned(&found, "'angle_deg'"), "{:?}", found.report.warnings);
        assert!(apart(&found.pattern, &truth) > 0.02);
    }
    let (text, _) = Film {
        angle: 0.6,
        ..STRAIGHT
    }
    .shoot();
    let found = read(&text, &options()).unwrap();
    assert!(
        warned(&found, "'angle_deg' 0.6"),
        "{:?}",
        found.report.warnings
    );
}

#[test]
fn a_turned_camera_is_not_taken_for_a_wrong_scale() {
    for angle in [-30.0, 45.0, 60.0] {
        let (text, _) = Film { angle, ..STRAIGHT }.shoot();
        let message = read(&text, &options()).unwrap_err();
        assert!(
            message.contains("give 'angle_deg' ") && !message.contains("'scale_m_per_px'"),
            "{message}"
        );
    }
}

#[test]
fn a_wrong_frame_rate_scale_or_speed_is_refused_with_what_would_agree() {
    let (text, truth) = STRAIGHT.shoot();
    let mut fast = options();
    fast.fps = 30.0;
    let message = read(&text, &fast).unwrap_err();
    for words in [
        "0.3000 m/s",
        "given belt speed is 0.25",
        "'fps' 25 ",
        "'scale_m_per_px' 0.00166",
        "'belt_speed' 0.3",
    ] {
        assert!(message.contains(words), "{words} not in {message}");
    }
    assert!(!message.contains("0 of 60"), "{message}");
    let mut across = options();
    across.axis = ImageAxis::Y;
    let message = read(&text, &across).unwrap_err();
    assert!(message.contains("give 'axis' x,"), "{message}");
    let mut coarse = options();
    coarse.scale_m_per_px = 0.0026;
    let message = read(&text, &coarse).unwrap_err();
    assert!(message.contains("'scale_m_per_px' 0.002"), "{message}");
    assert!(
        message.contains("60 of 60 items are more than 25 % off"),
        "{message}"
    );
    // Places add up over the film: 4 % are a wrong pattern, well below 1 % are warned of.
    let mut nearly = options();
    nearly.fps = 24.0;
    let message = read(&text, &nearly).unwrap_err();
    for words in ["'fps' 25 ", "puts items up to 0.19", "'belt_speed' 0.24"] {
        assert!(message.contains(words), "{words} not in {message}");
    }
    let mut slow = options();
    slow.belt_speed = 0.248;
    let found = read(&text, &slow).unwrap();
    assert!(
        warned(&found, "items move at 0.25") && warned(&found, " m off"),
        "{:?}",
        found.report.warnings
    );
    // What is said to agree does.
    slow.belt_speed = 0.24;
    let message = read(&text, &slow).unwrap_err();
    let said = message.split("'belt_speed' ").nth(1).unwrap();
    slow.belt_speed = said.split(' ').next().unwrap().parse().unwrap();
    let found = read(&text, &slow).unwrap();
    assert!(
        found.report.warnings.is_empty(),
        "{:?}",
        found.report.warnings
    );
    assert!(apart(&read(&text, &options()).unwrap().pattern, &truth) < 0.002);
}

#[test]
fn lens_distortion_and_tilted_cameras_are_detected() {
    for (film, cause) in [
        (
            Film {
                barrel: 0.05,
                halves: true,
                ..STRAIGHT
            },
            "lens",
        ),
        (
            Film {
                barrel: -0.05,
                halves: true,
                ..STRAIGHT
            },
            "lens",
        ),
        (
            Film {
                tilt: 0.06,
                halves: true,
                ..STRAIGHT
            },
            "tilted",
        ),
    ] {
        let (text, truth) = film.shoot();
        let mut accepted = options();
        accepted.accept_mismatch = true;
        let found = read(&text, &accepted).unwrap();
        assert!(warned(&found, cause), "{cause}: {:?}", found.report);
        assert!(warned(&found, "undistort"), "{:?}", found.report.warnings);
        let said = found.report.motion.unwrap().bent_off_m;
        assert!(said > 0.005, "{said}");
        let off = apart(&found.pattern, &truth);
        assert!(off > 0.003, "{off}");
    }
    let (text, _) = Film {
        barrel: 0.3,
        ..STRAIGHT
    }
    .shoot();
    let message = read(&text, &options()).unwrap_err();
    assert!(message.contains("lens"), "{message}");
}

#[test]
fn boxes_without_tracks_that_travel_another_way_are_refused_with_the_way() {
    let ways = [
        (ImageAxis::X, false, "'axis' x without 'reverse'"),
        (ImageAxis::Y, false, "'axis' y without 'reverse'"),
        (ImageAxis::X, true, "'axis' x with 'reverse'"),
        (ImageAxis::Y, true, "'axis' y with 'reverse'"),
    ];
    let mut accepted = 0;
    for sparse in [false, true] {
        for (turns, (.., cure)) in ways.iter().enumerate() {
            let text = detections(turns, sparse, false);
            for (given, (axis, reverse, _)) in ways.iter().enumerate() {
                let mut options = ImportOptions::new(20.0, 0.001, *axis, 0.2);
                options.reverse = *reverse;
                let found = read(&text, &options);
                if given == turns {
                    let items = found.unwrap().pattern.len();
                    assert_eq!(items, if sparse { 10 } else { 30 }, "{turns}");
                    continue;
                }
                let message = found.unwrap_err();
                assert!(message.contains(cure), "{turns} {given}: {message}");
                options.accept_mismatch = true;
                if let Ok(found) = read(&text, &options) {
                    assert!(warned(&found, cure), "{:?}", found.report.warnings);
                    accepted += 1;
                }
            }
        }
    }
    assert!(accepted > 0);
}

#[test]
fn more_tracks_backwards_than_forwards_are_refused() {
    let (text, _) = STRAIGHT.shoot();
    // One thing that moves the way given must not make a pattern of the rest.
    let mut film: Vec<String> = text.lines().map(str::to_owned).collect();
    for frame in 1..60 {
        let left = 1100 - 5 * frame;
        film.push(format!("{frame},999,{left},900,40,30,0.9,-1,-1,-1"));
    }
    let mut reverse = options();
    reverse.reverse = true;
    let message = read(&film.join("\n"), &reverse).unwrap_err();
    for words in [
        "60 tracks travel backwards, but only 1 item",
        "omit 'reverse'",
    ] {
        assert!(message.contains(words), "{words} not in {message}");
    }
}

#[test]
fn a_belt_that_changes_its_speed_is_named_and_refused() {
    let options = ImportOptions::new(20.0, 0.001, ImageAxis::X, 0.2);
    let steady = moving_film(80, |t| 0.2 * t);
    let found = read(&steady, &options).unwrap();
    let motion = found.report.motion.unwrap();
    assert_eq!(motion.unsteady_off_m, 0.0, "{motion:?}");
    let stops = |t: f64| 0.2 * (t - (t - 20.0).clamp(0.0, 5.0));
    let speeds_up = |t: f64| 0.2 * t + 0.005 * t * t / 2.0;
    let slower = |t: f64| 0.2 * t - 0.05 * (t - 25.0).max(0.0);
    let sways = |t: f64| 0.2 * t + 0.1 * (0.6 * t).sin();
    let films: [&dyn Fn(f64) -> f64; 4] = [&stops, &speeds_up, &slower, &sways];
    for (number, moved) in films.into_iter().enumerate() {
        let text = moving_film(80, moved);
        let message = read(&text, &options).unwrap_err();
        for words in [
            "belt speed changes during the recording",
            "constant speed out of the video",
        ] {
            assert!(
                message.contains(words),
                "{number}: {words} not in {message}"
            );
        }
        for words in ["lens", "tilted", "'belt_speed'"] {
            assert!(!message.contains(words), "{number}: {words} in {message}");
        }
    }
}

/// Dirt and parts of the machine stand from their first frame to their last, also while no item
/// passes: from frame 960 on the belt is empty.
#[test]
fn tracks_that_never_move_do_not_count_for_the_belts_speed() {
    let options = ImportOptions::new(20.0, 0.001, ImageAxis::X, 0.2);
    for first in [1, 960] {
        let mut text = moving_film(80, |t| 0.2 * t);
        for frame in first..=1999 {
            for part in 0..4 {
                let (id, left) = (900 + part, 200 + 300 * part);
                let _ = writeln!(text, "{frame},{id},{left},20,40,30,0.9,-1,-1,-1");
            }
        }
        let found = read(&text, &options).unwrap();
        assert_eq!(found.pattern.len(), 80);
        assert_eq!(found.report.dropped.len(), 4, "{:?}", found.report.dropped);
        let motion = found.report.motion.unwrap();
        assert_eq!(motion.unsteady_off_m, 0.0, "{motion:?}");
        for speed in motion.speeds_over_time.unwrap() {
            assert!((speed - 0.2).abs() < 0.002, "{motion:?}");
        }
    }
}

#[test]
fn angles_are_those_in_the_picture() {
    let film = Film {
        angle: 2.0,
        ..STRAIGHT
    };
    let (text, _) = film.shoot();
    let mut turned = options();
    turned.angle_deg = 2.0;
    let lines = read(&text, &turned).unwrap().report.lines();
    let said = |words: &str| lines.iter().any(|line| line.contains(words));
    assert!(said("travels at 2.0") && !said("-0.00"), "{lines:?}");
    turned.angle_deg = -2.0;
    let message = read(&text, &turned).unwrap_err();
    for words in [
        "travels 2.0",
        "not at -2 as given by 'angle_deg'",
        "give 'angle_deg' 2.0",
    ] {
        assert!(message.contains(words), "{words} not in {message}");
    }
}
