//! What the observation for real lines adds to the full one, against a plain transcription of the
//! tables in `src/decision/observation/real.rs`.

use super::observation::{FULL, encoded};
use pickline::decision::observation::{Layout, View};
use pickline::decision::{Action, Snapshot};
use pickline::pattern::{ClassShares, Pattern, grid, random_stream};
use pickline::sim::{Conditions, Disturbances, Run, Scene};
use pickline::station::{Station, built_in};

const REAL: Layout = Layout {
    view: View::Real,
    ..FULL
};

/// The features after those of the full observation: the globals, and those of every candidate.
fn added(s: &Snapshot) -> (Vec<f64>, Vec<[f64; 4]>) {
    let (robot, belt) = (&s.station.robots()[s.robot], s.station.belt());
    let to_belt = if robot.base.y <= 0.0 { 1.0 } else { -1.0 };
    let relative = |x: f64, y: f64| {
        let (dx, dy) = (x - robot.base.x, y - robot.base.y);
        [dx / robot.reach, to_belt * dy / robot.reach]
    };
    let place = usize::from(s.places[s.robot]);
    let arm = robot.bins.get(place).map_or(robot.rest, |bin| bin.at);
    let count = s.in_view.len() as f64;
    let mean = |of: &dyn Fn(usize) -> f64| match s.in_view.len() {
        0 => 1.0,
        n => (0..n).map(of).sum::<f64>() / count,
    };
    let mut globals = relative(arm.x, arm.y).to_vec();
    globals.extend([
        robot.arm.time(robot.reach / 4.0) / robot.arm.time(robot.reach),
        2.0 * robot.arm.lift / robot.reach,
        robot.bins.len() as f64 / 4.0,
        relative(0.0, 0.0)[1],
        belt.width / robot.reach,
        mean(&|item| s.in_view[item].odds.grasp),
        mean(&|item| s.in_view[item].odds.detection),
    ]);
    let slots = s.candidates.iter().enumerate().map(|(place, candidate)| {
        let bin = robot.bins[usize::from(candidate.bin)].at;
        let [x, y] = relative(bin.x, bin.y);
        let odds = s.odds_of(place);
        [odds.grasp, odds.detection, x, y]
    });
    (globals, slots.collect())
}

fn check(snapshot: &Snapshot) {
    let (full, _) = encoded(FULL, snapshot);
    let (real, _) = encoded(REAL, snapshot);
    let (globals, slots) = added(snapshot);
    assert_eq!((globals.len(), real.len()), (9, 30 + 4 * 21));
    assert_eq!(real[..21], full[..21]);
    let close = |found: f32, expected: f64, what: &str| {
        let far = (f64::from(found) - expected).abs();
        assert!(
            far < 2e-6 * (1.0 + expected.abs()),
            "{what}: {found}, {expected}"
        );
    };
    for (index, (found, expected)) in real[21..30].iter().zip(&globals).enumerate() {
        close(*found, *expected, &format!("global {}", 21 + index));
    }
    if snapshot.candidates.len() > 4 {
        // Which of them have slots is tested elsewhere.
        return;
    }
    for (number, expected) in slots.iter().enumerate() {
        let slot = &real[30 + 21 * number..][..21];
        assert_eq!(slot[..17], full[21 + 17 * number..][..17]);
        for (index, (found, expected)) in slot[17..].iter().zip(expected).enumerate() {
            close(*found, *expected, &format!("slot feature {}", 17 + index));
        }
    }
    assert!(
        real[30 + 21 * slots.len()..]
            .iter()
            .all(|value| *value == 0.0)
    );
}

/// A pattern of items with classes and probabilities of their own.
fn pattern(station: &Station, spacing: f64) -> Pattern {
    let plain = grid(station.belt().width, spacing, 60).unwrap();
    let shares: ClassShares = "pet:0.4,hdpe:0.3,paper:0.2,wood:0.1".parse().unwrap();
    let classed = shares.apply(&plain, &mut random_stream(1, 0)).unwrap();
    let mut items = classed.items().to_vec();
    for (number, item) in items.iter_mut().enumerate() {
        item.p_grasp = (number % 3 > 0).then_some(0.3 + 0.01 * number as f64);
    }
    Pattern::new(items).unwrap()
}

#[test]
fn the_real_observation_is_the_full_one_and_what_its_table_says() {
    for (name, robots) in [("paper", 2), ("delta", 3), ("sorting", 4)] {
        let station = built_in(name).unwrap().station(Some(robots)).unwrap();
        for spacing in [0.1, 0.25] {
            let pattern = pattern(&station, spacing);
            let failing = Disturbances::default()
                .with_grasp_failures(true)
                .with_default_p_grasp(0.8);
            for disturbances in [Disturbances::default(), failing] {
                let conditions = Conditions::default().with_disturbances(disturbances);
                let scene = Scene::under(&station, &pattern, conditions).unwrap();
                let mut run = Run::new(&scene);
                let mut decisions = 0;
                while let Some(snapshot) = run.next_decision() {
                    let sure =
                        (0..snapshot.candidates.len()).all(|c| snapshot.odds_of(c).grasp == 1.0);
                    assert!(disturbances.grasp_failures || sure);
                    check(&snapshot);
                    let choice = decisions % snapshot.candidates.len();
                    run.act(Action::Pick(choice)).unwrap();
                    decisions += 1;
                }
                assert!(decisions > 10, "{name} {spacing}");
            }
        }
    }
}
