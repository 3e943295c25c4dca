//! What look-ahead does about failures that it foresees.

use nalgebra::Point2;
use pickline::checker;
use pickline::decision::Outcome;
use pickline::kinematics::Arm;
use pickline::pattern::{Item, Pattern, grid, poisson_disk, random_stream};
use pickline::planning::{Lookahead, LookaheadOptions};
use pickline::sim::{Conditions, Disturbances, Scene, simulate};
use pickline::station::{Belt, Robot, Station, built_in};

fn failing(p_grasp: f64, seed: u64) -> Disturbances {
    Disturbances::default()
        .with_grasp_failures(true)
        .with_default_p_grasp(p_grasp)
        .with_seed(seed)
}

fn run(station: &Station, pattern: &Pattern, disturbances: Disturbances, foresee: bool) -> Outcome {
    let conditions = Conditions::default().with_disturbances(disturbances);
    let scene = Scene::under(station, pattern, conditions).unwrap();
    let robots = station.robots().len();
    let base = |rule: &str| vec![rule; robots].join(",").parse().unwrap();
    let options = LookaheadOptions::default()
        .with_bases(vec![base("SPT"), base("FIFO")])
        .with_foresee(foresee);
    let outcome = simulate(&scene, &mut Lookahead::new(options)).unwrap();
    checker::check(station, pattern, &outcome).unwrap();
    outcome
}

/// One robot beside the middle of the belt.
fn one() -> Station {
    let belt = Belt {
        speed: 0.1,
        length: 2.0,
        width: 1.0,
    };
    let at = Point2::new(1.0, -0.5);
    let robot = Robot::new("r", at, at, 0.6, Arm::constant(0.5)).with_dwell(2.0, 2.0);
    Station::new(belt, vec![robot]).unwrap()
}

#[test]
fn of_two_items_the_surer_one_is_tried_if_there_is_time_for_only_one() {
    // They pass the robot together, and a pick takes so long that the other is out of reach after it.
    let items = |near: f64, far: f64| {
        let item = |id: &str, y: f64, p_grasp: f64| Item {
            p_grasp: Some(p_grasp),
            ..Item::at(id, 0.0, y)
        };
        Pattern::new(vec![item("near", -0.4, near), item("far", -0.2, far)]).unwrap()
    };
    let station = Station::new(
        Belt {
            speed: 0.3,
            ..*one().belt()
        },
        one().robots().to_vec(),
    )
    .unwrap();
    let first = |pattern: &Pattern, foresee: bool| {
        let outcome = run(&station, pattern, failing(1.0, 1), foresee);
        let attempts = outcome.failures.iter().map(|failure| failure.attempt);
        let first = outcome.picks.iter().copied().chain(attempts);
        let first = first.min_by(|a, b| a.decide.total_cmp(&b.decide)).unwrap();
        pattern.items()[first.item as usize].id.clone()
    };
    let (near_is_unsure, far_is_unsure) = (items(0.2, 0.9), items(0.9, 0.2));
    assert_eq!(first(&near_is_unsure, true), "far");
    assert_eq!(first(&far_is_unsure, true), "near");
    // Without foresight the chance does not matter.
    let blind = first(&near_is_unsure, false);
    assert_eq!(first(&far_is_unsure, false), blind);
}

#[test]
fn an_item_that_cannot_be_grasped_is_left_alone() {
    let hopeless = Item {
        p_grasp: Some(0.0),
        ..Item::at("hopeless", 0.0, 0.0)
    };
    let pattern = Pattern::new(vec![hopeless]).unwrap();
    let tried = |foresee| {
        run(&one(), &pattern, failing(1.0, 1), foresee)
            .failures
            .len()
    };
    assert_eq!(tried(true), 0);
    assert!(tried(false) > 0);
}

#[test]
fn where_nothing_can_fail_foresight_changes_nothing() {
    for (name, robots) in [("paper", 2), ("delta", 3)] {
        let station = built_in(name).unwrap().station(Some(robots)).unwrap();
        let pattern = grid(station.belt().width, 0.12, 60).unwrap();
        for disturbances in [Disturbances::default(), failing(1.0, 3)] {
            let [with, without] =
                [true, false].map(|foresee| run(&station, &pattern, disturbances, foresee));
            assert_eq!(with, without, "{name}");
        }
    }
}

/// Near what the line can do, an attempt that fails early can be made good further downstream.
#[test]
fn where_half_of_the_grasps_fail_foresight_picks_more() {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let more = (0..6).map(|seed| {
        let mut rng = random_stream(4_000, seed);
        let pattern = poisson_disk(station.belt().width, 0.2, 80, &mut rng).unwrap();
        let [with, without] = [true, false].map(|foresee| {
            run(&station, &pattern, failing(0.5, seed), foresee)
                .picks
                .len() as f64
        });
        with - without
    });
    let more: Vec<f64> = more.collect();
    let mean = more.iter().sum::<f64>() / 6.0;
    let variance = more.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 5.0;
    // Student's t for five degrees of freedom, 95 %.
    assert!(mean > 2.571 * (variance / 6.0).sqrt(), "{more:?}");
}
