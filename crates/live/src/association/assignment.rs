//! The cheapest assignment of a picture's detections to items.

use pathfinding::prelude::{Matrix, kuhn_munkres};

/// Up to this many detections that compete for the same items are assigned optimally. Larger
/// groups, which no picture of a real line has, are assigned greedily, cheapest pair first.
const MOST_EXACT: usize = 100;
/// Only this many of the cheapest items of each detection count.
const MOST_RIVALS: usize = 8;
/// Costs are compared as multiples of this step, in integers, so that the result is the same on
/// every machine.
const STEP: f64 = 1e-6;

/// A detection and an item that it may show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct CandidatePair {
    /// Index of the detection in its picture.
    pub detection: usize,
    /// Number of the item.
    pub item: u32,
    /// Cost of this match.
    pub cost: f64,
}

/// The item of each detection, or none, such that the total cost is minimal. `alone` is the cost of
/// each detection if it matches no item.
///
/// Each group of detections that compete for the same items is solved separately by the Hungarian
/// method (Kuhn, *The Hungarian method for the assignment problem*, Naval Research Logistics
/// Quarterly 2, 1955, doi:10.1002/nav.3800020109).
pub(super) fn assign(pairs: &[CandidatePair], alone: &[f64]) -> Vec<Option<u32>> {
    let mut pairs: Vec<CandidatePair> = pairs
        .iter()
        .filter(|pair| pair.cost < alone[pair.detection])
        .copied()
        .collect();
    pairs.sort_by(|a, b| {
        let by_cost = a
            .detection
            .cmp(&b.detection)
            .then(a.cost.total_cmp(&b.cost));
        by_cost.then(a.item.cmp(&b.item))
    });
    let mut rank = 0;
    let mut last = None;
    pairs.retain(|pair| {
        rank = if last == Some(pair.detection) {
            rank + 1
        } else {
            0
        };
        last = Some(pair.detection);
        rank < MOST_RIVALS
    });
    let mut found = vec![None; alone.len()];
    for group in groups(&pairs, alone.len()) {
        assign_group(&group, alone, &mut found);
    }
    found
}

/// The pairs in groups that share no detection and no item.
fn groups(pairs: &[CandidatePair], detections: usize) -> Vec<Vec<CandidatePair>> {
    let mut leader: Vec<usize> = (0..detections).collect();
    fn lead(leader: &mut [usize], mut detection: usize) -> usize {
        while leader[detection] != detection {
            leader[detection] = leader[leader[detection]];
            detection = leader[detection];
        }
        detection
    }
    let mut by_item: Vec<(u32, usize)> = pairs.iter().map(|p| (p.item, p.detection)).collect();
    by_item.sort_unstable();
    for two in by_item.windows(2) {
        if two[0].0 == two[1].0 {
            let (a, b) = (lead(&mut leader, two[0].1), lead(&mut leader, two[1].1));
            leader[a.max(b)] = a.min(b);
        }
    }
    let mut place = vec![usize::MAX; detections];
    let mut groups: Vec<Vec<CandidatePair>> = Vec::new();
    for pair in pairs {
        let leads = lead(&mut leader, pair.detection);
        if place[leads] == usize::MAX {
            place[leads] = groups.len();
            groups.push(Vec::new());
        }
        groups[place[leads]].push(*pair);
    }
    groups
}

fn assign_group(pairs: &[CandidatePair], alone: &[f64], found: &mut [Option<u32>]) {
    // Sorted by detection, then by cost.
    let mut rows: Vec<usize> = pairs.iter().map(|pair| pair.detection).collect();
    rows.dedup();
    if let [row] = rows[..] {
        found[row] = pairs.first().map(|pair| pair.item);
        return;
    }
    let mut columns: Vec<u32> = pairs.iter().map(|pair| pair.item).collect();
    columns.sort_unstable();
    columns.dedup();
    if rows.len() > MOST_EXACT {
        assign_greedily(pairs, &mut columns, found);
        return;
    }
    // Savings compared with a new item, which every detection may also be.
    let mut saved = Matrix::new(rows.len(), columns.len() + rows.len(), 0i64);
    for pair in pairs {
        let place = (
            rows.binary_search(&pair.detection),
            columns.binary_search(&pair.item),
        );
        if let (Ok(row), Ok(column)) = place {
            let saving = (alone[pair.detection] - pair.cost) / STEP;
            // Far below 2^53; at least one step, because the pair is better than none.
            saved[(row, column)] = (saving.round() as i64).max(1);
        }
    }
    let (_, chosen) = kuhn_munkres(&saved);
    for (row, column) in chosen.into_iter().enumerate() {
        let is_possible = column < columns.len() && saved[(row, column)] > 0;
        found[rows[row]] = is_possible.then(|| columns[column]);
    }
}

