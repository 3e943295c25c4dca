//! Evaluates assignments on patterns with common random numbers.

use super::environment::Environment;
use super::objective::{Objective, Risk};
use crate::dispatch::RuleAssignment;
use crate::error::{Error, Result};
use crate::pattern::{Pattern, random_stream};
use crate::sim::{AssignmentTree, Conditions, Scene, check_offered, simulate_while};
use crate::station::Station;
use crate::stats;
use crate::strategies::Blueprint;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// The score of one assignment on the patterns.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Score {
    /// The objective on each pattern.
    pub values: Vec<f64>,
    /// Share of the items picked at the station's own belt speed, averaged over patterns.
    pub picked_share: f64,
}

/// The scores of a batch of assignments.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Evaluation {
    /// The assignments, in registry order.
    pub assignments: Vec<RuleAssignment>,
    /// The scores, one per assignment.
    pub scores: Vec<Score>,
    /// Indices of the patterns in the scores; all of them unless the work was stopped.
    pub patterns: Vec<usize>,
}

/// Number of patterns run first to estimate the cost of the others.
const TRIAL: usize = 8;
/// Approximate number of parts in which the others are evaluated if their costs differ; each
/// part may then take this many times the mean cost.
const PARTS: usize = 4;

/// Number of patterns to evaluate next if there are runs left for `afforded`. The first part only
/// estimates the cost.
fn next_part(afforded: usize, first: bool) -> usize {
    let part = (afforded / PARTS).max(1);
    if first { part.min(TRIAL) } else { part }
}

/// Objective and picked share of every assignment on one pattern.
type OnPattern = (Vec<f64>, Vec<f64>);

/// Runs assignments on patterns. Every assignment runs on the same patterns, patterns are
/// distributed over threads, and no figure depends on the number of threads.
pub struct Evaluator<'a> {
    station: &'a Station,
    patterns: &'a [Pattern],
    /// Like the fields below, shared with evaluators of other objectives made from this one.
    scenes: Arc<Vec<Scene<'a>>>,
    objective: Objective,
    runs: Arc<AtomicU64>,
    passes: Arc<AtomicU64>,
    /// The order in which the patterns are evaluated: random, so that an interrupted search
    /// ranks by a sample of the set rather than its first part.
    order: Arc<Vec<usize>>,
}

impl<'a> Evaluator<'a> {
    /// An evaluator of `objective` for `station` on `patterns` under `conditions`. If failures
    /// are simulated, pattern i draws its random events from the conditions' seed + i, for every
    /// assignment.
    ///
    /// # Errors
    /// No pattern, one that does not fit on the belt, invalid conditions, or no item that is to be
    /// picked.
    pub fn new(
        station: &'a Station,
        patterns: &'a [Pattern],
        objective: Objective,
        conditions: &Conditions,
    ) -> Result<Self> {
        if patterns.is_empty() {
            return Err(Error::usage(
                "'patterns'",
                "the set has no pattern to score on",
                "give one or more patterns",
            ));
        }
        let scenes = patterns
            .par_iter()
            .enumerate()
            .map(|(place, pattern)| Scene::under(station, pattern, conditions.of_place(place)))
            .collect::<Result<_>>()?;
        check_offered(station, patterns)?;
        let mut order: Vec<usize> = (0..patterns.len()).collect();
        order.shuffle(&mut random_stream(0, 0));
        Ok(Self {
            station,
            patterns,
            scenes: Arc::new(scenes),
            objective,
            runs: Arc::default(),
            passes: Arc::default(),
            order: Arc::new(order),
        })
    }

    /// The same patterns with another objective.
    pub fn with_objective(&self, objective: Objective) -> Self {
        Self {
            station: self.station,
            patterns: self.patterns,
            scenes: Arc::clone(&self.scenes),
            objective,
            runs: Arc::clone(&self.runs),
            passes: Arc::clone(&self.passes),
            order: Arc::clone(&self.order),
        }
    }

