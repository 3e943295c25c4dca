//! The ranking of assignments, with its ties and how they are broken.

use super::environment::Environment;
use super::evaluator::{Evaluation, Evaluator};
use super::objective::{Objective, Risk};
use super::speed_limit::SpeedScan;
use crate::dispatch::RuleAssignment;
use crate::error::Result;
use crate::stats::{self, Bootstrap, Interval};
use rayon::prelude::*;

/// One assignment in the ranking.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Ranked {
    /// The rule of each robot, upstream first.
    pub assignment: RuleAssignment,
    /// Mean of the objective over the patterns.
    pub mean: f64,
    /// Aggregate of the objective; equal to the mean unless another risk is chosen.
    pub value: f64,
    /// 95 % interval of the best's aggregate minus this one's, paired over patterns; `None` for
    /// a single pattern.
    pub difference: Option<Interval>,
    /// Whether that interval contains 0; for a single pattern, whether both are equal.
    pub tied: bool,
    /// Mean share of the items picked, at the station's belt speed.
    pub picked_share: f64,
    /// The objective on its worst pattern.
    pub worst: f64,
    /// Index of that pattern in the set.
    pub worst_pattern: usize,
    /// Mean speed limit over the patterns [m/s], if it broke a tie.
    pub max_speed: Option<f64>,
}

impl Ranked {
    /// The entries of all assignments of `evaluation`, in its order, before any comparison.
    fn all(evaluation: &Evaluation, risk: Risk) -> Vec<Self> {
        let pairs = evaluation.assignments.iter().zip(&evaluation.scores);
        pairs
            .map(|(assignment, score)| {
                let (worst_place, worst) = score
                    .values
                    .iter()
                    .copied()
                    .enumerate()
                    .reduce(|a, b| if b.1 < a.1 { b } else { a })
                    .unwrap_or_default();
                Self {
                    assignment: assignment.clone(),
                    mean: stats::mean(&score.values),
                    value: risk.aggregate(&score.values),
                    difference: None,
                    tied: false,
                    picked_share: score.picked_share,
                    worst,
                    worst_pattern: evaluation.patterns[worst_place],
                    max_speed: None,
                }
            })
            .collect()
    }
}

/// All scored assignments, best first.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Ranking {
    /// The best first, then its contenders in the order in which the tie was broken, then the
    /// others by their aggregate.
    pub entries: Vec<Ranked>,
    /// The assignment with the highest aggregate before ties were broken.
    pub leader: RuleAssignment,
    /// Number of assignments, including the best, that no paired test proved worse than
    /// another; the tie was broken among them.
    pub contenders: usize,
    /// How the intervals were computed.
    pub method: String,
    /// For how many of the contenders speed limits broke ties, and over how many patterns;
    /// `None` if none did.
    pub by_speed: Option<(usize, usize)>,
    /// Whether speed limits were computed for only some of the contenders, on only some of the
    /// patterns, or not at all.
    pub cut: bool,
}

/// How ties are broken.
#[derive(Debug, Clone, Copy)]
pub struct TieBreak {
    /// Resolution of the speed limits; `None` to break ties without them.
    pub scan: Option<SpeedScan>,
    /// Maximum number of runs for them.
    pub runs: u64,
}

/// Number of highest-ranked assignments against which every assignment is tested.
pub const FRONT_RUNNERS: usize = 16;

/// Maximum work for bootstrap intervals: resampled values over all assignments.
const BOOTSTRAP_WORK: usize = 200_000_000;

impl Ranking {
    /// Ranks `evaluation`. Assignments that no paired test proves worse than another are
    /// ordered by their speed limits if there is a scan, then by their worst pattern, then by
    /// their mean, then by registry order. If the runs do not suffice for all of them, only the
    /// front-runners have speed limits, over as many patterns as possible. `None` if nothing
    /// was evaluated.
    ///
    /// # Errors
    /// As for [`Evaluator::evaluate`].
    pub fn new(
        evaluation: &Evaluation,
        evaluator: &Evaluator,
        risk: Risk,
        tie_break: TieBreak,
        environment: &Environment,
    ) -> Result<Option<Self>> {
        let Some(leader) = evaluation.leader(risk) else {
            return Ok(None);
        };
        let intervals = Intervals::new(evaluation, risk);
        let contenders = contenders(evaluation, &intervals, risk);
        let wanted = tie_break.scan.filter(|_| {
            let by_speed = matches!(evaluator.objective(), Objective::MaxSpeed(_));
            contenders.len() > 1 && !by_speed
        });
        let speeds = match wanted {
            Some(scan) => {
                let limits = evaluator.with_objective(Objective::MaxSpeed(scan));
                let each = limits.pattern_count() as f64 * limits.runs_per_value();
                let value = |place: usize| risk.aggregate(&evaluation.scores[place].values);
                let valued: Vec<_> = contenders.iter().map(|&p| (p, value(p))).collect();
                let most = tie_break.runs;
                let told_apart = affordable(&valued, each, most);
                speed_limits(&told_apart, evaluation, &limits, most, environment)?
            }
            None => None,
        };
        let cut = wanted.is_some()
            && speeds.as_ref().is_none_or(|speeds| {
                speeds.of.len() < contenders.len() || speeds.patterns < evaluator.pattern_count()
            });
        let mut entries = Ranked::all(evaluation, risk);
        for &(place, speed) in speeds.iter().flat_map(|speeds| &speeds.of) {
            entries[place].max_speed = Some(speed);
        }
        let winner = |a: usize, b: usize| match wins_tie(&entries[b], &entries[a]) {
            true => b,
            false => a,
        };
        let best = contenders.iter().copied().reduce(winner).unwrap_or(leader);
        let several = evaluation.patterns.len() > 1;
        for (entry, difference) in entries.iter_mut().zip(intervals.against(best)) {
            entry.difference = several.then_some(difference);
            entry.tied = difference.contains(0.0);
        }
        let leader = evaluation.assignments[leader].clone();
        Ok(Some(Self {
            entries: in_order(entries, &contenders),
            leader,
            contenders: contenders.len(),
            method: intervals.method(),
            by_speed: speeds.map(|speeds| (speeds.of.len(), speeds.patterns)),
            cut,
        }))
    }

