//! Varies one quantity of the line: belt speed, robots, spacing, reach, or the threshold of
//! detections.

use super::bounds::PatternBound;
use super::class_result::{ClassBound, class_results};
use super::method::{Method, MethodRun};
use super::robots_down::ROBOTS_DOWN;
use super::sweep_result::{Sweep, SweepBound, SweepPoint, SweepValue};
use crate::clearance;
use crate::decision::{Figures, picked_shares};
use crate::error::{Error, Result, known_names, shown};
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::planning::bound::certified_percent;
use crate::purity::PurityByBin;
use crate::shards::none_complete;
use crate::sim::{Conditions, Scene};
use crate::station::Station;
use crate::stats;
use crate::throughput::{Steadiness, Throughput};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use strum::VariantArray as _;

/// The varied quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr, strum::VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Axis {
    /// Belt speed [m/s].
    Speed,
    /// Number of robots.
    Robots,
    /// Distance between neighbouring bases along the belt [m].
    Spacing,
    /// Reach of every robot [m].
    Reach,
    /// Lowest `p_detection` of items that are picked.
    #[strum(serialize = "min-detection")]
    MinDetection,
}

impl Axis {
    /// All axes, the default first.
    pub const ALL: &'static [Self] = Self::VARIANTS;

    /// The axis with this name.
    ///
    /// # Errors
    /// The name is unknown; the message suggests the nearest known one.
    pub fn named(name: &str) -> Result<Self> {
        let mut all = Self::ALL.iter().copied();
        all.find(|axis| axis.name() == name).ok_or_else(|| {
            let axes = Self::ALL.iter().map(|axis| axis.name());
            let names: Vec<_> = axes.chain([ROBOTS_DOWN]).collect();
            Error::usage(
                "'sweep_axis'",
                format!("`{}` cannot be swept", shown(name)),
                known_names(name, &names),
            )
        })
    }

    /// The name: `speed`, `robots`, `spacing`, `reach` or `min-detection`.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether larger values help. If so, everything is picked from some value on, rather than
    /// up to one.
    pub fn helps(self) -> bool {
        matches!(self, Self::Robots | Self::Reach | Self::MinDetection)
    }

    /// The unit of the values: `m/s`, `m`, or `1` for robots and probabilities.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Speed => "m/s",
            Self::Robots | Self::MinDetection => "1",
            Self::Spacing | Self::Reach => "m",
        }
    }
}

/// One value of the sweep: the line with this value, and the methods on it.
#[derive(Debug, Clone)]
pub struct Setting {
    /// The varied quantity, in the unit of its [`Axis`].
    pub value: f64,
    /// The station at this value.
    pub station: Station,
    /// Items with a lower `p_detection` are left on the belt; `None` for the threshold of the
    /// sweep's conditions.
    pub min_detection: Option<f64>,
    /// The methods, of the same kinds in the same order at every value.
    pub methods: Vec<Method>,
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
    let least = setting.min_detection.unwrap_or(conditions.min_detection);
    let conditions = conditions.with_min_detection(least);
    let scene = Scene::under(&setting.station, pattern, conditions)?;
    let methods = setting.methods.iter();
    let runs = methods.map(|method| method.run(&scene, environment));
    let runs: Vec<MethodRun> = runs.collect::<Result<_>>()?;
    let bound = || {
        let runs: Vec<&MethodRun> = runs.iter().collect();
        PatternBound::beside(&runs, &scene, environment)
    };
    let bound = bounded.then(bound).transpose()?;
    Ok(Runs { runs, bound })
}

/// The runs at one value on pattern `place`, known or made; `None` if they are missing in a part of the
/// shards. Random events are drawn from the conditions' seed + `place`.
fn runs_at(
    setting: &Setting,
    (place, pattern): (usize, &Pattern),
    conditions: &Conditions,
    bounded: bool,
    environment: &Environment,
) -> Result<Option<Runs>> {
    let name = format!("runs at {}", setting.value);
    environment.ledger.unit(&name, place, || {
        let seed = conditions.disturbances.seed.wrapping_add(place as u64);
        let conditions = conditions.with_seed(seed);
        run_methods(setting, pattern, conditions, bounded, environment)
    })
}

