//! Instances whose optimum lies exactly at a limit, where a bound that is rounded to the wrong
//! side is too low, and one that is rounded too far is too high.

use crate::brute_force::{bound, holds, optimum, options, undisturbed};
use pickline::pattern::{Item, Pattern};
use pickline::planning::bound::{Bound, BoundObjective, BoundStop};
use pickline::sim::{Conditions, Disturbances, Scene};
use pickline::station::{Belt, Robot, Station};

const BELT: Belt = Belt {
    speed: 0.1,
    length: 4.0,
    width: 1.0,
};

fn robot(name: &str, x: f64, dwell: f64) -> Robot {
    Robot::new(
        name,
        [x, -0.5].into(),
        [x, -0.5].into(),
        0.6,
        pickline::kinematics::Arm::constant(0.5),
    )
    .with_dwell(dwell, 0.0)
}

/// Robots that hold each item for so long [s], 1.5 m from each other.
pub fn line(dwells: &[f64]) -> Station {
    let names = ["a", "b", "c"];
    let robots = dwells.iter().zip(names).enumerate();
    let robots = robots.map(|(i, (&dwell, name))| robot(name, 1.0 + 1.5 * i as f64, dwell));
    Station::new(BELT, robots.collect()).unwrap()
}

/// Items at (x0, y) [m] with these weights.
fn items(items: &[(f64, f64, f64)]) -> Pattern {
    let item = |(i, &(x0, y, weight)): (usize, &(f64, f64, f64))| Item {
        weight: Some(weight),
        ..Item::at(i.to_string(), x0, y)
    };
    Pattern::new(items.iter().enumerate().map(item).collect()).unwrap()
}

/// The largest value from 0 to `most` for which `holds`, which holds up to some value.
fn last(most: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, most);
    assert!(holds(low) && !holds(high));
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return low;
        }
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// Slots whose boundaries lie exactly at `times`, in front of them and behind them, and
/// usual ones.
fn lengths(times: &[f64]) -> Vec<f64> {
    let mut lengths = vec![0.02, 0.1, 0.3, 1.0, 5.0];
    for time in times.iter().filter(|time| **time > 0.1) {
        for parts in [1.0, 3.0, 7.0, 64.0] {
            let length = time / parts;
            lengths.extend([length, length.next_up(), length.next_down()]);
        }
    }
    lengths
}

fn with_slots(scene: &Scene, objective: BoundObjective, slot_s: Option<f64>) -> Bound {
    let options = options(objective, 60).with_slot_s(slot_s);
    bound(scene, &options)
}

/// Every time at which a window opens or closes, or a pick that leaves then ends.
fn limits(scene: &Scene) -> Vec<f64> {
    let mut times = Vec::new();
    for robot in 0..scene.station().robots().len() {
        for candidate in scene.queue(robot) {
            for time in [candidate.open, candidate.close] {
                let moment = pickline::decision::Moment::new(scene.station(), robot, 0, time);
                times.extend([time, time + moment.processing_time(candidate)]);
            }
        }
    }
    times
}

/// The bound holds in slots of any length, and is the optimum in usual ones.
fn at_the_limit(scene: &Scene, picks: usize) {
    let best = optimum(scene);
    assert_eq!(best.picks, picks);
    for length in lengths(&limits(scene)) {
        for objective in [BoundObjective::Picks, BoundObjective::Weight] {
            holds(&with_slots(scene, objective, Some(length)), &best);
        }
    }
    let usual = with_slots(scene, BoundObjective::Picks, None);
    assert_eq!(usual.value, picks as f64, "{usual:?}");
}

