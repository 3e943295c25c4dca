//! Varies one quantity of the line: belt speed, robots, spacing or reach.

use super::method::{Method, MethodRun};
use crate::clearance;
use crate::decision::Figures;
use crate::error::{Error, Result, known_names, shown};
use crate::optimize::{Environment, bound_beside};
use crate::pattern::Pattern;
use crate::planning::bound::{Bound, certified_percent};
use crate::sim::{Conditions, Scene};
use crate::station::Station;
use crate::stats::{self, Interval};
use crate::throughput::{Steadiness, Throughput};
use rayon::prelude::*;

/// The varied quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// Belt speed [m/s].
    Speed,
    /// Number of robots.
    Robots,
    /// Distance between neighbouring bases along the belt [m].
    Spacing,
    /// Reach of every robot [m].
    Reach,
}

impl Axis {
    /// All axes with their names and units, the default first. By hand, because derived names
    /// would have their units elsewhere.
    pub const NAMES: [(Self, &'static str, &'static str); 4] = [
        (Self::Speed, "speed", "m/s"),
        (Self::Robots, "robots", "1"),
        (Self::Spacing, "spacing", "m"),
        (Self::Reach, "reach", "m"),
    ];

    /// The axis with this name.
    ///
    /// # Errors
    /// The name is unknown; the message suggests the nearest known one.
    pub fn named(name: &str) -> Result<Self> {
        let found = Self::NAMES.iter().find(|entry| entry.1 == name);
        found.map(|entry| entry.0).ok_or_else(|| {
            Error::usage(
                "'sweep_axis'",
                format!("`{}` cannot be swept", shown(name)),
                known_names(name, &Self::NAMES.map(|entry| entry.1)),
            )
        })
    }

    fn entry(self) -> (Self, &'static str, &'static str) {
        Self::NAMES[match self {
            Self::Speed => 0,
            Self::Robots => 1,
            Self::Spacing => 2,
            Self::Reach => 3,
        }]
    }

    /// The name: `speed`, `robots`, `spacing` or `reach`.
    pub fn name(self) -> &'static str {
        self.entry().1
    }

    /// Whether larger values help. If so, everything is picked from some value on, rather than
    /// up to one.
    pub fn helps(self) -> bool {
        matches!(self, Self::Robots | Self::Reach)
    }

    /// The unit of the values: `m/s`, `m`, or `1` for robots.
    pub fn unit(self) -> &'static str {
        self.entry().2
    }
}

/// A throughput of at least this share of the highest counts as equally good: a smaller gain is
/// not worth another robot or a longer belt.
pub const AS_GOOD: f64 = 0.99;

/// One value of the sweep: the line with this value, and the methods on it.
#[derive(Debug, Clone)]
pub struct Setting {
    /// The varied quantity, in the unit of its [`Axis`].
    pub value: f64,
    /// The station at this value.
    pub station: Station,
    /// The methods, of the same kinds in the same order at every value.
    pub methods: Vec<Method>,
}

/// One method at one value.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SweepPoint {
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
    /// For each pattern, whether everything was picked.
    complete: Vec<bool>,
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

/// The methods at all values of a sweep.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Sweep {
    /// The completed values; all of them unless the user stopped the sweep.
    pub values: Vec<f64>,
    /// Number of values that were asked for; fewer are complete after a stop request.
    pub planned: usize,
    /// For each value, the methods in their order.
    pub points: Vec<Vec<SweepPoint>>,
    /// For each value, what no strategy can exceed; `None` if not requested.
    pub bounds: Option<Vec<SweepBound>>,
    /// For each value, whether arms can meet.
    pub arms_meet: Vec<bool>,
    /// Whether items have attributes, so that weight differs from the count.
    pub weighs: bool,
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
    /// Up to which value a method picked every item of every pattern.
    pub fn complete(&self, method: usize) -> Limit {
        let whole = |i: usize| self.points[i][method].complete.iter().all(|c| *c);
        Limit::of(&self.values, whole)
    }

    /// The lowest value, among those at which no arms can meet, with which a method's
    /// throughput is at least [`AS_GOOD`] of the highest, each as a share of the flow. `None`
    /// without a throughput, or if arms can meet at every value.
    pub fn recommended(&self, method: usize) -> Option<f64> {
        let throughput = |i: usize| self.points[i][method].throughput.share();
        let may = (0..self.values.len()).filter(|&i| !self.arms_meet[i]);
        let fits: Vec<(usize, f64)> = may.filter_map(|i| Some((i, throughput(i)?))).collect();
        let best = fits.iter().map(|fit| fit.1).fold(0.0, f64::max);
        let good = fits.iter().find(|fit| fit.1 >= AS_GOOD * best);
        good.map(|fit| self.values[fit.0])
    }

    /// Up to which value at least `share` of the patterns were picked to at least 99 %.
    pub fn nearly_complete(&self, method: usize, share: f64) -> Limit {
        Limit::of(&self.values, |i| {
            self.points[i][method].nearly_complete_share >= share
        })
    }

    /// For every pattern, up to which value a method picked all of it; 0 if not even at the
    /// first.
    pub fn limits(&self, method: usize) -> Vec<f64> {
        let patterns = self.points[0][method].complete.len();
        let limit =
            |pattern: usize| Limit::of(&self.values, |i| self.points[i][method].complete[pattern]);
        (0..patterns)
            .map(|p| limit(p).highest.unwrap_or(0.0))
            .collect()
    }
}

