//! A benchmark as CSV.

use super::report::BenchmarkReport;
use crate::csv_rows::{CsvRows, Displayed, OptionalNumber};
use serde::Serialize;

#[derive(Default, Serialize)]
struct StandingRow<'r> {
    entrant: &'r str,
    track: &'static str,
    runs: usize,
    failed: usize,
    picked: usize,
    gap_to_best_percent: OptionalNumber,
    gap_to_bound_percent: OptionalNumber,
    rate_gap_to_bound_percent: OptionalNumber,
}

#[derive(Default, Serialize)]
struct BenchmarkRow<'r> {
    instance: &'r str,
    entrant: &'r str,
    track: &'static str,
    items: usize,
    best_known: OptionalNumber,
    picks_upper_bound: OptionalNumber,
    picking_rate_upper_bound_per_min: OptionalNumber,
    picked: OptionalNumber,
    picking_rate_per_min: OptionalNumber,
    gap_to_best_percent: OptionalNumber,
    gap_to_bound_percent: OptionalNumber,
    rate_gap_to_bound_percent: OptionalNumber,
    /// Why there is no valid run; empty if there is one.
    failure: &'r str,
}

impl BenchmarkReport {
    /// Everyone who took part, the best first.
    pub(super) fn ranking_csv(&self) -> CsvRows {
        let rows = self.ranking.iter().map(|standing| StandingRow {
            entrant: &standing.entrant,
            track: standing.track,
            runs: standing.runs,
            failed: standing.failed,
            picked: standing.picked,
            gap_to_best_percent: standing.gap_to_best_percent.map(Displayed),
            gap_to_bound_percent: standing.gap_to_bound_percent.map(Displayed),
            rate_gap_to_bound_percent: standing.rate_gap_to_bound_percent.map(Displayed),
        });
        CsvRows::of(rows)
    }

    /// Every run.
    pub(super) fn runs_csv(&self) -> CsvRows {
        let count = |count: Option<usize>| count.map(|count| Displayed(count as f64));
        let rows = self.runs.iter().map(|run| BenchmarkRow {
            instance: &run.instance,
            entrant: &run.entrant,
            track: run.track,
            items: run.items,
            best_known: count(run.best_known),
            picks_upper_bound: count(run.picks_upper_bound),
            picking_rate_upper_bound_per_min: run.picking_rate_upper_bound_per_min.map(Displayed),
            picked: count(run.picked),
            picking_rate_per_min: run.picking_rate_per_min.map(Displayed),
            gap_to_best_percent: run.gap_to_best_percent.map(Displayed),
            gap_to_bound_percent: run.gap_to_bound_percent.map(Displayed),
            rate_gap_to_bound_percent: run.rate_gap_to_bound_percent.map(Displayed),
            failure: run.failure.as_deref().unwrap_or_default(),
        });
        CsvRows::of(rows)
    }
}
