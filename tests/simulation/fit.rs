//! Laws that are fitted to recorded moves, held to the law that made them.

use nalgebra::Point2;
use pickline::fit::{
    ArmFit, Chased, FitLaw, FitOptions, FittedLaw, TimedMove, fit_line, fitted_station, read_moves,
};
use pickline::kinematics::{Arm, Encounter, TravelLaw};
use pickline::pattern::random_stream;
use pickline::station::{Belt, Robot, Station};
use rand::RngExt as _;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

pub const BELT: Belt = Belt {
    speed: 0.3,
    length: 2.0,
    width: 0.8,
};
/// Dwell times of the truth [s].
pub const GRASP: f64 = 0.05;
pub const RELEASE: f64 = 0.08;
/// Standard deviation of the measured times [s].
pub const NOISE: f64 = 0.003;

pub fn trapezoid(speed: f64, acceleration: f64, lift: f64) -> Arm {
    Arm {
        law: TravelLaw::Trapezoid {
            speed,
            acceleration,
            deceleration: acceleration,
        },
        lift,
    }
}

pub fn constant(speed: f64, lift: f64) -> Arm {
    Arm {
        lift,
        ..Arm::constant(speed)
    }
}

/// A station of one robot with this arm, which rests at its bin.
pub fn station_of(arm: Arm) -> Station {
    let robot = Robot::new(
        "a",
        Point2::new(1.0, 0.0),
        Point2::new(1.0, -0.55),
        0.9,
        arm,
    );
    Station::new(BELT, vec![robot.with_dwell(GRASP, RELEASE)]).unwrap()
}

/// What the fit begins with: nothing of it is right.
pub fn guess() -> Station {
    station_of(constant(2.0, 0.01))
}

pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (a, b): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
}

/// Moves of the truth from its bin, with noise on every time and this share of rows with a wait.
pub fn moves_of(truth: &Arm, count: usize, waits: f64, seed: u64) -> Vec<TimedMove> {
    let mut rng = random_stream(seed, 0);
    let bin = Point2::new(1.0, -0.55);
    let mut now = 0.0;
    let mut draw = |line: usize| {
        let meet = Point2::new(
            0.4 + 1.2 * rng.random::<f64>(),
            0.7 * rng.random::<f64>() - 0.35,
        );
        let way = nalgebra::distance(&bin, &meet);
        let mut wait = || match rng.random::<f64>() < waits {
            true => 0.05 + 0.4 * rng.random::<f64>(),
            false => 0.0,
        };
        let (out, back) = (wait(), if waits > 0.0 { wait() } else { 0.0 });
        let depart = now + NOISE * normal(&mut rng);
        let grasp = now + truth.time(way) + out;
        let release = grasp + GRASP + truth.time(way) + RELEASE + back;
        now = release + 0.1;
        let mut row = TimedMove::new(0, line as u64 + 2, bin, meet);
        row.depart = Some(depart);
        row.grasp = Some(grasp + NOISE * normal(&mut rng));
        row.release = Some(release + NOISE * normal(&mut rng));
        row.bin = Some(bin);
        row
    };
    (0..count).map(&mut draw).collect()
}

pub fn fit(moves: &[TimedMove], options: &FitOptions) -> ArmFit {
    let fit = fit_line(&guess(), moves, options).unwrap();
    fit.arms.into_iter().next().unwrap().unwrap()
}

/// In how many of a hundred seeded runs the interval of each parameter contains its true value.
fn coverage(truth: &Arm, law: FitLaw, waits: f64, expected: &[(&str, f64)]) -> Vec<usize> {
    let options = FitOptions::default().with_resamples(200).with_law(law);
    let inside = |seed: u64| {
        let found = fit(
            &moves_of(truth, 150, waits, seed),
            &options.with_seed(1000 + seed),
        );
        let contains = |&(name, value): &(&str, f64)| {
            let mut named = found.parameters.iter();
            let parameter = named.find(|p| p.name == name);
            let interval = parameter.and_then(|p| p.interval);
            usize::from(interval.is_some_and(|interval| interval.contains(value)))
        };
        expected.iter().map(contains).collect::<Vec<_>>()
    };
    let runs: Vec<Vec<usize>> = (0..100).into_par_iter().map(inside).collect();
    let sum = |index: usize| runs.iter().map(|run| run[index]).sum();
    (0..expected.len()).map(sum).collect()
}

