//! Finds the best assignment: chooses the method, runs it, and ranks what it scored.

use super::environment::{Deadline, Environment};
use super::evaluator::{Evaluation, Evaluator};
use super::exact::{self, Proof, prove};
use super::grasp::GraspOutcome;
use super::objective::Risk;
use super::ranking::{Ranking, TieBreak};
use super::search::{Optimum, Search, SearchKind, StopReason, USUAL_ITEMS};
use crate::dispatch::{RULES, RuleAssignment};
use crate::error::{Error, Result};
use crate::shards::none_complete;

/// Maximum memory for an enumeration, or for branch and bound if it is chosen automatically [bytes].
const MOST_MEMORY: f64 = 2e9;
/// Memory per assignment, for lists, the ranking and the report, and memory per assignment and
/// pattern [bytes]; measured.
const PER_ASSIGNMENT: f64 = 800.0;
const PER_VALUE: f64 = 24.0;

/// Share of the runs that GRASP may use before branch and bound.
const BEFORE_PROOF: f64 = 0.25;
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
    let find = || find_by(kind, max_runs, evaluator, search, environment);
    if splits(kind, max_runs.unwrap_or(u64::MAX), evaluator) {
        return find();
    }
    environment.ledger.shared("search", find)
}

/// Whether shards score all assignments on patterns of their own; otherwise each makes the whole search,
/// whose steps depend on those before.
fn splits(kind: SearchKind, most: u64, evaluator: &Evaluator) -> bool {
    let all = (RULES.len() as f64).powi(evaluator.station().robots().len() as i32);
    let runs = all * evaluator.pattern_count() as f64;
    enumerates(kind) && evaluator.runs_per_value() == 1.0 && runs <= most as f64
}

/// Searches by `kind`, which is not `Auto`.
fn find_by(
    kind: SearchKind,
    max_runs: Option<u64>,
    evaluator: &Evaluator,
    search: &Search,
    environment: &Environment,
) -> Result<Optimum> {
    let deadline = Deadline {
        other: environment.stop,
        at: search.limits.until,
    };
    let within = Environment {
        stop: &deadline,
        ..*environment
    };
    let most = max_runs.unwrap_or(u64::MAX);
    let sampled = match (kind, max_runs) {
        (SearchKind::Grasp, Some(most)) => sample(search, most, evaluator),
        _ => None,
    };
    let judge = sampled.as_ref().unwrap_or(evaluator);
    let began = judge.runs();
    let left = || most.saturating_sub(judge.runs() - began);
    let found = run_methods(kind, search, judge, &left, &within)?;
    let tie_break = TieBreak {
        scan: search.scan,
        runs: left(),
    };
    let ranking = Ranking::new(&found.evaluation, judge, search.risk, tie_break, &within)?
        .ok_or_else(|| nothing_scored(environment))?;
    let proven = found.proof.is_some() && !found.cut;
    let cut = sampled.is_some() || found.cut || ranking.cut;
    Ok(Optimum {
        kind,
        stop: match cut {
            // However far breaking ties came.
            _ if proven => StopReason::Proven,
            _ if environment.stopped() => StopReason::Interrupted,
            true if environment.ledger.is_partial() => StopReason::Interrupted,
            true if deadline.passed() => StopReason::TimeLimit,
            true => StopReason::Budget,
            false if enumerates(kind) => StopReason::Enumerated,
            false => StopReason::LocalOptima,
        },
        ranking,
        grasp_gap: found.gap(kind, search.risk),
        grasp: found.grasp,
        proof: found.proof,
        runs: judge.runs() - began,
        max_runs,
        patterns: found.evaluation.patterns.len(),
    })
}

/// What the methods of a search found.
struct MethodsOutcome {
    /// The scores of the enumeration, or else of everything that GRASP scored.
    evaluation: Evaluation,
    /// What GRASP found, if it ran.
    grasp: Option<GraspOutcome>,
    /// What branch and bound proved, if it ran.
    proof: Option<Proof>,
    /// Whether a method was stopped or used up its runs.
    cut: bool,
}

impl MethodsOutcome {
    /// GRASP's gap to the optimum in units of the objective, if both methods ran.
    fn gap(&self, kind: SearchKind, risk: Risk) -> Option<f64> {
        let grasp = self.grasp.as_ref();
        let grasp = grasp.filter(|grasp| enumerates(kind) && grasp.best.is_some())?;
        let leader = self.evaluation.leader(risk)?;
        Some(risk.aggregate(&self.evaluation.scores[leader].values) - grasp.value)
    }
}

/// Whether a search of this kind enumerates.
fn enumerates(kind: SearchKind) -> bool {
    matches!(kind, SearchKind::Exhaustive | SearchKind::Both)
}

/// Runs the methods of `kind` on the patterns of `judge`; `left` says how many runs are left.
fn run_methods(
    kind: SearchKind,
    search: &Search,
    judge: &Evaluator,
    left: &dyn Fn() -> u64,
    environment: &Environment,
) -> Result<MethodsOutcome> {
    let mut cut = false;
    let mut enumeration = None;
    if enumerates(kind) {
        let evaluation = enumerate(judge, left(), environment)?;
        cut = !evaluation.is_whole(judge);
        enumeration = Some(evaluation);
    }
    let mut grasp = None;
    if !matches!(kind, SearchKind::Exhaustive) && !cut {
        let most = match kind {
            SearchKind::Exact => (left() as f64 * BEFORE_PROOF) as u64,
            _ => left(),
        };
        let known = enumeration.as_ref();
        let (outcome, scored) = run_grasp(judge, search, known, most, environment)?;
        cut = outcome.cut;
        grasp = Some(outcome);
        enumeration.get_or_insert(scored);
    }
    let mut evaluation = enumeration.unwrap_or_default();
    let mut proof = None;
    if kind == SearchKind::Exact {
        let most = (left() as f64 * (1.0 - FOR_TIES)) as u64;
        let outcome = prove(judge, search.risk, evaluation, most, environment)?;
        evaluation = outcome.evaluation;
        proof = Some(outcome.proof);
        cut = outcome.cut;
    }
    Ok(MethodsOutcome {
        evaluation,
        grasp,
        proof,
        cut,
    })
}

