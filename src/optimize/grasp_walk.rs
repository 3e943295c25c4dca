//! The starts of GRASP: each constructs an assignment and climbs to a local optimum.

use super::environment::{Environment, Progress};
use super::evaluator::{Evaluation, Evaluator, Score};
use super::objective::{Objective, Risk};
use crate::dispatch::{Rule, RuleAssignment};
use crate::error::{Result, counted};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

/// Scores that were computed once, by assignment.
pub(super) type Memo = HashMap<RuleAssignment, Score>;

/// The starts of one search: they share scores and a limit on runs.
pub(super) struct Walk<'w, 'a> {
    /// The evaluator's run count at which the search has used up its runs.
    last_run: u64,
    evaluator: &'w Evaluator<'a>,
    for_parts: Evaluator<'a>,
    parts: Memo,
    risk: Risk,
    memo: &'w mut Memo,
    environment: &'w Environment<'w>,
}

impl<'w, 'a> Walk<'w, 'a> {
    /// Starts that use at most `most` runs, except for the first score; `memo` caches scores.
    pub(super) fn new(
        evaluator: &'w Evaluator<'a>,
        risk: Risk,
        memo: &'w mut Memo,
        most: u64,
        environment: &'w Environment<'w>,
    ) -> Self {
        Self {
            last_run: evaluator.runs().saturating_add(most),
            evaluator,
            // A part of the line rarely picks everything at any speed, so its speed limit says
            // nothing about it; its picked share does.
            for_parts: match evaluator.objective() {
                Objective::MaxSpeed(_) => evaluator.with_objective(Objective::PickedShare),
                other => evaluator.with_objective(other),
            },
            parts: Memo::new(),
            risk,
            memo,
            environment,
        }
    }

    /// Scores one rule for all robots, which is the obvious first attempt, so that the result is
    /// never worse than that. Returns whether `most` runs were enough to score all of these.
    pub(super) fn score_uniform(&mut self, most: u64) -> Result<bool> {
        let robots = self.evaluator.station().robots().len();
        let uniform = Rule::all().map(|rule| RuleAssignment::new(vec![rule; robots]));
        let mut uniform: Vec<RuleAssignment> = uniform.collect();
        let each = self.evaluator.pattern_count() as f64 * self.evaluator.runs_per_value();
        let afforded = (most as f64 / each) as usize;
        let all = uniform.len();
        uniform.truncate(afforded.max(1));
        let scored = self.values(&uniform, true)?.is_some();
        Ok(scored && afforded >= all)
    }

    /// The best of the assignments scored so far, with its aggregate; of equal ones the first in
    /// registry order.
    pub(super) fn best_scored(&self) -> Option<(RuleAssignment, f64)> {
        let (best, value) = best_scored(self.memo, self.risk)?;
        Some((best.clone(), value))
    }

    /// A local optimum, its value and the moves to it; `None` if cut short.
    pub(super) fn one_start(
        &mut self,
        alpha: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<(RuleAssignment, f64, usize)>> {
        let robots = self.evaluator.station().robots().len();
        let Some(mut current) = self.construct(robots, alpha, rng)? else {
            return Ok(None);
        };
        let Some(values) = self.values(std::slice::from_ref(&current), true)? else {
            return Ok(None);
        };
        let mut value = values[0];
        let mut moves = 0;
        loop {
            let neighbours = neighbours(&current);
            let Some(values) = self.values(&neighbours, true)? else {
                return Ok(None);
            };
            match first_highest(&values) {
                Some(best) if values[best] > value => {
                    current = neighbours[best].clone();
                    value = values[best];
                    moves += 1;
                }
                _ => return Ok(Some((current, value, moves))),
            }
        }
    }

    /// An assignment built robot by robot, each rule drawn from the restricted candidate list;
    /// `None` if cut short.
    fn construct(
        &mut self,
        robots: usize,
        alpha: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<RuleAssignment>> {
        let mut rules: Vec<Rule> = Vec::with_capacity(robots);
        for robot in 0..robots {
            let options: Vec<RuleAssignment> = Rule::all()
                .map(|rule| RuleAssignment::new([&rules[..], &[rule]].concat()))
                .collect();
            let Some(values) = self.values(&options, robot + 1 == robots)? else {
                return Ok(None);
            };
            let eligible = restricted(&values, alpha);
            let choice = eligible[rng.random_range(0..eligible.len())];
            rules = options[choice].rules().to_vec();
        }
        Ok(Some(RuleAssignment::new(rules)))
    }

    /// The aggregate of each assignment, from the memo if known; `None` if stopped or if too
    /// few runs are left. `whole`: the assignments are for the whole line.
    fn values(&mut self, assignments: &[RuleAssignment], whole: bool) -> Result<Option<Vec<f64>>> {
        let (evaluator, memo) = if whole {
            (self.evaluator, &mut *self.memo)
        } else {
            (&self.for_parts, &mut self.parts)
        };
        let unknown: Vec<RuleAssignment> = assignments
            .iter()
            .filter(|a| !memo.contains_key(a))
            .cloned()
            .collect();
        if !unknown.is_empty() {
            let cost = unknown.len() as f64 * evaluator.pattern_count() as f64;
            let left = self.last_run.saturating_sub(evaluator.runs());
            // The first score is always computed, so that there is a result.
            let first = whole && memo.is_empty();
            if cost * evaluator.runs_per_value() > left as f64 && !first {
                return Ok(None);
            }
            let within = Within {
                outer: self.environment.progress,
                assignments: unknown.len(),
                patterns: evaluator.pattern_count(),
                done: AtomicU64::new(0),
            };
            let environment = Environment {
                stop: self.environment.stop,
                progress: &within,
                ..*self.environment
            };
            let mut evaluation = evaluator.evaluate_within(unknown.clone(), left, &environment)?;
            let scored = evaluation.is_whole(evaluator);
            if first && !scored && !environment.stopped() {
                let one = unknown[..1].to_vec();
                evaluation = evaluator.evaluate(one, &environment)?;
            }
            if !evaluation.is_whole(evaluator) {
                return Ok(None);
            }
            let Evaluation {
                assignments,
                scores,
                ..
            } = evaluation;
            memo.extend(assignments.into_iter().zip(scores));
        }
        let value = |a: &RuleAssignment| memo.get(a).map(|s| self.risk.aggregate(&s.values));
        Ok(assignments.iter().map(value).collect())
    }
}

/// Progress within a start, which takes minutes on a long line: the evaluator counts patterns,
/// the search counts starts.
struct Within<'p> {
    outer: &'p dyn Progress,
    assignments: usize,
    patterns: usize,
    done: AtomicU64,
}

impl Progress for Within<'_> {
    fn begin(&self, _: &str, _: u64, _: &str) {}
    fn advance(&self, steps: u64) {
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        self.outer.doing(&format!(
            "{} at once, pattern {done}/{}",
            counted(self.assignments, "assignment"),
            self.patterns
        ));
    }
    fn doing(&self, _: &str) {}
    fn incumbent(&self, _: &str) {}
    fn end(&self) {}
}

