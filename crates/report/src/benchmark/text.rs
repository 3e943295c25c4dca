//! A benchmark as text for the terminal.

use super::report::{BenchmarkReport, EntryReport, StandingReport};
use crate::columns::TableColumns;
use crate::presentation::Presentation;
use crate::table::fixed;
use pickline::error::counted;

impl BenchmarkReport {
    /// All runs, what failed, and the ranking.
    pub(super) fn text(&self, shown: &Presentation) -> String {
        let mut text = self.runs_table();
        for run in &self.runs {
            if let Some(failure) = &run.failure {
                let why = shown.spelled(failure);
                text += &format!("failed    {}, {}: {why}\n", run.instance, run.entrant);
            }
        }
        text += "\n";
        text += &self.ranking_table();
        let better = self.runs.iter().filter(|run| run.better).count();
        if better > 0 {
            text += &format!(
                "note      better than the best known: {}\n",
                counted(better, "run")
            );
        }
        text + &self.made.lines()
    }

    fn runs_table(&self) -> String {
        let several = self.entrants > 1;
        let mut before = "";
        let rows: Vec<(bool, &EntryReport)> = self
            .runs
            .iter()
            .map(|run| {
                // The instance stands beside its first entrant only.
                let first = run.instance != before;
                before = &run.instance;
                (first, run)
            })
            .collect();
        let once = |first: bool, text: String| if first { text } else { String::new() };
        let count = |count: Option<usize>| count.map_or("-".to_owned(), |n| n.to_string());
        TableColumns::new()
            .with("<instance", |(first, run): &(bool, &EntryReport)| {
                once(*first, run.instance.clone())
            })
            .with("items", |(first, run)| once(*first, run.items.to_string()))
            .with("best known", |(first, run)| {
                once(*first, count(run.best_known))
            })
            .with("bound", |(first, run)| {
                once(*first, count(run.picks_upper_bound))
            })
            .with_if(several, "<entrant", |(_, run)| run.entrant.clone())
            .with("picks", |(_, run)| count(run.picked))
            .with("below best [%]", |(_, run)| {
                number(run.gap_to_best_percent, 1)
            })
            .with("below bound [%]", |(_, run)| {
                number(run.gap_to_bound_percent, 1)
            })
            .with("rate [1/min]", |(_, run)| {
                number(run.picking_rate_per_min, 2)
            })
            .with("below its bound [%]", |(_, run)| {
                number(run.rate_gap_to_bound_percent, 1)
            })
            .table(rows)
    }

    fn ranking_table(&self) -> String {
        let rows = self.ranking.iter().enumerate();
        TableColumns::new()
            .with("#", |(place, _): &(usize, &StandingReport)| {
                (place + 1).to_string()
            })
            .with("<entrant", |(_, standing)| standing.entrant.clone())
            .with("<track", |(_, standing)| standing.track.to_owned())
            .with("runs", |(_, standing)| standing.runs.to_string())
            .with("failed", |(_, standing)| standing.failed.to_string())
            .with("picks", |(_, standing)| standing.picked.to_string())
            .with("below best [%]", |(_, standing)| {
                number(standing.gap_to_best_percent, 2)
            })
            .with("below bound [%]", |(_, standing)| {
                number(standing.gap_to_bound_percent, 2)
            })
            .with("rate below its bound [%]", |(_, standing)| {
                number(standing.rate_gap_to_bound_percent, 2)
            })
            .with("decision [ms]", |(_, standing)| {
                number(standing.decision_ms, 3)
            })
            .table(rows)
    }
}

/// A number, or a dash.
fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_owned(), |value| fixed(value, digits))
}
