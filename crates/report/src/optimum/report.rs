//! The result of a search.

use super::objective::ObjectiveFormat;
use super::rivals::RivalsReport;
use super::validation::ValidationReport;
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use pickline::optimize::{Objective, Optimum, Proof, Ranked, Search, SearchKind, StopReason};
use pickline::pattern::PatternSet;
use pickline::stats::Interval;
use pickline::study::Optimized;
use serde::Serialize;

/// A search as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct OptimumReport {
    /// The winner's rules, upstream first.
    pub best: Vec<&'static str>,
    /// Name of the objective.
    pub objective: &'static str,
    /// Unit of the objective, for example `1/min`.
    pub unit: &'static str,
    /// How values of several patterns are aggregated.
    pub risk: String,
    /// `exhaustive`, `grasp` or `exact`.
    pub search: &'static str,
    /// Why the search ended, in snake case.
    pub stop_reason: &'static str,
    /// Assignments in the ranking.
    pub assignments: usize,
    /// Number of patterns in the ranking.
    pub patterns: usize,
    /// Simulated runs: one assignment on one pattern at one belt speed each.
    pub runs: u64,
    /// Limit on the number of runs; `None` if unlimited.
    pub max_runs: Option<u64>,
    /// What GRASP found, if it ran.
    pub grasp: Option<GraspReport>,
    /// What branch and bound proved; omitted if it did not run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proof: Option<Proof>,
    /// The assignment with the highest aggregate before ties were broken.
    pub leader: Vec<&'static str>,
    /// Number of assignments among which the tie was broken, including the leader.
    pub contenders: usize,
    /// How many of them have a speed limit, and over how many patterns; `None` if ties were
    /// broken without it.
    pub speed_limits_of: Option<(usize, usize)>,
    /// How the intervals were computed.
    pub intervals: String,
    /// All assignments, best first.
    pub ranking: Vec<RankedReport>,
    /// The winner on fresh patterns.
    pub validation: Option<ValidationReport>,
    /// Other strategies compared with it; omitted if not requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub beside: Option<RivalsReport>,
    /// Remarks on how the figures are to be read.
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
}

/// What greedy randomised adaptive search (GRASP) found.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct GraspReport {
    /// Number of starts that reached a local optimum.
    pub starts: usize,
    /// Number of those that ended in the best assignment.
    pub hits: usize,
    /// Moves made by all local searches.
    pub moves: usize,
    /// Width of the restricted candidate list.
    pub alpha: f64,
    /// The best assignment that it found; `None` if it was stopped before the first was scored.
    pub best: Option<Vec<&'static str>>,
    /// The figure of that assignment, in the unit of the objective.
    pub value: Option<f64>,
    /// Optimum minus that value, if all assignments were also enumerated.
    pub gap: Option<f64>,
}

/// An assignment in the ranking.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RankedReport {
    /// The rules, upstream first.
    pub assignment: Vec<&'static str>,
    /// Mean of the objective over the patterns.
    pub mean: f64,
    /// Its aggregate under the chosen risk.
    pub value: f64,
    /// 95 % interval of best minus this one; `None` for a single pattern.
    #[serde(flatten, serialize_with = "crate::ends::difference")]
    pub difference: Option<Interval>,
    /// Whether that interval contains 0; for a single pattern, whether both are equal.
    pub tied: bool,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// The objective on the worst pattern.
    pub worst: f64,
    /// Label of the worst pattern.
    pub worst_pattern: String,
    /// Mean speed limit [m/s], if it broke a tie.
    pub max_speed: Option<f64>,
}

impl RankedReport {
    /// How this line, the `i`-th of the ranking, stands to the best.
    pub(super) fn standing(&self, i: usize) -> &'static str {
        match (i, self.tied) {
            (0, _) => "best",
            (_, true) => "tied",
            (_, false) => "",
        }
    }
}

impl OptimumReport {
    /// The report of a search on `set` for the best `objective`, made as `made` says, which is
    /// completed by how far it got.
    pub fn of_study(
        optimized: &Optimized,
        objective: Objective,
        set: &PatternSet,
        shown: &Presentation,
        made: Provenance,
    ) -> Self {
        let optimum = &optimized.optimum;
        let made = match optimum.stop {
            StopReason::Interrupted => {
                made.of_parts(optimum.patterns, set.patterns.len(), "patterns")
            }
            _ => made,
        };
        let validation = optimized.validation.as_ref();
        let mut report = Self::new(
            optimum,
            &optimized.search,
            objective,
            &set.labels,
            validation.map(|(validation, on)| ValidationReport::new(validation, on)),
            shown.notes(&optimized.notes),
            made,
        );
        let best = optimum.ranking.best().assignment.names();
        report.beside = optimized.rivals.as_ref().map(|scored| {
            let names = scored.names.iter().map(String::as_str);
            RivalsReport::new(&scored.rivals, &best, names, &scored.patterns, scored.count)
        });
        report
    }

    /// The report of `optimum`; `labels` names the patterns.
    pub fn new(
        optimum: &Optimum,
        search: &Search,
        objective: Objective,
        labels: &[String],
        validation: Option<ValidationReport>,
        notes: Vec<String>,
        made: Provenance,
    ) -> Self {
        let ranking = &optimum.ranking;
        let line = |ranked: &Ranked| RankedReport {
            assignment: ranked.assignment.names(),
            mean: ranked.mean,
            value: ranked.value,
            difference: ranked.difference,
            tied: ranked.tied,
            picked_share: ranked.picked_share,
            worst: ranked.worst,
            worst_pattern: labels[ranked.worst_pattern].clone(),
            max_speed: ranked.max_speed,
        };
        Self {
            best: ranking.best().assignment.names(),
            objective: objective.name(),
            unit: objective.unit(),
            risk: search.risk.to_string(),
            search: match optimum.kind {
                SearchKind::Grasp => "grasp",
                SearchKind::Exact => "exact",
                _ => "exhaustive",
            },
            stop_reason: optimum.stop.name(),
            assignments: ranking.entries.len(),
            patterns: optimum.patterns,
            runs: optimum.runs,
            max_runs: optimum.max_runs,
            grasp: optimum.grasp.as_ref().map(|grasp| GraspReport {
                starts: grasp.starts,
                hits: grasp.hits,
                moves: grasp.moves,
                alpha: search.grasp.alpha,
                best: grasp.best.as_ref().map(|best| best.names()),
                value: grasp.best.as_ref().map(|_| grasp.value),
                gap: optimum.grasp_gap,
            }),
            proof: optimum.proof.clone(),
            leader: ranking.leader.names(),
            contenders: ranking.contenders,
            speed_limits_of: ranking.by_speed,
            intervals: ranking.method.clone(),
            ranking: ranking.entries.iter().map(line).collect(),
            validation,
            beside: None,
            notes,
            made,
        }
    }

    /// How the figures of the objective are named and shown.
    pub(super) fn format(&self) -> ObjectiveFormat<'_> {
        ObjectiveFormat {
            objective: self.objective,
            unit: self.unit,
            risk: &self.risk,
        }
    }
}