/// Runs the methods of `setting` on `pattern`. With `bounded`, the bound for every strategy is
/// computed too.
fn run_methods(
    setting: &Setting,
    pattern: &Pattern,
    conditions: Conditions,
    bounded: bool,
    environment: &Environment,
) -> Result<Runs> {
    if environment.stopped() {
        return Err(Error::interrupted());
    }
    let scene = Scene::under(&setting.station, pattern, conditions)?;
    let runs = setting.methods.iter().map(|method| method.run(&scene));
    let runs: Vec<MethodRun> = runs.collect::<Result<_>>()?;
    let picked = runs.iter().map(|run| run.figures.picked).max();
    let bound = bounded
        .then(|| bound_beside(&scene, picked.unwrap_or_default(), environment))
        .transpose()?;
    Ok(Runs { runs, bound })
}

/// Runs all methods at all settings on the same patterns. If failures are simulated, pattern i
/// draws its random events from the conditions' seed + i at every setting. With `bounded`, the bound for
/// every strategy is computed for every value and pattern. The same input gives the same result
/// on any number of threads. A stop request takes effect after a whole value.
///
/// # Errors
/// A pattern that does not fit on the belt, an illegal action, or
/// [`Interrupted`](crate::error::ErrorKind) before the first value is complete.
pub fn sweep_settings(
    settings: &[Setting],
    patterns: &[Pattern],
    conditions: &Conditions,
    bounded: bool,
    environment: &Environment,
) -> Result<Sweep> {
    environment
        .progress
        .begin("sweeping", settings.len() as u64, "values");
    let mut points: Vec<Vec<SweepPoint>> = Vec::with_capacity(settings.len());
    let mut bounds = Vec::new();
    let mut steadiness: Vec<Vec<Steadiness>> = Vec::new();
    for setting in settings {
        let run = |(place, pattern): (usize, &Pattern)| {
            let seed = conditions.disturbances.seed.wrapping_add(place as u64);
            let conditions = conditions.with_seed(seed);
            run_methods(setting, pattern, conditions, bounded, environment)
        };
        let by_pattern: Result<Vec<Runs>> = patterns.par_iter().enumerate().map(run).collect();
        let by_pattern = match by_pattern {
            Err(error) if error.is_interrupted() && !points.is_empty() => break,
            by_pattern => by_pattern?,
        };
        bounds.extend(summarise_bounds(&by_pattern));
        points.push(summarise_methods(&setting.methods, &by_pattern));
        let of_method = |i: usize| by_pattern.iter().map(move |runs| &runs.runs[i].steady);
        let methods = 0..setting.methods.len();
        steadiness.extend(methods.map(|i| of_method(i).cloned().collect()));
        environment.progress.advance(1);
    }
    environment.progress.end();
    // All values use the same patterns.
    let runs: Vec<Vec<&Steadiness>> = steadiness.iter().map(|of| of.iter().collect()).collect();
    let throughputs = Throughput::beside(&runs);
    for (point, throughput) in points.iter_mut().flatten().zip(throughputs) {
        point.throughput = throughput;
    }
    let done = settings.iter().take(points.len());
    Ok(Sweep {
        values: done.clone().map(|setting| setting.value).collect(),
        planned: settings.len(),
        points,
        bounds: bounded.then_some(bounds),
        arms_meet: done
            .map(|setting| clearance::apart(&setting.station).is_doubtful())
            .collect(),
        weighs: patterns.iter().any(Pattern::has_attributes),
    })
}

