//! Evaluates the winner on fresh patterns, so that the reported figure is not the one it was
//! selected by.

use super::beside::picks_bound_beside;
use super::environment::Environment;
use super::evaluator::Evaluator;
use super::objective::{Objective, Risk};
use super::ranking::Ranked;
use crate::dispatch::RuleAssignment;
use crate::error::Result;
use crate::pattern::Pattern;
use crate::planning::bound::certified_percent;
use crate::setters::setters;
use crate::sim::{Conditions, Scene};
use crate::station::Station;
use crate::stats::{self, Interval};
use rayon::prelude::*;

/// Figures of one assignment on patterns that played no part in choosing it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Validation {
    /// Number of patterns evaluated.
    pub patterns: usize,
    /// Mean of the objective over the fresh patterns, in its unit.
    pub value: f64,
    /// 95 % interval of the mean; `None` for a single pattern.
    pub interval: Option<Interval>,
    /// The objective aggregated under the risk used in the search.
    pub at_risk: f64,
    /// Mean share of the items picked, at the station's belt speed.
    pub picked_share: f64,
    /// The objective on the worst pattern.
    pub worst: f64,
    /// Belt speed for the completion share [m/s]: the station's, or the flow chosen by a
    /// `max-speed` search.
    pub speed: f64,
    /// Number of patterns that were picked completely at that speed (Huang et al. 2015 report
    /// their share at the chosen flow).
    pub complete: usize,
    /// 95 % interval of the share of these patterns.
    pub complete_interval: Interval,
    /// Its picks compared with the bound for every strategy, if requested.
    pub certificate: Option<Certificate>,
}

/// Picks compared with the bound for every strategy.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Certificate {
    /// Number of patterns with a bound: the first of the fresh ones.
    pub patterns: usize,
    /// Upper bound on the share of their items that can be picked.
    pub picked_share: f64,
    /// Picks on these patterns as a proven share of the optimum [%], rounded down.
    pub percent: f64,
}

impl Validation {
    /// Share of the patterns that were picked completely.
    pub fn complete_share(&self) -> f64 {
        self.complete as f64 / self.patterns as f64
    }
}

/// How an assignment is validated.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ValidationOptions {
    /// How the objective is aggregated over the patterns.
    pub risk: Risk,
    /// The conditions under which the evaluator was made.
    pub conditions: Conditions,
    /// Belt speed at which completion is counted [m/s]; `None` for the station's own.
    pub flow: Option<f64>,
    /// Whether the picks at that speed are compared with the bound for every strategy.
    pub certify: bool,
}

impl ValidationOptions {
    /// Aggregated under `risk`, for an evaluator made under `conditions`; at the station's belt
    /// speed and without the bound.
    pub fn new(risk: Risk, conditions: Conditions) -> Self {
        Self {
            risk,
            conditions,
            flow: None,
            certify: false,
        }
    }
}

setters!(ValidationOptions {
    /// With completion counted at this belt speed [m/s].
    fn with_flow(flow: impl Into<Option<f64>>);
    /// With the picks compared with the bound for every strategy, or without.
    fn with_certify(certify: bool);
});

/// Scores `assignment` on the fresh patterns of `evaluator`. `None` if the user stopped.
///
/// # Errors
/// As for [`Evaluator::evaluate`], or the flow is not a valid belt speed.
pub fn validate(
    evaluator: &Evaluator,
    assignment: &RuleAssignment,
    options: &ValidationOptions,
    environment: &Environment,
) -> Result<Option<Validation>> {
    let patterns = evaluator.pattern_count();
    environment
        .progress
        .begin("validating", patterns as u64, "patterns");
    let evaluation = evaluator.evaluate(vec![assignment.clone()], environment)?;
    environment.progress.end();
    if !evaluation.is_whole(evaluator) {
        return Ok(None);
    }
    let score = &evaluation.scores[0];
    let speed = options.flow.unwrap_or(evaluator.station().belt().speed);
    let station = evaluator.station().with_belt_speed(speed)?;
    let Some(shares) = picked_shares(evaluator, assignment, &station, options, environment)? else {
        return Ok(None);
    };
    // A share of exactly 1 is k of k.
    let complete = shares.iter().filter(|share| **share == 1.0).count();
    let mut certificate = None;
    if options.certify {
        let set = evaluator.patterns();
        certificate = certify(&station, set, &options.conditions, &shares, environment)?;
        if certificate.is_none() && environment.stopped() {
            return Ok(None);
        }
    }
    Ok(Some(Validation {
        patterns,
        value: stats::mean(&score.values),
        interval: stats::mean_interval(&score.values),
        at_risk: options.risk.aggregate(&score.values),
        picked_share: score.picked_share,
        worst: score.values.iter().copied().fold(f64::INFINITY, f64::min),
        speed,
        complete,
        complete_interval: stats::share_interval(complete, patterns),
        certificate,
    }))
}