pub const DWELL: &str = "grasp_time + release_time";

/// Parameters are inside their 95 % intervals in at least 90 of 100 runs, with and without waits.
#[test]
fn intervals_contain_the_truth() {
    let ramped = [
        ("speed", 3.0),
        ("acceleration", 15.0),
        ("lift", 0.04),
        (DWELL, GRASP + RELEASE),
    ];
    let plain = [("speed", 1.5), ("lift", 0.05), (DWELL, GRASP + RELEASE)];
    // Only ways of 0.75 m and more, of 0.89 m at most, reach the top speed.
    let barely = [
        ("speed", 3.0),
        ("acceleration", 12.0),
        ("lift", 0.03),
        (DWELL, GRASP + RELEASE),
    ];
    for waits in [0.1, 0.0] {
        for (truth, law, expected) in [
            (trapezoid(3.0, 15.0, 0.04), FitLaw::Auto, &ramped[..]),
            (trapezoid(3.0, 12.0, 0.03), FitLaw::Auto, &barely[..]),
            // Only who knows that the arm does not accelerate can know its lift.
            (constant(1.5, 0.05), FitLaw::Speed, &plain[..]),
        ] {
            let found = coverage(&truth, law, waits, expected);
            println!("{waits} {expected:?}: {found:?}");
            assert!(
                found.iter().all(|count| *count >= 90),
                "{expected:?}: {found:?}"
            );
        }
    }
}

pub fn value(fit: &ArmFit, name: &str) -> Option<f64> {
    let mut named = fit.parameters.iter();
    named.find(|p| p.name == name).unwrap().value
}

/// Where no move is long enough, the top speed is not guessed, and times are right all the same.
#[test]
fn a_speed_that_is_never_reached_is_not_determined() {
    let truth = trapezoid(20.0, 100.0, 0.03);
    let moves = moves_of(&truth, 200, 0.05, 1);
    let found = fit(&moves, &FitOptions::default().with_resamples(200));
    assert_eq!(found.law, FittedLaw::Trapezoid);
    let speed = found.parameters.iter().find(|p| p.name == "speed").unwrap();
    assert_eq!(speed.value, None);
    let interval = speed.interval.unwrap();
    // The longest moves come close to 10 m/s.
    assert!(
        (6.0..=20.0).contains(&interval.low) && interval.high.is_none(),
        "{interval:?}"
    );
    assert!(
        found
            .notes
            .iter()
            .any(|note| note.contains("top speed is unknown"))
    );
    assert!((value(&found, "acceleration").unwrap() - 100.0).abs() < 5.0);
    for way in [0.2, 0.5, 0.9] {
        let off = found.arm.time(way) - truth.time(way);
        assert!(off.abs() < NOISE, "{way}: {off}");
    }
}

/// Where all moves are at top speed, lift and acceleration are one figure; it is said, and with the
/// lift given the acceleration is found.
#[test]
fn lift_and_acceleration_are_told_apart_only_where_moves_say_it() {
    let options = FitOptions::default().with_resamples(200);
    for (truth, law) in [
        (trapezoid(1.5, 30.0, 0.05), FitLaw::Trapezoid),
        (trapezoid(1.5, 30.0, 0.05), FitLaw::Auto),
        // A constant speed with a higher lift fits these as well.
        (trapezoid(1.5, 15.0, 0.03), FitLaw::Auto),
        (constant(1.5, 0.05), FitLaw::Auto),
    ] {
        let moves = moves_of(&truth, 200, 0.0, 2);
        let found = fit(&moves, &options.with_law(law));
        assert_eq!(found.law, FittedLaw::Trapezoid);
        assert_eq!(value(&found, "acceleration"), None);
        let lift = found.parameters.iter().find(|p| p.name == "lift").unwrap();
        assert_eq!((lift.value, lift.interval), (Some(0.01), None));
        assert!(
            lift.remark.contains("that of the station"),
            "{}",
            lift.remark
        );
        assert!((value(&found, "speed").unwrap() - 1.5).abs() < 0.02);
        assert!((found.arm.time(0.6) - truth.time(0.6)).abs() < NOISE);
    }
    let truth = trapezoid(1.5, 30.0, 0.05);
    let moves = moves_of(&truth, 200, 0.0, 2);
    let options = options.with_law(FitLaw::Trapezoid);
    let found = fit(&moves, &options.with_lift(0.05));
    let acceleration = value(&found, "acceleration").unwrap();
    assert!((acceleration - 30.0).abs() < 3.0, "{acceleration}");
}

