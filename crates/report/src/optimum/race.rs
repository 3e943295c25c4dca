//! The result of a race of assignments.

use super::objective::{ObjectiveFormat, bracketed};
use crate::columns::TableColumns;
use crate::csv_rows::{CsvRows, Displayed};
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::table::fixed;
use crate::verb_report::{ResultFile, VerbReport};
use pickline::error::{counted, shown_number};
use pickline::optimize::Objective;
use pickline::study::{RaceStop, Raced, Racer};
use serde::Serialize;

/// A race as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RaceReport {
    /// The figure that was maximised.
    pub objective: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// The rules of the selected assignment, upstream first, or of the best so far.
    pub best: Vec<&'static str>,
    /// `separated`: it alone is left; `equal`: what is left scored the same on every pattern;
    /// `max_patterns`, `time_limit`, `interrupted`: the race ended before that.
    pub stop_reason: &'static str,
    /// The indifference zone, in units of the objective.
    pub delta: f64,
    /// Least probability that `best` is the best of all, if that is better than every other by `delta`;
    /// `None` if the race ended before.
    pub probability_of_correct_selection: Option<f64>,
    /// Number of assignments at the start.
    pub assignments: usize,
    /// Number of patterns in a batch, whose mean is one observation.
    pub batch: usize,
    /// Number of patterns on which the survivors were scored.
    pub patterns: usize,
    /// Passes of one robot over a pattern that were simulated.
    pub passes: u64,
    /// Those that an enumeration of all assignments takes on as many patterns.
    pub enumeration_passes: u64,
    /// Those that are left, the best first.
    pub survivors: Vec<RacerReport>,
    /// Those that were dropped, the last one first.
    pub dropped: Vec<RacerReport>,
    /// Remarks on how the figures are to be read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    #[serde(skip)]
    confidence: f64,
}

/// An assignment in a race.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RacerReport {
    /// The rule of each robot, upstream first.
    pub assignment: Vec<&'static str>,
    /// Number of patterns on which it was scored; a dropped one was dropped after these.
    pub patterns: usize,
    /// Mean of the objective over them.
    pub mean: f64,
    /// How far that was below the highest mean over the same patterns.
    pub behind: f64,
}

impl RacerReport {
    fn new(racer: &Racer) -> Self {
        Self {
            assignment: racer.assignment.names(),
            patterns: racer.patterns,
            mean: racer.mean,
            behind: racer.behind,
        }
    }
}

#[derive(Default, Serialize)]
struct RacerRow {
    rank: usize,
    assignment: String,
    survived: bool,
    patterns: usize,
    mean: Displayed,
    behind: Displayed,
}

impl RaceReport {
    /// The report of a race for `objective`.
    pub fn new(
        raced: &Raced,
        objective: Objective,
        shown: &Presentation,
        made: Provenance,
    ) -> Self {
        let made = match raced.stop {
            RaceStop::Interrupted => made.of_parts(raced.patterns, raced.max_patterns, "patterns"),
            _ => made,
        };
        let reports = |racers: &[Racer]| racers.iter().map(RacerReport::new).collect();
        Self {
            objective: objective.name(),
            unit: objective.unit(),
            best: raced.best().assignment.names(),
            stop_reason: raced.stop.name(),
            delta: raced.selection.delta,
            probability_of_correct_selection: raced.probability(),
            assignments: raced.survivors.len() + raced.dropped.len(),
            batch: raced.batch,
            patterns: raced.patterns,
            passes: raced.passes,
            enumeration_passes: raced.enumeration_passes,
            survivors: reports(&raced.survivors),
            dropped: reports(&raced.dropped),
            notes: shown.notes(&raced.notes),
            made,
            confidence: raced.selection.confidence,
        }
    }

