//! The smallest distance between arms: against dense sampling of runs, and what `station
//! check` and `simulate --check` say of arms that can touch.

use crate::common::{pickline, text};
use nalgebra::Point2;
use pickline::clearance::{TOLERANCE, apart, smallest};
use pickline::decision::{Outcome, Pick};
use pickline::pattern::{poisson_disk, random_stream};
use pickline::sim::{Conditions, Disturbances, Scene, simulate_rules};
use pickline::station::{Belt, Robot, Station};

/// Two robots that face each other over the belt; `bins` are where their bins are across.
fn facing(bins: [f64; 2], gap: f64) -> Station {
    let robot = |name: &str, x: f64, y: f64, bin: f64| {
        Robot::new(
            name,
            Point2::new(x, y),
            Point2::new(x, bin),
            0.9,
            pickline::kinematics::Arm::constant(1.5),
        )
        .with_dwell(0.2, 0.1)
    };
    let belt = Belt {
        speed: 0.1,
        length: 3.0,
        width: 0.8,
    };
    let robots = vec![
        robot("front", 1.2, -0.6, bins[0]),
        robot("back", 1.2 + gap, 0.6, bins[1]),
    ];
    Station::new(belt, robots).unwrap()
}

/// Where the tool point of `robot` is at `time`, step by step from docs/model.md.
fn tool(station: &Station, outcome: &Outcome, robot: usize, time: f64) -> Point2<f64> {
    let of = &station.robots()[robot];
    let failed = outcome.failures.iter().map(|failure| &failure.attempt);
    let trips = outcome.picks.iter().chain(failed);
    let under_way = |p: &&Pick| p.robot == robot && p.decide <= time && time < p.release;
    let Some(trip) = trips.into_iter().find(under_way) else {
        return of.rest;
    };
    let way = trip.meet - of.rest;
    let speed = way.norm() / (trip.grasp - trip.decide);
    let share = if time < trip.grasp {
        (time - trip.decide) / (trip.grasp - trip.decide)
    } else {
        1.0 - ((time - trip.grasp - of.grasp_time) * speed / way.norm()).clamp(0.0, 1.0)
    };
    of.rest + way * share
}

/// The distance of two segments by trying many points of both.
fn sampled_distance(a: [Point2<f64>; 2], b: [Point2<f64>; 2]) -> f64 {
    const STEPS: i32 = 60;
    let at = |s: [Point2<f64>; 2], i: i32| s[0] + (s[1] - s[0]) * (f64::from(i) / f64::from(STEPS));
    let pairs = (0..=STEPS).flat_map(|i| (0..=STEPS).map(move |j| (i, j)));
    let distances = pairs.map(|(i, j)| (at(a, i) - at(b, j)).norm());
    distances.fold(f64::INFINITY, f64::min)
}

#[test]
fn the_smallest_distance_is_that_of_dense_sampling() {
    // Arms that cross, that come near, and that stay apart; with failing grasps too.
    for (bins, gap, crosses) in [
        ([0.5, -0.5], 0.4, true),
        ([-0.5, 0.5], 1.2, false),
        ([-0.5, 0.5], 1.7, false),
    ] {
        let station = facing(bins, gap);
        let pattern = poisson_disk(0.8, 0.15, 40, &mut random_stream(3, 0)).unwrap();
        for fails in [false, true] {
            let conditions = Conditions::default().with_disturbances(
                Disturbances::default()
                    .with_grasp_failures(fails)
                    .with_default_p_grasp(0.5)
                    .with_seed(1),
            );
            let scene = Scene::under(&station, &pattern, conditions).unwrap();
            let outcome = simulate_rules(&scene, &"SPT,FIFO".parse().unwrap()).unwrap();
            assert_eq!(!outcome.failures.is_empty(), fails);
            let found = smallest(&station, &outcome).unwrap();
            assert_eq!(found.robots, [0, 1]);
            let arms = |time: f64| {
                [0, 1].map(|i| [station.robots()[i].base, tool(&station, &outcome, i, time)])
            };
            // Never above what sampling finds.
            let mut least = f64::INFINITY;
            let steps = 4000;
            for step in 0..=steps {
                let time = outcome.figures.end * f64::from(step) / f64::from(steps);
                let [a, b] = arms(time);
                least = least.min(sampled_distance(a, b));
            }
            assert!(found.distance <= least + TOLERANCE, "{found:?}: {least}");
            // And true at the time and the places that it names.
            let [a, b] = arms(found.time);
            let there = sampled_distance(a, b);
            assert!((there - found.distance).abs() < 0.02, "{found:?}: {there}");
            let between = (found.points[0] - found.points[1]).norm();
            assert!((between - found.distance).abs() < 1e-9);
            assert_eq!(found.distance == 0.0, crosses, "{found:?}");
            // What geometry rules out never happens.
            let apart = apart(&station);
            assert_eq!(apart.overlaps.is_empty(), gap > 1.5, "{apart:?}");
            // The pair is either named or apart.
            assert_eq!(
                apart.others.is_some(),
                apart.overlaps.is_empty(),
                "{apart:?}"
            );
            if let Some((bound, _)) = apart.others {
                assert!(bound > 0.0 && found.distance >= bound - TOLERANCE);
            }
        }
    }
}

