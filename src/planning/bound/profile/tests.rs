//! Compares steps of a profile with separate evaluations, and ends with hand-computed ones.

use super::*;
use crate::kinematics::Arm;
use crate::pattern::{Item, Pattern};
use crate::planning::bound::BoundObjective;
use crate::planning::bound::network::Slots;
use crate::station::{Belt, Robot, Station};

const LENGTH: f64 = 0.5;

/// When the items leave the belt [s].
const LEAVES: [f64; 5] = [80.0, 82.0, 84.0, 86.0, 88.0];

/// Five items, and two robots whose picks take 70 s and end about when the items leave.
fn scene(with: impl FnOnce(&Scene, &Dual)) {
    let belt = Belt {
        speed: 0.125,
        length: 10.0,
        width: 1.0,
    };
    let robot = |name: &str, x: f64| {
        Robot::new(
            name,
            [x, -0.5].into(),
            [x, -0.5].into(),
            0.75,
            Arm::constant(1.0),
        )
        .with_dwell(70.0, 0.0)
    };
    let station = Station::new(belt, vec![robot("a", 1.0), robot("b", 1.5)]).unwrap();
    let item = |i: usize| Item::at(i.to_string(), -0.25 * i as f64, -0.25);
    let pattern = Pattern::new((0..5).map(item).collect()).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let dual = Dual::new(&scene, BoundObjective::Picks, Slots { length: LENGTH });
    with(&scene, &dual);
}

fn slots(dual: &Dual) -> Vec<u64> {
    let networks = dual.networks.iter();
    let mut slots: Vec<u64> = networks.flat_map(|n| n.slots().to_vec()).collect();
    slots.sort_unstable();
    slots.dedup();
    slots
}

/// The earliest time at which each item can be in a bin.
fn releases(scene: &Scene) -> Vec<f64> {
    let of = |item: u32| {
        let robots = 0..scene.station().robots().len();
        let all = robots.flat_map(|robot| {
            let own = scene.queue(robot).iter().filter(move |c| c.item == item);
            own.map(move |c| earliest_release(scene.station(), robot, (c, 0)))
        });
        all.fold(f64::INFINITY, f64::min)
    };
    (0..scene.pattern().len() as u32).map(of).collect()
}

/// Initially, every item counts from the slot of its earliest release.
#[test]
fn no_item_earns_twice_or_before_it_can_be_released() {
    scene(|scene, dual| {
        let profile = BoundProfile::new(dual);
        let unit = dual.units as i64;
        let releases = releases(scene);
        for (step, slot) in slots(dual).into_iter().enumerate() {
            let by = (slot + 1) as f64 * LENGTH;
            let count = releases.iter().filter(|release| **release < by).count();
            assert_eq!(profile.value(step), count as i64 * unit, "{slot}");
        }
        assert!(!profile.is_empty());
    });
}

/// Prices below 0 are valid for runs that end before their item leaves the belt, because it
/// must be picked by then. For runs that pick everything they are always valid.
#[test]
fn negative_prices_hold_until_their_item_leaves() {
    scene(|scene, dual| {
        let belt = Leaving::new(scene, dual);
        assert_eq!(belt.leaves, LEAVES);
        let unit = dual.units as i64;
        let slots = slots(dual);
        let part = unit / 8;
        for (prices, until) in [
            ([part, 2 * part, 0, 0, 0], f64::INFINITY),
            ([-part, part, 0, 0, part], 80.0),
            ([part, -part, -part, 0, 0], 82.0),
        ] {
            let mut profile = BoundProfile::new(dual);
            let before = profile.best.clone();
            let mut at = DualEvaluation::default();
            dual.evaluate(&prices, u64::MAX, &mut at);
            profile.enter(&belt, &prices, &at);
            let mut lower = [0, 0];
            for (step, &slot) in slots.iter().enumerate() {
                dual.evaluate(&prices, slot, &mut at);
                let with = before[step].min(at.value);
                let next = slots
                    .get(step + 1)
                    .map_or(f64::INFINITY, |&s| s as f64 * LENGTH);
                let expected = if next <= until { with } else { before[step] };
                assert_eq!(profile.value(step), expected, "{prices:?} {slot}");
                assert_eq!(profile.all[step], with, "{prices:?} {slot}");
                lower[usize::from(next <= until)] += usize::from(with < before[step]);
            }
            assert!(
                lower[1] > 0 && (until.is_infinite() || lower[0] > 0),
                "{lower:?}"
            );
        }
        // Some slot begins exactly when the first item leaves.
        assert!(slots.contains(&160));
    });
}

