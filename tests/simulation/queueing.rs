//! What queueing theory knows: a robot that cannot wait for its items is a loss system.

use nalgebra::Point2;
use pickline::kinematics::{Arm, TravelLaw};
use pickline::pattern::{Item, Pattern, random_stream};
use pickline::sim::{Scene, simulate_rules};
use pickline::station::{Belt, Robot, Station};
use rand::RngExt as _;

/// With a reach so short and an arm so fast that only grasp and release take time, S together, an
/// item is picked if the robot is free when it passes, and lost otherwise. Poisson arrivals of rate
/// lambda see the robot free with probability 1 / (1 + lambda S), whatever takes the time S (Erlang's
/// loss formula for one server; Kleinrock, Queueing Systems I, 1975, ISBN 0-471-49110-1, section
/// 3.6).
#[test]
fn a_robot_without_reach_loses_what_erlang_says() {
    const SERVICE: f64 = 0.5;
    let belt = Belt {
        speed: 0.2,
        length: 1.0,
        width: 0.2,
    };
    let arms = [
        Arm::constant(1e4),
        Arm {
            law: TravelLaw::Trapezoid {
                speed: 1e4,
                acceleration: 1e6,
                deceleration: 1e6,
            },
            lift: 1e-6,
        },
    ];
    for (arm, load) in arms
        .iter()
        .flat_map(|arm| [0.5, 1.0, 2.0].map(|load| (arm, load)))
    {
        let place = Point2::new(0.5, 0.0);
        let robot =
            Robot::new("r1", place, place, 1e-4, arm.clone()).with_dwell(0.3, SERVICE - 0.3);
        let station = Station::new(belt, vec![robot]).unwrap();
        let mut rng = random_stream(7, 0);
        let mut arrival = 0.0;
        let items = (0..200_000).map(|i| {
            arrival += -(1.0 - rng.random::<f64>()).ln() * SERVICE / load;
            Item::at(i.to_string(), -belt.speed * arrival, 0.0)
        });
        let pattern = Pattern::new(items.collect()).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let outcome = simulate_rules(&scene, &"FIFO".parse().unwrap()).unwrap();
        let (share, expected) = (outcome.figures.picked_share(), 1.0 / (1.0 + load));
        assert!(
            (share / expected - 1.0).abs() < 0.01,
            "{arm:?}, load {load}: {share} of {expected}"
        );
    }
}
