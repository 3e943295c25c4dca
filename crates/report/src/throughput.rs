//! Throughput as shown in the reports of all commands.

use super::csv_rows::{Displayed, OptionalNumber, high, low};
use super::table::{fixed, interval};
use pickline::stats::Interval;
use pickline::throughput::Throughput;
use serde::Serialize;

/// Picks per minute in the steady state; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ThroughputReport {
    /// Mean picks per minute in the steady state; `None` without a steady state.
    pub throughput_per_min: Option<f64>,
    /// 95 % interval of the throughput [1/min].
    #[serde(flatten, serialize_with = "crate::ends::throughput")]
    pub interval: Option<Interval>,
    /// Items that arrive per minute.
    pub flow_per_min: Option<f64>,
    /// For each robot, upstream first: the share of the time it is busy while the items of the
    /// steady state pass it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub utilisation_steady: Vec<f64>,
    /// Number of patterns on which the run has a steady state.
    pub steady_patterns: usize,
    /// Why there is no throughput, and what to do about it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_throughput: Option<String>,
    /// Whether the flow changes over the pattern, so that the throughput is a mean over it;
    /// omitted if not.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub flow_changes: bool,
    #[serde(skip)]
    pub(crate) note: Option<String>,
}

/// Throughput in CSV files.
#[derive(Debug, Default, Serialize)]
pub(crate) struct ThroughputColumns {
    throughput_per_min: OptionalNumber,
    throughput_low_per_min: OptionalNumber,
    throughput_high_per_min: OptionalNumber,
    flow_per_min: OptionalNumber,
}

impl ThroughputReport {
    /// The report of `throughput`.
    pub fn new(throughput: &Throughput) -> Self {
        let reason = throughput.missing.as_ref();
        let missing = reason.map(|reason| match throughput.runs {
            1 => reason.to_string(),
            runs if throughput.mean.is_some() => format!(
                "over {} of {runs} patterns; on the first of the others {reason}",
                throughput.steady
            ),
            runs => format!(
                "{} of {runs} patterns have no steady state; on the first of them {reason}",
                runs - throughput.steady
            ),
        });
        let flow_changes = throughput.mean.is_some() && throughput.changing > 0;
        let changing = flow_changes.then(|| match (throughput.changing, throughput.runs) {
            (_, 1) => "the flow changes over the pattern; this is the mean over it".to_owned(),
            (changing, runs) => format!(
                "the flow changes over the pattern on {changing} of {runs} patterns; there it is \
                 the mean over the pattern"
            ),
        });
        let note = [&missing, &changing];
        let note: Vec<&str> = note.into_iter().flatten().map(String::as_str).collect();
        let note = (!note.is_empty()).then(|| note.join("; "));
        Self {
            throughput_per_min: throughput.mean,
            interval: throughput.interval,
            flow_per_min: throughput.flow,
            utilisation_steady: throughput.utilisation.clone(),
            steady_patterns: throughput.steady,
            no_throughput: missing.filter(|_| throughput.mean.is_none()),
            flow_changes,
            note,
        }
    }

    /// The figures in CSV files.
    pub(crate) fn columns(&self) -> ThroughputColumns {
        ThroughputColumns {
            throughput_per_min: self.throughput_per_min.map(Displayed),
            throughput_low_per_min: low(self.interval),
            throughput_high_per_min: high(self.interval),
            flow_per_min: self.flow_per_min.map(Displayed),
        }
    }

    /// The figure in a table; a dash for `None`.
    pub(crate) fn shown(&self, digits: usize) -> String {
        let value = self.throughput_per_min;
        value.map_or("-".to_owned(), |value| fixed(value, digits))
    }

    /// The 95 % interval in a table.
    pub(crate) fn shown_interval(&self, digits: usize) -> String {
        interval(self.interval, digits)
    }

    /// The flow in a table.
    pub(crate) fn flow(&self, digits: usize) -> String {
        let value = self.flow_per_min;
        value.map_or("-".to_owned(), |value| fixed(value, digits))
    }

    /// One line for the terminal.
    pub(crate) fn line(&self) -> String {
        let flow = self.flow_per_min.map(|flow| fixed(flow, 1));
        match (self.throughput_per_min, &self.no_throughput) {
            (Some(throughput), _) => {
                let interval = self.interval.map_or(String::new(), |ends| {
                    format!(" (95 % interval {})", interval(Some(ends), 1))
                });
                format!(
                    "throughput {} picks/min{interval} of a flow of {} items/min, {}\n",
                    fixed(throughput, 1),
                    flow.unwrap_or_default(),
                    match self.flow_changes {
                        true => "the mean over a pattern whose flow changes",
                        false => "in the steady state",
                    }
                )
            }
            (None, Some(reason)) => format!("throughput none: {reason}\n"),
            (None, None) => String::new(),
        }
    }

    /// A note about the figures that are missing from a table.
    pub(crate) fn note<'r>(of: impl IntoIterator<Item = &'r Self>) -> Option<String> {
        let note = of.into_iter().find_map(|report| report.note.as_ref());
        note.map(|note| format!("throughput: {note}"))
    }
}
