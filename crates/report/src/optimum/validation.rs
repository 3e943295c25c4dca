//! The winner of a search on fresh patterns.

use crate::table::{fixed, interval};
use pickline::optimize::Validation;
use pickline::stats::Interval;
use serde::Serialize;

/// The winner on patterns that played no part in choosing it.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ValidationReport {
    /// Description of the patterns.
    pub patterns: String,
    /// Number of fresh patterns.
    pub count: usize,
    /// Mean of the objective over the fresh patterns, in its unit.
    pub mean: f64,
    /// 95 % interval of that mean; `None` for a single pattern.
    #[serde(flatten, serialize_with = "crate::ends::mean")]
    pub mean_interval: Option<Interval>,
    /// The objective aggregated under the risk used in the search.
    pub value: f64,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// The objective on the worst pattern.
    pub worst: f64,
    /// Belt speed at which completion was counted [m/s].
    pub speed: f64,
    /// Number of patterns that were picked completely.
    pub complete: usize,
    /// Their share of the patterns: the task-completion share.
    pub complete_share: f64,
    /// 95 % interval of that share.
    #[serde(flatten, serialize_with = "crate::ends::complete")]
    pub complete_interval: Interval,
    /// Its picks compared with the bound for every strategy; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bound: Option<CertificateReport>,
}

/// Picks compared with the bound for every strategy.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct CertificateReport {
    /// Number of patterns with a bound: the first of those above.
    pub patterns: usize,
    /// Upper bound on the share of their items that can be picked.
    pub picked_share: f64,
    /// Picks on these patterns as a proven share of the optimum [%], rounded down.
    pub certified_percent: f64,
}

impl ValidationReport {
    /// The report of `validation` on the patterns described by `patterns`.
    pub fn new(validation: &Validation, patterns: &str) -> Self {
        Self {
            patterns: patterns.to_owned(),
            count: validation.patterns,
            mean: validation.value,
            mean_interval: validation.interval,
            value: validation.at_risk,
            picked_share: validation.picked_share,
            worst: validation.worst,
            speed: validation.speed,
            complete: validation.complete,
            complete_share: validation.complete_share(),
            complete_interval: validation.complete_interval,
            bound: validation.certificate.as_ref().map(|c| CertificateReport {
                patterns: c.patterns,
                picked_share: c.picked_share,
                certified_percent: c.percent,
            }),
        }
    }

    pub(super) fn lines(&self, digits: usize, unit: &str, risk: &str) -> String {
        let at_risk = match risk {
            // Already printed.
            "mean" | "worst" => String::new(),
            _ => format!(", {risk} {}", fixed(self.value, digits)),
        };
        let interval = self.mean_interval.map_or(String::new(), |ends| {
            format!(" (95 % interval {})", interval(Some(ends), digits))
        });
        format!(
            "validated mean {}{unit}{interval}{at_risk}, worst {}, {} % picked\n          \
             task completion at {} m/s: {} of {} patterns fully picked, {} % (95 % interval {} to {} %)\n          \
             on {}\n{}",
            fixed(self.mean, digits),
            fixed(self.worst, digits),
            fixed(100.0 * self.picked_share, 1),
            self.speed,
            self.complete,
            self.count,
            fixed(100.0 * self.complete_share, 1),
            fixed(100.0 * self.complete_interval.low, 1),
            fixed(100.0 * self.complete_interval.high, 1),
            self.patterns,
            self.bound.as_ref().map_or(String::new(), |bound| format!(
                "certified at least {} % of the picks that the best strategy could make (bounded: the first {} of these)\n",
                fixed(bound.certified_percent, 1),
                bound.patterns
            ))
        )
    }
}