/// All methods on one pattern at one value.
struct Runs {
    runs: Vec<MethodRun>,
    bound: Option<Bound>,
}

/// The figures of every method at one value.
fn summarise_methods(methods: &[Method], by_pattern: &[Runs]) -> Vec<SweepPoint> {
    let bounds = by_pattern.iter().map(|runs| runs.bound.as_ref());
    let most: Option<f64> = bounds.map(|bound| bound.map(|bound| bound.value)).sum();
    let point = |(i, method): (usize, &Method)| {
        let runs: Vec<&MethodRun> = by_pattern.iter().map(|runs| &runs.runs[i]).collect();
        summarise(method.title(), &runs, most)
    };
    methods.iter().enumerate().map(point).collect()
}

fn summarise_bounds(by_pattern: &[Runs]) -> Option<SweepBound> {
    let bounds = by_pattern.iter().map(|runs| runs.bound.as_ref());
    let bounds: Vec<&Bound> = bounds.collect::<Option<_>>()?;
    let items = by_pattern.iter().map(|runs| runs.runs[0].figures.items);
    let rates: Option<Vec<f64>> = bounds.iter().map(|bound| bound.rate).collect();
    let shares = bounds.iter().zip(items.clone());
    let shares: Vec<f64> = shares.map(|(b, items)| b.value / items as f64).collect();
    Some(SweepBound {
        picked_share: stats::mean(&shares),
        picking_rate: rates.map(|rates| stats::mean(&rates)),
    })
}

/// The figures of `runs`, in which no strategy picks more than `most` items in total.
fn summarise(title: String, runs: &[&MethodRun], most: Option<f64>) -> SweepPoint {
    let figures: Vec<Figures> = runs.iter().map(|run| run.figures).collect();
    let all = |of: &dyn Fn(&Figures) -> f64| -> Vec<f64> { figures.iter().map(of).collect() };
    let shares = all(&Figures::picked_share);
    let rates = all(&Figures::picking_rate);
    let of_patterns = |holds: &dyn Fn(&Figures) -> bool| {
        figures.iter().filter(|run| holds(run)).count() as f64 / runs.len() as f64
    };
    SweepPoint {
        title,
        picked_share: stats::mean(&shares),
        picked_share_interval: stats::share_mean_interval(&shares),
        throughput: Throughput::of(runs.iter().map(|run| &run.steady)),
        picking_rate: stats::mean(&rates),
        picking_rate_interval: stats::rate_mean_interval(&rates),
        weighted_rate: stats::mean(&all(&Figures::weighted_rate)),
        complete_share: of_patterns(&Figures::complete),
        nearly_complete_share: of_patterns(&|run| run.picked_share() >= 0.99),
        certified: most.map(|most| {
            let picked: usize = figures.iter().map(|run| run.picked).sum();
            certified_percent(picked as f64, most)
        }),
        complete: figures.iter().map(Figures::complete).collect(),
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
            complete: vec![true],
        };
        Sweep {
            values: (1..=throughputs.len()).map(|value| value as f64).collect(),
            planned: throughputs.len(),
            points: throughputs.iter().map(|mean| vec![point(mean)]).collect(),
            bounds: None,
            arms_meet: arms_meet.to_vec(),
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
                sweep.recommended(0),
                recommended,
                "{throughputs:?} {arms_meet:?}"
            );
        }
    }

    #[test]
    fn axes_have_names_and_units() {
        for (axis, name, unit, helps) in [
            (Axis::Speed, "speed", "m/s", false),
            (Axis::Robots, "robots", "1", true),
            (Axis::Spacing, "spacing", "m", false),
            (Axis::Reach, "reach", "m", true),
        ] {
            assert_eq!(Axis::named(name).unwrap(), axis);
            assert_eq!(
                (axis.name(), axis.unit(), axis.helps()),
                (name, unit, helps)
            );
        }
        let message = Axis::named("sped").unwrap_err().to_string();
        assert!(message.contains("`sped` cannot be swept"), "{message}");
    }
}
