//! Compares networks with hand-computed times, and with an enumeration of all paths.

use super::best_two::BestTwo;
use super::*;
use crate::kinematics::Arm;
use crate::station::ClassId;
use crate::station::{Belt, Bin, Robot};
use proptest::prelude::*;
use std::collections::{BTreeMap, HashMap};

const BELT_SPEED: f64 = 0.125;

/// A line on which times are easy to compute: leaving at t for an item that passes the bin at
/// a, the robot is free at `t + dwell + 2/9 (a - t)` before a and at `t + dwell + 2/7 (t - a)`
/// after it.
fn station(dwell: f64) -> Station {
    let belt = Belt {
        speed: BELT_SPEED,
        length: 100.0,
        width: 1.0,
    };
    let robot = Robot::new(
        "a",
        [1.0, 0.0].into(),
        [1.0, 0.0].into(),
        10.0,
        Arm::constant(1.0),
    )
    .with_dwell(dwell, 0.0);
    Station::new(belt, vec![robot]).unwrap()
}

/// An item that passes the bin at `at` [s] with a window from `open` to `close` [s].
fn passing(item: u32, at: f64, (open, close): (f64, f64)) -> Candidate {
    Candidate {
        item,
        bin: 0,
        class: ClassId::OTHER,
        x0: 1.0 - BELT_SPEED * at,
        y: 0.0,
        weight: 1.0,
        open,
        close,
    }
}

/// The same, each from the robot's only place.
fn from_rest(queue: &[Candidate]) -> impl Iterator<Item = (Candidate, usize)> {
    queue.iter().map(|candidate| (*candidate, 0))
}

fn network(dwell: f64, queue: &[Candidate], length: f64) -> SlotNetwork {
    SlotNetwork::new(&station(dwell), 0, from_rest(queue), Slots { length })
}

/// A time on a boundary belongs to the slot that begins there, however the quotient is rounded.
#[test]
fn a_time_is_in_the_last_slot_that_begins_by_then() {
    for length in [1e-6, 0.01, 0.1, 0.3, 1.0 / 3.0, 1.0, 7.3] {
        let slots = Slots { length };
        for slot in (0..200).chain([12_345, 1_000_003, 999_999_999_999]) {
            assert_eq!(slots.start(slot), slot as f64 * length);
            assert_eq!(slots.of(slots.start(slot)), slot, "{length}");
            assert_eq!(slots.of(slots.start(slot + 1).next_down()), slot);
        }
        assert_eq!(slots.of(-0.5 * length), 0);
        assert_eq!(slots.of(-1e9), 0);
    }
}

/// Picks may end up to 2e-9 (1 + t) early, but no more.
#[test]
fn a_release_may_be_early_by_the_slack() {
    // Free at 2 s, so at least 6e-9 s before that.
    let queue = [passing(0, 0.0, (0.0, 0.0))];
    assert_eq!(network(2.0, &queue, 2.0 - 5.9e-9).slots(), [0]);
    assert_eq!(network(2.0, &queue, 2.0 - 6.1e-9).slots(), [1]);
    let release = earliest_release(&station(2.0), 0, (&queue[0], 0));
    assert!((release - (2.0 - 6e-9)).abs() < 1e-13, "{release}");
    // Nothing is released before the run begins.
    assert_eq!(earliest_release(&station(0.0), 0, (&queue[0], 0)), 0.0);
}

#[test]
fn a_departure_may_be_early_by_the_slack() {
    // Free at 2 s; leaving 4e-9 s earlier for an item that is upstream then saves 7/9 of that.
    let queue = [passing(0, 1.0, (1.0, 1.0))];
    let early = 6e-9 + 4e-9 * 7.0 / 9.0;
    assert_eq!(network(1.0, &queue, 2.0 - early + 0.1e-9).slots(), [0]);
    assert_eq!(network(1.0, &queue, 2.0 - early - 0.1e-9).slots(), [1]);
    let release = earliest_release(&station(1.0), 0, (&queue[0], 0));
    assert!((release - (2.0 - early)).abs() < 1e-13, "{release}");
}

#[test]
fn a_departure_may_be_late_by_the_slack() {
    // Leaving in slots 0, 1, 2 and 3 ends at 3.17, 3.94, 4.72 and 5.5 s.
    let queue = |close| [passing(0, 3.0, (0.0, close))];
    for (late, slots) in [
        (0.0, &[3, 4, 5][..]),
        (7.9e-9, &[3, 4, 5]),
        (8.1e-9, &[3, 4]),
    ] {
        let network = network(2.5, &queue(3.0 - late), 1.0);
        assert_eq!(network.slots(), slots, "{late}");
    }
    let release = latest_release(&station(2.5), 0, (&queue(3.0)[0], 0));
    assert!((release - 5.5).abs() < 1e-12, "{release}");
}

