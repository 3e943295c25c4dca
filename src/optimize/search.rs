//! The search as a whole: its method, how it ended, and its result.

use super::environment::{Deadline, Environment};
use super::evaluator::{Evaluation, Evaluator, Score};
use super::grasp::{Grasp, GraspOutcome, Memo};
use super::objective::Risk;
use super::ranking::{Ranking, TieBreak};
use super::speed_limit::SpeedScan;
use crate::dispatch::{RULES, RuleAssignment};
use crate::error::{Error, Result};
use crate::setters::setters;
use std::time::Instant;

/// How the best assignment is searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchKind {
    /// Enumerates if that costs less than GRASP, and also runs GRASP if that adds almost
    /// nothing.
    Auto,
    /// Enumerates all `6^N` assignments.
    Exhaustive,
    /// Greedy randomised adaptive search (GRASP).
    Grasp,
    /// Both, to measure GRASP's gap to the optimum.
    Both,
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
    fn of(self, evaluator: &Evaluator) -> Option<u64> {
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

impl Limits {
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
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum StopReason {
    /// Every assignment was scored.
    Enumerated,
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
#[derive(Debug)]
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
    /// Runs of the search, including those that break ties: one assignment on one pattern at
    /// one speed each.
    pub runs: u64,
    /// The limit on runs; `None` for no limit.
    pub max_runs: Option<u64>,
    /// Number of patterns in the ranking; all of them unless the search was cut short.
    pub patterns: usize,
}

/// Maximum memory for an enumeration [bytes].
const MOST_MEMORY: f64 = 2e9;
/// Memory per assignment, for lists, the ranking and the report, and memory per assignment and
/// pattern [bytes]; measured.
const PER_ASSIGNMENT: f64 = 800.0;
const PER_VALUE: f64 = 24.0;

/// Share of the runs that GRASP leaves for breaking ties.
const FOR_TIES: f64 = 0.25;
/// Minimum number of typical patterns on which GRASP evaluates, if its runs suffice to try each
/// rule for all robots on them. Longer patterns give as much information in smaller numbers.
const LEAST_PATTERNS: f64 = 24.0;
/// Minimum number of patterns on which GRASP evaluates, however long they are.
const LEAST_LONG_PATTERNS: usize = 3;
/// GRASP runs in addition to an enumeration if it adds less than this share of work.
const BESIDE: f64 = 0.1;

/// Searches for the best assignment.
///
/// # Errors
/// An enumeration that does not fit into memory, a time limit reached before anything was
/// scored, or [`Interrupted`](crate::error::ErrorKind) if the user stopped it before that.
pub fn find_optimum(
    evaluator: &Evaluator,
    search: &Search,
    environment: &Environment,
) -> Result<Optimum> {
    search.risk.checked()?;
    let max_runs = search.limits.runs.of(evaluator);
    let kind = resolve(search, max_runs, evaluator)?;
    let deadline = Deadline {
        other: environment.stop,
        at: search.limits.until,
    };
    let within = Environment {
        stop: &deadline,
        progress: environment.progress,
    };
    let most = max_runs.unwrap_or(u64::MAX);
    let sampled = match (kind, max_runs) {
        (SearchKind::Grasp, Some(most)) => sample(search, most, evaluator),
        _ => None,
    };
    let judge = sampled.as_ref().unwrap_or(evaluator);
    let began = judge.runs();
    let left = || most.saturating_sub(judge.runs() - began);
    let enumerated = matches!(kind, SearchKind::Exhaustive | SearchKind::Both);
    let mut memo = Memo::new();
    let mut cut = sampled.is_some();
    let mut enumeration = None;
    if enumerated {
        let evaluation = enumerate(judge, left(), &within)?;
        cut |= !evaluation.is_whole(judge);
        enumeration = Some(evaluation);
    }
    let mut grasp = None;
    if matches!(kind, SearchKind::Grasp | SearchKind::Both) && (enumeration.is_none() || !cut) {
        let outcome = run_grasp(
            judge,
            search,
            &mut memo,
            enumeration.as_ref(),
            left(),
            &within,
        )?;
        cut |= outcome.cut;
        grasp = Some(outcome);
    }
    let evaluation = match enumeration {
        Some(evaluation) => evaluation,
        None => from_memo(memo, judge),
    };
    let tie_break = TieBreak {
        scan: search.scan,
        runs: left(),
    };
    let ranking = Ranking::new(&evaluation, judge, search.risk, tie_break, &within)?
        .ok_or_else(|| nothing_scored(environment))?;
    cut |= ranking.cut;
    let grasp_gap = match (&grasp, evaluation.leader(search.risk)) {
        (Some(grasp), Some(leader)) if enumerated && grasp.best.is_some() => {
            Some(search.risk.aggregate(&evaluation.scores[leader].values) - grasp.value)
        }
        _ => None,
    };
    Ok(Optimum {
        kind,
        stop: match cut {
            _ if environment.stopped() => StopReason::Interrupted,
            true if deadline.passed() => StopReason::TimeLimit,
            true => StopReason::Budget,
            false if enumerated => StopReason::Enumerated,
            false => StopReason::LocalOptima,
        },
        ranking,
        grasp,
        grasp_gap,
        runs: judge.runs() - began,
        max_runs,
        patterns: evaluation.patterns.len(),
    })
}

/// Runs GRASP with the scores of `enumeration`, if there is one. Otherwise it leaves a share of the
/// `left` runs for breaking ties.
fn run_grasp(
    judge: &Evaluator,
    search: &Search,
    memo: &mut Memo,
    enumeration: Option<&Evaluation>,
    left: u64,
    environment: &Environment,
) -> Result<GraspOutcome> {
    let share = if enumeration.is_some() { 0.0 } else { FOR_TIES };
    if let Some(evaluation) = enumeration {
        let scores = evaluation.scores.iter().cloned();
        memo.extend(evaluation.assignments.iter().cloned().zip(scores));
    }
    let runs = (left as f64 * (1.0 - share)) as u64;
    let starts = search.grasp.starts as u64;
    environment.progress.begin("GRASP", starts, "starts");
    let outcome = search
        .grasp
        .run(judge, search.risk, memo, runs, environment)?;
    environment.progress.end();
    Ok(outcome)
}

/// Why there is no result.
fn nothing_scored(environment: &Environment) -> Error {
    if environment.stopped() {
        return Error::interrupted();
    }
    Error::usage(
        "'time_limit'",
        "the time limit passed before any assignment was scored",
        "give a longer time limit, or fewer patterns",
    )
}

/// Enumerates all assignments, on as many patterns as `most` runs allow.
fn enumerate(evaluator: &Evaluator, most: u64, environment: &Environment) -> Result<Evaluation> {
    let patterns = evaluator.pattern_count() as u64;
    environment
        .progress
        .begin("enumerating", patterns, "patterns");
    let robots = evaluator.station().robots().len();
    let all: Vec<RuleAssignment> = RuleAssignment::all(robots).collect();
    let count = all.len();
    let evaluation = evaluator.evaluate_within(all, most, environment)?;
    environment.progress.end();
    if evaluation.patterns.is_empty() && !environment.stopped() {
        return Err(Error::usage(
            "'max_runs'",
            format!("{most} runs are too few for {count} assignments on one pattern"),
            "give more runs, or use 'search' grasp",
        ));
    }
    Ok(evaluation)
}

/// The patterns on which GRASP can evaluate within its runs, if not on all: all starts on some
/// patterns find more than a few starts on all patterns.
fn sample<'a>(search: &Search, most: u64, evaluator: &Evaluator<'a>) -> Option<Evaluator<'a>> {
    let robots = evaluator.station().robots().len();
    let scores = search.grasp.estimated_scores(robots) * evaluator.runs_per_value();
    let afforded = ((1.0 - FOR_TIES) * most as f64 / scores) as usize;
    let length = (evaluator.mean_items() / USUAL_ITEMS as f64).max(1.0);
    let least = ((LEAST_PATTERNS / length).ceil() as usize).max(LEAST_LONG_PATTERNS);
    let uniform = RULES.len() as f64 * evaluator.runs_per_value();
    let possible = ((most as f64 / uniform) as usize).max(1);
    let count = afforded.max(least.min(possible));
    (count < evaluator.pattern_count()).then(|| evaluator.sample(count))
}