    fn format(&self) -> ObjectiveFormat<'_> {
        ObjectiveFormat {
            objective: self.objective,
            unit: self.unit,
            risk: "mean",
        }
    }

    /// All assignments, those that are left first.
    fn racers(&self) -> impl Iterator<Item = &RacerReport> {
        self.survivors.iter().chain(&self.dropped)
    }

    fn text(&self, shown: &Presentation) -> String {
        let digits = self.format().digits() + 1;
        let unit = self.format().bracketed_unit();
        let left = self.survivors.len();
        let columns = TableColumns::new()
            .with("#", |(i, _): &(usize, &RacerReport)| (i + 1).to_string())
            .with("<assignment", |(_, racer)| bracketed(&racer.assignment))
            .with(format!("mean{unit}"), move |(_, r)| fixed(r.mean, digits))
            .with(format!("behind{unit}"), move |(_, r)| {
                fixed(r.behind, digits)
            })
            .with("patterns", |(_, racer)| racer.patterns.to_string())
            .with("<", move |(i, _)| {
                let standing = match *i {
                    0 => "best",
                    i if i < left => "left",
                    _ => "dropped",
                };
                standing.to_owned()
            });
        let mut text = columns.table(self.racers().take(shown.top).enumerate());
        let more = self.assignments.saturating_sub(shown.top);
        if more > 0 {
            text += &shown.spelled(&format!("          ... {more} more ('top')\n"));
        }
        text += &format!(
            "best      {}: {}, mean\n",
            bracketed(&self.best),
            self.objective
        );
        text += &shown.spelled(&self.selected_line());
        let near = self.dropped.iter().filter(|r| r.behind < self.delta);
        let near = near.count();
        if near > 0 {
            text += &format!(
                "near      {} of the dropped {} less than {} behind when dropped\n",
                near,
                if near == 1 { "was" } else { "were" },
                self.zone()
            );
        }
        let share = 100.0 * self.passes as f64 / self.enumeration_passes.max(1) as f64;
        text += &format!(
            "race      {} of {} assignments dropped on {} in batches of {}\n          \
             {} robot passes, {} % of the {} of an enumeration on as many patterns\n",
            self.dropped.len(),
            self.assignments,
            counted(self.patterns, "pattern"),
            self.batch,
            self.passes,
            fixed(share, 1),
            self.enumeration_passes
        );
        for note in &self.notes {
            text += &format!("note      {note}\n");
        }
        text + &self.made.lines()
    }

    /// The indifference zone with its unit.
    fn zone(&self) -> String {
        format!(
            "{}{}",
            shown_number(self.delta),
            self.format().bracketed_unit()
        )
    }

    /// What is known of the best, and how surely.
    fn selected_line(&self) -> String {
        let zone = self.zone();
        let ended = match self.stop_reason {
            "separated" => "alone is left".to_owned(),
            "equal" => format!(
                "is the first of {} that scored the same on every pattern",
                self.survivors.len()
            ),
            reason => {
                let by = match reason {
                    "max_patterns" => "'max_patterns' was reached",
                    "time_limit" => "'until' was reached",
                    _ => "it was interrupted",
                };
                return format!(
                    "selected  not yet: {} are left and {by}; nothing is guaranteed\n",
                    counted(self.survivors.len(), "assignment")
                );
            }
        };
        format!(
            "selected  it {ended}; if one assignment is better than every other by {zone} or more,\n          \
             this is it with a probability of at least {} ('confidence')\n",
            self.confidence
        )
    }

    /// All assignments, those that are left first.
    fn racers_csv(&self) -> CsvRows {
        let rows = self.racers().enumerate();
        CsvRows::of(rows.map(|(i, racer)| RacerRow {
            rank: i + 1,
            assignment: racer.assignment.join(" "),
            survived: i < self.survivors.len(),
            patterns: racer.patterns,
            mean: Displayed(racer.mean),
            behind: Displayed(racer.behind),
        }))
    }
}

impl VerbReport for RaceReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::json("optimize.json"),
        ResultFile::csv("race.csv", Self::racers_csv),
    ];

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, shown: &Presentation) -> String {
        self.text(shown)
    }

    fn to_csv(&self) -> String {
        self.racers_csv().text(&self.made)
    }
}
