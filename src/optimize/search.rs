//! The search as a whole: which way, how it ended, what came out.

use super::environment::Environment;
use super::evaluator::{Evaluation, Evaluator, Score};
use super::grasp::{Grasp, GraspOutcome, Memo};
use super::objective::Risk;
use super::ranking::Ranking;
use super::speed_limit::SpeedScan;
use crate::dispatch::{RULES, RuleAssignment};
use crate::error::{Error, Result};

/// Which way the assignments are searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchKind {
    /// Enumerates while that costs less than GRASP.
    Auto,
    /// All `6^N` assignments.
    Exhaustive,
    /// GRASP.
    Grasp,
    /// Both, to see how far GRASP falls short.
    Both,
}

/// How to search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Search {
    /// Which way.
    pub kind: SearchKind,
    /// Settings of GRASP.
    pub grasp: Grasp,
    /// How the patterns' figures become one.
    pub risk: Risk,
    /// Resolution of the speed limits that break ties; none to break them without. On a
    /// long line nearly all assignments are tied, and their limits take most of the time.
    pub scan: Option<SpeedScan>,
}

/// Why the search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StopReason {
    /// Every assignment was scored.
    Enumerated,
    /// Every start of GRASP reached a local optimum.
    LocalOptima,
    /// The user stopped it; the result is the best so far.
    Interrupted,
}

impl StopReason {
    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Enumerated => "enumerated",
            Self::LocalOptima => "local_optima",
            Self::Interrupted => "interrupted",
        }
    }
}

/// What came out.
#[derive(Debug)]
pub struct Optimum {
    /// The way that was taken: never `Auto`.
    pub kind: SearchKind,
    /// Why it ended.
    pub stop: StopReason,
    /// The ranking.
    pub ranking: Ranking,
    /// What GRASP found, where it ran.
    pub grasp: Option<GraspOutcome>,
    /// GRASP's shortfall to the optimum in units of the objective, where both ran.
    pub grasp_gap: Option<f64>,
    /// Runs for the search, ties and all: one assignment on one pattern at one speed.
    pub runs: u64,
    /// Patterns that the ranking is over; all of them unless it was interrupted.
    pub patterns: usize,
}

/// Memory that an enumeration may take [bytes].
const MOST_MEMORY: f64 = 2e9;
/// What it takes for each assignment, in lists, the ranking and the report, and for each
/// assignment and pattern [bytes]; measured.
const PER_ASSIGNMENT: f64 = 800.0;
const PER_VALUE: f64 = 24.0;

/// Searches the best assignment.
///
/// # Errors
/// An enumeration that would not fit into memory, [`Error::Interrupted`] when the user
/// stopped before anything was scored.
pub fn optimize(
    evaluator: &Evaluator,
    search: &Search,
    environment: &Environment,
) -> Result<Optimum> {
    let robots = evaluator.station().robots().len();
    let kind = resolve(search, evaluator)?;
    let mut memo = Memo::new();
    let mut interrupted = false;
    let mut enumeration = None;
    if matches!(kind, SearchKind::Exhaustive | SearchKind::Both) {
        let patterns = evaluator.pattern_count() as u64;
        environment
            .progress
            .begin("enumerating", patterns, "patterns");
        let all = RuleAssignment::all(robots).collect();
        let evaluation = evaluator.evaluate(all, environment)?;
        environment.progress.end();
        interrupted = !evaluation.is_whole(evaluator);
        enumeration = Some(evaluation);
    }
    let mut grasp = None;
    if matches!(kind, SearchKind::Grasp | SearchKind::Both) && !interrupted {
        if let Some(evaluation) = &enumeration {
            let scores = evaluation.scores.iter().cloned();
            memo.extend(evaluation.assignments.iter().cloned().zip(scores));
        }
        environment
            .progress
            .begin("GRASP", search.grasp.starts as u64, "starts");
        let outcome = search
            .grasp
            .run(evaluator, search.risk, &mut memo, environment)?;
        environment.progress.end();
        interrupted = outcome.interrupted;
        grasp = Some(outcome);
    }
    let evaluation = match enumeration {
        Some(evaluation) => evaluation,
        None => from_memo(memo, evaluator),
    };
    let ranking = Ranking::new(
        &evaluation,
        evaluator,
        search.risk,
        search.scan,
        environment,
    )?
    .ok_or(Error::Interrupted)?;
    let enumerated = matches!(kind, SearchKind::Exhaustive | SearchKind::Both);
    let grasp_gap = match (&grasp, evaluation.leader(search.risk)) {
        (Some(grasp), Some(leader)) if enumerated && grasp.best.is_some() => {
            Some(search.risk.aggregate(&evaluation.scores[leader].values) - grasp.value)
        }
        _ => None,
    };
    Ok(Optimum {
        kind,
        stop: if interrupted || environment.stopped() {
            StopReason::Interrupted
        } else if enumerated {
            StopReason::Enumerated
        } else {
            StopReason::LocalOptima
        },
        ranking,
        grasp,
        grasp_gap,
        runs: evaluator.runs(),
        patterns: evaluation.patterns.len(),
    })
}

fn resolve(search: &Search, evaluator: &Evaluator) -> Result<SearchKind> {
    let robots = evaluator.station().robots().len();
    let all = (RULES.len() as f64).powi(robots as i32);
    let memory = all * (PER_ASSIGNMENT + PER_VALUE * evaluator.pattern_count() as f64);
    let fits = memory <= MOST_MEMORY;
    match search.kind {
        SearchKind::Auto => {
            // Passes of one robot a pattern, the unit of both.
            let enumeration: f64 = (1..=robots as i32)
                .map(|depth| (RULES.len() as f64).powi(depth))
                .sum();
            let cheaper = enumeration <= search.grasp.estimated_passes(robots);
            Ok(if fits && cheaper {
                // Its scores are all that GRASP would ask for, so telling GRASP's gap
                // costs next to nothing.
                SearchKind::Both
            } else {
                SearchKind::Grasp
            })
        }
        SearchKind::Exhaustive | SearchKind::Both if !fits => Err(Error::input(
            "--search",
            format!(
                "the {}^{robots} assignments of {robots} robots are too many to enumerate",
                RULES.len()
            ),
            "use --search grasp, or fewer patterns",
        )),
        kind => Ok(kind),
    }
}

/// What GRASP scored, in registry order.
fn from_memo(memo: Memo, evaluator: &Evaluator) -> Evaluation {
    let mut scored: Vec<(RuleAssignment, Score)> = memo.into_iter().collect();
    scored.sort_unstable_by(|a, b| a.0.cmp(&b.0));
    let patterns = if scored.is_empty() {
        Vec::new()
    } else {
        (0..evaluator.pattern_count()).collect()
    };
    let (assignments, scores) = scored.into_iter().unzip();
    Evaluation {
        assignments,
        scores,
        patterns,
    }
}