/// Of several robots the closest two, whichever they are, as if they were alone.
#[test]
fn the_closest_two_of_several_robots_are_found() {
    let two = facing([-0.5, 0.5], 0.9);
    let moved = |place: usize, name: &str, by: f64| {
        let mut robot = two.robots()[place].clone();
        robot.name = name.into();
        robot.base.x += by;
        robot.bins[0].at.x += by;
        robot.rest.x += by;
        robot
    };
    // Two that never come near anybody, then two pairs, one of which stands closer.
    for (gaps, closest) in [([1.0, 1.4], [2, 3]), ([1.4, 1.2], [4, 5])] {
        let robots = vec![
            moved(0, "a", 0.0),
            moved(1, "b", 2.0),
            moved(0, "c", 6.0),
            moved(1, "d", 5.1 + gaps[0]),
            moved(0, "e", 10.0),
            moved(1, "f", 9.1 + gaps[1]),
        ];
        let belt = Belt {
            length: 14.0,
            ..*two.belt()
        };
        let station = Station::new(belt, robots).unwrap();
        let pattern = poisson_disk(0.8, 0.1, 300, &mut random_stream(3, 0)).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let rules = "LPT,LPT,LPT,LPT,LPT,LPT".parse().unwrap();
        let outcome = simulate_rules(&scene, &rules).unwrap();
        assert!(outcome.robots.iter().all(|robot| robot.picked > 3));
        let found = smallest(&station, &outcome).unwrap();
        let alone = |pair: [usize; 2]| {
            let robots = pair.map(|i| station.robots()[i].clone()).to_vec();
            let mut outcome = outcome.clone();
            outcome.picks.retain(|pick| pair.contains(&pick.robot));
            for pick in &mut outcome.picks {
                pick.robot = usize::from(pick.robot == pair[1]);
            }
            let station = Station::new(belt, robots).unwrap();
            smallest(&station, &outcome).unwrap().distance
        };
        let pairs = (0..6).flat_map(|i| (i + 1..6).map(move |j| [i, j]));
        let (least, pair) = pairs
            .map(|pair| (alone(pair), pair))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap();
        assert_eq!((found.robots, pair), (closest, closest), "{found:?}");
        assert!(
            (found.distance - least).abs() <= TOLERANCE,
            "{found:?}: {least}"
        );
    }
}

/// Two arms with one trip each: distances, times and places reckoned by hand.
#[test]
fn the_closest_moment_of_two_trips_is_found() {
    // Bases 4 m apart; each tool point goes 1 m towards the other base at 1 m/s.
    let robot = |name: &str, x: f64| {
        Robot::new(
            name,
            Point2::new(x, 0.0),
            Point2::new(x, 0.0),
            1.5,
            pickline::kinematics::Arm::constant(1.0),
        )
        .with_dwell(0.5, 0.25)
    };
    let belt = Belt {
        speed: 0.5,
        length: 6.0,
        width: 1.0,
    };
    let station = Station::new(belt, vec![robot("a", 1.0), robot("b", 5.0)]).unwrap();
    let trip = |robot: usize, decide: f64, x: f64| Pick {
        robot,
        bin: 0,
        item: robot as u32,
        decide,
        grasp: decide + 1.0,
        release: decide + 2.75,
        meet: Point2::new(x, 0.0),
    };
    let of = |picks: Vec<Pick>| {
        let scene_pattern = pickline::pattern::grid(1.0, 0.5, 2).unwrap();
        let scene = Scene::new(&station, &scene_pattern).unwrap();
        let mut outcome = pickline::sim::Run::new(&scene).into_outcome();
        outcome.picks = picks;
        smallest(&station, &outcome).unwrap()
    };
    // Alone: 4 m apart at rest, 3 m while `a` grasps.
    let rest = of(vec![]);
    assert_eq!((rest.distance, rest.time), (4.0, 0.0));
    assert_eq!(rest.points, [Point2::new(1.0, 0.0), Point2::new(5.0, 0.0)]);
    let one = of(vec![trip(0, 2.0, 2.0)]);
    assert_eq!((one.distance, one.time), (3.0, 3.0));
    assert_eq!(one.points, [Point2::new(2.0, 0.0), Point2::new(5.0, 0.0)]);
    // `b` arrives 0.25 s later, while `a` is still there.
    let both = of(vec![trip(0, 2.0, 2.0), trip(1, 2.25, 4.0)]);
    assert_eq!((both.distance, both.time), (2.0, 3.25));
    // `b` leaves when `a` turns back: they come no closer than on the way, 3 m.
    let after = of(vec![trip(0, 2.0, 2.0), trip(1, 3.5, 4.0)]);
    assert!(
        (after.distance - 3.0).abs() < 1e-12 && after.time == 3.0,
        "{after:?}"
    );
    // Where `b` turns back and comes again, `a` meets it at its turn.
    let again = of(vec![
        trip(1, 0.0, 4.0),
        trip(0, 2.0, 2.0),
        trip(1, 2.75, 4.0),
    ]);
    assert!((again.distance - 2.25).abs() < 1e-12, "{again:?}");
    assert_eq!(again.time, 3.5);
    assert_eq!(again.robots, [0, 1]);
}

