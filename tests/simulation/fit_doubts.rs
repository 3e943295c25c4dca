//! What a fit must not claim: figures that the moves do not tell, precision that the stamps do not
//! have, places that the station does not have.

use crate::fit::{
    BELT, DWELL, GRASP, NOISE, RELEASE, constant, fit, guess, moves_of, normal, recorded,
    station_of, trapezoid, value,
};
use nalgebra::Point2;
use pickline::fit::{ArmFit, FitLaw, FitOptions, FittedLaw, TimedMove, fit_line, fitted_station};
use pickline::kinematics::{Arm, TravelLaw};
use pickline::pattern::random_stream;
use pickline::station::{Bin, Robot, Station};
use rand::RngExt as _;
use rayon::prelude::*;

const HOME: Point2<f64> = Point2::new(1.0, -0.55);

fn quick() -> FitOptions {
    FitOptions::default().with_resamples(200)
}

fn has_note(fit: &ArmFit, words: &str) -> bool {
    fit.notes.iter().any(|note| note.contains(words))
}

/// The same moves with stamps rounded to this step [s]; departures that are multiples of it are known
/// exactly, as where a controller acts in cycles.
fn rounded(mut moves: Vec<TimedMove>, step: f64, in_cycles: bool) -> Vec<TimedMove> {
    let round = |stamp: f64| (stamp / step).round() * step;
    for timed in &mut moves {
        let depart = timed.depart.unwrap();
        let shift = if in_cycles {
            round(depart) - depart
        } else {
            0.0
        };
        for stamp in [&mut timed.depart, &mut timed.grasp, &mut timed.release] {
            *stamp = stamp.map(|stamp| round(stamp + shift));
        }
    }
    moves
}

/// Where stamps are rounded, it is said, no time is an outlier for it, and parameters are inside their
/// intervals in at least 90 of 100 runs, or have none.
#[test]
fn rounded_stamps_are_told_and_intervals_allow_for_them() {
    let truth = trapezoid(3.0, 15.0, 0.04);
    let expected = [
        ("speed", 3.0),
        ("acceleration", 15.0),
        ("lift", 0.04),
        (DWELL, GRASP + RELEASE),
    ];
    for (step, in_cycles) in [(0.01, false), (0.01, true), (0.1, false), (0.1, true)] {
        let run = |seed: u64| {
            let moves = rounded(moves_of(&truth, 150, 0.0, seed), step, in_cycles);
            let found = fit(&moves, &quick().with_seed(1000 + seed));
            assert_eq!(found.step, Some(step));
            assert!(
                has_note(&found, "all stamps are multiples of"),
                "{:?}",
                found.notes
            );
            assert!(found.outliers() <= 3, "{}", found.outliers());
            // Not all of the error is hidden by equal stamps.
            assert!(found.error.worst > 0.2 * step, "{:?}", found.error);
            let inside = |&(name, value): &(&str, f64)| {
                let mut named = found.parameters.iter().filter(|p| p.name == name);
                let interval = named.next().and_then(|p| p.interval);
                usize::from(interval.is_none_or(|interval| interval.contains(value)))
            };
            expected.iter().map(inside).collect::<Vec<_>>()
        };
        let runs: Vec<Vec<usize>> = (0..100).into_par_iter().map(run).collect();
        let sum = |index: usize| runs.iter().map(|run| run[index]).sum::<usize>();
        let inside: Vec<usize> = (0..expected.len()).map(sum).collect();
        println!("{step} {in_cycles}: {inside:?}");
        assert!(
            inside.iter().all(|count| *count >= 90),
            "{step} {in_cycles}: {inside:?}"
        );
    }
    let exact = fit(&moves_of(&truth, 150, 0.0, 1), &quick());
    assert_eq!(exact.step, None);
    assert!(!has_note(&exact, "stamps"), "{:?}", exact.notes);
}

/// The error is that of all times; what it is without the outliers stands beside it.
#[test]
fn the_error_includes_the_outliers() {
    let moves = moves_of(&trapezoid(3.0, 15.0, 0.04), 200, 0.2, 1);
    let found = fit(&moves, &quick());
    let (all, rest) = (found.error, found.error_without_outliers);
    assert_eq!(all.count, 400);
    assert_eq!(rest.count, 400 - found.outliers());
    // A fifth of the times include a wait of up to 0.45 s.
    assert!(
        all.worst > 0.2 && rest.worst < 5.0 * NOISE,
        "{all:?} {rest:?}"
    );
    assert!(all.median > rest.median, "{all:?} {rest:?}");
}