/// An arm that no profile describes gets a table that follows it.
#[test]
fn what_no_law_fits_is_a_table() {
    let truth = Arm {
        law: TravelLaw::Table(vec![
            (0.0, 0.1),
            (0.35, 0.15),
            (0.5, 0.4),
            (0.7, 0.42),
            (2.0, 0.9),
        ]),
        lift: 0.01,
    };
    let moves = moves_of(&truth, 400, 0.05, 3);
    let found = fit(&moves, &FitOptions::default().with_resamples(200));
    assert_eq!(found.law, FittedLaw::Table);
    let TravelLaw::Table(points) = &found.arm.law else {
        panic!("{:?}", found.arm);
    };
    assert_eq!((points[0].0, found.table.len()), (0.0, points.len()));
    let later = |pair: &[(f64, f64)]| pair[0].0 < pair[1].0 && pair[0].1 <= pair[1].1;
    assert!(points.windows(2).all(later), "{points:?}");
    for way in [0.3, 0.45, 0.6, 0.8] {
        let off = found.arm.time(way) - truth.time(way);
        assert!(off.abs() < 0.03, "{way}: {off}");
    }
    assert!((value(&found, DWELL).unwrap() - GRASP - RELEASE).abs() < 0.01);
    // The law with parameters says that it does not fit, if it is asked for.
    let forced = fit(
        &moves,
        &FitOptions::default()
            .with_law(FitLaw::Trapezoid)
            .with_resamples(0),
    );
    assert!(
        forced
            .notes
            .iter()
            .any(|note| note.contains("does not fit")),
        "{:?}",
        forced.notes
    );
    assert!(forced.error.worst > found.error.worst);
}

/// Moves as a recording has them, of which only departure and release are known, chasing the item; or the
/// end of the grasp, if each sixth fails.
pub fn recorded(truth: &Arm, failing: bool) -> Vec<TimedMove> {
    let bin = Point2::new(1.0, -0.55);
    let mut rng = random_stream(4, 0);
    let mut draw = |line: u64| {
        let (x, y) = (
            0.1 + 1.2 * rng.random::<f64>(),
            0.7 * rng.random::<f64>() - 0.35,
        );
        let tau = truth.travel_time(&Encounter {
            dx: x - bin.x,
            dy: y - bin.y,
            belt_speed: BELT.speed,
            upstream: -x,
            downstream: BELT.length - x,
        });
        let met = Point2::new(x + BELT.speed * tau, y);
        let mut row = TimedMove::new(0, line, bin, Point2::new(x, y));
        row.chased = Some(Chased::new(BELT.speed, BELT.length));
        row.depart = Some(5.0);
        row.bin = Some(bin);
        let grasped = 5.0 + tau + GRASP + NOISE * normal(&mut rng);
        match failing && line.is_multiple_of(6) {
            true => row.failed = Some(grasped),
            false => {
                row.release = Some(grasped + truth.time(nalgebra::distance(&met, &bin)) + RELEASE);
            }
        }
        row
    };
    (0..300).map(&mut draw).collect()
}

/// A recording gives the law as well.
#[test]
fn recorded_moves_give_the_law_as_well() {
    let moves = recorded(&trapezoid(4.0, 30.0, 0.04), true);
    let found = fit(&moves, &FitOptions::default().with_resamples(200));
    let mut inside = 0;
    for (name, truth) in [
        ("speed", 4.0),
        ("acceleration", 30.0),
        ("lift", 0.04),
        ("grasp_time", GRASP),
        (DWELL, GRASP + RELEASE),
    ] {
        let parameter = found.parameters.iter().find(|p| p.name == name).unwrap();
        let interval = parameter.interval.unwrap();
        inside += usize::from(interval.contains(truth));
        // And none is far off.
        let width = interval.high.unwrap() - interval.low;
        let off = (parameter.value.unwrap() - truth).abs();
        assert!(off < width, "{name}: {interval:?}");
    }
    assert!(inside >= 4, "{:?}", found.parameters);
    assert!(
        found.error.median < NOISE && found.error.count == 300,
        "{:?}",
        found.error
    );
}

