//! What methods pick of each class, and what no strategy can exceed.

use crate::error::Result;
use crate::optimize::{Environment, part_bound_beside};
use crate::planning::bound::certified_percent;
use crate::sim::{ClassRun, Scene};
use crate::stats::{self, Interval};
use std::collections::BTreeMap;

/// Maximum number of classes of a pattern that are bounded one by one: each takes as long as the
/// bound on all picks.
const MOST_BOUNDED: usize = 20;

/// The most items of one class that any strategy can pick from one pattern.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct ClassBound {
    /// Name of the class; `None` for the items without one.
    pub class: Option<String>,
    /// Upper bound on their picks.
    pub picks: usize,
}

/// One class over all patterns.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ClassResult {
    /// Name of the class; `None` for the items without one.
    pub class: Option<String>,
    /// Whether the class is wanted and some robot has a bin for it.
    pub wanted: bool,
    /// Number of items of this class in all patterns together.
    pub items: usize,
    /// How many of them were picked.
    pub picked: usize,
    /// The share of them that was picked; `None` if they are not to be picked.
    pub recovery: Option<f64>,
    /// 95 % interval of that share over the patterns; `None` for a single pattern.
    pub recovery_interval: Option<Interval>,
    /// Upper bound on the picks of every strategy; `None` if it was not requested.
    pub picks_bound: Option<usize>,
    /// The picks as a proven share of the optimum for this class alone [%].
    pub certified: Option<f64>,
}

/// Bounds the picks of each wanted class on `scene`, where `runs` are those of all methods: the
/// bound on all picks with the items of the other classes worth nothing. These may still be picked,
/// so every run obeys it, whatever else it picks. Empty if no item has a class, and if there are more
/// than 20 classes.
///
/// # Errors
/// As for [`bound_beside`](crate::optimize::bound_beside).
pub fn class_bounds(
    scene: &Scene,
    runs: &[&[ClassRun]],
    environment: &Environment,
) -> Result<Vec<ClassBound>> {
    let classes = runs.first().copied().unwrap_or_default();
    let wanted: Vec<&ClassRun> = classes.iter().filter(|run| run.wanted).collect();
    if classes.iter().all(|run| run.class.is_none()) || wanted.len() > MOST_BOUNDED {
        return Ok(Vec::new());
    }
    let bound = |class: &Option<String>| {
        let items = scene.pattern().items().iter();
        let counted = items.map(|item| item.class == *class).collect();
        let alike = runs.iter().copied().flatten();
        let picked = alike
            .filter(|run| run.class == *class)
            .map(|run| run.picked);
        let most = picked.max().unwrap_or_default();
        let bound = part_bound_beside(scene, counted, most, environment)?;
        Ok(ClassBound {
            class: class.clone(),
            picks: bound.value as usize,
        })
    };
    wanted.into_iter().map(|run| bound(&run.class)).collect()
}

/// Sums over the patterns for one class.
#[derive(Default)]
struct ClassSums {
    wanted: bool,
    /// For each pattern with items of the class, their number and how many were picked.
    patterns: Vec<(usize, usize)>,
    /// Upper bound on the picks.
    most: usize,
}

/// The classes in the runs of one method on all patterns, with the bounds of each pattern if they
/// are known. Empty if no item has a class that matters on the station.
pub(super) fn class_results<'r>(
    runs: impl Iterator<Item = &'r [ClassRun]>,
    bounds: Option<&[Vec<ClassBound>]>,
) -> Vec<ClassResult> {
    let mut classes: BTreeMap<Option<&str>, ClassSums> = BTreeMap::new();
    for (place, runs) in runs.enumerate() {
        for run in runs {
            let of = bounds.map_or(&[][..], |bounds| &bounds[place]);
            let bound = of.iter().find(|bound| bound.class == run.class);
            let sums = classes.entry(run.class.as_deref()).or_default();
            sums.wanted = run.wanted;
            sums.patterns.push((run.items, run.picked));
            // No more can be picked than there are.
            sums.most += bound.map_or(run.items, |bound| bound.picks);
        }
    }
    if classes.keys().all(Option::is_none) {
        return Vec::new();
    }
    let is_bounded = bounds.is_some_and(|bounds| bounds.iter().any(|of| !of.is_empty()));
    let result = |(class, sums): (Option<&str>, ClassSums)| {
        let items = sums.patterns.iter().map(|(items, _)| items).sum();
        let picked = sums.patterns.iter().map(|(_, picked)| picked).sum();
        let most = (is_bounded && sums.wanted).then_some(sums.most);
        ClassResult {
            class: class.map(str::to_owned),
            wanted: sums.wanted,
            items,
            picked,
            recovery: sums.wanted.then(|| picked as f64 / items as f64),
            recovery_interval: match sums.wanted {
                true => ratio_interval(&sums.patterns),
                false => None,
            },
            picks_bound: most,
            certified: most.map(|most| certified_percent(picked as f64, most as f64)),
        }
    };
    classes.into_iter().map(result).collect()
}