/// A station of one robot with bins on both sides of the belt.
fn with_two_bins() -> Station {
    let robot = station_of(constant(2.0, 0.01)).robots()[0].clone();
    let bin = |name: &str, y: f64, classes: Option<Vec<String>>| Bin {
        name: name.into(),
        at: Point2::new(1.0, y),
        classes,
        release_time: 0.25,
    };
    let bins = vec![
        bin("near", -0.55, None),
        bin("far", 0.55, Some(vec!["pet".into()])),
    ];
    Station::new(BELT, vec![Robot { bins, ..robot }]).unwrap()
}

/// Moves between other places than those of the station are refused if all are, and told if some are.
#[test]
fn places_are_those_of_the_station() {
    let truth = trapezoid(3.0, 15.0, 0.04);
    let moves = moves_of(&truth, 60, 0.0, 1);
    let refused = |change: &dyn Fn(&mut TimedMove)| {
        let mut moves = moves.clone();
        moves.iter_mut().for_each(change);
        let refused = fit_line(&guess(), &moves, &quick());
        refused.unwrap_err().to_string()
    };
    let elsewhere = refused(&|m| m.bin = Some(Point2::new(0.2, 0.8)));
    for words in [
        "robot `a`: line 2: releases at (0.2, 0.8), 1.57 m from the nearest bin, `b1` at (1, -0.55)",
        "none of 60 items",
        "'station'",
    ] {
        assert!(elsewhere.contains(words), "{elsewhere}");
    }
    let beside = refused(&|m| m.meet.y += 1.5);
    assert!(beside.contains("line 2: meets its item at"), "{beside}");
    assert!(
        beside.contains("beside the belt, which is 2 m long and 0.8 m wide"),
        "{beside}"
    );
    // Some of them are told.
    let mut some = moves.clone();
    some[3].bin = Some(Point2::new(1.0, -0.7));
    some[4].from = Point2::new(0.5, -0.55);
    some[5].meet = Point2::new(0.02, 0.0);
    let found = fit(&some, &quick());
    for words in [
        "1 of 60 releases are at no bin of this robot, and count for the nearest",
        "the first, line 5, releases at (1, -0.7), 0.15 m from",
        "1 of 60 moves begin neither at a bin nor at the rest",
        "the first, line 6, begins at (0.5, -0.55)",
        "1 of 60 items are met where this robot cannot",
        "line 7, meets its item at (0.02, 0), 0.98 m from its base, but it reaches 0.9 m",
    ] {
        assert!(has_note(&found, words), "{words}: {:?}", found.notes);
    }
    assert!(!has_note(&fit(&moves, &quick()), "of 60"));
    // A bin without releases is in the report.
    let line = fit_line(&with_two_bins(), &moves, &quick()).unwrap();
    let arm = line.arms[0].as_ref().unwrap();
    let bin = |name: &str| {
        let mut named = arm.parameters.iter();
        named.find(|p| p.name.ends_with(name)).unwrap()
    };
    assert!((bin("bin near").value.unwrap() - GRASP - RELEASE).abs() < 0.01);
    assert_eq!(
        (bin("bin far").value, bin("bin far").interval),
        (None, None)
    );
    assert_eq!(
        bin("bin far").remark,
        "no time ends there: the release time of the station, 0.25 s, is kept"
    );
    assert_eq!(arm.release_times[1], 0.25);
}

/// A law that explains next to nothing is not handed over without a word.
#[test]
fn a_law_that_explains_little_is_told() {
    let mut rng = random_stream(3, 0);
    let mut moves = moves_of(&trapezoid(3.0, 15.0, 0.04), 150, 0.0, 1);
    for timed in &mut moves {
        let depart = timed.depart.unwrap();
        let grasp = depart + 0.1 + 0.8 * rng.random::<f64>();
        timed.grasp = Some(grasp);
        timed.release = Some(grasp + 0.1 + 0.8 * rng.random::<f64>());
    }
    let found = fit(&moves, &quick());
    assert!(found.error.median > 0.1, "{:?}", found.error);
    assert!(
        has_note(&found, "the law explains little"),
        "{:?}",
        found.notes
    );
    assert!(has_note(&found, "'chart'"), "{:?}", found.notes);
    let good = fit(
        &moves_of(&trapezoid(3.0, 15.0, 0.04), 150, 0.2, 1),
        &quick(),
    );
    assert!(!has_note(&good, "explains little"), "{:?}", good.notes);
}

