//! A comparison as CSV.

use super::report::{CaseReport, ComparisonReport, MethodResultReport, RunRow};
use crate::csv_rows::{CsvRows, Displayed, OptionalNumber, high, low};
use crate::purity::{PurityByBinReport, PurityColumns};
use crate::throughput::ThroughputColumns;
use serde::Serialize;

#[derive(Default, Serialize)]
struct CaseMethod<'r> {
    case: &'r str,
    method: &'r str,
}

#[derive(Default, Serialize)]
struct PatternCounts {
    steady_patterns: usize,
    patterns: usize,
}

#[derive(Default, Serialize)]
struct PatternCount {
    patterns: usize,
}

#[derive(Default, Serialize)]
struct PickedTime {
    picked_share: Displayed,
    end_s: Displayed,
    patterns: usize,
}

#[derive(Default, Serialize)]
struct PickingRate {
    picking_rate_per_min: Displayed,
    picking_rate_low_per_min: OptionalNumber,
    picking_rate_high_per_min: OptionalNumber,
    benefit_percent: OptionalNumber,
    diff_low_per_min: OptionalNumber,
    diff_high_per_min: OptionalNumber,
    picking_rate_upper_bound_per_min: OptionalNumber,
    patterns: usize,
}

impl ComparisonReport {
    /// Every method on every case, with the method's place.
    fn results(&self) -> impl Iterator<Item = (usize, &CaseReport, &MethodResultReport)> {
        self.cases.iter().flat_map(|case| {
            let results = case.results.iter().enumerate();
            results.map(move |(place, result)| (place, case, result))
        })
    }

    /// A file with a row for every method on every case.
    fn csv_of<'r, R: Default + Serialize>(
        &'r self,
        row: impl Fn(usize, &'r CaseReport, &'r MethodResultReport) -> R,
    ) -> CsvRows {
        let rows = self.results().map(|(place, case, result)| {
            let of = CaseMethod {
                case: &case.name,
                method: &result.method,
            };
            (of, row(place, case, result))
        });
        CsvRows::of(rows)
    }

    /// Each method's picks per minute in the steady state of each case.
    pub(super) fn throughput_csv(&self) -> CsvRows {
        self.csv_of(|_, case, result| -> (ThroughputColumns, PatternCounts) {
            let counts = PatternCounts {
                steady_patterns: result.throughput.steady_patterns,
                patterns: case.patterns,
            };
            (result.throughput.columns(), counts)
        })
    }

    /// Table 2 of the paper: items picked and time taken.
    pub(super) fn picked_time_csv(&self) -> CsvRows {
        self.csv_of(|_, case, result| PickedTime {
            picked_share: Displayed(result.picked_share),
            end_s: Displayed(result.end_s),
            patterns: case.patterns,
        })
    }

    /// Table 3 of the paper: each method's picking rate on each case, its excess over the first
    /// method, and the upper bound for every strategy.
    pub(super) fn picking_rate_csv(&self) -> CsvRows {
        self.csv_of(|place, case, result| {
            let bound = case.bound.as_ref().and_then(|b| b.picking_rate_per_min);
            // The first method has nothing to compare with.
            let other = place > 0;
            let difference = result.difference.filter(|_| other);
            PickingRate {
                picking_rate_per_min: Displayed(result.picking_rate_per_min),
                picking_rate_low_per_min: low(result.picking_rate_interval),
                picking_rate_high_per_min: high(result.picking_rate_interval),
                benefit_percent: other.then_some(Displayed(result.benefit_percent)),
                diff_low_per_min: low(difference),
                diff_high_per_min: high(difference),
                picking_rate_upper_bound_per_min: bound.map(Displayed),
                patterns: case.patterns,
            }
        })
    }

    /// What each method picks of each class, if there are classes.
    pub(super) fn classes_csv(&self) -> Option<CsvRows> {
        self.classes().next()?;
        let classes = self.results().flat_map(|(_, case, result)| {
            let classes = result.classes.iter();
            classes.map(move |class| (case, result, class))
        });
        let rows = classes.map(|(case, result, class)| {
            let of = CaseMethod {
                case: &case.name,
                method: &result.method,
            };
            let patterns = PatternCount {
                patterns: case.patterns,
            };
            (of, class.csv_columns(), patterns)
        });
        Some(CsvRows::of(rows))
    }

    /// Every run.
    pub(super) fn runs_csv(&self) -> CsvRows {
        let runs = self.cases.iter().flat_map(|case| &case.runs);
        let rows = CsvRows::like(&RunRow::default(), runs.cloned());
        let mut omitted = Vec::new();
        if !self.weighs() {
            omitted.push("weighted_rate_per_min");
        }
        if !self.has_purity() {
            omitted.extend(["rightly_binned", "due"]);
        }
        rows.without(&omitted)
    }

    /// Purity and recovery of each method's bins, if detections may be wrong.
    pub(super) fn purity_csv(&self) -> Option<CsvRows> {
        let rows = self.results().flat_map(|(_, case, result)| {
            let parts = result.sorting.iter().flat_map(PurityByBinReport::parts);
            parts.map(|(bin, purity, _)| {
                let of = CaseMethod {
                    case: &case.name,
                    method: &result.method,
                };
                (of, PurityColumns::new(bin, purity))
            })
        });
        self.has_purity().then(|| CsvRows::of(rows))
    }
}