/// Runs GRASP with the scores of `enumeration`, if there is one. Otherwise it leaves a share of the
/// `left` runs for breaking ties.
fn run_grasp(
    judge: &Evaluator,
    search: &Search,
    enumeration: Option<&Evaluation>,
    left: u64,
    environment: &Environment,
) -> Result<(GraspOutcome, Evaluation)> {
    let share = if enumeration.is_some() { 0.0 } else { FOR_TIES };
    let runs = (left as f64 * (1.0 - share)) as u64;
    let starts = search.grasp.starts as u64;
    environment.progress.begin("GRASP", starts, "starts");
    let outcome = search
        .grasp
        .run(judge, search.risk, enumeration, runs, environment)?;
    environment.progress.end();
    Ok(outcome)
}

/// Why there is no result.
fn nothing_scored(environment: &Environment) -> Error {
    if environment.stopped() {
        return Error::interrupted();
    }
    Error::usage(
        "'until'",
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
    let evaluation = match splits(SearchKind::Exhaustive, most, evaluator) {
        true => evaluator.evaluate_units("enumeration", all, environment)?,
        false => evaluator.evaluate_within(all, most, environment)?,
    };
    environment.progress.end();
    if evaluation.patterns.is_empty() && environment.ledger.is_partial() {
        return Err(none_complete("pattern"));
    }
    if evaluation.patterns.is_empty() && !environment.stopped() {
        return Err(Error::usage(
            "'runs'",
            format!("{most} runs are too few for {count} assignments on one pattern"),
            "give more runs, or use 'kind' grasp",
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

/// The method of `search` on the patterns of `evaluator`, within `most` runs: never `Auto`.
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
                // GRASP goes first, and must at least score every rule for all robots.
                let uniform = (RULES.len() * evaluator.pattern_count()) as f64;
                let suffices = |most: u64| {
                    let whole = sample(search, most, evaluator).is_none();
                    whole && uniform <= BEFORE_PROOF * most as f64
                };
                let takes = exact::check(evaluator).is_ok();
                let fits = exact::memory(evaluator) <= MOST_MEMORY;
                match takes && fits && most.is_none_or(suffices) {
                    true => SearchKind::Exact,
                    false => SearchKind::Grasp,
                }
            } else if beside < BESIDE {
                SearchKind::Both
            } else {
                SearchKind::Exhaustive
            })
        }
        SearchKind::Exhaustive | SearchKind::Both if !fits => Err(Error::usage(
            "'kind'",
            format!(
                "the {}^{robots} assignments of {robots} robots are too many to enumerate",
                RULES.len()
            ),
            "use 'kind' grasp, or fewer patterns",
        )),
        kind => Ok(kind),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::{Grasp, Limits, MostRuns, Objective};
    use crate::pattern::{Pattern, grid};
    use crate::sim::{Conditions, Disturbances};
    use crate::station::{Station, built_in};

    fn station(robots: usize) -> Station {
        built_in("paper").unwrap().station(Some(robots)).unwrap()
    }

    fn grids(count: usize, items: usize) -> Vec<Pattern> {
        vec![grid(1.05, 0.3, items).unwrap(); count]
    }

    fn evaluator<'a>(station: &'a Station, patterns: &'a [Pattern], fails: bool) -> Evaluator<'a> {
        let conditions = Conditions {
            disturbances: Disturbances {
                grasp_failures: fails,
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
        for (robots, items, fails, runs) in [
            (1, 20, false, 36_000_000),
            (2, 150, false, 18_000_000),
            (3, 150, false, 12_000_000),
            (2, 300, false, 9_000_000),
            (2, 20, true, 2_000_000),
            (4, 300, true, 500_000),
        ] {
            let (station, patterns) = (station(robots), grids(2, items));
            let evaluator = evaluator(&station, &patterns, fails);
            let of = |most: MostRuns| most.of(&evaluator);
            assert_eq!(of(MostRuns::Usual), Some(runs), "{robots} {items} {fails}");
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
        for (robots, most, fails, kind) in [
            (2, None, false, SearchKind::Exhaustive),
            (2, Some(180), false, SearchKind::Exhaustive),
            (2, Some(179), false, SearchKind::Exact),
            // A quarter is not enough for each rule on each pattern.
            (2, Some(119), false, SearchKind::Grasp),
            // Six first steps in addition to 36 runs of the event loop, and 8 starts of parts
            // in addition to 6^4.
            (2, None, true, SearchKind::Exhaustive),
            (4, Some(5 * 1296), false, SearchKind::Both),
            (4, Some(5 * 1296 - 1), false, SearchKind::Exact),
            (4, None, true, SearchKind::Both),
            // Attempts may fail, or the runs are not enough for all patterns.
            (5, None, true, SearchKind::Grasp),
            (5, Some(20), false, SearchKind::Grasp),
            (5, None, false, SearchKind::Exact),
        ] {
            let station = station(robots);
            let evaluator = evaluator(&station, &patterns, fails);
            let found = resolve(&SEARCH, most, &evaluator).unwrap();
            assert_eq!(found, kind, "{robots} {most:?} {fails}");
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
                let words = "'kind': the 6^9 assignments of 9 robots are too many to enumerate";
                assert!(told.starts_with(words), "{told}");
            }
        }
    }
}