    /// The assignment that is ranked first.
    pub fn best(&self) -> &Ranked {
        &self.entries[0]
    }
}

/// Indices of the assignments that no other is proven better than: those that a paired test
/// separates neither from the leader nor from any other front-runner. Ties are not transitive,
/// so comparing only with the leader could let an assignment win the tie-break although it is
/// worse than another contender.
fn contenders(evaluation: &Evaluation, intervals: &Intervals, risk: Risk) -> Vec<usize> {
    let values: Vec<f64> = evaluation
        .scores
        .iter()
        .map(|score| risk.aggregate(&score.values))
        .collect();
    let mut by_value: Vec<usize> = (0..values.len()).collect();
    by_value.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
    let mut contends = vec![true; values.len()];
    for &front in by_value.iter().take(FRONT_RUNNERS) {
        for (place, difference) in intervals.against(front).iter().enumerate() {
            contends[place] &= difference.low <= 0.0;
        }
    }
    (0..values.len()).filter(|&place| contends[place]).collect()
}

/// Higher speed limit first (those without one last), then the better worst case, then the
/// higher mean.
fn tie_order(a: &Ranked, b: &Ranked) -> std::cmp::Ordering {
    let speed = |entry: &Ranked| entry.max_speed.unwrap_or_default();
    speed(b)
        .total_cmp(&speed(a))
        .then_with(|| b.worst.total_cmp(&a.worst))
        .then_with(|| b.mean.total_cmp(&a.mean))
}

fn wins_tie(a: &Ranked, b: &Ranked) -> bool {
    tie_order(a, b).is_lt()
}

/// The entries in the order of the ranking: the contenders first.
fn in_order(entries: Vec<Ranked>, contenders: &[usize]) -> Vec<Ranked> {
    let mut contends = vec![false; entries.len()];
    for &place in contenders {
        contends[place] = true;
    }
    let mut entries: Vec<(bool, Ranked)> = contends.into_iter().zip(entries).collect();
    // The sort is stable, so equal entries stay in registry order.
    entries.sort_by(|(a_contends, a), (b_contends, b)| {
        b_contends.cmp(a_contends).then_with(|| {
            if *a_contends {
                tie_order(a, b)
            } else {
                b.value.total_cmp(&a.value)
            }
        })
    });
    entries.into_iter().map(|(_, entry)| entry).collect()
}

/// Whether `runs` suffice for the speed limits of this many assignments on this many patterns,
/// at `each` runs per limit.
fn suffices(assignments: usize, patterns: usize, each: f64, runs: u64) -> bool {
    assignments as f64 * patterns as f64 * each <= runs as f64
}

/// Whether ties are broken by speed limits on so many of `count` patterns: on at least `least`,
/// on all of them when the search was stopped.
fn are_told_apart(patterns: usize, (least, count): (usize, usize), stopped: bool) -> bool {
    patterns >= if stopped { count } else { least }
}

/// The contenders (with their aggregates, in registry order) whose speed limits can be computed
/// in about `runs`, at `each` runs per limit: all of them, or the highest, but at least the
/// front-runners.
fn affordable(contenders: &[(usize, f64)], each: f64, runs: u64) -> Vec<usize> {
    let mut highest = contenders.to_vec();
    if !suffices(contenders.len(), 1, each, runs) {
        highest.sort_by(|a, b| b.1.total_cmp(&a.1));
        highest.truncate(((runs as f64 / each) as usize).max(FRONT_RUNNERS));
    }
    let mut places: Vec<usize> = highest.into_iter().map(|(place, _)| place).collect();
    // In registry order, as everywhere.
    places.sort_unstable();
    places
}

