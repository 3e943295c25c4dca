//! Strategies of any kind, evaluated on the winner's patterns and compared with it.

use super::environment::Environment;
use super::evaluator::{Evaluator, Score};
use super::objective::Risk;
use crate::dispatch::RuleAssignment;
use crate::error::Result;
use crate::stats::{self, Interval};
use crate::strategies::Blueprint;

/// One strategy, or the winner itself.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Rival {
    /// Mean of the objective over the patterns, in its unit.
    pub mean: f64,
    /// The objective aggregated under the risk used in the search.
    pub at_risk: f64,
    /// Mean share of the items picked, at the station's belt speed.
    pub picked_share: f64,
    /// The objective on the worst pattern.
    pub worst: f64,
    /// 95 % interval of the objective minus the winner's, paired over patterns; `None` for a
    /// single pattern.
    pub difference: Option<Interval>,
}

/// `winner` and then `strategies` in their order, all on the patterns of `evaluator`. `None` if
/// the user stopped.
///
/// # Errors
/// As for [`Evaluator::evaluate`], or a strategy acts illegally.
pub fn rivals(
    evaluator: &Evaluator,
    winner: &RuleAssignment,
    strategies: &[Blueprint],
    risk: Risk,
    environment: &Environment,
) -> Result<Option<Vec<Rival>>> {
    let patterns = evaluator.pattern_count();
    let runs = patterns * (strategies.len() + 1);
    environment
        .progress
        .begin("other strategies", runs as u64, "runs");
    let evaluation = evaluator.evaluate(vec![winner.clone()], environment)?;
    if !evaluation.is_whole(evaluator) {
        return Ok(None);
    }
    let mut scores = evaluation.scores;
    for blueprint in strategies {
        let Some(score) = evaluator.score(blueprint, environment)? else {
            return Ok(None);
        };
        scores.push(score);
    }
    environment.progress.end();
    let first = &scores[0].values;
    let rival = |score: &Score| {
        let pairs = score.values.iter().zip(first);
        let differences: Vec<f64> = pairs.map(|(value, first)| value - first).collect();
        Rival {
            mean: stats::mean(&score.values),
            at_risk: risk.aggregate(&score.values),
            picked_share: score.picked_share,
            worst: Risk::Worst.aggregate(&score.values),
            difference: stats::mean_interval(&differences),
        }
    };
    Ok(Some(scores.iter().map(rival).collect()))
}