/// A window that opens within a slot is not open from the slot's beginning.
#[test]
fn nobody_leaves_before_the_window_opens() {
    // Leaving at 0.5 s, it ends at 1.1 s; leaving at 0 s, it would end at 0.71 s.
    let queue = [passing(0, 0.5, (0.5, 0.5))];
    assert_eq!(network(0.6, &queue, 1.0).slots(), [1]);
}

/// A pick that takes no time ends in the slot in which it begins, not before.
#[test]
fn a_pick_without_a_time_of_its_own_goes_nowhere() {
    let network = network(0.0, &[passing(0, 1.0, (1.0, 1.0))], 1.0);
    assert_eq!((network.slots(), network.arcs()), (&[0, 1][..], 2));
    let mut values = Vec::new();
    network.longest_path(&[5], &mut values, &mut Vec::new());
    // Loops are not remembered.
    assert_eq!(values, [0, 5, 10]);
}

/// Of departures that end in the same slot, the last is kept: a robot may be free only for that
/// one.
#[test]
fn the_last_of_several_departures_with_one_arrival_is_kept() {
    // The second item, with departures in slots 4 and 5, is in the bin in slot 16; the first
    // one is in slot 5.
    let dwell = 0.788;
    let queue = [passing(0, 0.6, (0.6, 0.6)), passing(1, 11.0, (1.0, 1.3))];
    let network = network(dwell, &queue, 0.25);
    assert_eq!((network.slots()[0], network.arcs()), (5, 2));
    let mut values = Vec::new();
    network.longest_path(&[1, 1], &mut values, &mut Vec::new());
    let up_to = |slot| values[network.nodes_up_to(slot)];
    assert_eq!((up_to(4), up_to(5), up_to(15), up_to(16)), (0, 1, 1, 2));
}

/// The estimated size is an upper bound on the number of picks in slots, and a close one.
#[test]
fn the_size_covers_the_picks() {
    let queue = [passing(0, 3.0, (1.0, 4.0)), passing(1, 3.0, (2.0, 2.0))];
    let size = |length| SlotNetwork::size(from_rest(&queue), Slots { length });
    assert_eq!((size(1.0), size(0.5), size(8.0)), (7.0, 10.0, 4.375));
}

/// Every pick in slots of `queue` (item, departure and arrival), found by enumeration.
fn picks(dwell: f64, queue: &[Candidate], slots: Slots) -> Vec<(usize, u64, u64)> {
    let mut all = Vec::new();
    for candidate in queue {
        let station = station(dwell);
        let mut by_arrival = BTreeMap::new();
        for slot in slots.of(candidate.open)..=slots.of(candidate.close) {
            let time = slots.start(slot).max(candidate.open);
            let moment = Moment::new(&station, 0, 0, time);
            let free = time + moment.processing_time(candidate);
            by_arrival.insert(slots.of(free), slot);
        }
        let of_item = by_arrival.into_iter();
        all.extend(
            of_item.map(|(arrival, departure)| (candidate.item as usize, departure, arrival)),
        );
    }
    all
}

/// Where a path has come to.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Way {
    slot: u64,
    /// The loops of the slot that it has taken, one bit for each item.
    used: u32,
    /// The item that must not follow.
    last: Option<usize>,
}

impl Way {
    const START: Self = Self {
        slot: 0,
        used: 0,
        last: None,
    };
}

/// The best of all paths that go on from `way`, by enumeration, with no item twice in a row.
fn best_from(
    picks: &[(usize, u64, u64)],
    rewards: &[i64],
    way: Way,
    known: &mut HashMap<Way, i64>,
) -> i64 {
    let Way { slot, used, last } = way;
    if picks.iter().all(|(_, departure, _)| *departure < slot) {
        return 0;
    }
    if let Some(&value) = known.get(&way) {
        return value;
    }
    // Wherever there are loops, nothing is remembered.
    let loops = picks.iter().any(|(_, d, a)| *d == slot && *a == slot);
    let last = last.filter(|_| !loops);
    let next_slot = Way {
        slot: slot + 1,
        used: 0,
        last,
    };
    let mut best = best_from(picks, rewards, next_slot, known);
    for &(item, departure, arrival) in picks {
        let next = match arrival == slot {
            _ if departure != slot => continue,
            true if used >> item & 1 == 1 => continue,
            true => Way {
                used: used | 1 << item,
                ..way
            },
            false if last == Some(item) => continue,
            false => Way {
                slot: arrival,
                used: 0,
                last: Some(item),
            },
        };
        best = best.max(rewards[item] + best_from(picks, rewards, next, known));
    }
    known.insert(way, best);
    best
}