/// 95 % interval of all picked over all items by the ratio estimator (Cochran 1977, Sampling
/// Techniques, ISBN 0-471-16240-X, section 6.3): patterns have different numbers of items of a
/// class.
fn ratio_interval(patterns: &[(usize, usize)]) -> Option<Interval> {
    let items: usize = patterns.iter().map(|(items, _)| items).sum();
    let picked: usize = patterns.iter().map(|(_, picked)| picked).sum();
    let ratio = picked as f64 / items as f64;
    let mean = items as f64 / patterns.len() as f64;
    let squares = patterns.iter().map(|&(items, picked)| {
        let distance = (picked as f64 - ratio * items as f64) / mean;
        distance * distance
    });
    let interval = stats::interval_of(patterns.len(), ratio, squares.sum());
    interval.map(|interval| interval.within(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(class: Option<&str>, items: usize, picked: usize) -> ClassRun {
        ClassRun {
            class: class.map(str::to_owned),
            wanted: class != Some("wood"),
            items,
            picked,
        }
    }

    fn bound(class: &str, picks: usize) -> ClassBound {
        ClassBound {
            class: Some(class.to_owned()),
            picks,
        }
    }

    #[test]
    fn classes_are_summed_over_the_patterns() {
        let runs = [
            vec![run(Some("pet"), 10, 8), run(Some("wood"), 5, 0)],
            vec![run(None, 3, 3), run(Some("pet"), 30, 12)],
        ];
        let bounds = [vec![bound("pet", 9)], vec![bound("pet", 16)]];
        let results = class_results(runs.iter().map(Vec::as_slice), Some(&bounds));
        let rows: Vec<_> = results
            .iter()
            .map(|r| {
                (
                    r.class.as_deref(),
                    r.items,
                    r.picked,
                    r.recovery,
                    r.picks_bound,
                )
            })
            .collect();
        assert_eq!(
            rows,
            [
                // Unbounded in its pattern: all of its items.
                (None, 3, 3, Some(1.0), Some(3)),
                (Some("pet"), 40, 20, Some(0.5), Some(25)),
                (Some("wood"), 5, 0, None, None),
            ]
        );
        let pet = &results[1];
        assert_eq!(pet.certified, Some(80.0));
        // Residuals 8 - 5 and 12 - 15 over a mean of 20 items; t = 12.706 with one degree of
        // freedom, so that the interval reaches both ends.
        assert_eq!(
            pet.recovery_interval,
            Some(Interval {
                low: 0.0,
                high: 1.0
            })
        );
        assert_eq!(results[2].certified, None);
        let unbounded = class_results(runs.iter().map(Vec::as_slice), None);
        assert!(
            unbounded
                .iter()
                .all(|r| r.picks_bound.is_none() && r.certified.is_none())
        );
    }

    /// Three patterns by hand: residuals 1, -1 and 0 over a mean of 10, t = 4.30265.
    #[test]
    fn the_interval_is_that_of_a_ratio() {
        let Interval { low, high } = ratio_interval(&[(10, 6), (10, 4), (10, 5)]).unwrap();
        let half = 4.302_652_73 * (0.02f64 / 2.0 / 3.0).sqrt();
        assert!((low - (0.5 - half)).abs() < 1e-8 && (high - (0.5 + half)).abs() < 1e-8);
        assert_eq!(ratio_interval(&[(10, 6)]), None);
    }

    #[test]
    fn without_classes_there_is_nothing_to_tell_apart() {
        let runs = [vec![run(None, 10, 8)], Vec::new()];
        assert_eq!(class_results(runs.iter().map(Vec::as_slice), None), []);
    }
}
