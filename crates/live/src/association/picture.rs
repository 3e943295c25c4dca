//! Matches the detections of one picture to the known items.

use super::{AssociationGate, CandidatePair, Number, assign, cost, cost_of_new, is_close, is_near};
use crate::items::{ItemState, Items};
use crate::sight::PlacedDetection;
use std::collections::HashSet;

/// What a detection shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Match {
    /// This known item.
    Item(u32),
    /// No known item.
    New,
    /// A repetition of another detection of the picture, by its id.
    Repeats(usize),
    /// A second box around the item of another detection of the picture.
    Doubles(usize),
    /// A second box around an item that an earlier part of the picture has shown.
    DoublesItem(u32),
}

/// A picture whose detections have been matched to items.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Association {
    /// What each detection shows.
    pub matches: Vec<Match>,
    /// Pairs of an item that the picture does not show and the other item whose detection is at its
    /// place.
    pub overlooked: Vec<(u32, u32)>,
    /// Items that the picture shows beside each other, with none overlooked.
    pub beside: Vec<u32>,
}

/// The pairs of a detection and an item that may belong together.
#[derive(Debug, Default)]
struct Candidates {
    pairs: Vec<CandidatePair>,
    /// Items near a detection, and whether they are so near that they may be the same item.
    near: Vec<(usize, u32, bool)>,
    /// Items that an earlier part of the picture has shown.
    shown: Vec<(usize, u32)>,
}

/// Finds the items that each of the `active` detections may show.
fn candidates(
    items: &Items,
    gate: AssociationGate,
    seen: &[PlacedDetection],
    active: &[bool],
    travelled: impl Fn(f64) -> f64,
) -> Candidates {
    let mut found = Candidates::default();
    let Some(first) = seen.first() else {
        return found;
    };
    let (source, time) = (first.source(), first.time);
    let travel = travelled(time);
    for (index, one) in seen.iter().enumerate().filter(|(i, _)| active[*i]) {
        let reach = gate.reach(one.covariance, items.widest());
        let by_id = one.id().and_then(|id| items.known_as(source, id));
        let around = items.around(one.place, reach).map(|(item, _)| item);
        let rivals = around.filter(|item| Some(*item) != by_id).chain(by_id);
        for item in rivals {
            let Some(tracked) = items.get(item) else {
                continue;
            };
            let off = [one.place - tracked.place, one.y - tracked.y];
            if off[1].abs() > 3.0 * reach {
                continue;
            }
            let way = travel - travelled(tracked.measured);
            let squared = gate.squared_distance(off, one.covariance, tracked.covariance, way);
            let is_same = by_id == Some(item);
            let number = match (one.id.is_some(), tracked.is_named_by(source)) {
                _ if is_same => Number::Same,
                (true, true) => Number::Other,
                _ => Number::Unknown,
            };
            // What lies where an item was already picked is another item, unless the tracker's id
            // says that it is the same.
            let is_gone = matches!(tracked.state, ItemState::Picked(at) if at < time);
            let is_shown = tracked.seen_at(source) == Some(time);
            if is_shown && !is_same {
                found.shown.push((index, item));
            }
            if (is_gone || is_shown) && !is_same {
                continue;
            }
            if is_near(squared) {
                found.near.push((index, item, is_close(squared)));
            }
            if let Some(cost) = cost(squared, number, !is_gone) {
                let detection = index;
                found.pairs.push(CandidatePair {
                    detection,
                    item,
                    cost,
                });
            }
        }
    }
    found
}

/// Matches the detections `seen` in one picture to the items. `travelled` [m] is the belt's travel
/// when an item was measured and when the picture was taken.
pub(crate) fn associate(
    items: &Items,
    gate: AssociationGate,
    seen: &[PlacedDetection],
    travelled: impl Fn(f64) -> f64,
) -> Association {
    if seen.is_empty() {
        return Association::default();
    }
    let mut matches: Vec<Match> = vec![Match::New; seen.len()];
    let mut active = vec![true; seen.len()];
    for i in 0..seen.len() {
        if let Some(later) = repetition(gate, seen, i) {
            (matches[i], active[i]) = (Match::Repeats(later), false);
        }
    }
    let Candidates { pairs, near, shown } = candidates(items, gate, seen, &active, travelled);
    let doubled = gate.doubled();
    let way = |i: usize, j: usize| seen[i].way(seen[j].place, seen[j].y);
    let is_doubled = |i: usize| {
        let others = (0..seen.len()).filter(|j| *j != i && active[*j]);
        let mut near = others.filter(|j| way(i, *j) <= doubled);
        near.next().is_some()
    };
    let alone: Vec<f64> = (0..seen.len())
        .map(|i| cost_of_new(active[i] && is_doubled(i)))
        .collect();
    let found = assign(&pairs, &alone);
    for (i, item) in found.iter().enumerate() {
        if let Some(item) = item {
            matches[i] = Match::Item(*item);
        }
    }
    for i in (0..seen.len()).filter(|i| active[*i] && found[*i].is_none()) {
        let is_rival = |j: &usize| active[*j] && way(i, *j) <= doubled;
        let of_item = (0..seen.len()).filter(|j| found[*j].is_some());
        let of_new = (0..i).filter(|j| matches[*j] == Match::New);
        if let Some(other) = of_item.chain(of_new).find(is_rival) {
            matches[i] = Match::Doubles(other);
            continue;
        }
        let mut before = shown.iter().filter(|(index, _)| *index == i);
        let is_near = |item: u32| {
            items
                .get(item)
                .is_some_and(|t| seen[i].way(t.place, t.y) <= doubled)
        };
        if let Some((_, item)) = before.find(|(_, item)| is_near(*item)) {
            matches[i] = Match::DoublesItem(*item);
        }
    }
    let (overlooked, beside) = neighbours(near, &found);
    Association {
        matches,
        overlooked,
        beside,
    }
}

