//! Every feature of the two observations, at its index, by numbers worked out by hand for one
//! decision; and what actions mean.

use nalgebra::Point2;
use pickline::decision::observation::{Encoder, Layout, View};
use pickline::decision::{Action, BeltItem, Candidate, Snapshot};
use pickline::station::{Belt, Robot, Station};

pub const FULL: Layout = Layout {
    view: View::Full,
    slots: 4,
    wait: false,
};

fn robot(name: &str, base: [f64; 2], bin: [f64; 2], reach: f64, speed: f64, dwell: f64) -> Robot {
    Robot::new(
        name,
        Point2::from(base),
        Point2::from(bin),
        reach,
        pickline::kinematics::Arm::constant(speed),
    )
    .with_dwell(0.25 * dwell, 0.75 * dwell)
}

/// Belt at 0.1 m/s, 4 m by 1 m. Robots below, above and below it; reach and speed of the
/// middle one make T = 2 s.
fn three() -> Station {
    let belt = Belt {
        speed: 0.1,
        length: 4.0,
        width: 1.0,
    };
    let robots = vec![
        robot("a", [0.8, -0.5], [0.8, -0.5], 0.7, 0.5, 1.0),
        robot("b", [2.0, 0.6], [2.0, 0.5], 1.0, 0.5, 0.8),
        robot("c", [3.2, -0.5], [3.2, -0.5], 0.9, 0.4, 1.2),
    ];
    Station::new(belt, robots).unwrap()
}

/// Shorthands of the tables, for the deciding robot `b`.
fn log(time: f64) -> f64 {
    (1.0 + time / 2.0).ln() / 3.0
}

pub fn count(items: f64) -> f64 {
    (1.0 + items).ln() / 4.0
}

fn assert_features(found: &[f32], expected: &[(&str, f64)], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (index, (found, (name, expected))) in found.iter().zip(expected).enumerate() {
        assert!(
            (f64::from(*found) - expected).abs() < 2e-5 * expected.abs().max(1.0),
            "{what}: feature {index}, {name}: {found}, expected {expected}"
        );
    }
}

pub fn encoded(layout: Layout, snapshot: &Snapshot) -> (Vec<f32>, Vec<bool>) {
    let mut observation = vec![f32::NAN; layout.observation()];
    let mut mask = vec![false; layout.actions()];
    Encoder::new(layout).encode(snapshot, &mut observation, &mut mask);
    (observation, mask)
}

/// At t = 10 s robot `b` chooses between an item at (1.6, 0.5), straight upstream of its bin,
/// and one at (2.3, 0.1).
fn decision(station: &Station, work: impl FnOnce(&Snapshot)) {
    let candidate = |item, x: f64, y, weight, close| Candidate {
        item,
        bin: 0,
        class: pickline::station::ClassId::OTHER,
        x0: x - 1.0,
        y,
        weight,
        open: 8.0,
        close,
    };
    let candidates = [
        candidate(4, 2.3, 0.1, 0.25, 14.0),
        candidate(6, 1.6, 0.5, 0.75, 22.0),
    ];
    let seen = |item, x: f64, y| BeltItem {
        item,
        class: pickline::station::ClassId::OTHER,
        x0: x - 1.0,
        x,
        y,
        weight: 0.5,
        odds: pickline::decision::Odds::SURE,
    };
    let in_view = [
        // Past `b`, for `c` alone.
        seen(1, 3.4, -0.3),
        seen(4, 2.3, 0.1),
        seen(6, 1.6, 0.5),
        // Beyond the reach of `a` and of `c`.
        seen(7, 0.9, 0.45),
        seen(8, 0.4, -0.4),
    ];
    work(&Snapshot {
        station,
        time: 10.0,
        robot: 1,
        candidates: &candidates,
        free_at: &[16.0, 10.0, 14.0],
        places: &[0; 8],
        candidate_odds: &[],
        in_view: &in_view,
    });
}