/// The station with the fitted laws is one, and the fit does not depend on the number of threads.
#[test]
fn a_fit_makes_a_station_and_depends_on_no_thread() {
    let truth = trapezoid(3.0, 15.0, 0.04);
    let moves = moves_of(&truth, 100, 0.1, 5);
    let options = FitOptions::default().with_resamples(100);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| fit_line(&guess(), &moves, &options).unwrap())
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(format!("{one:?}"), format!("{three:?}"));
    let arm = one.arms[0].as_ref().unwrap();
    // Those that waited, and no others but by chance.
    assert!((12..=28).contains(&arm.outliers()), "{}", arm.outliers());
    let station = fitted_station(&guess(), &one).unwrap();
    let robot = &station.robots()[0];
    assert_eq!(robot.arm, arm.arm);
    let dwell = robot.grasp_time + robot.bins[0].release_time;
    assert!((dwell - GRASP - RELEASE).abs() < 0.01, "{dwell}");
}

/// What is not a file of moves, or of too few, is refused with place and cure.
#[test]
fn what_gives_no_law_is_refused() {
    let header = "robot,from_x,from_y,meet_x,meet_y,depart_s,grasp_s\n";
    let row = "a,1,-0.55,1,0,1,1.2\n";
    let read = |text: &str| read_moves(text, "m", &guess());
    for (text, words) in [
        (
            format!("{header}b,1,0,1,0,1,2\n"),
            &["m:2: robot", "no robot `b`", "known: a"][..],
        ),
        (
            format!("{header}a,1,0,1,0,2,1\n"),
            &["m:2: grasp_s", "1 s is before depart_s, 2 s"],
        ),
        (
            format!("{header}a,1,,1,0,1,2\n"),
            &["m:2: from_x", "the place is not complete"],
        ),
        (
            format!("{header}a,1,0,1,0,1,x\n"),
            &["m:2: grasp_s", "`x` is not a number"],
        ),
        (
            format!("{header}a,1,0,1,0,1,\n"),
            &["no row has two times", "give depart_s and grasp_s"],
        ),
        ("robot,x\na,1\n".into(), &["m:1", "`from_x` is missing"]),
    ] {
        let message = read(&text).unwrap_err().to_string();
        for word in words {
            assert!(message.contains(word), "{word} not in {message}");
        }
    }
    let refused = |text: String| {
        let moves = read(&text).unwrap().moves;
        fit_line(&guess(), &moves, &FitOptions::default())
            .unwrap_err()
            .to_string()
    };
    let halted = refused(format!("{header}{}", "a,1,-0.55,1,0,1,1\n".repeat(20)));
    assert!(
        halted.contains("robot `a`: half of its times or more are 0"),
        "{halted}"
    );
    let few = refused(format!("{header}{row}{row}"));
    assert!(
        few.contains("robot `a`: 2 moves are too few for a law"),
        "{few}"
    );
    // Milliseconds and millimetres.
    let late = refused(format!("{header}{}", "a,1,0,1,0.5,1000,1200\n".repeat(20)));
    assert!(
        late.contains("milliseconds, name the columns depart_ms"),
        "{late}"
    );
    let far = refused(format!(
        "{header}{}",
        "a,1000,0,1000,500,1,1.2\n".repeat(20)
    ));
    assert!(
        far.contains("millimetres, name the columns from_x_mm"),
        "{far}"
    );
    let in_units = read(
        "robot,from_x_mm,from_y_mm,meet_x_mm,meet_y_mm,depart [ms],grasp [ms]\n\
                         a,1000,-550,1000,0,1000,1200\n",
    );
    assert_eq!(
        in_units.unwrap().moves,
        read(&format!("{header}{row}")).unwrap().moves
    );
}