/// The share of the items of each pattern that `assignment` picks on `station`, which runs at the
/// flow of `options`. `None` if the user stopped.
fn picked_shares(
    evaluator: &Evaluator,
    assignment: &RuleAssignment,
    station: &Station,
    options: &ValidationOptions,
    environment: &Environment,
) -> Result<Option<Vec<f64>>> {
    let objective = Objective::PickedShare;
    let shares = match options.flow {
        None => evaluator.with_objective(objective),
        Some(_) => Evaluator::new(
            station,
            evaluator.patterns(),
            objective,
            &options.conditions,
        )?,
    };
    let mut shares = shares.evaluate(vec![assignment.clone()], environment)?;
    let whole = shares.patterns.len() == evaluator.pattern_count();
    Ok(whole.then(|| shares.scores.swap_remove(0).values))
}

/// Number of patterns with a bound: enough for a figure, few enough to take little time.
const CERTIFIED: usize = 100;
/// Maximum number of their items in total.
const CERTIFIED_ITEMS: f64 = 60_000.0;

/// Compares `shares` of the items of `patterns`, picked on `station`, with the bound for every
/// strategy. `None` if the user stopped, or if some patterns are another shard's.
fn certify(
    station: &Station,
    patterns: &[Pattern],
    conditions: &Conditions,
    shares: &[f64],
    environment: &Environment,
) -> Result<Option<Certificate>> {
    let items: usize = patterns.iter().map(Pattern::len).sum();
    let mean = items as f64 / patterns.len().max(1) as f64;
    let afforded = ((CERTIFIED_ITEMS / mean.max(1.0)) as usize).clamp(1, CERTIFIED);
    let patterns = &patterns[..patterns.len().min(afforded)];
    let progress = environment.progress;
    progress.begin("bounding", patterns.len() as u64, "patterns");
    let places = patterns.par_iter().enumerate();
    let ledger = environment.ledger;
    let bounded = places.zip(shares).map(|((place, pattern), share)| {
        let bound = ledger.own_unit("bounds of fresh patterns", place, || {
            // A share of n items is that of a whole number of items.
            let picked = (share * pattern.len() as f64).round() as usize;
            let scene = Scene::under(station, pattern, conditions.of_place(place))?;
            let bound = picks_bound_beside(&scene, picked, environment)?;
            Ok((picked, bound.value as usize))
        });
        progress.advance(1);
        bound
    });
    let bounded: Result<Vec<Option<(usize, usize)>>> = bounded.collect();
    progress.end();
    let bounded = match bounded {
        Err(error) if error.is_interrupted() => return Ok(None),
        bounded => bounded?,
    };
    let Some(bounded) = bounded.into_iter().collect::<Option<Vec<_>>>() else {
        return Ok(None);
    };
    let items: usize = patterns.iter().map(Pattern::len).sum();
    let picked: usize = bounded.iter().map(|(picked, _)| picked).sum();
    let most: usize = bounded.iter().map(|(_, most)| most).sum();
    Ok(Some(Certificate {
        patterns: patterns.len(),
        picked_share: most as f64 / items as f64,
        percent: certified_percent(picked as f64, most as f64),
    }))
}

/// The flow that a `max-speed` search recommends [m/s]: the smallest speed limit of its
/// patterns (Huang et al.'s minimum-maximal part flow). `None` for other objectives, and if no
/// speed picks every item of every pattern.
pub(crate) fn chosen_flow(objective: Objective, best: &Ranked) -> Option<f64> {
    (matches!(objective, Objective::MaxSpeed(_)) && best.worst > 0.0).then_some(best.worst)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::SpeedScan;

    #[test]
    fn the_flow_is_the_smallest_speed_limit() {
        let entry = |worst: f64| Ranked {
            assignment: "SPT".parse().unwrap(),
            mean: 0.5,
            value: 0.4,
            difference: None,
            tied: true,
            picked_share: 1.0,
            worst,
            worst_pattern: 0,
            max_speed: None,
        };
        let by_speed = Objective::MaxSpeed(SpeedScan::default());
        assert_eq!(chosen_flow(by_speed, &entry(0.3)), Some(0.3));
        assert_eq!(chosen_flow(by_speed, &entry(0.0)), None);
        assert_eq!(chosen_flow(Objective::PickingRate, &entry(0.3)), None);
    }
}