    /// The station on which assignments are scored.
    pub fn station(&self) -> &'a Station {
        self.station
    }

    /// The figure by which assignments are scored.
    pub fn objective(&self) -> Objective {
        self.objective
    }

    /// The patterns on which assignments are scored.
    pub fn patterns(&self) -> &'a [Pattern] {
        self.patterns
    }

    /// How many patterns there are.
    pub fn pattern_count(&self) -> usize {
        self.order.len()
    }

    /// The same evaluator on only `count` of the patterns. They are drawn at random; larger
    /// counts include the same patterns. If there are no more than `count`, all are used.
    pub fn sample(&self, count: usize) -> Self {
        let mut sample = self.with_objective(self.objective);
        sample.order = Arc::new(self.order[..count.min(self.order.len())].to_vec());
        sample
    }

    /// The same evaluator on the patterns with these indices only.
    pub(super) fn on_places(&self, places: &[usize]) -> Self {
        let mut some = self.with_objective(self.objective);
        some.order = Arc::new(places.to_vec());
        some
    }

    /// The pattern with this index on the station.
    pub(super) fn scene(&self, place: usize) -> &Scene<'a> {
        &self.scenes[place]
    }

    /// Counts `runs` that were made elsewhere, in `passes` of one robot.
    pub(super) fn count(&self, runs: u64, passes: u64) {
        self.runs.fetch_add(runs, Ordering::Relaxed);
        self.passes.fetch_add(passes, Ordering::Relaxed);
    }

    /// Indices of the patterns on which it evaluates.
    pub(super) fn places(&self) -> Vec<usize> {
        let mut places = self.order.to_vec();
        places.sort_unstable();
        places
    }

    /// The scenes on which it evaluates, in the order of [`Evaluator::places`].
    pub(super) fn scenes(&self) -> impl Iterator<Item = &Scene<'a>> {
        self.places().into_iter().map(|place| &self.scenes[place])
    }

    /// Counts runs that were made without it.
    pub(super) fn count_runs(&self, runs: u64) {
        self.runs.fetch_add(runs, Ordering::Relaxed);
    }

    /// Number of patterns on which the robots are independent, so that the cascade can be used.
    pub fn independent_patterns(&self) -> usize {
        let independent = |place: &&usize| self.scenes[**place].is_independent();
        self.order.iter().filter(independent).count()
    }

    /// Mean number of items in the patterns on which it evaluates.
    pub(super) fn mean_items(&self) -> f64 {
        let items: usize = self.order.iter().map(|&p| self.patterns[p].len()).sum();
        items as f64 / self.order.len().max(1) as f64
    }

    /// Approximate number of runs needed to score one assignment on one pattern.
    pub(super) fn runs_per_value(&self) -> f64 {
        match self.objective {
            Objective::MaxSpeed(scan) => scan.expected_steps(self.station),
            _ => 1.0,
        }
    }

    /// Runs so far, by this evaluator and those made from it: one assignment on one pattern at
    /// one belt speed each.
    pub fn runs(&self) -> u64 {
        self.runs.load(Ordering::Relaxed)
    }

    /// Passes of one robot at the station's own belt speed so far, by this evaluator and those made
    /// from it. Assignments that begin alike share them, so there are fewer than robots times runs.
    pub fn passes(&self) -> u64 {
        self.passes.load(Ordering::Relaxed)
    }

    /// Scores `assignments` and reports each completed pattern as progress. If an assignment is
    /// shorter than the line, the robots beyond its end stay idle.
    ///
    /// # Errors
    /// There are more rules than robots.
    pub fn evaluate(
        &self,
        assignments: Vec<RuleAssignment>,
        environment: &Environment,
    ) -> Result<Evaluation> {
        self.evaluate_within(assignments, u64::MAX, environment)
    }

    /// Like [`Evaluator::evaluate`], with every pattern a unit of the work called `name`.
    ///
    /// # Errors
    /// As for [`Evaluator::evaluate`]; [`Sharded`](crate::error::ErrorKind::Sharded) in a shard.
    pub(super) fn evaluate_units(
        &self,
        name: &str,
        assignments: Vec<RuleAssignment>,
        environment: &Environment,
    ) -> Result<Evaluation> {
        let ledger = environment.ledger;
        let tree = AssignmentTree::new(assignments);
        let before = self.runs();
        let on_place = |&place: &usize| {
            if environment.stopped() {
                return None;
            }
            let made = ledger.unit(name, place, || {
                let scene = &self.scenes[place];
                let values = self.on_pattern(scene, &tree, u64::MAX, environment)?;
                values.ok_or_else(Error::interrupted)
            });
            environment.progress.advance(1);
            match made {
                Err(error) if error.is_interrupted() => None,
                made => made.map(|values| Some((place, values?))).transpose(),
            }
        };
        let own = self.order.iter().copied();
        let own: Vec<usize> = own.filter(|&place| ledger.owns(place)).collect();
        let done = own.par_iter().filter_map(on_place);
        let done: Vec<(usize, OnPattern)> = done.collect::<Result<_>>()?;
        if ledger.shard().is_some() {
            return Err(match done.len() == own.len() {
                true => Error::sharded(),
                false => Error::interrupted(),
            });
        }
        // Those that were made elsewhere count too.
        let runs = (done.len() * tree.assignments().len()) as u64;
        self.count_runs(runs - (self.runs() - before));
        Ok(Evaluation::new(tree.assignments().to_vec(), done))
    }

    /// Like [`Evaluator::evaluate`], in at most `most` runs. If these do not suffice, only as
    /// many patterns as possible are evaluated, perhaps none. Runs are counted, not timed, so
    /// equal input gives equal results on every machine.
    ///
    /// # Errors
    /// As for [`Evaluator::evaluate`].
    pub fn evaluate_within(
        &self,
        assignments: Vec<RuleAssignment>,
        most: u64,
        environment: &Environment,
    ) -> Result<Evaluation> {
        let tree = AssignmentTree::new(assignments);
        let on_place = |place: usize, allowance: u64| {
            if environment.stopped() {
                return None;
            }
            let result = self.on_pattern(&self.scenes[place], &tree, allowance, environment);
            if let Ok(Some(_)) = &result {
                environment.progress.advance(1);
            }
            Some(result.map(|values| (place, values)))
        };
        let began = self.runs();
        let mut done: Vec<(usize, OnPattern)> = Vec::with_capacity(self.order.len());
        let mut left: Vec<usize> = self.order.to_vec();
        // The cost of a pattern is known once some are done, or in advance if there is only one
        // speed.
        let mut cost = tree.assignments().len() as f64 * self.runs_per_value();
        // Speed limits of some patterns take far more runs than those of others, so they are
        // computed in parts for which the runs more than suffice.
        let in_parts = matches!(self.objective, Objective::MaxSpeed(_)) && most < u64::MAX;
        let mut first = true;
        while !left.is_empty() && !environment.stopped() {
            let over = most.saturating_sub(self.runs() - began);
            let afforded = (over as f64 / cost.max(1.0)) as usize;
            if afforded == 0 {
                break;
            }
            let part = if in_parts {
                next_part(afforded, first)
            } else {
                afforded
            };
            let count = part.min(left.len());
            first = false;
            let later = left.split_off(count);
            let allowance = over / count as u64;
            let results = left.par_iter();
            let results = results.filter_map(|&place| on_place(place, allowance));
            let results: Vec<(usize, Option<OnPattern>)> = results.collect::<Result<_>>()?;
            let before = done.len();
            left = later;
            for (place, found) in results {
                match found {
                    Some(found) => done.push((place, found)),
                    // Retried later, when there are more runs for each.
                    None => left.push(place),
                }
            }
            if done.len() == before {
                break;
            }
            cost = (self.runs() - began) as f64 / done.len() as f64;
        }
        Ok(Evaluation::new(tree.assignments().to_vec(), done))
    }

    /// Scores a strategy of any kind on the same patterns, each of which is a unit of work, and reports
    /// each as progress. `None` if stopped, or if some patterns are another shard's.
    ///
    /// # Errors
    /// The strategy acts illegally.
    pub fn score(&self, strategy: &Blueprint, environment: &Environment) -> Result<Option<Score>> {
        let on_pattern = |scene: &Scene| {
            let run = |scene: &Scene| {
                let go_on = || !environment.stopped();
                Ok(simulate_while(scene, strategy.make().as_mut(), go_on)?.figures)
            };
            let figures = run(scene)?;
            let value = match self.objective {
                Objective::MaxSpeed(scan) => {
                    scan.limit(self.station, scene.pattern(), scene.conditions(), run)?
                }
                objective => objective.of_run(&figures).unwrap_or_default(),
            };
            environment.progress.advance(1);
            Ok((value, figures.picked_share()))
        };
        let name = format!("runs of {}", strategy.name());
        let ledger = environment.ledger;
        let on_place =
            |(place, scene): (usize, &Scene)| ledger.own_unit(&name, place, || on_pattern(scene));
        let runs = self.scenes.par_iter().enumerate().map(on_place);
        let runs: Vec<Option<(f64, f64)>> = match runs.collect::<Result<_>>() {
            Err(error) if error.is_interrupted() => return Ok(None),
            runs => runs?,
        };
        let Some(runs) = runs.into_iter().collect::<Option<Vec<_>>>() else {
            return Ok(None);
        };
        let (values, shares): (Vec<f64>, Vec<f64>) = runs.into_iter().unzip();
        Ok(Some(Score {
            values,
            picked_share: stats::mean(&shares),
        }))
    }

    /// Objective and picked share of every assignment on one pattern; `None` if stopped, or if
    /// `most` runs do not suffice.
    fn on_pattern(
        &self,
        scene: &Scene,
        tree: &AssignmentTree,
        most: u64,
        environment: &Environment,
    ) -> Result<Option<OnPattern>> {
        let count = tree.assignments().len();
        let (mut values, mut shares) = (vec![0.0; count], vec![0.0; count]);
        let go_on = || !environment.stopped();
        let passes = tree.evaluate_passes(scene, go_on, |place, figures, _| {
            shares[place] = figures.picked_share();
            values[place] = self.objective.of_run(&figures).unwrap_or_default();
        })?;
        let Some(passes) = passes else {
            return Ok(None);
        };
        self.passes.fetch_add(passes, Ordering::Relaxed);
        let runs = count as u64;
        self.runs.fetch_add(runs, Ordering::Relaxed);
        if let Objective::MaxSpeed(scan) = self.objective {
            let most = most.saturating_sub(runs);
            let (pattern, conditions) = (scene.pattern(), scene.conditions());
            let (limits, more) =
                scan.limits_within(self.station, pattern, tree, conditions, most)?;
            self.runs.fetch_add(more, Ordering::Relaxed);
            let Some(limits) = limits else {
                return Ok(None);
            };
            values = limits;
        }
        Ok(Some((values, shares)))
    }
}