/// Windows, a dwell time, a slot length and rewards. The times are such that the slack does not
/// matter.
fn days() -> impl Strategy<Value = (Vec<Candidate>, f64, f64, Vec<i64>)> {
    let item = (0.0..12.0f64, 0.0..8.0f64, 0.0..4.0f64);
    let items = prop::collection::vec((item, -2..6i64), 1..=5);
    let dwell = prop_oneof![Just(0.011), 0.2..2.0f64];
    (
        items,
        dwell,
        prop_oneof![Just(0.217), Just(0.93), Just(3.1)],
    )
        .prop_map(|(items, dwell, length)| {
            let rewards = items.iter().map(|(_, reward)| *reward).collect();
            let mut queue: Vec<Candidate> = items
                .iter()
                .zip(0u32..)
                .map(|(((at, open, lasts), _), item)| passing(item, *at, (*open, open + lasts)))
                .collect();
            queue.sort_by(|a, b| a.open.total_cmp(&b.open));
            (queue, dwell, length, rewards)
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Forwards, and backwards completely and partially, the values equal those of the best of all paths
    /// without an item twice in a row. The path that is followed has the computed value.
    #[test]
    fn values_are_those_of_the_best_path((queue, dwell, length, rewards) in days()) {
        let slots = Slots { length };
        let network = network(dwell, &queue, length);
        let picks = picks(dwell, &queue, slots);
        prop_assert_eq!(network.arcs(), picks.len());
        prop_assert!(network.arcs() as f64 <= SlotNetwork::size(from_rest(&queue), slots));
        let best = |rewards: &[i64], slot| {
            let way = Way { slot, ..Way::START };
            best_from(&picks, rewards, way, &mut HashMap::new())
        };
        let (mut values, mut endings) = (Vec::new(), Vec::new());
        network.longest_path(&rewards, &mut values, &mut endings);
        let places = network.slots().len() + 1;
        prop_assert_eq!(values.len(), places);
        prop_assert_eq!(values[places - 1], best(&rewards, 0));
        for (place, &value) in values.iter().enumerate() {
            let mut found = 0;
            network.follow(&rewards, &endings, place, |item| found += rewards[item as usize]);
            prop_assert_eq!(found, value);
        }
        let whole = |rewards: &[i64]| {
            let mut values = vec![BestTwo::free(0); places];
            network.longest_path_from(rewards, &mut values, 0..places);
            values
        };
        let mut to_come = whole(&rewards);
        for (place, value) in to_come.iter().enumerate() {
            // A robot that is free after this many nodes can leave in the slot after the last
            // one at the latest.
            let slot = match place {
                0 => 0,
                _ => network.slot_of_place(place),
            };
            prop_assert!(value.best <= best(&rewards, slot), "{}", place);
        }
        prop_assert_eq!(to_come[0].best, best(&rewards, 0));
        // A removed item changes only the values of places before its last one.
        let last = network.last_places(rewards.len());
        for item in 0..rewards.len() {
            let mut fewer = rewards.clone();
            fewer[item] = -1_000_000;
            let stale = last[item] as usize;
            network.longest_path_from(&fewer, &mut to_come, 0..stale);
            prop_assert_eq!(&to_come, &whole(&fewer));
            to_come = whole(&rewards);
            let mut alone = vec![0; rewards.len()];
            alone[item] = 1;
            let alone = whole(&alone);
            prop_assert!(alone[stale - 1].best > 0 && alone[stale..].iter().all(|v| v.best == 0));
        }
        for (place, &slot) in network.slots().iter().enumerate() {
            prop_assert_eq!(network.slot_of_place(place + 1), slot);
            prop_assert_eq!(network.nodes_up_to(slot), place + 1);
        }
        prop_assert_eq!(network.slot_of_place(0), 0);
    }
}

/// The line with another bin, 2 m upstream of the first, so that an item is cheap for the arm in one place
/// and expensive in the other.
fn station_with_two_bins(dwell: f64) -> Station {
    let plain = station(dwell);
    let mut robot = plain.robots()[0].clone();
    robot.bins.push(Bin {
        name: "b2".into(),
        at: [-1.0, 0.0].into(),
        classes: Some(vec!["b".into()]),
        ..robot.bins[0].clone()
    });
    Station::new(*plain.belt(), vec![robot]).unwrap()
}

/// A pick in slots of a robot with two bins: where and when it begins and ends.
#[derive(Clone, Copy)]
struct PlacedPick {
    item: usize,
    from: (u64, usize),
    to: (u64, usize),
}

/// The best of all paths from `slot` and `place` on, by enumeration, with no item twice in a row; if
/// `anywhere`, waiting may take the arm to the other place.
fn best_from_place(
    picks: &[PlacedPick],
    rewards: &[i64],
    anywhere: bool,
    (slot, place, last): (u64, usize, Option<usize>),
    known: &mut HashMap<(u64, usize, Option<usize>), i64>,
) -> i64 {
    if picks.iter().all(|pick| pick.from.0 < slot) {
        return 0;
    }
    if let Some(&value) = known.get(&(slot, place, last)) {
        return value;
    }
    let mut best = best_from_place(picks, rewards, anywhere, (slot + 1, place, last), known);
    for pick in picks {
        let is_there = pick.from == (slot, place) || anywhere && pick.from.0 == slot;
        if is_there && last != Some(pick.item) {
            let (slot, place) = pick.to;
            let next = (slot, place, Some(pick.item));
            let later = best_from_place(picks, rewards, anywhere, next, known);
            best = best.max(rewards[pick.item] + later);
        }
    }
    known.insert((slot, place, last), best);
    best
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The same for a robot with two bins, where picks are longer than slots.
    #[test]
    fn values_are_those_of_the_best_path_between_places(
        (mut queue, _, length, rewards) in days(),
        bins in prop::collection::vec(0..2u16, 5),
    ) {
        let (slots, dwell) = (Slots { length }, 1.01 * length);
        for candidate in &mut queue {
            candidate.bin = bins[candidate.item as usize];
        }
        let station = station_with_two_bins(dwell);
        let from_both = || queue.iter().flat_map(|c| [(*c, 0), (*c, 1)]);
        let mut picks = Vec::new();
        for (candidate, from) in from_both() {
            for slot in slots.of(candidate.open)..=slots.of(candidate.close) {
                let time = slots.start(slot).max(candidate.open);
                let moment = Moment::new(&station, 0, from, time);
                let free = time + moment.processing_time(&candidate);
                picks.push(PlacedPick {
                    item: candidate.item as usize,
                    from: (slot, from),
                    to: (slots.of(free), usize::from(candidate.bin)),
                });
            }
        }
        let network = SlotNetwork::new(&station, 0, from_both(), slots);
        let (mut values, mut endings) = (Vec::new(), Vec::new());
        network.longest_path(&rewards, &mut values, &mut endings);
        // The arm rests at the first bin.
        let best_from = |from, anywhere| {
            best_from_place(&picks, &rewards, anywhere, from, &mut HashMap::new())
        };
        let best = best_from((0, 0, None), false);
        let last = values.len() - 1;
        prop_assert_eq!(values[last], best);
        let mut found = 0;
        network.follow(&rewards, &endings, last, |item| found += rewards[item as usize]);
        prop_assert_eq!(found, best);
        let mut to_come = vec![BestTwo::free(0); network.positions()];
        let all = 0..network.slots().len() + 1;
        network.longest_path_from(&rewards, &mut to_come, all.clone());
        for place in 0..2 {
            let from = (0, usize::from(place), None);
            prop_assert_eq!(to_come[network.position(0, place)].best, best_from(from, false));
        }
        // Picks that may fail take the arm anywhere.
        let failing = network.clone().with_failures();
        failing.longest_path(&rewards, &mut values, &mut endings);
        let best = best_from((0, 0, None), true);
        prop_assert_eq!(values[last], best);
        let mut found = 0;
        failing.follow(&rewards, &endings, last, |item| found += rewards[item as usize]);
        prop_assert_eq!(found, best);
        // In two parts, the later first.
        let mut in_parts = to_come.clone();
        in_parts[..network.position(all.end / 2, 0)].fill(BestTwo::free(7));
        network.longest_path_from(&rewards, &mut in_parts, 0..all.end / 2);
        prop_assert_eq!(in_parts, to_come);
    }
}
