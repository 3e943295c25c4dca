//! What a sweep found: each method at each value, and up to which value it picks everything.

use super::class_result::ClassResult;
use crate::error::{Error, Result, known_names, shown};
use crate::purity::PurityByBin;
use crate::stats::Interval;
use crate::throughput::Throughput;

/// A throughput of at least this share of the highest counts as equally good: a smaller gain is
/// not worth another robot or a longer belt.
pub const AS_GOOD: f64 = 0.99;

/// One method at one value.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SweepPoint {
    /// The method's name in files: [`Method::id`](super::Method::id).
    pub method: String,
    /// Its name in tables at this value.
    pub title: String,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// 95 % interval of that mean; `None` for a single pattern, as for the next one.
    pub picked_share_interval: Option<Interval>,
    /// Picks per minute in the steady state.
    pub throughput: Throughput,
    /// Mean picking rate [1/min].
    pub picking_rate: f64,
    /// 95 % interval of that mean [1/min].
    pub picking_rate_interval: Option<Interval>,
    /// Mean weighted rate [1/min].
    pub weighted_rate: f64,
    /// Share of the patterns that were picked completely.
    pub complete_share: f64,
    /// Share of the patterns of which at least 99 % was picked.
    pub nearly_complete_share: f64,
    /// Picks over all patterns as a proven share of the optimum [%]; `None` if not requested.
    pub certified: Option<f64>,
    /// Purity and recovery; `None` unless detections may be wrong.
    pub purity: Option<PurityByBin>,
    /// What it picked of each class; empty if no item has a class that matters on the station.
    pub classes: Vec<ClassResult>,
    /// For each pattern, whether everything was picked.
    pub(super) complete: Vec<bool>,
}

/// What no strategy can exceed at one value.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SweepBound {
    /// Mean of the most items that can be picked, as a share of the items.
    pub picked_share: f64,
    /// Mean of the highest possible rates [1/min]; `None` if some pattern has no finite bound.
    pub picking_rate: Option<f64>,
}

impl SweepBound {
    /// Whether some strategy may pick every item of every pattern. If false, it is proven that
    /// none can.
    pub fn complete(&self) -> bool {
        // The mean of shares, each of which is exactly 1 if everything may be picked.
        self.picked_share >= 1.0
    }
}

/// What was found at one value of a sweep.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SweepValue {
    /// The varied quantity, in the unit of its [`Axis`](super::Axis).
    pub value: f64,
    /// The methods, in the same order at every value.
    pub methods: Vec<SweepPoint>,
    /// What no strategy can exceed; `None` if not requested.
    pub bound: Option<SweepBound>,
    /// Whether arms can meet.
    pub arms_meet: bool,
}

/// The methods at all values of a sweep.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Sweep {
    /// The completed values, one at least; all of them unless the user stopped the sweep.
    pub values: Vec<SweepValue>,
    /// Number of values that were asked for; fewer are complete after a stop request.
    pub planned: usize,
    /// Whether items have attributes or classes of different value, so that weight differs from the
    /// count.
    pub weighs: bool,
}

/// One method at all values of a sweep.
#[derive(Debug, Clone)]
pub struct SweptMethod<'s> {
    points: Vec<(&'s SweepValue, &'s SweepPoint)>,
}

/// Up to which value of a sweep a condition held.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Limit {
    /// The highest value up to which it always held; `None` if it failed at the first value.
    pub highest: Option<f64>,
    /// The first value at which it failed; `None` if it never did.
    pub first_miss: Option<f64>,
    /// The values above that at which it held again.
    pub again: Vec<f64>,
    /// The lowest value from which it always held; `None` if it failed at the last value.
    pub lowest: Option<f64>,
}

impl Limit {
    fn of(values: &[f64], held: impl Fn(usize) -> bool) -> Self {
        let miss = (0..values.len()).find(|&i| !held(i));
        let end = miss.unwrap_or(values.len());
        let last_miss = (0..values.len()).rfind(|&i| !held(i));
        Self {
            lowest: values.get(last_miss.map_or(0, |i| i + 1)).copied(),
            highest: end.checked_sub(1).map(|i| values[i]),
            first_miss: miss.map(|i| values[i]),
            again: (end..values.len())
                .filter(|&i| held(i))
                .map(|i| values[i])
                .collect(),
        }
    }
}

impl Sweep {
    /// The methods in their order.
    pub fn methods(&self) -> impl Iterator<Item = SweptMethod<'_>> {
        let count = self.values.first().map_or(0, |value| value.methods.len());
        (0..count).map(|place| SweptMethod {
            points: self
                .values
                .iter()
                .map(|value| (value, &value.methods[place]))
                .collect(),
        })
    }

    /// The method with this name in files: `robust_gt`, `greedy_gt`, or the strategy as it is
    /// written.
    ///
    /// # Errors
    /// No such method was run; the message suggests the nearest one.
    pub fn method(&self, name: &str) -> Result<SweptMethod<'_>> {
        let found = self.methods().find(|method| method.name() == name);
        found.ok_or_else(|| {
            let names: Vec<&str> = self.methods().map(|method| method.name()).collect();
            Error::usage(
                "the sweep",
                format!("no method `{}` was run", shown(name)),
                known_names(name, &names),
            )
        })
    }
}

