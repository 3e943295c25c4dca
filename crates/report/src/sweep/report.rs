//! A sweep: figures over one varied quantity, and up to which value everything is picked.

use super::thresholds::ThresholdsReport;
use crate::classes::ClassReport;
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::purity::{PageGroup, PurityByBinReport, PurityRow};
use crate::throughput::ThroughputReport;
use pickline::error::spell_settings;
use pickline::experiment::{
    Axis, Limit, Sweep, SweepPoint, SweepValue, SweptMethod, ThresholdChoices, paper,
};
use pickline::stats::{self, Interval};
use pickline::study::Swept;
use pickline::throughput::UnsteadyReason;
use serde::Serialize;

/// A sweep as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct SweepReport {
    /// Name of the varied quantity: `speed`, `robots`, `spacing`, `reach` or `min-detection`.
    pub sweep: &'static str,
    /// Unit of the varied quantity.
    pub unit: &'static str,
    /// Number of patterns at each value.
    pub patterns: usize,
    /// All points, ordered by value, then by method.
    pub points: Vec<PointReport>,
    /// Up to which value each method picks everything.
    pub limits: Vec<LimitReport>,
    /// What no strategy can exceed, for each value; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounds: Option<BoundsReport>,
    /// The threshold of detections for each method; omitted without a wanted purity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub thresholds: Option<ThresholdsReport>,
    /// The paper's limits, if they are comparable with ours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper: Option<PaperLimits>,
    /// Remarks on how the figures are to be read.
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    /// The values at which arms can meet.
    pub arms_can_meet: Vec<f64>,
    /// Number of planned values; more than were run if the user stopped the sweep.
    #[serde(skip)]
    pub(super) planned: usize,
    #[serde(skip)]
    pub(super) helps: bool,
    #[serde(skip)]
    pub(super) weighs: bool,
}

/// One method at one value.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct PointReport {
    /// The varied quantity, in its unit.
    pub value: f64,
    /// The method's name in files.
    pub method: String,
    /// Its name in tables at this value.
    pub title: String,
    /// Picks per minute in the steady state.
    #[serde(flatten)]
    pub throughput: ThroughputReport,
    /// Throughput minus that at the previous value, per robot; omitted unless robots are swept.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub added_per_robot_per_min: Option<f64>,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// 95 % interval of that share; `None` for a single pattern, as for the rate.
    #[serde(flatten, serialize_with = "crate::ends::picked_share")]
    pub picked_share_interval: Option<Interval>,
    /// Mean picks per minute.
    pub picking_rate_per_min: f64,
    /// 95 % interval of that rate [1/min].
    #[serde(flatten, serialize_with = "crate::ends::picking_rate")]
    pub picking_rate_interval: Option<Interval>,
    /// Mean reward-weighted picks per minute.
    pub weighted_rate_per_min: f64,
    /// Share of the patterns that were picked completely.
    pub complete_share: f64,
    /// Share of the patterns of which at least 99 % was picked.
    pub nearly_complete_share: f64,
    /// Picks over all patterns as a proven share of the optimum [%]; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certified_percent: Option<f64>,
    /// Purity and recovery of the bins; omitted unless detections may be wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sorting: Option<PurityByBinReport>,
    /// What it picked of each class; omitted if no item has a class that matters on the station.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub classes: Vec<ClassReport>,
}

/// What no strategy can exceed, along a sweep.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct BoundsReport {
    /// The values at which no strategy picks every item of every pattern (proven).
    pub impossible: Vec<f64>,
    /// One point per value.
    pub points: Vec<BoundPoint>,
}

/// What no strategy can exceed at one value.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct BoundPoint {
    /// The varied quantity, in its unit.
    pub value: f64,
    /// Mean of the most items that can be picked, as a share of the items.
    pub picked_share: f64,
    /// Mean of the highest possible rates [1/min]; `None` if some pattern has no finite bound.
    pub picking_rate_per_min: Option<f64>,
}

impl BoundsReport {
    /// The report of the bounds at `values`, if they were requested.
    fn new(values: &[SweepValue]) -> Option<Self> {
        let bounds = values.iter().map(|at| Some((at.value, at.bound.as_ref()?)));
        let bounds: Vec<_> = bounds.collect::<Option<_>>()?;
        let points = bounds.iter();
        Some(Self {
            impossible: points
                .clone()
                .filter(|(_, bound)| !bound.complete())
                .map(|(value, _)| *value)
                .collect(),
            points: points
                .map(|(value, bound)| BoundPoint {
                    value: *value,
                    picked_share: bound.picked_share,
                    picking_rate_per_min: bound.picking_rate,
                })
                .collect(),
        })
    }
}