/// What items near the detections are if the detections were `found` to show others: overlooked, or
/// shown beside.
fn neighbours(near: Vec<(usize, u32, bool)>, found: &[Option<u32>]) -> (Vec<(u32, u32)>, Vec<u32>) {
    let taken: HashSet<u32> = found.iter().flatten().copied().collect();
    let (mut overlooked, mut beside) = (Vec::new(), Vec::new());
    for (index, item, is_close) in near {
        match found[index] {
            Some(other) if other != item && taken.contains(&item) => beside.extend([item, other]),
            Some(other) if other != item && is_close => overlooked.push((item, other)),
            _ => {}
        }
    }
    overlooked.sort_unstable();
    overlooked.dedup_by_key(|(item, _)| *item);
    beside.sort_unstable();
    beside.dedup();
    beside.retain(|item| overlooked.iter().all(|(_, other)| other != item));
    (overlooked, beside)
}

/// The later detection of the same picture that repeats or corrects this one: it has the same id
/// and is near.
fn repetition(gate: AssociationGate, seen: &[PlacedDetection], index: usize) -> Option<usize> {
    let one = &seen[index];
    let id = one.id()?;
    let same = (index + 1..seen.len()).filter(|later| seen[*later].id() == Some(id));
    let mut same = same.filter(|later| {
        let other = &seen[*later];
        let off = [one.place - other.place, one.y - other.y];
        let squared = gate.squared_distance(off, one.covariance, other.covariance, 0.0);
        cost(squared, Number::Same, true).is_some()
    });
    same.next()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::Features;

    fn sight(id: Option<&str>, place: f64, time: f64) -> PlacedDetection {
        PlacedDetection {
            source: None,
            id: id.map(str::to_owned),
            time,
            place,
            y: 0.0,
            covariance: None,
            features: Features::default(),
        }
    }

    fn put(items: &Items, seen: &[PlacedDetection]) -> Association {
        associate(items, AssociationGate::new(0.02), seen, |_| 0.0)
    }

    #[test]
    fn what_a_picture_does_not_show_is_overlooked() {
        let mut items = Items::default();
        let a = items.add(&sight(Some("a"), 0.0, 0.0));
        let b = items.add(&sight(Some("b"), 0.009, 0.0));
        // Too far to be the same item as the others.
        items.add(&sight(Some("c"), 0.03, 0.0));
        let both = [sight(Some("a"), 0.001, 1.0), sight(Some("b"), 0.01, 1.0)];
        let found = put(&items, &both);
        assert_eq!(found.matches, [Match::Item(a), Match::Item(b)]);
        assert_eq!((found.overlooked, found.beside), (vec![], vec![a, b]));
        let found = put(&items, &both[..1]);
        assert_eq!((found.overlooked, found.beside), (vec![(b, a)], vec![]));
        // Neither takes the other's place.
        let found = put(&items, &[sight(Some("b"), 0.001, 1.0)]);
        assert_eq!(found.matches, [Match::Item(a)]);
    }

    #[test]
    fn parts_of_a_picture_know_of_each_other() {
        let mut items = Items::default();
        let a = items.add(&sight(None, 0.0, 1.0));
        // The same timestamp: another item, a second box, and a repetition by id.
        let found = put(&items, &[sight(None, 0.01, 1.0)]);
        assert_eq!(found.matches, [Match::New]);
        let found = put(&items, &[sight(None, 0.003, 1.0)]);
        assert_eq!(found.matches, [Match::DoublesItem(a)]);
        let b = items.add(&sight(Some("b"), 0.1, 1.0));
        let found = put(&items, &[sight(Some("b"), 0.11, 1.0)]);
        assert_eq!(found.matches, [Match::Item(b)]);
        let found = put(&items, &[sight(None, 0.01, 1.5)]);
        assert_eq!(found.matches, [Match::Item(a)]);
    }

    #[test]
    fn repetitions_and_doubles_lead_to_one_detection() {
        let items = Items::default();
        let seen = [
            sight(Some("a"), 0.0, 1.0),
            sight(Some("a"), 0.01, 1.0),
            sight(Some("b"), 0.012, 1.0),
            sight(Some("a"), 0.5, 1.0),
        ];
        let found = put(&items, &seen);
        let expected = [Match::Repeats(1), Match::New, Match::Doubles(1), Match::New];
        assert_eq!(found.matches, expected);
        assert_eq!(put(&items, &[]), Association::default());
    }
}