#[test]
fn what_leaves_after_the_next_step_must_be_picked() {
    scene(|scene, dual| {
        let (belt, profile) = (Leaving::new(scene, dual), BoundProfile::new(dual));
        let slots = slots(dual);
        for (step, &slot) in slots.iter().enumerate().take(slots.len() - 1) {
            let next = slots[step + 1] as f64 * LENGTH;
            let left = LEAVES.iter().filter(|leaves| **leaves < next).count();
            let found = profile.schedules(step, &belt);
            assert_eq!((found.horizon, found.must_from), (slot, left));
            let found = profile.complete_schedules(step);
            assert_eq!((found.horizon, found.must_from), (slot, 0));
        }
    });
}

/// A run ends with its last release, or when the last unpicked item leaves: all items after it
/// are picked.
#[test]
fn the_least_end_leaves_one_item_or_none() {
    scene(|scene, dual| {
        let belt = Leaving::new(scene, dual);
        let releases = releases(scene);
        let last = releases.iter().copied().fold(0.0, f64::max);
        let behind = |item: usize| releases[item + 1..].iter().copied().fold(0.0, f64::max);
        let leaving = (0..5).map(|item| belt.leaves[item].max(behind(item)));
        assert_eq!(belt.least_end, leaving.fold(last, f64::min));
        assert_eq!(belt.last_release, last);
        let unit = dual.units as i64;
        let worth: Vec<i64> = (0..=5).rev().map(|count| count * unit).collect();
        assert_eq!(belt.worth_from, worth);
        assert_eq!(belt.total, 5 * unit);
    });
}

/// Steps that begin at 10, 20 and 30 s, and items that leave at these times [s].
fn ends(leaves: [f64; 4], best: [f64; 3], all: [f64; 3]) -> Ends {
    let mut found = None;
    scene(|_, dual| {
        let units = |values: [f64; 3]| values.map(|v| (v * dual.units) as i64).to_vec();
        let profile = BoundProfile {
            slots: vec![10, 20, 30],
            begins: vec![10.0, 20.0, 30.0, f64::INFINITY],
            best: units(best),
            all: units(all),
            released: Vec::new(),
            by_release: Vec::new(),
            nodes: Vec::new(),
        };
        let unit = dual.units as i64;
        let belt = Leaving {
            leaves: leaves.to_vec(),
            worth_from: (0..=4).rev().map(|count| count * unit).collect(),
            total: 4 * unit,
            least_end: 7.0,
            last_release: 45.0,
        };
        found = Some(profile.ends(dual, &belt));
    });
    found.unwrap()
}

/// Each step by hand: the items still on the belt at the end must be among those that can be
/// earned by then.
#[test]
fn ends_and_rates_follow_from_the_steps() {
    // One pick: the last item to leave without being picked is the third, at 40 s, too late for
    // the step. Two: the second, at 25 s. Three: the first.
    let found = ends([15.0, 25.0, 40.0, 50.0], [1.0, 2.0, 3.9], [1.0, 3.9, 4.0]);
    assert_eq!((found.end, found.rate), (Some((25.0, 1)), Some((6.0, 2))));
    assert_eq!(found.all, Some((45.0, 2)));
    // No step earns all of them.
    let found = ends([15.0, 25.0, 40.0, 50.0], [1.0, 2.0, 3.0], [1.0, 3.0, 3.9]);
    assert_eq!(found.all, None);
    // An end at the beginning of the next step belongs to that step.
    let found = ends([15.0, 30.0, 40.0, 50.0], [1.0, 2.0, 3.0], [0.0; 3]);
    assert_eq!((found.end, found.rate), (Some((30.0, 2)), Some((6.0, 2))));
    // Of equal rates, the first counts; a later, lower one changes nothing.
    let found = ends([15.0, 16.0, 40.0, 50.0], [1.0, 2.0, 3.0], [0.0; 3]);
    assert_eq!((found.end, found.rate), (Some((20.0, 1)), Some((6.0, 1))));
    let found = ends([15.0, 16.0, 17.0, 50.0], [1.0, 2.0, 2.0], [0.0; 3]);
    assert_eq!((found.end, found.rate), (Some((17.0, 0)), Some((6.0, 1))));
    // A bound for later steps also holds for earlier ones.
    let found = ends([15.0, 25.0, 40.0, 50.0], [3.0, 2.0, 2.0], [0.0; 3]);
    assert_eq!((found.end, found.rate), (Some((25.0, 1)), Some((4.8, 1))));
    // Nothing needs to be earned; less than nothing is impossible.
    let found = ends([5.0, 6.0, 12.0, 15.0], [0.0, 0.0, 1.0], [0.0; 3]);
    assert_eq!((found.end, found.rate), (Some((15.0, 0)), Some((2.0, 2))));
    let found = ends([5.0, 6.0, 12.0, 15.0], [-1.0, -1.0, 1.0], [0.0; 3]);
    assert_eq!((found.end, found.rate), (Some((30.0, 2)), Some((2.0, 2))));
    // A run that ends before anything can be released.
    let found = ends([5.0, 6.0, 7.5, 8.0], [1.0, 1.0, 1.0], [0.0; 3]);
    assert_eq!(found.end, Some((8.0, 0)));
}
