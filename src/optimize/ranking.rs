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
#[derive(Debug, Clone, PartialEq)]
pub struct Ranked {
    /// The assignment.
    pub assignment: RuleAssignment,
    /// Its mean of the objective.
    pub mean: f64,
    /// Its aggregate of the objective, the mean again unless risk says otherwise.
    pub value: f64,
    /// 95 % interval of the best's aggregate minus this one's, paired over patterns; none
    /// on a single pattern.
    pub difference: Option<Interval>,
    /// Whether that interval contains 0; on a single pattern, whether they are equal.
    pub tied: bool,
    /// Mean share of the items picked, at the station's belt speed.
    pub picked_share: f64,
    /// The objective on its worst pattern.
    pub worst: f64,
    /// Place of that pattern in the set.
    pub worst_pattern: usize,
    /// Mean speed limit over the patterns [m/s], where a tie was broken by it.
    pub max_speed: Option<f64>,
}

/// All scored assignments, the best first.
#[derive(Debug, Clone)]
pub struct Ranking {
    /// The best first; then its contenders in the order in which the tie was broken;
    /// then the others by their aggregate.
    pub entries: Vec<Ranked>,
    /// The assignment with the highest aggregate before ties were broken.
    pub leader: RuleAssignment,
    /// How many assignments, the best included, no paired test proved worse than
    /// another, so that the tie was broken among them.
    pub contenders: usize,
    /// How the intervals were made.
    pub method: String,
}

/// How many of the highest aggregates every assignment is tested against.
pub const FRONT_RUNNERS: usize = 16;

/// Work that bootstrap intervals may take: resampled values over all assignments.
const BOOTSTRAP_WORK: usize = 200_000_000;

impl Ranking {
    /// Ranks `evaluation`. Those that no paired test proves worse than another are
    /// told apart by their speed limits if there is a `scan`, then by their worst pattern, then by
    /// their mean, then by registry order. None when nothing was evaluated.
    ///
    /// # Errors
    /// As for [`Evaluator::evaluate`].
    pub fn new(
        evaluation: &Evaluation,
        evaluator: &Evaluator,
        risk: Risk,
        scan: Option<SpeedScan>,
        environment: &Environment,
    ) -> Result<Option<Self>> {
        let Some(leader) = evaluation.leader(risk) else {
            return Ok(None);
        };
        let intervals = Intervals::new(evaluation, risk);
        let contenders = contenders(evaluation, &intervals, risk);
        let speeds = speed_limits(&contenders, evaluation, evaluator, scan, environment)?;
        let mut entries: Vec<Ranked> = evaluation
            .assignments
            .iter()
            .zip(&evaluation.scores)
            .map(|(assignment, score)| {
                let (worst_place, worst) = score
                    .values
                    .iter()
                    .copied()
                    .enumerate()
                    .reduce(|a, b| if b.1 < a.1 { b } else { a })
                    .unwrap_or_default();
                Ranked {
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
            .collect();
        for (&place, speed) in contenders.iter().zip(speeds) {
            entries[place].max_speed = speed;
        }
        let best = contenders
            .iter()
            .copied()
            .reduce(|a, b| {
                if wins_tie(&entries[b], &entries[a]) {
                    b
                } else {
                    a
                }
            })
            .unwrap_or(leader);
        let several = evaluation.patterns.len() > 1;
        for (entry, difference) in entries.iter_mut().zip(intervals.against(best)) {
            entry.difference = several.then_some(difference);
            entry.tied = difference.contains(0.0);
        }
        let leader = evaluation.assignments[leader].clone();
        let mut contends = vec![false; entries.len()];
        for &place in &contenders {
            contends[place] = true;
        }
        let mut entries: Vec<(bool, Ranked)> = contends.into_iter().zip(entries).collect();
        // Stable, so what is equal in everything stays in registry order.
        entries.sort_by(|(a_contends, a), (b_contends, b)| {
            b_contends.cmp(a_contends).then_with(|| {
                if *a_contends {
                    tie_order(a, b)
                } else {
                    b.value.total_cmp(&a.value)
                }
            })
        });
        Ok(Some(Self {
            entries: entries.into_iter().map(|(_, entry)| entry).collect(),
            leader,
            contenders: contenders.len(),
            method: intervals.method(),
        }))
    }

    /// The winner.
    pub fn best(&self) -> &Ranked {
        &self.entries[0]
    }
}

/// Places of the assignments than which no other is proven better: those that a paired
/// test separates neither from the leader nor from any other of the front-runners.
/// Being tied is not transitive, so comparing with the leader alone could let an
/// assignment win the tie-break that is worse than another contender.
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

/// Higher speed limit first, then the better worst case, then the higher mean.
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

/// Mean speed limit of each contender; none where there is nothing to break: a single
/// contender, or the objective is the speed limit itself, or no scan is wanted, or the user
/// stopped.
fn speed_limits(
    contenders: &[usize],
    evaluation: &Evaluation,
    evaluator: &Evaluator,
    scan: Option<SpeedScan>,
    environment: &Environment,
) -> Result<Vec<Option<f64>>> {
    let none = vec![None; contenders.len()];
    let by_speed = matches!(evaluator.objective(), Objective::MaxSpeed(_));
    let Some(scan) = scan.filter(|_| contenders.len() > 1 && !by_speed) else {
        return Ok(none);
    };
    let limits = evaluator.with_objective(Objective::MaxSpeed(scan));
    let tied: Vec<RuleAssignment> = contenders
        .iter()
        .map(|&place| evaluation.assignments[place].clone())
        .collect();
    environment
        .progress
        .begin("breaking ties", limits.pattern_count() as u64, "patterns");
    // Both lists are in registry order.
    let speeds = limits.evaluate(tied, environment)?;
    environment.progress.end();
    if !speeds.is_whole(&limits) {
        return Ok(none);
    }
    Ok(speeds
        .scores
        .iter()
        .map(|score| Some(stats::mean(&score.values)))
        .collect())
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
        // The mean has a t interval; for the others there is none in closed form.
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
            (_, 1) => "a single pattern: differences without interval".into(),
            (Some((_, count)), _) => format!("paired bootstrap, {count} resamples"),
            (None, n) => format!("paired t interval over {n} patterns"),
        }
    }

    /// 95 % interval of `reference` minus each assignment; the difference itself on a
    /// single pattern, of which it is the whole.
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