/// Up to which value one method picks everything.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct LimitReport {
    /// The method's name in files.
    pub method: String,
    /// Highest value up to which every item of every pattern is picked.
    pub highest: Option<f64>,
    /// First value at which an item is missed.
    pub first_miss: Option<f64>,
    /// Values above that at which everything is picked again.
    pub again: Vec<f64>,
    /// Lowest value from which every item of every pattern is picked.
    pub lowest: Option<f64>,
    /// Highest value up to which at least 99 % is picked of 95 % of the patterns.
    pub highest_95_99: Option<f64>,
    /// Minimum, median and maximum of the limits of single patterns; 0 is below the sweep.
    pub of_patterns: [f64; 3],
    /// The limits of single patterns in ascending order, if there are several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub all_of_patterns: Vec<f64>,
    /// Excess over the first method's limit [%].
    pub benefit_percent: Option<f64>,
    /// The recommended value; `None` in a sweep of the belt speed, without a throughput, and if
    /// arms can meet at every value.
    pub recommended: Option<f64>,
}

/// The paper's belt speed limits on the grid of 0.15 m.
#[derive(Debug, Clone, Copy, Serialize)]
#[non_exhaustive]
pub struct PaperLimits {
    /// Limit of robust game theory (GT) [m/s].
    pub robust_gt: f64,
    /// Limit of the policy of reinforcement learning (RL) [m/s].
    pub rl: f64,
    /// Excess of the RL policy's limit over robust GT's [%].
    pub benefit_percent: f64,
}

/// A note that limits on short patterns are not limits of the line, if there are any.
fn short_limit(sweep: &Sweep) -> Option<String> {
    let mut points = sweep.values.iter().flat_map(|at| &at.methods);
    let enough = points
        .clone()
        .filter_map(|point| match point.throughput.missing {
            Some(UnsteadyReason::Short { items, .. }) => items,
            _ => None,
        });
    let enough = match enough.max() {
        Some(items) => format!("{items} items or more"),
        None => "more items".to_owned(),
    };
    let short = |point: &SweepPoint| {
        let missing = &point.throughput.missing;
        point.throughput.mean.is_none() && matches!(missing, Some(UnsteadyReason::Short { .. }))
    };
    points.any(short).then(|| {
        format!(
            "a limit on patterns as short as these is that of the patterns: the line picks \
             everything of a few items also where it cannot keep up with their flow for long; for the \
             limit of the line give patterns of {enough} ('items')"
        )
    })
}

impl PointReport {
    /// The report of a method at `value`. With `fewer`, the same method with fewer robots, it says
    /// what a further robot adds.
    fn new(value: f64, point: &SweepPoint, fewer: Option<(f64, &SweepPoint)>) -> Self {
        let added = || {
            let (robots, before) = fewer?;
            let (here, before) = (&point.throughput, &before.throughput);
            // The flow differs only if other patterns have a steady state.
            let share = here.share()? - before.share()?;
            Some(share * here.flow? / (value - robots))
        };
        Self {
            value,
            method: point.method.clone(),
            title: point.title.clone(),
            throughput: ThroughputReport::new(&point.throughput),
            added_per_robot_per_min: added(),
            picked_share: point.picked_share,
            picked_share_interval: point.picked_share_interval,
            picking_rate_per_min: point.picking_rate,
            picking_rate_interval: point.picking_rate_interval,
            weighted_rate_per_min: point.weighted_rate,
            complete_share: point.complete_share,
            nearly_complete_share: point.nearly_complete_share,
            certified_percent: point.certified,
            sorting: point.purity.as_ref().map(PurityByBinReport::new),
            classes: ClassReport::all(&point.classes),
        }
    }
}

impl LimitReport {
    /// The report of the limits of `method` on `axis`; `first` is the limit of the first method if
    /// this is another one.
    fn new(method: &SweptMethod, axis: Axis, first: Option<f64>) -> Self {
        let Limit {
            highest,
            first_miss,
            again,
            lowest,
            ..
        } = method.complete();
        let mut of_patterns = method.limits();
        of_patterns.sort_by(f64::total_cmp);
        Self {
            method: method.name().to_owned(),
            highest,
            first_miss,
            again,
            lowest,
            highest_95_99: method.nearly_complete(0.95).highest,
            of_patterns: [0.0, 0.5, 1.0].map(|share| stats::quantile(&of_patterns, share)),
            all_of_patterns: match of_patterns.len() {
                1 => Vec::new(),
                _ => of_patterns,
            },
            benefit_percent: first
                .zip(highest)
                .filter(|_| !axis.helps())
                .map(|(first, this)| 100.0 * (this / first - 1.0)),
            recommended: match axis {
                Axis::Speed | Axis::MinDetection => None,
                _ => method.recommended(),
            },
        }
    }
}

/// Every method at every value, ordered by value, then by method.
fn points(sweep: &Sweep, axis: Axis) -> Vec<PointReport> {
    let mut points = Vec::new();
    let mut before: Option<&SweepValue> = None;
    for at in &sweep.values {
        for (place, point) in at.methods.iter().enumerate() {
            let fewer = before.filter(|_| axis == Axis::Robots);
            let fewer = fewer.map(|fewer| (fewer.value, &fewer.methods[place]));
            points.push(PointReport::new(at.value, point, fewer));
        }
        before = Some(at);
    }
    points
}

