//! A search as CSV.

use super::report::OptimumReport;
use super::rivals::RivalsReport;
use crate::csv_rows::{CsvRows, Displayed, OptionalNumber, high, low};
use serde::Serialize;

#[derive(Default, Serialize)]
struct RankingRow<'r> {
    rank: usize,
    assignment: String,
    mean: Displayed,
    value: Displayed,
    diff_low: OptionalNumber,
    diff_high: OptionalNumber,
    tied: bool,
    picked_share: Displayed,
    worst: Displayed,
    worst_pattern: &'r str,
    max_speed_m_per_s: OptionalNumber,
}

#[derive(Default, Serialize)]
struct StrategyRow<'r> {
    strategy: &'r str,
    mean: Displayed,
    value: Displayed,
    diff_low: OptionalNumber,
    diff_high: OptionalNumber,
    picked_share: Displayed,
    worst: Displayed,
    patterns: usize,
}

impl OptimumReport {
    /// The whole ranking.
    pub(super) fn ranking_csv(&self) -> CsvRows {
        let lines = self.ranking.iter().enumerate();
        let rows = CsvRows::of(lines.map(|(i, line)| RankingRow {
            rank: i + 1,
            assignment: line.assignment.join(" "),
            mean: Displayed(line.mean),
            value: Displayed(line.value),
            diff_low: low(line.difference),
            diff_high: high(line.difference),
            tied: line.tied,
            picked_share: Displayed(line.picked_share),
            worst: Displayed(line.worst),
            worst_pattern: &line.worst_pattern,
            max_speed_m_per_s: line.max_speed.map(Displayed),
        }));
        self.csv_of(rows.without_empty())
    }

    /// The strategies beside the winner, if there are any.
    pub(super) fn strategies_csv(&self) -> Option<CsvRows> {
        let beside: &RivalsReport = self.beside.as_ref()?;
        let strategies = beside.strategies.iter();
        let rows = CsvRows::of(strategies.map(|line| StrategyRow {
            strategy: &line.strategy,
            mean: Displayed(line.mean),
            value: Displayed(line.value),
            diff_low: low(line.difference),
            diff_high: high(line.difference),
            picked_share: Displayed(line.picked_share),
            worst: Displayed(line.worst),
            patterns: beside.count,
        }));
        Some(self.csv_of(rows))
    }

    /// `rows`, in which figures of the objective have its name and unit.
    fn csv_of(&self, rows: CsvRows) -> CsvRows {
        let name = |name: &str| match name {
            "mean" | "value" | "diff_low" | "diff_high" | "worst" => self.format().column(name),
            name => name.to_owned(),
        };
        rows.renamed(name)
    }
}
