//! A certified bound.

use crate::presentation::Presentation;
use crate::provenance::Provenance;
use pickline::decision::Figures;
use pickline::planning::bound::{Bound, certified_percent};
use pickline::sim::Scene;
use pickline::study::PatternBounds;
use serde::Serialize;

/// A bound as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct BoundReport {
    /// Number of items in the pattern.
    pub items: usize,
    /// Number of those that are to be picked; omitted if all are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wanted: Option<usize>,
    /// Items within reach of at least one robot.
    pub reachable: usize,
    /// Upper bound on the picks of every strategy.
    pub picks_upper_bound: usize,
    /// The same bound before rounding down to a whole number.
    pub picks_relaxed: f64,
    /// Upper bound on the sum of weights picked by any strategy; `None` if it was not requested
    /// and does not follow from the picks.
    pub weight_upper_bound: Option<f64>,
    /// Upper bound on the picking rate of every strategy [1/min]; `None` if no finite bound was
    /// found.
    pub picking_rate_upper_bound_per_min: Option<f64>,
    /// Upper bound on the weighted rate of every strategy [1/min].
    pub weighted_rate_upper_bound_per_min: Option<f64>,
    /// Lower bound on the end of every run [s].
    pub end_lower_bound_s: f64,
    /// Whether everything can be picked: `yes` (a schedule does so), `no` (proven) or `open`.
    pub all_picked: &'static str,
    /// Lower bound on the end of every run that picks everything [s]; `None` if there is no
    /// such run.
    pub all_picked_end_lower_bound_s: Option<f64>,
    /// The best schedule found during the search.
    pub schedule: Option<ScheduleReport>,
    /// Length of a time slot [s].
    pub slot_s: f64,
    /// Number of picks in time slots.
    pub arcs: usize,
    /// Steps of the prices: for picks and, if requested, for weight.
    pub iterations: usize,
    /// `optimal`: the schedule reaches the bound; `done`; `interrupted`: the bound still holds;
    /// `too_many_items`: time slots would be too coarse to be useful.
    pub stop_reason: &'static str,
    /// Remarks on how the figures are to be read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    #[serde(skip)]
    pub(super) prices: Vec<(String, f64)>,
    /// Whether items have different weights, or the bound on weight was requested.
    #[serde(skip)]
    pub(super) weighs: bool,
}

/// A schedule confirmed by the independent checker.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ScheduleReport {
    /// Number of items picked.
    pub picked: usize,
    /// Sum of the weights of those items.
    pub weight: f64,
    /// End of the schedule [s].
    pub end_s: f64,
    /// Picks per minute of the schedule.
    pub picking_rate_per_min: f64,
    /// Weighted picks per minute of the schedule.
    pub weighted_rate_per_min: f64,
    /// Picks of the schedule as a proven share of the optimum [%].
    pub certified_percent: f64,
}

impl ScheduleReport {
    /// The report of a schedule with these `figures`, found in the search for `bound`.
    fn new(figures: &Figures, bound: &Bound) -> Self {
        Self {
            picked: figures.picked,
            weight: figures.weight,
            end_s: figures.end,
            picking_rate_per_min: figures.picking_rate(),
            weighted_rate_per_min: figures.weighted_rate(),
            certified_percent: certified_percent(bound.earned(figures), bound.value),
        }
    }
}

impl BoundReport {
    /// The report of a study of the pattern of `scene`.
    pub fn of_study(
        found: &PatternBounds,
        scene: &Scene,
        shown: &Presentation,
        made: Provenance,
    ) -> Self {
        Self {
            notes: shown.notes(&found.notes),
            ..Self::new(scene, &found.picks, found.weight.as_ref(), made)
        }
    }

    /// The report of the bound on `picks` for `scene`, with the bound on `weight` if it was
    /// requested.
    pub fn new(scene: &Scene, picks: &Bound, weight: Option<&Bound>, made: Provenance) -> Self {
        let pattern = scene.pattern();
        let main = weight.unwrap_or(picks);
        // If all items weigh the same, weight is picks in another unit.
        let station = scene.station();
        let wanted = pattern.items().iter();
        let wanted = wanted.filter(|item| station.takes(item.class_on(station)));
        let mut weights = wanted.map(|item| item.weight_on(station));
        let first = weights.next().unwrap_or_default();
        let equal = weights.all(|weight| weight == first);
        // Rounded up by more than the product's rounding error.
        let as_weight = |picks: f64| first * picks * (1.0 + 1e-12);
        let least = |found: Option<f64>, follows: Option<f64>| match (found, follows) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        let schedule = main.schedule.as_ref();
        let complete = [Some(picks), weight].into_iter().flatten().any(|bound| {
            let figures = bound.schedule.as_ref().map(|s| s.figures);
            figures.is_some_and(|figures| figures.complete())
        });
        // Both bounds hold, so the tighter one counts.
        let ends = [Some(picks), weight].into_iter().flatten();
        let end = ends.clone().map(|bound| bound.end).fold(0.0, f64::max);
        let all_end = ends.map(|bound| bound.all_end.unwrap_or(f64::INFINITY));
        let all_end = all_end.fold(0.0, f64::max);
        Self {
            items: pattern.len(),
            wanted: (!scene.left().is_empty()).then(|| pattern.len() - scene.left().len()),
            reachable: picks.reachable,
            picks_upper_bound: picks.value as usize,
            picks_relaxed: picks.relaxed,
            weight_upper_bound: least(
                weight.map(|bound| bound.value),
                equal.then(|| as_weight(picks.value)),
            ),
            picking_rate_upper_bound_per_min: picks.rate,
            weighted_rate_upper_bound_per_min: least(
                weight.and_then(|bound| bound.rate),
                picks.rate.filter(|_| equal).map(as_weight),
            ),
            end_lower_bound_s: end,
            all_picked: match all_end.is_finite() {
                _ if complete || scene.offered() == 0 => "yes",
                true => "open",
                false => "no",
            },
            all_picked_end_lower_bound_s: Some(all_end).filter(|end| end.is_finite()),
            schedule: schedule.map(|outcome| ScheduleReport::new(&outcome.figures, main)),
            slot_s: main.slot_s,
            arcs: main.arcs,
            iterations: picks.iterations + weight.map_or(0, |bound| bound.iterations),
            stop_reason: main.stop.name(),
            notes: Vec::new(),
            made,
            weighs: weight.is_some() || pattern.weighs_on(station),
            prices: pattern
                .items()
                .iter()
                .map(|item| item.id.clone())
                .zip(main.prices.iter().copied())
                .collect(),
        }
    }
}