impl<'s> SweptMethod<'s> {
    /// The method's name in files.
    pub fn name(&self) -> &'s str {
        self.points.first().map_or("", |(_, point)| &point.method)
    }

    /// The values with what the method picks at each.
    pub fn points(&self) -> impl Iterator<Item = (f64, &'s SweepPoint)> + Clone {
        self.points.iter().map(|(at, point)| (at.value, *point))
    }

    /// Up to which value the method picked every item of every pattern.
    pub fn complete(&self) -> Limit {
        self.limit(|point| point.complete.iter().all(|complete| *complete))
    }

    /// The lowest value, among those at which no arms can meet, with which the method's
    /// throughput is at least [`AS_GOOD`] of the highest, each as a share of the flow. `None`
    /// without a throughput, or if arms can meet at every value.
    pub fn recommended(&self) -> Option<f64> {
        let apart = self.points.iter().filter(|(at, _)| !at.arms_meet);
        let fits = apart.filter_map(|(at, point)| Some((at.value, point.throughput.share()?)));
        let best = fits.clone().map(|fit| fit.1).fold(0.0, f64::max);
        let good = fits.clone().find(|fit| fit.1 >= AS_GOOD * best);
        good.map(|fit| fit.0)
    }

    /// Up to which value at least `share` of the patterns were picked to at least 99 %.
    pub fn nearly_complete(&self, share: f64) -> Limit {
        self.limit(|point| point.nearly_complete_share >= share)
    }

    /// For every pattern, up to which value the method picked all of it; 0 if not even at the
    /// first.
    pub fn limits(&self) -> Vec<f64> {
        let first = self.points.first();
        let patterns = first.map_or(0, |(_, point)| point.complete.len());
        let limit = |pattern: usize| self.limit(|point| point.complete[pattern]).highest;
        (0..patterns).map(|p| limit(p).unwrap_or(0.0)).collect()
    }

    fn limit(&self, held: impl Fn(&SweepPoint) -> bool) -> Limit {
        let values: Vec<f64> = self.points.iter().map(|(at, _)| at.value).collect();
        Limit::of(&values, |i| held(self.points[i].1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_where_it_first_fails_not_where_it_last_holds() {
        let values = [1.0, 2.0, 3.0, 4.0, 5.0];
        let held = [true, true, false, true, false];
        let limit = Limit::of(&values, |i| held[i]);
        assert_eq!(limit.highest, Some(2.0));
        assert_eq!(limit.first_miss, Some(3.0));
        assert_eq!(limit.again, [4.0]);
        assert_eq!(limit.lowest, None);
        assert_eq!(Limit::of(&values, |i| i == 0 || i > 2).lowest, Some(4.0));
        assert_eq!(Limit::of(&values, |_| false).highest, None);
        assert_eq!(Limit::of(&values, |_| true).first_miss, None);
    }

    /// One method with these throughputs at a flow of 100/min.
    fn swept(throughputs: &[Option<f64>], arms_meet: &[bool]) -> Sweep {
        let point = |mean: &Option<f64>| SweepPoint {
            method: "m".into(),
            title: "t".into(),
            picked_share: 1.0,
            picked_share_interval: None,
            throughput: Throughput {
                mean: *mean,
                interval: None,
                flow: Some(100.0),
                utilisation: Vec::new(),
                steady: 1,
                changing: 0,
                runs: 1,
                missing: None,
            },
            picking_rate: 1.0,
            picking_rate_interval: None,
            weighted_rate: 1.0,
            complete_share: 1.0,
            nearly_complete_share: 1.0,
            certified: None,
            purity: None,
            classes: Vec::new(),
            complete: vec![true],
        };
        let values = throughputs.iter().zip(arms_meet).enumerate();
        let value = |(place, (mean, arms_meet)): (usize, (&Option<f64>, &bool))| SweepValue {
            value: (place + 1) as f64,
            methods: vec![point(mean)],
            bound: None,
            arms_meet: *arms_meet,
        };
        Sweep {
            values: values.map(value).collect(),
            planned: throughputs.len(),
            weighs: false,
        }
    }

    #[test]
    fn the_least_value_that_is_as_good_as_the_best_is_recommended() {
        let apart = [false; 4];
        for (throughputs, arms_meet, recommended) in [
            (
                [Some(50.0), Some(70.0), Some(80.0), Some(80.0)],
                apart,
                Some(3.0),
            ),
            // A loss of one percent is still as good; a larger loss is not.
            (
                [Some(50.0), Some(79.2), Some(80.0), Some(80.0)],
                apart,
                Some(2.0),
            ),
            (
                [Some(50.0), Some(79.1), Some(80.0), Some(80.0)],
                apart,
                Some(3.0),
            ),
            // A value at which arms meet is not a valid line, not even to compare with.
            (
                [Some(50.0), Some(60.0), Some(80.0), Some(80.0)],
                [false, false, true, true],
                Some(2.0),
            ),
            (
                [Some(80.0), Some(50.0), None, None],
                [true, false, false, false],
                Some(2.0),
            ),
            ([None, None, Some(40.0), None], apart, Some(3.0)),
            ([None; 4], apart, None),
            ([Some(80.0); 4], [true; 4], None),
        ] {
            let sweep = swept(&throughputs, &arms_meet);
            assert_eq!(
                sweep.method("m").unwrap().recommended(),
                recommended,
                "{throughputs:?} {arms_meet:?}"
            );
        }
    }

    #[test]
    fn methods_are_found_by_name() {
        let sweep = swept(&[Some(80.0)], &[false]);
        assert_eq!(sweep.methods().count(), 1);
        assert_eq!(sweep.method("m").unwrap().name(), "m");
        let message = sweep.method("n").unwrap_err().to_string();
        assert!(message.contains("no method `n` was run"), "{message}");
    }
}