fn assign_greedily(pairs: &[CandidatePair], free: &mut Vec<u32>, found: &mut [Option<u32>]) {
    let mut pairs = pairs.to_vec();
    pairs.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    for pair in pairs {
        if found[pair.detection].is_none()
            && let Ok(column) = free.binary_search(&pair.item)
        {
            found[pair.detection] = Some(pair.item);
            free.remove(column);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pickline::pattern::random_stream;
    use rand::RngExt as _;

    fn pair(detection: usize, item: u32, cost: f64) -> CandidatePair {
        CandidatePair {
            detection,
            item,
            cost,
        }
    }

    /// The least cost of all assignments, tried one by one.
    fn least(
        pairs: &[CandidatePair],
        alone: &[f64],
        detection: usize,
        taken: &mut Vec<u32>,
    ) -> f64 {
        if detection == alone.len() {
            return 0.0;
        }
        let mut best = alone[detection] + least(pairs, alone, detection + 1, taken);
        for pair in pairs.iter().filter(|pair| pair.detection == detection) {
            if !taken.contains(&pair.item) {
                taken.push(pair.item);
                best = best.min(pair.cost + least(pairs, alone, detection + 1, taken));
                taken.pop();
            }
        }
        best
    }

    #[test]
    fn nothing_is_cheaper_and_no_item_is_taken_twice() {
        for seed in 0..300 {
            let mut rng = random_stream(seed, 1);
            let detections = rng.random_range(1..6usize);
            let alone: Vec<f64> = (0..detections)
                .map(|_| if rng.random_bool(0.8) { 10.5 } else { 3.0 })
                .collect();
            let mut pairs = Vec::new();
            for detection in 0..detections {
                for item in 0..rng.random_range(1..7u32) {
                    if rng.random_bool(0.5) {
                        pairs.push(pair(detection, item, rng.random_range(0.0..10.0)));
                    }
                }
            }
            let found = assign(&pairs, &alone);
            let mut taken: Vec<u32> = found.iter().flatten().copied().collect();
            taken.sort_unstable();
            let count = taken.len();
            taken.dedup();
            assert_eq!(taken.len(), count);
            let cost = |(detection, item): (usize, &Option<u32>)| {
                let its = |p: &&CandidatePair| p.detection == detection && Some(p.item) == *item;
                pairs.iter().find(its).map_or(alone[detection], |p| p.cost)
            };
            let cost: f64 = found.iter().enumerate().map(cost).sum();
            let best = least(&pairs, &alone, 0, &mut Vec::new());
            assert!((cost - best).abs() < 1e-4, "{seed}: {cost} {best}");
        }
    }

    #[test]
    fn one_moves_over_where_that_is_cheaper_for_all() {
        // Item 1 is the nearest of both.
        let pairs = [pair(0, 1, 1.0), pair(0, 2, 2.0), pair(1, 1, 0.5)];
        assert_eq!(assign(&pairs, &[10.5; 2]), [Some(2), Some(1)]);
        // A new item beats two bad fits.
        let pairs = [pair(0, 1, 0.1), pair(0, 2, 8.0), pair(1, 1, 7.0)];
        assert_eq!(assign(&pairs, &[10.5; 2]), [Some(1), None]);
        assert_eq!(assign(&[], &[10.5; 2]), [None, None]);
    }

    #[test]
    fn many_items_are_assigned_at_once() {
        // 400 detections, each next to its own item and near others.
        let pairs = (0..400).flat_map(|d| {
            let near = d.max(3) - 3..(d + 4).min(400);
            near.map(move |item| pair(d, item as u32, (d as f64 - item as f64).abs()))
        });
        let pairs: Vec<CandidatePair> = pairs.collect();
        let found = assign(&pairs, &[10.5; 400]);
        assert!(
            found
                .iter()
                .enumerate()
                .all(|(d, item)| *item == Some(d as u32))
        );
    }
}