/// Runs all methods at one value, as [`sweep_settings`] does, on those patterns of `places` only, in a
/// shard, whose ledger records them.
///
/// # Errors
/// As for [`sweep_settings`].
pub fn sweep_in_shard(
    setting: &Setting,
    (patterns, places): (&[Pattern], Range<usize>),
    conditions: &Conditions,
    bounded: bool,
    environment: &Environment,
) -> Result<()> {
    let own = places
        .into_par_iter()
        .map(|place| (place, &patterns[place]));
    own.try_for_each(|own| {
        runs_at(setting, own, conditions, bounded, environment)?;
        environment.progress.advance(1);
        Ok(())
    })
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
    let mut values: Vec<SweepValue> = Vec::with_capacity(settings.len());
    let mut steadiness: Vec<Vec<Steadiness>> = Vec::new();
    for setting in settings {
        let run = |own| runs_at(setting, own, conditions, bounded, environment).transpose();
        let by_pattern = patterns.par_iter().enumerate().map(run);
        let by_pattern: Option<Result<Vec<Runs>>> = by_pattern.collect();
        let by_pattern = match by_pattern.transpose() {
            Err(error) if error.is_interrupted() && !values.is_empty() => break,
            by_pattern => by_pattern?,
        };
        // Missing in a part of the shards.
        let Some(by_pattern) = by_pattern else {
            continue;
        };
        let of_method = |i: usize| by_pattern.iter().map(move |runs| &runs.runs[i].steady);
        let methods = 0..setting.methods.len();
        steadiness.extend(methods.map(|i| of_method(i).cloned().collect()));
        values.push(SweepValue {
            value: setting.value,
            methods: summarise_methods(&setting.methods, &by_pattern),
            bound: summarise_bounds(&by_pattern),
            arms_meet: clearance::apart(&setting.station).is_doubtful(),
        });
        environment.progress.advance(1);
    }
    environment.progress.end();
    if values.is_empty() {
        return Err(none_complete("value"));
    }
    // All values use the same patterns.
    let runs: Vec<Vec<&Steadiness>> = steadiness.iter().map(|of| of.iter().collect()).collect();
    let throughputs = Throughput::beside(&runs);
    let points = values.iter_mut().flat_map(|value| &mut value.methods);
    for (point, throughput) in points.zip(throughputs) {
        point.throughput = throughput;
    }
    Ok(Sweep {
        values,
        planned: settings.len(),
        weighs: settings
            .iter()
            .any(|setting| patterns.iter().any(|p| p.weighs_on(&setting.station))),
    })
}

/// All methods on one pattern at one value.
#[derive(Serialize, Deserialize)]
struct Runs {
    runs: Vec<MethodRun>,
    bound: Option<PatternBound>,
}

/// The figures of every method at one value.
fn summarise_methods(methods: &[Method], by_pattern: &[Runs]) -> Vec<SweepPoint> {
    let bounds = by_pattern.iter().map(|runs| runs.bound.as_ref());
    let most: Option<f64> = bounds.map(|bound| bound.map(|bound| bound.picks)).sum();
    let of_classes = by_pattern.iter().filter_map(|runs| runs.bound.as_ref());
    let of_classes: Vec<Vec<ClassBound>> = of_classes.map(|bound| bound.classes.clone()).collect();
    let point = |(i, method): (usize, &Method)| {
        let runs: Vec<&MethodRun> = by_pattern.iter().map(|runs| &runs.runs[i]).collect();
        let classes = runs.iter().map(|run| run.classes.as_slice());
        let classes = class_results(classes, most.map(|_| of_classes.as_slice()));
        SweepPoint {
            classes,
            ..summarise(method, &runs, most)
        }
    };
    methods.iter().enumerate().map(point).collect()
}

fn summarise_bounds(by_pattern: &[Runs]) -> Option<SweepBound> {
    let bounds = by_pattern.iter().map(|runs| runs.bound.as_ref());
    let bounds: Vec<&PatternBound> = bounds.collect::<Option<_>>()?;
    let figures = by_pattern.iter().map(|runs| runs.runs[0].figures);
    let rates: Option<Vec<f64>> = bounds.iter().map(|bound| bound.rate).collect();
    let shares = bounds.iter().zip(figures);
    let shares: Vec<f64> = shares.map(|(b, run)| run.share_of(b.picks)).collect();
    Some(SweepBound {
        picked_share: stats::mean(&shares),
        picking_rate: rates.map(|rates| stats::mean(&rates)),
    })
}

/// The figures of `method` in `runs`, in which no strategy picks more than `most` items in total.
fn summarise(method: &Method, runs: &[&MethodRun], most: Option<f64>) -> SweepPoint {
    let figures: Vec<Figures> = runs.iter().map(|run| run.figures).collect();
    let all = |of: &dyn Fn(&Figures) -> f64| -> Vec<f64> { figures.iter().map(of).collect() };
    let shares = picked_shares(&figures);
    let rates = all(&Figures::picking_rate);
    let contents: Option<Vec<_>> = runs.iter().map(|run| run.contents.as_ref()).collect();
    let of_patterns = |holds: &dyn Fn(&Figures) -> bool| {
        figures.iter().filter(|run| holds(run)).count() as f64 / runs.len() as f64
    };
    SweepPoint {
        method: method.id().to_owned(),
        title: method.title(),
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
        purity: contents.and_then(|contents| PurityByBin::of(&contents)),
        complete: figures.iter().map(Figures::complete).collect(),
        classes: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_have_names_and_units() {
        for (axis, name, unit, helps) in [
            (Axis::Speed, "speed", "m/s", false),
            (Axis::Robots, "robots", "1", true),
            (Axis::Spacing, "spacing", "m", false),
            (Axis::Reach, "reach", "m", true),
            (Axis::MinDetection, "min-detection", "1", true),
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