/// Two items, of which the second can be left for at the last moment of its window only, as
/// the robot is not free before; a breath later it is gone.
#[test]
fn an_item_that_can_be_picked_at_the_last_moment_counts() {
    let pattern = items(&[(0.0, -0.4, 1.0), (-0.25, -0.4, 2.0)]);
    let both = |dwell: f64| {
        let station = line(&[dwell]);
        optimum(&Scene::new(&station, &pattern).unwrap()).picks == 2
    };
    let dwell = last(60.0, both);
    let station = line(&[dwell]);
    at_the_limit(&Scene::new(&station, &pattern).unwrap(), 2);
    // By two slots too late.
    let slot = 0.02;
    let station = line(&[dwell + 2.0 * slot]);
    let scene = Scene::new(&station, &pattern).unwrap();
    assert_eq!(optimum(&scene).picks, 1);
    assert_eq!(
        with_slots(&scene, BoundObjective::Picks, Some(slot)).value,
        1.0
    );
}

/// Three picks without a moment between them, the last of them at the last moment.
#[test]
fn picks_that_touch_count() {
    let pattern = items(&[(0.0, -0.4, 1.0), (-0.3, -0.45, 1.0), (-0.55, -0.4, 1.0)]);
    let all = |dwell: f64| {
        let station = line(&[dwell]);
        optimum(&Scene::new(&station, &pattern).unwrap()).picks == 3
    };
    let dwell = last(60.0, all);
    assert!(dwell > 1.0, "{dwell}");
    let station = line(&[dwell]);
    at_the_limit(&Scene::new(&station, &pattern).unwrap(), 3);
}

/// Windows of a single moment: the item is within reach at one place only.
#[test]
fn a_window_of_a_moment_is_enough() {
    let at_reach = |y: f64| items(&[(0.0, y, 1.0)]);
    let reached = |y: f64| {
        let (station, pattern) = (line(&[1.0]), at_reach(y));
        !Scene::new(&station, &pattern).unwrap().queue(0).is_empty()
    };
    let y = last(0.45, reached);
    let (station, pattern) = (line(&[1.0]), at_reach(y));
    let scene = Scene::new(&station, &pattern).unwrap();
    let window = scene.queue(0)[0];
    assert!(window.close - window.open < 1e-6, "{window:?}");
    at_the_limit(&scene, 1);
    // Items that reach the station too late for their windows have none.
    let (station, pattern) = (line(&[1.0]), at_reach(y + 1e-6));
    let scene = Scene::new(&station, &pattern).unwrap();
    let found = with_slots(&scene, BoundObjective::Picks, None);
    assert_eq!((found.value, found.reachable, found.rate), (0.0, 0, None));
}

/// Equal items at one place, more than there is time for: which of them is picked is a tie.
#[test]
fn equal_items_are_interchangeable() {
    let pattern = items(&[(0.0, -0.4, 1.0); 5]);
    let station = line(&[12.0, 9.0]);
    let scene = Scene::new(&station, &pattern).unwrap();
    let best = optimum(&scene);
    assert!((2..5).contains(&best.picks), "{best:?}");
    at_the_limit(&scene, best.picks);
}

/// A sum of weights that are no binary fractions, exactly: weights from 1/128 to 1 are whole
/// multiples of 2^-60.
fn exactly(weights: &[f64]) -> i128 {
    weights.iter().map(|weight| in_parts(*weight)).sum()
}

fn in_parts(weight: f64) -> i128 {
    (weight * 60f64.exp2()) as i128
}

/// The bound on weight is no lower than the exact sum, not even by the last digit of its
/// units, and no higher than by a unit an item.
#[test]
fn weights_with_fractions_are_rounded_up() {
    for weights in [
        &[0.1][..],
        &[1.0 / 3.0],
        &[0.7, 0.1],
        &[0.1, 0.2, 0.3],
        &[0.9, 1.0 / 3.0, 1.0 / 7.0, 1.0 / 9.0],
    ] {
        let spread: Vec<(f64, f64, f64)> = (0..weights.len())
            .map(|i| (-0.8 * i as f64, -0.4, weights[i]))
            .collect();
        let (station, pattern) = (line(&[0.1]), items(&spread));
        let scene = Scene::new(&station, &pattern).unwrap();
        let least = exactly(weights);
        let found = with_slots(&scene, BoundObjective::Weight, None);
        for value in [found.value, found.relaxed] {
            let most = least + weights.len() as i128 * (1 << 20);
            assert!(
                (least..=most).contains(&in_parts(value)),
                "{weights:?}: {value}"
            );
        }
        // Without slots the bound is the sum of all, a little more than that.
        let none = options(BoundObjective::Weight, 1).with_arcs(0);
        let found = bound(&scene, &none);
        assert_eq!(found.stop, BoundStop::TooManyItems);
        let value = in_parts(found.value);
        assert!(
            least <= value && value <= least + (least >> 29),
            "{weights:?}: {value}"
        );
    }
}