#[test]
fn the_globals_are_those_of_a_decision_worked_out_by_hand() {
    let station = three();
    decision(&station, |snapshot| {
        let (observation, _) = encoded(FULL, snapshot);
        // Who can still take what: `a` reaches y up to 0.2 and the item at x = 0.4; `b`
        // reaches y down to -0.4 and all up to 7 and 8; `c` reaches y up to 0.4.
        // item   a  b  c
        //   1    -  -  x    (3.4, -0.3): past `b`; 0.2 past the base of `c`
        //   4    -  x  x    (2.3, 0.1)
        //   6    -  x  -    (1.6, 0.5): 1.0 across from `c`, which reaches 0.9
        //   7    -  x  -
        //   8    x  x  x    (0.4, -0.4): exactly 1.0 across from `b`
        let expected = [
            ("place in the line", 0.5),
            ("first", 0.0),
            ("last", 0.0),
            ("robots / 6", 0.5),
            ("downstream busy", 1.0),
            ("downstream time until free", log(4.0)),
            ("upstream busy", 1.0),
            ("upstream time until free", log(6.0)),
            ("mean time until free", (log(4.0) + log(6.0)) / 2.0),
            ("candidates", count(2.0)),
            ("load", count(4.0)),
            ("load that is nobody else's", count(2.0)),
            ("load downstream", count(3.0)),
            ("load upstream", count(1.0)),
            ("load of the others", count((3.0 + 1.0) / 2.0)),
            ("in view", count(5.0)),
            ("belt speed / arm speed", 0.2),
            ("time through the workspace", log(20.0)),
            ("grasp and release / T", 0.4),
            ("last item in view", 0.1),
            ("load shared", count(0.5 + 1.0 + 1.0 + 1.0 / 3.0)),
        ];
        assert_features(&observation[..21], &expected, "globals");
    });
}

#[test]
fn the_slots_are_those_of_a_decision_worked_out_by_hand() {
    let station = three();
    decision(&station, |snapshot| {
        let (observation, mask) = encoded(FULL, snapshot);
        assert_eq!(mask, [true, true, false, false]);
        // k = 0.5^2 - 0.1^2 = 0.24. To (2.3, 0.1): d = (0.3, -0.4).
        let tau: f64 = (0.1 * 0.3 + (0.01f64 * 0.09 + 0.24 * 0.25).sqrt()) / 0.24;
        let first = 2.0 * tau + 0.8;
        // To (1.6, 0.5), straight towards the bin: 0.4 m at 0.6 m/s.
        let second = 2.0 * 0.4 / 0.6 + 0.8;
        // At the bin itself the way is 0: when the item is there, 4 s from now.
        let (best, when) = (0.8, 4.0);
        // `a` has let the first pass. `c` leaves for it from 4 s on, when it is free. The item
        // is then at (2.7, 0.1), 0.5 m upstream of the bin and 0.6 m aside, k = 0.15.
        let at_once = 2.0 * (-0.05 + (0.01f64 * 0.25 + 0.15 * 0.61).sqrt()) / 0.15 + 1.2;
        // The best is straight across, 0.6 m: it is at x = 3.2 in 9 s, 1.5 s after leaving.
        let straight = 2.0 * 0.6 / 0.4 + 1.2;
        assert!(straight < at_once);
        // The workspace of `c` ends at 3.2 + sqrt(0.81 - 0.36), within the belt; the item is
        // there in (x - 2.3) / 0.1 s, and the way takes sqrt(0.45 + 0.36) / 0.4 = 2.25 s.
        let last = (0.9 + 0.45f64.sqrt()) / 0.1 - 2.25;
        let expected = [
            ("holds an item", 1.0),
            ("x", 0.3),
            // The belt is at the other side of a robot above it.
            ("y", 0.5),
            ("P", first / 4.0),
            ("time left", 4.0 / 20.0),
            ("log time left", log(4.0)),
            ("reward", 0.25),
            ("best P to come", first / 4.0),
            ("time until then", 0.0),
            ("P minus that", 0.0),
            ("share of the others", 0.5),
            ("next downstream could", 1.0),
            ("time until the first", log(4.0)),
            ("shortest P of the others", straight / 4.0),
            ("time until the last cannot", log(last)),
            ("P minus the shortest", (first - second).max(0.0) / 4.0),
            ("log time left minus the least", 0.0),
        ];
        assert_features(&observation[21..38], &expected, "the first slot");
        let expected = [
            ("holds an item", 1.0),
            ("x", -0.4),
            ("y", 0.1),
            ("P", second / 4.0),
            ("time left", 12.0 / 20.0),
            ("log time left", log(12.0)),
            ("reward", 0.75),
            ("best P to come", best / 4.0),
            ("time until then", log(when)),
            ("P minus that", (second - best) / 4.0),
            // Across from the others it is out of reach.
            ("share of the others", 0.0),
            ("next downstream could", 0.0),
            ("time until the first", 2.0),
            ("shortest P of the others", 2.0),
            ("time until the last cannot", 0.0),
            ("P minus the shortest", (second - first).max(0.0) / 4.0),
            ("log time left minus the least", log(12.0) - log(4.0)),
        ];
        assert_features(&observation[38..55], &expected, "the second slot");
        assert!(observation[55..].iter().all(|value| *value == 0.0));
    });
}