fn resolve(search: &Search, most: Option<u64>, evaluator: &Evaluator) -> Result<SearchKind> {
    let robots = evaluator.station().robots().len();
    let rules = RULES.len() as f64;
    let all = rules.powi(robots as i32);
    let memory = all * (PER_ASSIGNMENT + PER_VALUE * evaluator.pattern_count() as f64);
    let fits = memory <= MOST_MEMORY;
    match search.kind {
        SearchKind::Auto => {
            // Passes of one robot over a pattern, the unit of both estimates.
            let enumeration: f64 = (1..=robots as i32).map(|depth| rules.powi(depth)).sum();
            let cheaper = enumeration <= search.grasp.estimated_passes(robots);
            let runs = all * evaluator.pattern_count() as f64 * evaluator.runs_per_value();
            let affordable = most.is_none_or(|most| runs <= most as f64);
            let (runs, passes) = search.grasp.estimated_parts(robots);
            let shared = evaluator.independent_patterns() == evaluator.pattern_count();
            // GRASP reuses the enumeration's scores of the whole line.
            let beside = if shared {
                passes / enumeration
            } else {
                runs / all
            };
            Ok(if !(fits && cheaper && affordable) {
                SearchKind::Grasp
            } else if beside < BESIDE {
                SearchKind::Both
            } else {
                SearchKind::Exhaustive
            })
        }
        SearchKind::Exhaustive | SearchKind::Both if !fits => Err(Error::usage(
            "'search'",
            format!(
                "the {}^{robots} assignments of {robots} robots are too many to enumerate",
                RULES.len()
            ),
            "use 'search' grasp, or fewer patterns",
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
        evaluator.places()
    };
    let (assignments, scores) = scored.into_iter().unzip();
    Evaluation {
        assignments,
        scores,
        patterns,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::Objective;
    use crate::pattern::{Pattern, grid};
    use crate::sim::{Conditions, Disturbances};
    use crate::station::{Station, built_in};

    fn station(robots: usize) -> Station {
        built_in("paper").unwrap().station(Some(robots)).unwrap()
    }

    fn grids(count: usize, items: usize) -> Vec<Pattern> {
        vec![grid(1.05, 0.3, items).unwrap(); count]
    }

    fn evaluator<'a>(station: &'a Station, patterns: &'a [Pattern], luck: bool) -> Evaluator<'a> {
        let conditions = Conditions {
            disturbances: Disturbances {
                grasp_failures: luck,
                ..Disturbances::default()
            },
            ..Conditions::default()
        };
        Evaluator::new(station, patterns, Objective::PickingRate, &conditions).unwrap()
    }

    const SEARCH: Search = Search {
        kind: SearchKind::Auto,
        grasp: Grasp {
            starts: 8,
            alpha: 0.3,
            seed: 1,
        },
        risk: Risk::Mean,
        scan: None,
        limits: Limits::NONE,
    };

    /// Passes of one robot over a pattern of 150 items, divided by robots and length.
    #[test]
    fn budgets_are_what_the_model_page_says() {
        for (robots, items, luck, runs) in [
            (1, 20, false, 36_000_000),
            (2, 150, false, 18_000_000),
            (3, 150, false, 12_000_000),
            (2, 300, false, 9_000_000),
            (2, 20, true, 2_000_000),
            (4, 300, true, 500_000),
        ] {
            let (station, patterns) = (station(robots), grids(2, items));
            let evaluator = evaluator(&station, &patterns, luck);
            let of = |most: MostRuns| most.of(&evaluator);
            assert_eq!(of(MostRuns::Usual), Some(runs), "{robots} {items} {luck}");
            let passes = 6000 / robots as u64 / (items as u64 / 150).max(1);
            assert_eq!(of(MostRuns::Passes(6000)), Some(passes));
            assert_eq!((of(MostRuns::Of(7)), of(MostRuns::Any)), (Some(7), None));
        }
    }

    /// As many patterns as all starts can use within three quarters of the runs, but at least
    /// 24 if six runs on each are available, and fewer if patterns are long.
    #[test]
    fn grasp_judges_on_what_its_runs_are_enough_for() {
        let station = station(2);
        for (items, most, count) in [
            (20, 4800, Some(24)),
            (20, 14_400, Some(30)),
            (20, 18_719, Some(38)),
            (20, 18_720, Some(39)),
            (20, 19_200, None),
            (20, 65, Some(10)),
            (20, 3, Some(1)),
            (300, 4800, Some(12)),
            (1200, 500, Some(3)),
            (1200, 4800, Some(10)),
        ] {
            let patterns = grids(40, items);
            let evaluator = evaluator(&station, &patterns, false);
            let found = sample(&SEARCH, most, &evaluator);
            let found = found.map(|sample| sample.pattern_count());
            assert_eq!(found, count, "{items} {most}");
        }
    }

    #[test]
    fn auto_enumerates_where_that_fits_its_runs() {
        let patterns = grids(5, 20);
        for (robots, most, luck, kind) in [
            (2, None, false, SearchKind::Exhaustive),
            (2, Some(180), false, SearchKind::Exhaustive),
            (2, Some(179), false, SearchKind::Grasp),
            // Six first steps in addition to 36 runs of the event loop, and 8 starts of parts
            // in addition to 6^4.
            (2, None, true, SearchKind::Exhaustive),
            (4, Some(5 * 1296), false, SearchKind::Both),
            (4, Some(5 * 1296 - 1), false, SearchKind::Grasp),
            (4, None, true, SearchKind::Both),
            (5, None, false, SearchKind::Grasp),
        ] {
            let station = station(robots);
            let evaluator = evaluator(&station, &patterns, luck);
            let found = resolve(&SEARCH, most, &evaluator).unwrap();
            assert_eq!(found, kind, "{robots} {most:?} {luck}");
        }
        for kind in [SearchKind::Exhaustive, SearchKind::Both, SearchKind::Grasp] {
            let how = Search { kind, ..SEARCH };
            let resolved = |robots| {
                let station = station(robots);
                resolve(&how, Some(1), &evaluator(&station, &patterns, false))
                    .map_err(|error| error.to_string())
            };
            assert_eq!(resolved(8), Ok(kind));
            if kind == SearchKind::Grasp {
                assert_eq!(resolved(9), Ok(kind));
            } else {
                let told = resolved(9).unwrap_err();
                let words = "'search': the 6^9 assignments of 9 robots are too many to enumerate";
                assert!(told.starts_with(words), "{told}");
            }
        }
    }

    #[test]
    fn why_a_search_ended_has_a_name() {
        let names = [
            StopReason::Enumerated,
            StopReason::LocalOptima,
            StopReason::Budget,
            StopReason::TimeLimit,
            StopReason::Interrupted,
        ]
        .map(StopReason::name);
        let words = [
            "enumerated",
            "local_optima",
            "budget",
            "time_limit",
            "interrupted",
        ];
        assert_eq!(names, words);
    }
}