/// The rate and the ends of a run of one pick, or of none, are known exactly.
#[test]
fn the_rate_and_the_end_of_one_pick_are_known() {
    let station = line(&[1.0]);
    // Everything is picked: the run ends with the release.
    let pattern = items(&[(0.0, -0.4, 0.5)]);
    let scene = Scene::new(&station, &pattern).unwrap();
    let best = optimum(&scene);
    let release = best.all_end.unwrap();
    let near = |value: f64, exact: f64| (value - exact).abs() <= 1e-7 * exact;
    for (objective, earned) in [(BoundObjective::Picks, 1.0), (BoundObjective::Weight, 0.5)] {
        let found = with_slots(&scene, objective, None);
        holds(&found, &best);
        let (end, all_end) = (found.end, found.all_end.unwrap());
        assert!(near(end, release) && near(all_end, release), "{found:?}");
        assert!(
            near(found.rate.unwrap(), 60.0 * earned / release),
            "{found:?}"
        );
    }
    // One of two is out of reach: the run ends when that leaves the belt, which no slack
    // changes, nor does any rounding lower the rate.
    let pattern = items(&[(0.0, -0.4, 0.7), (-0.013, 0.4, 0.1)]);
    let scene = Scene::new(&station, &pattern).unwrap();
    let leaves = (4.0 + 0.013) / 0.1;
    for (objective, earned) in [(BoundObjective::Picks, 1.0), (BoundObjective::Weight, 0.7)] {
        let found = with_slots(&scene, objective, None);
        assert_eq!((found.end, found.all_end), (leaves, None));
        let (rate, exact) = (found.rate.unwrap(), 60.0 * earned / leaves);
        assert!(
            exact <= rate && rate <= exact * (1.0 + 3e-12),
            "{rate} {exact}"
        );
    }
}

/// An item that has been on the belt for long ends the run late unless it is picked; one that
/// comes much later cannot be picked by then.
#[test]
fn items_past_the_end_of_a_run_do_not_count_for_it() {
    // The second pair arrives 30 s after the first.
    let pattern = items(&[
        (0.0, -0.4, 1.0),
        (0.0, -0.35, 1.0),
        (-3.0, -0.4, 1.0),
        (-3.0, -0.35, 1.0),
    ]);
    for dwells in [&[1.0][..], &[9.0], &[60.0], &[9.0, 60.0]] {
        let station = line(dwells);
        let scene = Scene::new(&station, &pattern).unwrap();
        at_the_limit(&scene, optimum(&scene).picks);
        let best = optimum(&scene);
        let found = bound(&scene, &options(BoundObjective::Picks, 400));
        let most = found.rate.unwrap();
        assert!(most <= 1.02 * best.rate, "{dwells:?}: {most} {best:?}");
        // The end of any run is the looser one.
        assert!(
            found.end >= 0.79 * best.end,
            "{dwells:?}: {} {best:?}",
            found.end
        );
        assert_eq!(
            found.all_end.is_some(),
            best.all_end.is_some(),
            "{dwells:?}"
        );
        if let Some((least, end)) = found.all_end.zip(best.all_end) {
            assert!(least >= 0.98 * end, "{dwells:?}: {least} {end}");
        }
    }
}

/// A robot that is ready at once: the item is at its bin when the run begins.
#[test]
fn a_run_may_begin_with_a_pick() {
    let station = line(&[2.0]);
    let pattern = Pattern::new(vec![Item::at("0", 0.0, -0.5)]).unwrap();
    let mut robots = station.robots().to_vec();
    robots[0].base.x = 0.0;
    robots[0].bins[0].at.x = 0.0;
    robots[0].rest.x = 0.0;
    let station = Station::new(BELT, robots).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    assert_eq!(scene.queue(0)[0].open, 0.0);
    at_the_limit(&scene, 1);
    let found = with_slots(&scene, BoundObjective::Picks, None);
    assert!((2.0 - 1e-8..=2.0).contains(&found.end), "{found:?}");
}