/// Moves of this truth, all of ways between `least` and `most` [m].
fn alike(truth: &Arm, (least, most): (f64, f64)) -> Vec<TimedMove> {
    let mut rng = random_stream(5, 0);
    let mut draw = |line: u64| {
        let way = least + (most - least) * rng.random::<f64>();
        let angle = 1.0 + 1.1 * rng.random::<f64>();
        let meet = HOME + way * nalgebra::Vector2::new(angle.cos(), angle.sin());
        let mut timed = TimedMove::new(0, line, HOME, meet);
        let depart = 1.7 * line as f64 + rng.random::<f64>();
        let grasp = depart + truth.time(way);
        let release = grasp + GRASP + truth.time(way) + RELEASE;
        timed.depart = Some(depart + NOISE * normal(&mut rng));
        timed.grasp = Some(grasp + NOISE * normal(&mut rng));
        timed.release = Some(release + NOISE * normal(&mut rng));
        timed.bin = Some(HOME);
        timed
    };
    (0..150).map(&mut draw).collect()
}

/// Moves of one length tell one time: neither speed nor acceleration has a figure, however they are
/// asked for, unless the other one is known.
#[test]
fn moves_of_one_length_tell_neither_speed_nor_acceleration() {
    let truth = trapezoid(3.0, 15.0, 0.04);
    for ways in [(0.4, 0.4), (0.399, 0.401)] {
        let moves = alike(&truth, ways);
        for law in [FitLaw::Auto, FitLaw::Speed, FitLaw::Trapezoid] {
            let found = fit(&moves, &quick().with_law(law));
            for parameter in &found.parameters {
                if ["speed", "acceleration"].contains(&parameter.name.as_str()) {
                    let what = format!("{ways:?} {law:?} {parameter:?}");
                    assert_eq!(parameter.value, None, "{what}");
                    // A speed may have a lowest value, which is true.
                    let low = parameter.interval.map(|i| (i.low, i.high));
                    assert!(
                        low.is_none_or(|(low, high)| low < 3.0 && high.is_none()),
                        "{what}"
                    );
                    assert!(!parameter.remark.is_empty(), "{what}");
                }
            }
            // The time itself is told.
            assert!((found.arm.time(0.4) - truth.time(0.4)).abs() < 0.003);
            assert!((value(&found, DWELL).unwrap() - GRASP - RELEASE).abs() < 0.003);
        }
    }
    let moves = alike(&truth, (0.4, 0.4));
    let found = fit(&moves, &quick());
    assert!(
        has_note(&found, "most of them 0.4 to 0.4 m long, are too much alike"),
        "{:?}",
        found.notes
    );
    // Nor do whole picks tell the dwell.
    let mut whole = moves.clone();
    whole.iter_mut().for_each(|m| m.grasp = None);
    let whole = fit(&whole, &quick());
    assert_eq!((value(&whole, "speed"), value(&whole, DWELL)), (None, None));
    // Who knows that the arm does not accelerate, and its lift, knows its speed.
    let known = fit(&moves, &quick().with_law(FitLaw::Speed).with_lift(0.04));
    let speed = value(&known, "speed").unwrap();
    assert!((speed - 0.48 / truth.time(0.4)).abs() < 0.02, "{speed}");
    // A lift alone does not tell it.
    let known = fit(&moves, &quick().with_lift(0.04));
    assert_eq!(value(&known, "speed"), None);
    let trapezoid = fit(&moves, &quick().with_law(FitLaw::Trapezoid).with_lift(0.04));
    assert_eq!(value(&trapezoid, "acceleration"), None);
}

/// A table has no interval where nothing was measured, and its lift is called what it is.
#[test]
fn the_first_point_of_a_table_is_extrapolated() {
    let moves = moves_of(&trapezoid(3.0, 15.0, 0.04), 150, 0.0, 1);
    let table = quick().with_law(FitLaw::Table);
    let found = fit(&moves, &table);
    assert_eq!(found.law, FittedLaw::Table);
    assert_eq!(found.measured, 1..found.table.len());
    assert_eq!(found.table[0], None);
    assert!(found.table[1..].iter().all(Option::is_some));
    let remark = |fit: &ArmFit| {
        fit.parameters
            .iter()
            .find(|p| p.name == "lift")
            .unwrap()
            .remark
            .clone()
    };
    assert_eq!(
        remark(&found),
        "that of the station: a table of times does not tell it"
    );
    let given = fit(&moves, &table.with_lift(0.03));
    assert_eq!(
        (remark(&given).as_str(), value(&given, "lift")),
        ("given", Some(0.03))
    );
}

/// Copies of moves tell nothing, and equal durations do.
#[test]
fn copies_count_once() {
    let moves = alike(&trapezoid(3.0, 15.0, 0.04), (0.1, 0.8));
    let twice: Vec<TimedMove> = moves.iter().chain(&moves).cloned().collect();
    let (once, found) = (fit(&moves, &quick()), fit(&twice, &quick()));
    assert!(
        has_note(&found, "150 of 300 moves are copies"),
        "{:?}",
        found.notes
    );
    assert_eq!((found.moves, &found.parameters), (150, &once.parameters));
    // From stop watches: every time counts from 0.
    let timed: Vec<TimedMove> = twice
        .into_iter()
        .map(|mut timed| {
            let depart = timed.depart.unwrap();
            for time in [&mut timed.depart, &mut timed.grasp, &mut timed.release] {
                *time = time.map(|time| time - depart);
            }
            timed
        })
        .collect();
    let found = fit(&timed, &quick());
    assert_eq!(found.moves, 300);
    assert!(!has_note(&found, "copies"), "{:?}", found.notes);
}

