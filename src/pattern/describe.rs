//! What a pattern looks like in figures.

use super::item::Pattern;
use serde::Serialize;
use std::collections::BTreeMap;

/// Figures of one pattern.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Description {
    /// Number of items.
    pub items: usize,
    /// From the first item to the last along the belt [m].
    pub length_m: f64,
    /// Between the outermost items across the belt [m].
    pub width_m: f64,
    /// Smallest and largest position across the belt [m].
    pub y_range_m: [f64; 2],
    /// Items per metre of belt [1/m]; none for a single place along the belt.
    pub items_per_m: Option<f64>,
    /// Smallest distance between two items [m]; none for a single item.
    pub nearest_min_m: Option<f64>,
    /// Mean distance from an item to its nearest neighbour [m].
    pub nearest_mean_m: Option<f64>,
    /// Smallest, mean and largest object-specific reward.
    pub reward: [f64; 3],
    /// Sum of the rewards.
    pub reward_sum: f64,
    /// How many items carry an area, a detection and a grasp probability, a weight.
    pub with_area: usize,
    /// How many carry a detection probability.
    pub with_p_detection: usize,
    /// How many carry a grasp probability.
    pub with_p_grasp: usize,
    /// How many carry an explicit weight.
    pub with_weight: usize,
    /// Items per class, where there are classes.
    pub classes: BTreeMap<String, usize>,
}

/// The figures of `pattern`. Takes O(n k) steps, k the items within one
/// nearest-neighbour distance along the belt.
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
        items_per_m: (length_m > 0.0).then(|| n / length_m),
        nearest_min_m: nearest.iter().copied().reduce(f64::min),
        nearest_mean_m: (!nearest.is_empty()).then(|| nearest.iter().sum::<f64>() / n),
        reward: [reward_low, reward_sum / n, reward_high],
        reward_sum,
        with_area: count(&|i| i.area_cm2.is_some()),
        with_p_detection: count(&|i| i.p_detection.is_some()),
        with_p_grasp: count(&|i| i.p_grasp.is_some()),
        with_weight: count(&|i| i.weight.is_some()),
        classes,
    }
}

/// Distance from each item to its nearest neighbour [m]; empty for a single item.
fn nearest_neighbours(pattern: &Pattern) -> Vec<f64> {
    let items = pattern.items();
    if items.len() < 2 {
        return Vec::new();
    }
    // Items are sorted along the belt: walk away from each until the gap along the
    // belt alone is too long.
    let look = |i: usize, others: &mut dyn Iterator<Item = usize>, mut best: f64| {
        for j in others {
            if (items[j].x0 - items[i].x0).abs() >= best {
                break;
            }
            best = best.min((items[j].x0 - items[i].x0).hypot(items[j].y - items[i].y));
        }
        best
    };
    (0..items.len())
        .map(|i| {
            let best = look(i, &mut (i + 1..items.len()), f64::INFINITY);
            look(i, &mut (0..i).rev(), best)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Item, grid};

    #[test]
    fn a_grid_is_described_by_its_spacing() {
        let d = describe(&grid(1.05, 0.15, 48).unwrap());
        assert_eq!(d.items, 48);
        assert!((d.length_m - 0.75).abs() < 1e-12);
        assert!((d.width_m - 1.05).abs() < 1e-12);
        assert!((d.nearest_min_m.unwrap() - 0.15).abs() < 1e-12);
        assert!((d.nearest_mean_m.unwrap() - 0.15).abs() < 1e-12);
        assert_eq!(d.reward, [0.5; 3]);
    }

    #[test]
    fn a_single_item_has_no_neighbour() {
        let d = describe(&Pattern::new(vec![Item::at("a", 0.0, 0.0)]).unwrap());
        assert_eq!((d.nearest_min_m, d.items_per_m), (None, None));
    }
}