/// Indices of the restricted candidate list: values within the share `alpha` of the span from
/// the highest to the lowest.
fn restricted(values: &[f64], alpha: f64) -> Vec<usize> {
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let least = high - alpha * (high - low);
    let places = 0..values.len();
    places.filter(|&place| values[place] >= least).collect()
}

/// Index of the highest value, the first of ties.
fn first_highest(values: &[f64]) -> Option<usize> {
    (0..values.len()).reduce(|a, b| if values[b] > values[a] { b } else { a })
}

/// All assignments that differ in one robot's rule or by a swap of two robots' rules, in
/// registry order.
fn neighbours(assignment: &RuleAssignment) -> Vec<RuleAssignment> {
    let rules = assignment.rules();
    let mut list = Vec::new();
    for robot in 0..rules.len() {
        for rule in Rule::all().filter(|&rule| rule != rules[robot]) {
            let mut changed = rules.to_vec();
            changed[robot] = rule;
            list.push(RuleAssignment::new(changed));
        }
        for other in robot + 1..rules.len() {
            if rules[robot] != rules[other] {
                let mut swapped = rules.to_vec();
                swapped.swap(robot, other);
                list.push(RuleAssignment::new(swapped));
            }
        }
    }
    list.sort_unstable();
    list
}

/// The best of the assignments in `memo`, as for [`Walk::best_scored`].
fn best_scored(memo: &Memo, risk: Risk) -> Option<(&RuleAssignment, f64)> {
    let scored = memo.iter();
    let scored = scored.map(|(assignment, score)| (assignment, risk.aggregate(&score.values)));
    let scored = scored.filter(|(_, value)| !value.is_nan());
    scored.max_by(|(a, value), (b, other)| value.total_cmp(other).then_with(|| b.cmp(a)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimize::Grasp;
    use crate::pattern::{Pattern, grid, random_stream};
    use crate::sim::Conditions;
    use crate::station::{Station, built_in};

    #[test]
    fn the_neighbourhood_is_one_change_or_one_swap() {
        let at = "SPT,FIFO,SPT".parse().unwrap();
        let list = neighbours(&at);
        assert_eq!(list.len(), 3 * (Rule::all().len() - 1) + 2);
        assert!(list.is_sorted() && !list.contains(&at));
        assert!(list.contains(&"FIFO,SPT,SPT".parse().unwrap()));
    }

    #[test]
    fn candidates_are_within_a_share_of_the_span() {
        let values = [2.0, 6.0, 5.0, 6.0, 4.0];
        assert_eq!(restricted(&values, 0.0), [1, 3]);
        assert_eq!(restricted(&values, 0.24), [1, 3]);
        assert_eq!(restricted(&values, 0.25), [1, 2, 3]);
        assert_eq!(restricted(&values, 0.5), [1, 2, 3, 4]);
        assert_eq!(restricted(&values, 0.99), [1, 2, 3, 4]);
        assert_eq!(restricted(&values, 1.0), [0, 1, 2, 3, 4]);
        assert_eq!(restricted(&[-3.0, -1.0, -2.0], 0.5), [1, 2]);
    }

    #[test]
    fn of_equal_neighbours_the_first_is_taken() {
        assert_eq!(first_highest(&[2.0, 6.0, 5.0, 6.0]), Some(1));
        assert_eq!(first_highest(&[2.0, 2.0]), Some(0));
        assert_eq!(first_highest(&[-2.0, -1.0]), Some(1));
        assert_eq!(first_highest(&[]), None);
    }

    fn station(robots: usize) -> Station {
        built_in("paper").unwrap().station(Some(robots)).unwrap()
    }

    fn patterns() -> Vec<Pattern> {
        let spacings = [0.18, 0.21, 0.25, 0.3];
        spacings.map(|s| grid(1.05, s, 14).unwrap()).to_vec()
    }

    fn evaluator<'a>(station: &'a Station, patterns: &'a [Pattern]) -> Evaluator<'a> {
        let conditions = Conditions::default();
        Evaluator::new(station, patterns, Objective::PickingRate, &conditions).unwrap()
    }

    fn walk<'w, 'a>(evaluator: &'w Evaluator<'a>, memo: &'w mut Memo) -> Walk<'w, 'a> {
        Walk::new(evaluator, Risk::Mean, memo, u64::MAX, &Environment::QUIET)
    }

    #[test]
    fn what_was_scored_best_is_taken_and_of_equal_ones_the_first() {
        let score = |values: &[f64]| Score {
            values: values.to_vec(),
            picked_share: 1.0,
        };
        let named = |name: &str| name.parse::<RuleAssignment>().unwrap();
        let mut memo = Memo::new();
        assert_eq!(best_scored(&memo, Risk::Mean), None);
        memo.insert(named("FIFO"), score(&[3.0, 3.0]));
        memo.insert(named("LPT"), score(&[1.0, 9.0]));
        memo.insert(named("SPT"), score(&[8.0, 2.0]));
        memo.insert(named("PP"), score(&[4.0, 4.0]));
        assert_eq!(best_scored(&memo, Risk::Mean), Some((&named("SPT"), 5.0)));
        assert_eq!(best_scored(&memo, Risk::Worst), Some((&named("PP"), 4.0)));
    }

    /// Moves, and the starts that have found the best, are counted as the starts go one by one.
    #[test]
    fn starts_and_their_moves_are_counted() {
        let (station, patterns) = (station(2), patterns());
        let evaluator = evaluator(&station, &patterns);
        let grasp = Grasp {
            starts: 12,
            alpha: 1.0,
            seed: 5,
        };
        let mut memo = Memo::new();
        let found = grasp.run(
            &evaluator,
            Risk::Mean,
            &mut memo,
            u64::MAX,
            &Environment::QUIET,
        );
        let found = found.unwrap();
        let mut memo = Memo::new();
        let mut walk = walk(&evaluator, &mut memo);
        let mut ends = Vec::new();
        for start in 0..12 {
            let mut rng = random_stream(5, start);
            let began = walk.construct(2, 1.0, &mut rng).unwrap().unwrap();
            let mut rng = random_stream(5, start);
            let (end, value, moves) = walk.one_start(1.0, &mut rng).unwrap().unwrap();
            assert_eq!(moves == 0, began == end, "{began} to {end}");
            let around = walk.values(&neighbours(&end), true).unwrap().unwrap();
            assert!(around.iter().all(|&near| near <= value), "{end}");
            ends.push((end, value, moves));
        }
        let moves: usize = ends.iter().map(|end| end.2).sum();
        assert!(moves > 1, "{moves}");
        let best = ends
            .iter()
            .map(|end| end.1)
            .fold(f64::NEG_INFINITY, f64::max);
        let first = ends.iter().find(|end| end.1 == best).unwrap().0.clone();
        let hits = ends.iter().filter(|end| end.0 == first).count();
        assert!(hits > 1);
        assert_eq!((found.starts, found.moves, found.hits), (12, moves, hits));
        assert_eq!(
            (found.best, found.value, found.cut),
            (Some(first), best, false)
        );
    }

    /// Scores are had up to the last run that they need; the first one of all in any case.
    #[test]
    fn runs_are_enough_up_to_the_last_one() {
        let (station, patterns) = (station(2), patterns());
        let rules: Vec<RuleAssignment> = Rule::all()
            .map(|rule| RuleAssignment::new(vec![rule]))
            .collect();
        let need = (rules.len() * patterns.len()) as u64;
        for (runs, enough) in [(need, true), (need - 1, false), (0, false)] {
            let evaluator = evaluator(&station, &patterns);
            let mut memo = Memo::new();
            let mut walk = walk(&evaluator, &mut memo);
            walk.last_run = runs;
            let values = walk.values(&rules, false).unwrap();
            assert_eq!(
                values.map(|values| values.len()),
                enough.then_some(rules.len())
            );
            assert_eq!(evaluator.runs(), if enough { need } else { 0 });
        }
    }
}