impl Evaluation {
    /// The scores of `assignments` from what they scored on each pattern, by its index.
    fn new(assignments: Vec<RuleAssignment>, mut done: Vec<(usize, OnPattern)>) -> Self {
        done.sort_unstable_by_key(|(place, _)| *place);
        let (patterns, done): (Vec<usize>, Vec<_>) = done.into_iter().unzip();
        let score = |a: usize| Score {
            values: done.iter().map(|(values, _)| values[a]).collect(),
            picked_share: done.iter().map(|(_, shares)| shares[a]).sum::<f64>() / done.len() as f64,
        };
        Self {
            scores: (0..assignments.len()).map(score).collect(),
            assignments,
            patterns,
        }
    }

    /// Whether every pattern of `evaluator` was evaluated.
    pub fn is_whole(&self, evaluator: &Evaluator) -> bool {
        self.patterns.len() == evaluator.pattern_count()
    }

    /// Index of the assignment with the highest aggregate, the first of ties; `None` if nothing
    /// was evaluated.
    pub fn leader(&self, risk: Risk) -> Option<usize> {
        if self.patterns.is_empty() {
            return None;
        }
        let mut best: Option<(usize, f64)> = None;
        for (place, score) in self.scores.iter().enumerate() {
            let value = risk.aggregate(&score.values);
            if best.is_none_or(|(_, highest)| value > highest) {
                best = Some((place, value));
            }
        }
        best.map(|(place, _)| place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::SpeedScan;
    use crate::pattern::grid;
    use crate::station::built_in;

    #[test]
    fn the_first_part_is_a_trial_and_the_others_a_quarter() {
        for (afforded, first, part) in [
            (1, true, 1),
            (1, false, 1),
            (7, false, 1),
            (8, true, 2),
            (31, false, 7),
            (32, true, 8),
            (400, true, 8),
            (400, false, 100),
        ] {
            assert_eq!(next_part(afforded, first), part, "{afforded} {first}");
        }
    }

    /// Patterns whose speed limits take different numbers of runs.
    #[test]
    fn speed_limits_are_sought_on_as_many_patterns_as_the_runs_are_enough_for() {
        let station = built_in("paper").unwrap().station(Some(2)).unwrap();
        let spacings = (0..16).map(|i| 0.18 + 0.02 * f64::from(i));
        let patterns: Vec<Pattern> = spacings
            .map(|spacing| grid(1.05, spacing, 12).unwrap())
            .collect();
        let objective = Objective::MaxSpeed(SpeedScan::new(0.01, &station).unwrap());
        let all: Vec<RuleAssignment> = RuleAssignment::all(2).collect();
        let within = |most: u64| {
            let conditions = Conditions::default();
            let evaluator = Evaluator::new(&station, &patterns, objective, &conditions).unwrap();
            let found = evaluator.evaluate_within(all.clone(), most, &Environment::QUIET);
            (found.unwrap(), evaluator.runs(), evaluator.runs_per_value())
        };
        let (whole, runs, per_value) = within(u64::MAX);
        assert_eq!(whole.patterns.len(), patterns.len());
        let values = |evaluation: &Evaluation, at: usize| -> Vec<f64> {
            evaluation.scores.iter().map(|s| s.values[at]).collect()
        };
        for (most, least, greatest) in [(2 * runs, 16, 16), (runs / 2, 4, 8), (runs / 4, 1, 4)] {
            let (part, taken, _) = within(most);
            let count = part.patterns.len();
            assert!(taken <= most, "{taken} of {most}");
            assert!(
                (least..=greatest).contains(&count),
                "{count} under {most} of {runs}"
            );
            for (at, &place) in part.patterns.iter().enumerate() {
                assert_eq!(values(&part, at), values(&whole, place));
            }
        }
        // Where they are not enough for one pattern, none is spent.
        let too_few = (all.len() as f64 * per_value) as u64 - 1;
        assert!(too_few > all.len() as u64);
        let (none, taken, _) = within(too_few);
        assert_eq!((none.patterns.len(), taken), (0, 0));
    }
}
