//! The settings of a search, why it ended, and its result.

use super::evaluator::Evaluator;
use super::exact::Proof;
use super::grasp::{Grasp, GraspOutcome};
use super::objective::Risk;
use super::ranking::Ranking;
use super::speed_limit::SpeedScan;
use crate::error::{Error, Result, known_names, shown, shown_number};
use crate::setters::setters;
use std::time::{Duration, Instant};
use strum::VariantNames as _;

/// How the best assignment is searched.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    strum::EnumString,
    strum::IntoStaticStr,
    strum::VariantNames,
    serde::Serialize,
    serde::Deserialize,
)]
#[strum(serialize_all = "lowercase")]
pub enum SearchKind {
    /// Enumerates if that costs less than GRASP, and also runs GRASP if that adds almost
    /// nothing. Longer lines are searched by `Exact` if it takes them and the runs suffice for all
    /// patterns, otherwise by `Grasp`.
    Auto,
    /// Enumerates all `6^N` assignments.
    Exhaustive,
    /// Greedy randomised adaptive search (GRASP).
    Grasp,
    /// Both, to measure GRASP's gap to the optimum.
    Both,
    /// GRASP, then branch and bound, which proves what is best without scoring all assignments.
    Exact,
}

impl SearchKind {
    /// The method with this name: `auto`, `exhaustive`, `grasp`, `both` or `exact`.
    ///
    /// # Errors
    /// The name is unknown; the message suggests the nearest known one.
    pub fn named(name: &str) -> Result<Self> {
        Self::try_from(name).map_err(|_| {
            Error::usage(
                "'kind'",
                format!("unknown search `{}`", shown(name)),
                known_names(name, Self::VARIANTS),
            )
        })
    }
}

/// Limit on the runs of a search, including those that break ties; a run is one assignment on
/// one pattern at one speed. Runs are counted, not timed, so the result is the same on every
/// machine. One assignment is always scored, because there is no result otherwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MostRuns {
    /// A number that takes well under a minute on a typical machine.
    #[default]
    Usual,
    /// A number that takes as long as this many passes of one robot over a pattern of
    /// 150 items.
    Passes(u64),
    /// This number of runs.
    Of(u64),
    /// No limit.
    Any,
}

/// Items in a typical pattern. A run on a longer pattern takes proportionally longer.
pub(super) const USUAL_ITEMS: usize = 150;
/// Robot passes of a typical search. A run takes one pass per robot, so long lines get fewer
/// runs.
const PASSES: u64 = 36_000_000;
/// The same if only the event loop can be used, which shares no work between assignments.
const PASSES_ONE_BY_ONE: u64 = 4_000_000;

impl MostRuns {
    /// The limit for `evaluator`; `None` for no limit.
    pub(super) fn of(self, evaluator: &Evaluator) -> Option<u64> {
        let robots = evaluator.station().robots().len() as u64;
        let shared = evaluator.independent_patterns() == evaluator.pattern_count();
        let length = evaluator.mean_items() / USUAL_ITEMS as f64;
        let of_passes = |passes: u64| ((passes / robots) as f64 / length.max(1.0)) as u64;
        match self {
            Self::Usual if shared => Some(of_passes(PASSES)),
            Self::Usual => Some(of_passes(PASSES_ONE_BY_ONE)),
            Self::Passes(passes) => Some(of_passes(passes)),
            Self::Of(runs) => Some(runs),
            Self::Any => None,
        }
    }
}

/// How long a search may run. At the limit, it returns the best assignment so far.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Limits {
    /// Maximum number of runs, including those that break ties.
    pub runs: MostRuns,
    /// Time at which it must end; what is found by then depends on the machine.
    pub until: Option<Instant>,
}

setters!(Limits {
    /// With this maximum number of runs.
    fn with_runs(runs: MostRuns);
    /// With this time at which the search must end.
    fn with_until(until: impl Into<Option<Instant>>);
});

/// The longest accepted time limit [s]; a longer one is treated as a typing mistake.
const LONGEST: f64 = 1e7;