#[test]
fn the_papers_observation_is_that_of_a_decision_worked_out_by_hand() {
    let station = three();
    decision(&station, |snapshot| {
        let (observation, mask) = encoded(Layout::PAPER, snapshot);
        assert_eq!(mask[..3], [true, true, false]);
        let tau: f64 = (0.1 * 0.3 + (0.01f64 * 0.09 + 0.24 * 0.25).sqrt()) / 0.24;
        let mut expected = vec![
            ("a busy", 1.0),
            ("a free in", 6.0),
            ("b busy", 0.0),
            ("b free in", 0.0),
            ("c busy", 1.0),
            ("c free in", 4.0),
        ];
        expected.resize(12, ("no such robot", 0.0));
        expected.extend([
            ("x", 0.3),
            ("y", -0.5),
            ("P", 2.0 * tau + 0.8),
            ("reward", 0.25),
            ("x", -0.4),
            ("y", -0.1),
            ("P", 2.0 * 0.4 / 0.6 + 0.8),
            ("reward", 0.75),
        ]);
        expected.resize(52, ("an empty slot", 0.0));
        assert_features(&observation, &expected, "the paper's");
        // A robot that waits for ever counts as busy for a thousand seconds.
        let waiting = Snapshot {
            free_at: &[f64::INFINITY, 10.0, 14.0],
            places: &[0; 8],
            ..*snapshot
        };
        assert_eq!(encoded(Layout::PAPER, &waiting).0[..2], [1.0, 1000.0]);
        let (full, _) = encoded(FULL, &waiting);
        let expected = log(1e4);
        assert!((f64::from(full[7]) - expected).abs() < 1e-5, "{}", full[7]);
    });
}

#[test]
fn actions_are_slots_and_the_last_is_to_wait() {
    let station = three();
    decision(&station, |snapshot| {
        let layout = Layout { wait: true, ..FULL };
        let mut encoder = Encoder::new(layout);
        let mut observation = vec![0.0; layout.observation()];
        let mut mask = vec![false; layout.actions()];
        encoder.encode(snapshot, &mut observation, &mut mask);
        assert_eq!(mask, [true, true, false, false, true]);
        assert_eq!(encoder.action(snapshot, 1).unwrap(), Action::Pick(1));
        // A quarter of the time for a way as long as the reach, 2 s.
        assert_eq!(
            encoder.action(snapshot, 4).unwrap(),
            Action::WaitUntil(10.5)
        );
        // Robot `a` takes 1.4 s for a way as long as its reach.
        let of_a = Snapshot {
            robot: 0,
            ..*snapshot
        };
        let Action::WaitUntil(until) = encoder.action(&of_a, 4).unwrap() else {
            panic!("not a wait");
        };
        assert!((until - 10.35).abs() < 1e-12, "{until}");
        assert_eq!(encoder.index_of(Action::Pick(1)), Some(1));
        assert_eq!(encoder.index_of(Action::Pick(2)), None);
        assert_eq!(encoder.index_of(Action::WaitUntil(11.0)), Some(4));
        assert_eq!(encoder.index_of(Action::WaitForNextWindow), Some(4));
        assert_eq!(encoder.index_of(Action::NoAnswer), None);
        for action in [2, 3, 5] {
            let message = encoder.action(snapshot, action).unwrap_err().to_string();
            let words = format!("action {action}, but only 2 of 4 slots hold an item");
            assert!(
                message.contains(&words) && message.contains('b'),
                "{message}"
            );
        }
        // Without waiting the last action is no action.
        let mut encoder = Encoder::new(FULL);
        encoder.encode(
            snapshot,
            &mut observation[..FULL.observation()],
            &mut mask[..4],
        );
        assert!(encoder.action(snapshot, 4).is_err());
        assert_eq!(encoder.index_of(Action::WaitForNextWindow), None);
    });
}

#[test]
fn views_are_known_by_their_names() {
    for (view, name) in [
        (View::Paper, "paper"),
        (View::Full, "full"),
        (View::Real, "real"),
    ] {
        assert_eq!((view.name(), view.to_string().as_str()), (name, name));
        assert_eq!(name.parse::<View>().unwrap(), view);
    }
    let message = "ful".parse::<View>().unwrap_err().to_string();
    assert!(
        message.contains("`ful`") && message.contains("did you mean `full`"),
        "{message}"
    );
    // Globals, features of a slot, numbers in all, actions.
    let sizes = |layout: Layout| {
        let all = [
            layout.globals(),
            layout.slot_features(),
            layout.observation(),
        ];
        (all, layout.actions())
    };
    assert_eq!(sizes(Layout::PAPER), ([12, 4, 52], 10));
    assert_eq!(sizes(Layout { wait: true, ..FULL }), ([21, 17, 89], 5));
}