/// Times that do not grow with the length of the way are those of no speed or lift, but a table has them.
/// Where none can be fitted, nothing is made up.
#[test]
fn times_that_do_not_depend_on_the_way_are_a_table_or_nothing() {
    let flat = |noise: f64| {
        let mut rng = random_stream(11, 0);
        let mut moves = moves_of(&constant(2.0, 0.01), 200, 0.0, 11);
        for timed in &mut moves {
            let depart = timed.depart.unwrap();
            let mut later = |by: f64| Some(depart + by + noise * normal(&mut rng));
            (timed.grasp, timed.release) = (later(0.3), later(0.6));
        }
        moves
    };
    for noise in [0.0, 0.002] {
        let found = fit(&flat(noise), &quick());
        assert_eq!(found.law, FittedLaw::Table, "{noise}: {found:?}");
        for way in [0.4, 0.7] {
            assert!((found.arm.time(way) - 0.3).abs() < 0.003, "{noise} {way}");
        }
        assert!(found.error.worst < 0.02, "{noise}: {:?}", found.error);
        let line = fit_line(&guess(), &flat(noise), &quick()).unwrap();
        let station = fitted_station(&guess(), &line).unwrap();
        assert_eq!(station.warnings("s"), [], "{noise}");
    }
    // Asked for a speed, it says that none explains them.
    let speed = quick().with_law(FitLaw::Speed);
    let line = fit_line(&guess(), &flat(0.0), &speed).unwrap();
    let found = line.arms[0].as_ref().unwrap();
    assert!(
        has_note(found, "the law explains little"),
        "{:?}",
        found.notes
    );
}

/// Ways of one length give no table that an arm could have.
#[test]
fn one_length_gives_no_table() {
    let options = quick().with_law(FitLaw::Table);
    for ways in [(0.4, 0.4), (0.4, 0.400_000_1), (0.4, 0.4009)] {
        let moves = alike(&trapezoid(3.0, 15.0, 0.04), ways);
        let refused = fit_line(&guess(), &moves, &options)
            .unwrap_err()
            .to_string();
        assert!(
            refused.contains("over too few lengths"),
            "{ways:?}: {refused}"
        );
    }
}

/// A recording cannot give a table, which is said where one is asked for, and where no law fits.
#[test]
fn a_recording_says_why_it_gives_no_table() {
    let bent = Arm {
        law: TravelLaw::Table(vec![
            (0.0, 0.1),
            (0.35, 0.15),
            (0.6, 0.55),
            (0.7, 0.56),
            (2.0, 0.7),
        ]),
        lift: 0.01,
    };
    let moves = recorded(&bent, false);
    let refused = fit_line(&guess(), &moves, &quick().with_law(FitLaw::Table));
    let refused = refused.unwrap_err().to_string();
    assert!(
        refused.contains("a recording does not say when a grasp begins"),
        "{refused}"
    );
    assert!(refused.contains("in a CSV file"), "{refused}");
    let found = fit(&moves, &quick());
    assert!(
        has_note(&found, "the law does not fit"),
        "{:?}",
        found.notes
    );
    assert!(
        has_note(&found, "no table is fitted, because a recording"),
        "{:?}",
        found.notes
    );
    let good = fit(&recorded(&trapezoid(3.0, 15.0, 0.04), false), &quick());
    assert!(!has_note(&good, "does not fit"), "{:?}", good.notes);
}

/// A fitted arm that is slower than its belt is refused with both speeds and the bin.
#[test]
fn an_arm_slower_than_its_belt_is_named_with_its_figures() {
    let near = |arm: &Arm| {
        let moves = moves_of(arm, 150, 0.0, 1);
        let line = fit_line(&guess(), &moves, &quick().with_lift(0.0)).unwrap();
        fitted_station(&guess(), &line).unwrap_err().to_string()
    };
    let slow = near(&constant(0.25, 0.0));
    assert!(
        slow.contains("moves at 0.2") && slow.contains("the belt at 0.3 m/s"),
        "{slow}"
    );
    let soft = near(&trapezoid(2.0, 0.25, 0.0));
    for words in [
        "0.15 m from its bin to an item",
        "its arm gets ahead at 0.1",
        "the belt moves at 0.3 m/s",
    ] {
        assert!(soft.contains(words), "{soft}");
    }
}