#[test]
fn a_single_robot_has_nothing_to_run_into() {
    let station = pickline::station::built_in("paper").unwrap();
    let station = station.station(Some(1)).unwrap();
    let pattern = pickline::pattern::grid(1.05, 0.15, 20).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let outcome = simulate_rules(&scene, &"SPT".parse().unwrap()).unwrap();
    assert_eq!(smallest(&station, &outcome), None);
    assert_eq!(apart(&station).others, None);
}

/// A station file of [`facing`].
fn file(bins: [f64; 2], gap: f64) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("facing.toml");
    let toml = pickline::station::to_toml(&facing(bins, gap));
    std::fs::write(&path, toml).unwrap();
    let path = path.to_str().unwrap().to_owned();
    (folder, path)
}

#[test]
fn the_check_names_arms_that_can_collide() {
    // Exchanged bins: at rest the arms already lie across each other.
    let (_folder, path) = file([0.5, -0.5], 0.02);
    let report = text(&["station", "check", &path]);
    assert!(
        report.contains("the arms of front and back can collide: their workspaces share 0.")
            && report.contains("m^2 of the belt, x = 0.")
            && report.contains("at rest they are 0.020 m apart"),
        "{report}"
    );
    let (_folder, path) = file([-0.5, 0.5], 1.7);
    let report = text(&["station", "check", &path]);
    assert!(report.contains("arms      always at least 0."), "{report}");
    assert!(!report.contains("collide"), "{report}");
    let paper = text(&["station", "check"]);
    assert!(paper.contains("arms      always at least 0."), "{paper}");
}

#[test]
fn a_checked_run_reports_how_close_its_arms_came() {
    let (_folder, path) = file([0.5, -0.5], 0.4);
    let run = ["simulate", "--station", &path, "-q", "--no-bound"];
    let table = text(&[&run[..], &["--check"]].concat());
    assert!(
        table.contains("arms      front and back collide at "),
        "{table}"
    );
    let json = text(&[&run[..], &["--check", "--format", "json"]].concat());
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["clearance"]["distance_m"], 0.0);
    assert_eq!(report["clearance"]["robots"][1], "back");
    // Not asked, not computed.
    let plain = pickline(&run);
    assert!(!String::from_utf8_lossy(&plain.stdout).contains("arms  "));
    let paper = text(&["simulate", "-q", "--no-bound", "--check"]);
    assert!(
        paper.contains("arms      at least 1.076 m apart: r1 and r2 at 42.6"),
        "{paper}"
    );
}

#[test]
fn arms_that_come_nearer_than_their_thickness_are_doubtful() {
    let (folder, path) = file([-0.5, 0.5], 1.7);
    let toml = std::fs::read_to_string(&path).unwrap();
    // Bases further and further apart until the arms are 1 mm apart.
    let station = |gap: f64| facing([-0.5, 0.5], gap);
    let distance = |gap: f64| {
        apart(&station(gap))
            .others
            .map_or(0.0, |(distance, _)| distance)
    };
    let (mut low, mut high) = (0.5, 1.7);
    for _ in 0..50 {
        let middle = f64::midpoint(low, high);
        match distance(middle) < 0.001 {
            true => low = middle,
            false => high = middle,
        }
    }
    let near = pickline::station::to_toml(&station(high));
    assert!(near != toml);
    std::fs::write(&path, near).unwrap();
    let report = text(&["station", "check", &path]);
    assert!(
        report.contains("can come as close as 0.001 m, less than 0.05 m")
            && report.contains("doubtful"),
        "{report}"
    );
    assert!(apart(&station(high)).is_doubtful() && !apart(&station(high + 0.3)).is_doubtful());
    drop(folder);
}