/// Mean speed limits of some assignments, by their indices.
struct Speeds {
    of: Vec<(usize, f64)>,
    /// Number of patterns in the means.
    patterns: usize,
}

/// With fewer patterns than this, no differences are significant.
const LEAST_PATTERNS: usize = 10;

/// Mean speed limits of `contenders` in at most `runs`; `None` if these do not suffice for a
/// figure, or if the user stopped.
fn speed_limits(
    contenders: &[usize],
    evaluation: &Evaluation,
    limits: &Evaluator,
    runs: u64,
    environment: &Environment,
) -> Result<Option<Speeds>> {
    let count = limits.pattern_count();
    let least = count.min(LEAST_PATTERNS);
    if !suffices(contenders.len(), least, limits.runs_per_value(), runs) {
        return Ok(None);
    }
    let tied: Vec<RuleAssignment> = contenders
        .iter()
        .map(|&place| evaluation.assignments[place].clone())
        .collect();
    environment
        .progress
        .begin("breaking ties", count as u64, "patterns");
    // Both lists are in registry order.
    let speeds = limits.evaluate_within(tied, runs, environment)?;
    environment.progress.end();
    let patterns = speeds.patterns.len();
    if !are_told_apart(patterns, (least, count), environment.stopped()) {
        return Ok(None);
    }
    let means = speeds.scores.iter().map(|score| stats::mean(&score.values));
    Ok(Some(Speeds {
        of: contenders.iter().copied().zip(means).collect(),
        patterns,
    }))
}

/// Paired intervals between any two assignments of an evaluation.
struct Intervals<'a> {
    evaluation: &'a Evaluation,
    risk: Risk,
    bootstrap: Option<(Bootstrap, usize)>,
}

impl<'a> Intervals<'a> {
    fn new(evaluation: &'a Evaluation, risk: Risk) -> Self {
        let n = evaluation.patterns.len();
        // The mean has a t interval; the other risks have no closed form.
        let bootstrap = (risk != Risk::Mean && n > 1).then(|| {
            let work = n * evaluation.scores.len();
            let count = (BOOTSTRAP_WORK / work.max(1)).clamp(200, 2000);
            (Bootstrap::new(n, count, 0), count)
        });
        Self {
            evaluation,
            risk,
            bootstrap,
        }
    }

    fn method(&self) -> String {
        match (&self.bootstrap, self.evaluation.patterns.len()) {
            (_, 1) => "a single pattern: differences without intervals".into(),
            (Some((_, count)), _) => format!("paired bootstrap, {count} resamples"),
            (None, n) => format!("paired t interval over {n} patterns"),
        }
    }

    /// 95 % interval of `reference` minus each assignment; for a single pattern, the difference
    /// itself.
    fn against(&self, reference: usize) -> Vec<Interval> {
        let best = &self.evaluation.scores[reference].values;
        self.evaluation
            .scores
            .par_iter()
            .map(|score| match &self.bootstrap {
                Some((bootstrap, _)) => {
                    bootstrap.difference(best, &score.values, |v| self.risk.aggregate_in(v))
                }
                None => {
                    let differences: Vec<f64> =
                        best.iter().zip(&score.values).map(|(a, b)| a - b).collect();
                    stats::mean_interval(&differences)
                        .unwrap_or_else(|| Interval::point(stats::mean(&differences)))
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_suffice_up_to_the_last_one() {
        assert!(suffices(3, 10, 2.5, 75));
        assert!(!suffices(3, 10, 2.5, 74));
        assert!(suffices(0, 10, 2.5, 0));
    }

    #[test]
    fn few_patterns_break_ties_unless_the_search_was_stopped() {
        for (patterns, stopped, enough) in [
            (23, false, false),
            (24, false, true),
            (99, false, true),
            (24, true, false),
            (99, true, false),
            (100, true, true),
        ] {
            let found = are_told_apart(patterns, (24, 100), stopped);
            assert_eq!(found, enough, "{patterns} {stopped}");
        }
    }

    #[test]
    fn too_few_runs_are_for_the_highest_contenders() {
        // Twenty contenders, later ones with higher values, under different indices.
        let contenders: Vec<(usize, f64)> = (0..20).map(|i| (3 * i, i as f64)).collect();
        let places = |from: usize| (from..20).map(|i| 3 * i).collect::<Vec<_>>();
        assert_eq!(affordable(&contenders, 10.0, 200), places(0));
        assert_eq!(affordable(&contenders, 10.0, 199), places(1));
        assert_eq!(affordable(&contenders, 10.0, 170), places(3));
        // Never fewer than the front-runners.
        assert_eq!(
            affordable(&contenders, 10.0, 150),
            places(20 - FRONT_RUNNERS)
        );
        assert_eq!(affordable(&contenders, 10.0, 0), places(20 - FRONT_RUNNERS));
    }
}