impl SweepReport {
    /// The report of a study over `axis`, made as `made` says, which is completed by how far it got.
    /// `with_paper` is as for [`SweepReport::new`].
    pub fn of_study(
        swept: &Swept,
        axis: Axis,
        with_paper: bool,
        shown: &Presentation,
        made: Provenance,
    ) -> Self {
        let sweep = &swept.sweep;
        let made = made.of_parts(sweep.values.len(), sweep.planned, "values");
        let notes = shown.notes(&swept.notes);
        Self::new(sweep, axis, with_paper, notes, shown.spelling, made)
            .with_thresholds(swept.thresholds.as_ref())
    }

    /// The report of `sweep` over `axis`. `with_paper`: this is the paper's case; notes call
    /// settings what `spelling` makes of their names.
    pub fn new(
        sweep: &Sweep,
        axis: Axis,
        with_paper: bool,
        notes: Vec<String>,
        spelling: fn(&str) -> String,
        made: Provenance,
    ) -> Self {
        let points = points(sweep, axis);
        let throughputs = points.iter().map(|point| &point.throughput);
        let mut notes = notes;
        notes.extend(ThroughputReport::note(throughputs));
        let short = short_limit(sweep).filter(|_| axis == Axis::Speed);
        notes.extend(short.map(|note| spell_settings(&note, spelling)));
        let meet = sweep.values.iter().filter(|at| at.arms_meet);
        let methods: Vec<SweptMethod> = sweep.methods().collect();
        let first = methods.first().and_then(|first| first.complete().highest);
        let limits = methods.iter().enumerate().map(|(place, method)| {
            let first = first.filter(|_| place > 0);
            LimitReport::new(method, axis, first)
        });
        let (robust_gt, rl) = paper::SPEED_LIMITS;
        Self {
            planned: sweep.planned,
            helps: axis.helps(),
            sweep: axis.name(),
            unit: axis.unit(),
            patterns: methods.first().map_or(0, |first| first.limits().len()),
            points,
            arms_can_meet: meet.map(|at| at.value).collect(),
            weighs: sweep.weighs,
            limits: limits.collect(),
            bounds: BoundsReport::new(&sweep.values),
            thresholds: None,
            paper: with_paper.then(|| PaperLimits {
                robust_gt,
                rl,
                benefit_percent: 100.0 * (rl / robust_gt - 1.0),
            }),
            notes,
            made,
        }
    }

    /// The same with the thresholds that were chosen, if any.
    #[must_use]
    pub fn with_thresholds(mut self, choices: Option<&ThresholdChoices>) -> Self {
        self.thresholds = choices.map(ThresholdsReport::new);
        self
    }

    /// Whether the threshold of detections is varied, so that only the items above it count as
    /// those to be picked.
    pub(super) fn is_of_thresholds(&self) -> bool {
        self.sweep == Axis::MinDetection.name()
    }

    /// Whether detections may be wrong, so that bins have a purity.
    pub(super) fn has_purity(&self) -> bool {
        self.points.iter().any(|point| point.sorting.is_some())
    }

    /// The purities of every point, as rows of a table.
    pub(super) fn purities(&self) -> Vec<Vec<PurityRow<'_>>> {
        let methods = self.limits.len();
        let points = self.points.iter().enumerate();
        let rows = points.filter_map(|(i, point)| {
            let purity = point.sorting.as_ref()?;
            let group = match i % methods {
                0 => PageGroup::Value(point.value, format!("points.{i}.value")),
                _ => PageGroup::Words(String::new()),
            };
            let path = format!("points.{i}.sorting");
            Some(PurityRow::all(group, &point.title, purity, &path))
        });
        rows.collect()
    }

    /// The varied quantity with its unit, as the header of a table.
    pub(super) fn varied(&self) -> String {
        match self.unit {
            "1" => self.sweep.to_owned(),
            unit => format!("{} [{unit}]", self.sweep),
        }
    }

    /// Every class of every method at every value.
    pub(super) fn classes(&self) -> impl Iterator<Item = &ClassReport> {
        self.points.iter().flat_map(|point| &point.classes)
    }

    /// Whether there is a throughput at some point.
    pub(super) fn is_steady(&self) -> bool {
        let mut points = self.points.iter();
        points.any(|point| point.throughput.throughput_per_min.is_some())
    }

    /// Whether it is known how much a further robot adds.
    pub(super) fn adds(&self) -> bool {
        let mut points = self.points.iter();
        points.any(|point| point.added_per_robot_per_min.is_some())
    }

    /// The unit as written after a value.
    pub(super) fn unit_word(&self) -> &'static str {
        match self.unit {
            "1" => self.sweep,
            unit => unit,
        }
    }
}
