//! The checker confirms real runs and refutes every way of bending one.

use pickline::checker::check;
use pickline::decision::{MissReason, Outcome};
use pickline::pattern::{Pattern, grid};
use pickline::sim::{Scene, simulate_rules};
use pickline::station::{Station, built_in};

fn run() -> (Station, Pattern, Outcome) {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let pattern = grid(1.05, 0.15, 50).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let outcome = simulate_rules(&scene, &"SPT,FIFO".parse().unwrap()).unwrap();
    (station, pattern, outcome)
}

#[test]
fn a_real_run_is_confirmed() {
    let (station, pattern, outcome) = run();
    check(&station, &pattern, &outcome).unwrap();
}

#[test]
fn bent_runs_are_refuted() {
    type Bend = fn(&mut Outcome);
    let bends: [(&str, Bend); 18] = [
        ("another robot", |o| o.picks[3].robot = 1 - o.picks[3].robot),
        ("no such robot", |o| o.picks[3].robot = 2),
        ("no such item", |o| o.picks[3].item = 50),
        ("another item", |o| o.picks[3].item = o.missed[0].item),
        ("an item twice", |o| {
            let again = o.picks[0];
            o.picks.push(again);
        }),
        ("a robot in two places", |o| {
            let gap = o.picks[2].release - o.picks[2].decide;
            for pick in &mut o.picks[3..] {
                pick.decide -= gap;
                pick.grasp -= gap;
                pick.release -= gap;
            }
        }),
        ("an early grasp", |o| o.picks[3].grasp -= 1e-3),
        ("an early release", |o| o.picks[3].release -= 1e-3),
        ("a decision that is too late", |o| o.picks[3].decide += 1e-3),
        ("a decision before the start", |o| o.picks[0].decide = -1.0),
        ("times that are none", |o| o.picks[3].release = f64::NAN),
        ("a meeting elsewhere", |o| o.picks[3].meet.x += 1e-3),
        ("picks out of order", |o| o.picks.swap(3, 4)),
        ("a miss left out", |o| {
            o.missed.pop();
        }),
        ("a wrong reason", |o| {
            o.missed[0].reason = MissReason::Unreachable
        }),
        ("an end that is none", |o| o.figures.end = f64::NAN),
        ("an early end", |o| o.figures.end -= 1.0),
        ("too much weight", |o| o.figures.weight += 0.5),
    ];
    let (station, pattern, outcome) = run();
    for (name, bend) in bends {
        let mut bent = outcome.clone();
        bend(&mut bent);
        assert!(
            check(&station, &pattern, &bent).is_err(),
            "{name} was not noticed"
        );
    }
}

/// A pick that is right in everything but the reach.
#[test]
fn a_pick_out_of_reach_is_refuted() {
    let (station, pattern, outcome) = run();
    let mut robots = station.robots().to_vec();
    for robot in &mut robots {
        robot.reach *= 0.9;
    }
    let shorter = Station::new(*station.belt(), robots).unwrap();
    let message = check(&shorter, &pattern, &outcome).unwrap_err().to_string();
    assert!(message.contains("reach"), "{message}");
}