fn disturbed(camera_x: Option<f64>, failures: bool, position_noise: f64, seed: u64) -> Conditions {
    Conditions::default()
        .with_camera_x(camera_x)
        .with_disturbances(
            Disturbances::default()
                .with_grasp_failures(failures)
                .with_default_p_grasp(0.6)
                .with_position_noise(position_noise)
                .with_seed(seed),
        )
}

/// What a bound says, without how it was found.
fn said(found: &Bound) -> (f64, f64, Option<f64>, f64, Option<f64>, usize) {
    (
        found.value,
        found.relaxed,
        found.rate,
        found.end,
        found.all_end,
        found.reachable,
    )
}

/// The bound under noise is that of the line without noise and without a camera; the one under
/// failures alone keeps the camera.
#[test]
fn the_bound_of_a_disturbed_line_is_that_of_the_plain_one() {
    let pattern = items(&[(0.0, -0.4, 1.0), (-0.1, -0.3, 0.3), (-0.25, -0.45, 0.5)]);
    let station = line(&[6.0, 8.0]);
    for (camera_x, failures, noise, kept) in [
        (Some(1.2), true, 0.0, Some(1.2)),
        (Some(1.2), false, 0.1, None),
        (Some(1.2), true, 0.1, None),
        (None, true, 0.1, None),
        (None, false, 0.1, None),
    ] {
        let conditions = disturbed(camera_x, failures, noise, 3);
        let scene = Scene::under(&station, &pattern, conditions.clone()).unwrap();
        let plain = undisturbed(&scene, kept);
        for objective in [BoundObjective::Picks, BoundObjective::Weight] {
            let (found, expected) = (
                with_slots(&scene, objective, None),
                with_slots(&plain, objective, None),
            );
            assert_eq!(said(&found), said(&expected), "{conditions:?}");
        }
    }
}

/// Under noise an item can be picked before it has passed the camera, where it is reported
/// further downstream than it is: with the camera's line the bound would be too low, which
/// is why it is left out.
#[test]
fn a_camera_does_not_hold_under_noise() {
    let pattern = items(&[(0.0, -0.45, 1.0), (-0.02, -0.4, 1.0)]);
    let mut too_low = 0;
    for seed in 0..200 {
        let station = line(&[4.0]);
        let scene = Scene::under(&station, &pattern, disturbed(Some(1.0), false, 0.1, seed));
        let scene = scene.unwrap();
        let best = optimum(&scene);
        holds(&with_slots(&scene, BoundObjective::Picks, None), &best);
        let with_camera = undisturbed(&scene, Some(1.0));
        let wrong = with_slots(&with_camera, BoundObjective::Picks, None);
        too_low += usize::from(wrong.value < best.picks as f64 || wrong.end > best.end);
    }
    assert!(too_low > 10, "{too_low} of 200 would be too low");
}

/// Failed grasps only cost time: all attempts of all robots in every order pick no more.
#[test]
fn failures_only_cost_time() {
    let pattern = items(&[(0.0, -0.4, 1.0), (-0.1, -0.3, 0.3), (-0.4, -0.45, 0.5)]);
    let mut fewer = 0;
    for seed in 0..30 {
        let station = line(&[3.0, 4.0]);
        let conditions = disturbed(Some(0.2), true, 0.0, seed);
        let scene = Scene::under(&station, &pattern, conditions).unwrap();
        let best = optimum(&scene);
        for objective in [BoundObjective::Picks, BoundObjective::Weight] {
            holds(&with_slots(&scene, objective, None), &best);
        }
        fewer += usize::from(best.picks < 3);
    }
    assert!(
        (1..30).contains(&fewer),
        "{fewer} of 30 are not picked whole"
    );
}
