//! Summary figures of a pattern.

use super::item::Pattern;
use rstar::RTree;
use serde::Serialize;
use std::collections::BTreeMap;

/// Summary figures of one pattern.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Description {
    /// Number of items.
    pub items: usize,
    /// Distance from the first item to the last along the belt [m].
    pub length_m: f64,
    /// Distance between the outermost items across the belt [m].
    pub width_m: f64,
    /// Smallest and largest position across the belt [m].
    pub y_range_m: [f64; 2],
    /// Items per metre of belt [1/m]; `None` if all items have the same x. The items at the last x
    /// are not counted, so that a grid of whole columns gives its exact density.
    pub items_per_m: Option<f64>,
    /// Smallest distance between two items [m]; `None` for a single item.
    pub nearest_min_m: Option<f64>,
    /// Mean distance from an item to its nearest neighbour [m]; `None` for a single item.
    pub nearest_mean_m: Option<f64>,
    /// Smallest, mean and largest object-specific reward.
    pub reward: [f64; 3],
    /// Sum of the rewards r of all items.
    pub reward_sum: f64,
    /// Number of items with an area.
    pub with_area: usize,
    /// Number of items with a detection probability.
    pub with_p_detection: usize,
    /// Number of items with a grasp probability.
    pub with_p_grasp: usize,
    /// Number of items with an explicit weight.
    pub with_weight: usize,
    /// Number of items with a true class.
    pub with_true_class: usize,
    /// Number of items whose true class is another one than that detected.
    pub misdetected: usize,
    /// Number of items per class; empty if there are no classes.
    pub classes: BTreeMap<String, usize>,
}

/// Computes the figures of `pattern` in O(n log n).
pub fn describe(pattern: &Pattern) -> Description {
    let items = pattern.items();
    let n = items.len() as f64;
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| {
            [low.min(v), high.max(v)]
        })
    };
    let y_range_m = range(&mut items.iter().map(|item| item.y));
    let length_m = items[0].x0 - items[items.len() - 1].x0;
    let last = items[items.len() - 1].x0;
    let before_last = items.iter().filter(|item| item.x0 > last).count();
    let nearest = nearest_neighbours(pattern);
    let rewards: Vec<f64> = items.iter().map(|item| item.reward()).collect();
    let [reward_low, reward_high] = range(&mut rewards.iter().copied());
    let reward_sum: f64 = rewards.iter().sum();
    let count = |has: &dyn Fn(&super::Item) -> bool| items.iter().filter(|i| has(i)).count();
    let mut classes = BTreeMap::new();
    for class in items.iter().filter_map(|item| item.class.clone()) {
        *classes.entry(class).or_default() += 1;
    }
    Description {
        items: items.len(),
        length_m,
        width_m: y_range_m[1] - y_range_m[0],
        y_range_m,
        items_per_m: (length_m > 0.0).then(|| before_last as f64 / length_m),
        nearest_min_m: nearest.iter().copied().reduce(f64::min),
        nearest_mean_m: (!nearest.is_empty()).then(|| nearest.iter().sum::<f64>() / n),
        reward: [reward_low, reward_sum / n, reward_high],
        reward_sum,
        with_area: count(&|i| i.area_cm2.is_some()),
        with_p_detection: count(&|i| i.p_detection.is_some()),
        with_p_grasp: count(&|i| i.p_grasp.is_some()),
        with_weight: count(&|i| i.weight.is_some()),
        with_true_class: count(&|i| i.true_class.is_some()),
        misdetected: count(&|i| i.true_class.is_some() && i.true_class != i.class),
        classes,
    }
}

/// Distance from each item to its nearest neighbour [m]; empty for a single item.
fn nearest_neighbours(pattern: &Pattern) -> Vec<f64> {
    if pattern.len() < 2 {
        return Vec::new();
    }
    let places = pattern.items().iter().map(|item| [item.x0, item.y]);
    let tree = RTree::bulk_load(places.clone().collect());
    // The nearest neighbour of a point is the item itself, the second is the next one.
    let nearest = |place| tree.nearest_neighbor_iter_with_distance_2(place).nth(1);
    places
        .filter_map(nearest)
        .map(|(_, square)| square.sqrt())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Item, grid};
    use rand::RngExt;

    #[test]
    fn a_grid_is_described_by_its_spacing() {
        let d = describe(&grid(1.05, 0.15, 48).unwrap());
        assert_eq!(d.items, 48);
        assert!((d.length_m - 0.75).abs() < 1e-12);
        assert!((d.width_m - 1.05).abs() < 1e-12);
        assert!((d.items_per_m.unwrap() - 8.0 / 0.15).abs() < 1e-9);
        assert!((d.nearest_min_m.unwrap() - 0.15).abs() < 1e-12);
        assert!((d.nearest_mean_m.unwrap() - 0.15).abs() < 1e-12);
        assert_eq!(d.reward, [0.5; 3]);
    }

    #[test]
    fn neighbours_are_those_of_a_plain_search() {
        let mut rng = crate::pattern::random_stream(1, 0);
        for (n, columns) in [(2, 1), (3, 2), (200, 1), (200, 5), (300, 1000)] {
            let items = (0..n).map(|i| {
                let column = rng.random_range(0..columns);
                let row = rng.random_range(0..40);
                Item::at(
                    i.to_string(),
                    -0.1 * f64::from(column),
                    0.02 * f64::from(row),
                )
            });
            let pattern = Pattern::new(items.collect()).unwrap();
            let plain = pattern.items().iter().enumerate().map(|(i, a)| {
                let others = pattern.items().iter().enumerate().filter(|(j, _)| i != *j);
                let distances = others.map(|(_, b)| (b.x0 - a.x0).powi(2) + (b.y - a.y).powi(2));
                distances.fold(f64::INFINITY, f64::min).sqrt()
            });
            assert_eq!(nearest_neighbours(&pattern), plain.collect::<Vec<_>>());
        }
    }

    /// A single column is the worst case of a search along the belt: with 100,000 items it would
    /// take ten billion steps.
    #[test]
    fn many_items_in_one_column_are_described() {
        let items = (0..100_000).map(|i| Item::at(i.to_string(), 0.0, f64::from(i)));
        let d = describe(&Pattern::new(items.collect()).unwrap());
        assert_eq!(d.nearest_mean_m, Some(1.0));
    }

    #[test]
    fn a_single_item_has_no_neighbour() {
        let d = describe(&Pattern::new(vec![Item::at("a", 0.0, 0.0)]).unwrap());
        assert_eq!((d.nearest_min_m, d.items_per_m), (None, None));
    }
}
