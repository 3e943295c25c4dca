//! Runs and cases compared with their bound.

use super::rounding::rounded_up;
use crate::presentation::Presentation;
use crate::table::fixed;
use pickline::decision::Figures;
use pickline::experiment::CaseBound;
use pickline::planning::bound::{Bound, BoundStop, certified_percent};
use pickline::stats::Interval;
use serde::Serialize;

/// A run compared with the bound of its pattern.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct CertifiedReport {
    /// Upper bound on the picks of every strategy.
    pub picks_upper_bound: usize,
    /// Picks of the run as a proven share of the optimum [%], rounded down.
    pub certified_percent: f64,
    /// Upper bound on the picking rate of every strategy [1/min].
    pub picking_rate_upper_bound_per_min: Option<f64>,
    /// The run's rate as a proven share of the highest rate [%], rounded down.
    pub certified_rate_percent: Option<f64>,
    /// Whether the proof was cut short, so that `pickline bound` would prove more; omitted if
    /// not.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub cut_short: bool,
}

impl CertifiedReport {
    /// Compares `figures` with `bound`, a bound on picks.
    pub fn new(figures: &Figures, bound: &Bound) -> Self {
        let rate = figures.picking_rate();
        Self {
            picks_upper_bound: bound.value as usize,
            certified_percent: certified_percent(bound.earned(figures), bound.value),
            picking_rate_upper_bound_per_min: bound.rate,
            certified_rate_percent: bound.rate.map(|most| certified_percent(rate, most)),
            cut_short: bound.coarse && bound.stop != BoundStop::Optimal,
        }
    }

    /// One line for the terminal.
    pub(crate) fn line(&self, shown: &Presentation) -> String {
        let rate = match (
            self.certified_rate_percent,
            self.picking_rate_upper_bound_per_min,
        ) {
            (Some(percent), Some(most)) => format!(
                "; its rate at least {} % (at most {} picks/min)",
                fixed(percent, 1),
                rounded_up(most, 2)
            ),
            _ => String::new(),
        };
        let cut_short = match self.cut_short {
            true => shown.spelled(
                "          cut short to save time: `pickline bound` searches longer \
                 and proves more; a shorter 'slot' helps further\n",
            ),
            false => String::new(),
        };
        format!(
            "certified at least {} % of the optimum (no strategy picks more than {}){rate}\n{cut_short}",
            fixed(self.certified_percent, 1),
            self.picks_upper_bound
        )
    }
}

/// The bound for one case of a comparison.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct CaseBoundReport {
    /// Mean of the most items that can be picked from a pattern.
    pub picks_upper_bound: f64,
    /// The same as a share of the items.
    pub picked_share: f64,
    /// Mean of the highest possible rates [1/min].
    pub picking_rate_per_min: Option<f64>,
    /// 95 % interval of that mean minus the first method's rate, paired over patterns; `None`
    /// for a single pattern.
    pub difference: Option<Interval>,
    /// Excess over the first method's mean rate [%].
    pub benefit_percent: Option<f64>,
}

impl CaseBoundReport {
    pub(crate) fn new(bound: &CaseBound) -> Self {
        Self {
            picks_upper_bound: bound.picks.iter().sum::<usize>() as f64 / bound.picks.len() as f64,
            picked_share: bound.picked_share,
            picking_rate_per_min: bound.picking_rate,
            difference: bound.difference,
            benefit_percent: bound.benefit.map(|benefit| 100.0 * benefit),
        }
    }
}