impl Limits {
    /// At most this number of runs, 0 for any number, or the usual one; until this time [s] from now.
    ///
    /// # Errors
    /// An invalid time.
    pub fn of(runs: Option<u64>, seconds: Option<f64>) -> Result<Self> {
        let time = |limit: f64| {
            let time = Duration::try_from_secs_f64(limit).ok();
            let time = time.filter(|time| !time.is_zero() && limit <= LONGEST);
            time.ok_or_else(|| {
                Error::usage(
                    "'until'",
                    format!("{} is not a time for a search", shown_number(limit)),
                    format!("give seconds, above 0 and up to {LONGEST:e}"),
                )
            })
        };
        let time = seconds.map(time).transpose()?;
        Ok(Self {
            runs: match runs {
                None => MostRuns::Usual,
                Some(0) => MostRuns::Any,
                Some(runs) => MostRuns::Of(runs),
            },
            until: time.map(|time| Instant::now() + time),
        })
    }

    /// No limit on runs or time.
    pub const NONE: Self = Self {
        runs: MostRuns::Any,
        until: None,
    };
}

/// Settings of a search for the best assignment.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Search {
    /// How the best assignment is searched.
    pub kind: SearchKind,
    /// Settings of GRASP, if it runs.
    pub grasp: Grasp,
    /// How the patterns' figures are combined into one.
    pub risk: Risk,
    /// Resolution of the speed limits that break ties; `None` to break them without. On a long
    /// line nearly all assignments are tied, and computing their limits takes most of the time.
    pub scan: Option<SpeedScan>,
    /// How long it may run.
    pub limits: Limits,
}

impl Default for Search {
    /// The cheaper method, judged by the mean, with ties broken by speed limits, within the usual
    /// number of runs.
    fn default() -> Self {
        Self {
            kind: SearchKind::Auto,
            grasp: Grasp::default(),
            risk: Risk::Mean,
            scan: Some(SpeedScan::default()),
            limits: Limits::default(),
        }
    }
}

setters!(Search {
    /// With this method.
    fn with_kind(kind: SearchKind);
    /// With these settings of GRASP.
    fn with_grasp(grasp: Grasp);
    /// With the figures of the patterns combined in this way.
    fn with_risk(risk: Risk);
    /// With ties broken by speed limits of this resolution, or without them.
    fn with_scan(scan: impl Into<Option<SpeedScan>>);
    /// With these limits.
    fn with_limits(limits: Limits);
});

/// Why the search ended.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr, serde::Serialize, serde::Deserialize,
)]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum StopReason {
    /// Every assignment was scored.
    Enumerated,
    /// Branch and bound left no assignment that could be better.
    Proven,
    /// Every start of GRASP reached a local optimum.
    LocalOptima,
    /// The runs were used up; the result is the best so far, or over fewer patterns.
    Budget,
    /// The time was up; the result is the best so far.
    TimeLimit,
    /// The user stopped it; the result is the best so far.
    Interrupted,
}

impl StopReason {
    /// The name in files: the variant's in snake case.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// What a search for the best assignment found.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Optimum {
    /// The method that was used: never `Auto`.
    pub kind: SearchKind,
    /// Why the search ended.
    pub stop: StopReason,
    /// The assignments that were scored, the best first.
    pub ranking: Ranking,
    /// What GRASP found, if it ran.
    pub grasp: Option<GraspOutcome>,
    /// GRASP's gap to the optimum in units of the objective, if both methods ran.
    pub grasp_gap: Option<f64>,
    /// How far it is proven that nothing is better, if branch and bound ran.
    pub proof: Option<Proof>,
    /// Runs of the search, including those that break ties: one assignment on one pattern at
    /// one speed each.
    pub runs: u64,
    /// The limit on runs; `None` for no limit.
    pub max_runs: Option<u64>,
    /// Number of patterns in the ranking; all of them unless the search was cut short.
    pub patterns: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn why_a_search_ended_has_a_name() {
        let names = [
            StopReason::Enumerated,
            StopReason::Proven,
            StopReason::LocalOptima,
            StopReason::Budget,
            StopReason::TimeLimit,
            StopReason::Interrupted,
        ]
        .map(StopReason::name);
        let words = [
            "enumerated",
            "proven",
            "local_optima",
            "budget",
            "time_limit",
            "interrupted",
        ];
        assert_eq!(names, words);
    }
}
