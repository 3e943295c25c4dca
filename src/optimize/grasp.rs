//! GRASP: greedy randomised adaptive search.
//!
//! Feo and Resende, "Greedy randomized adaptive search procedures", Journal of Global
//! Optimization 6, 1995 (DOI 10.1007/BF01096763). Each start builds an assignment robot by
//! robot, choosing at random among the rules that score nearly as well as the best, and then
//! climbs to a local optimum.

use super::environment::{Environment, Progress};
use super::evaluator::{Evaluation, Evaluator, Score};
use super::objective::{Objective, Risk};
use crate::dispatch::{Rule, RuleAssignment};
use crate::error::{Error, Result, counted, shown_number};
use crate::pattern::random_stream;
use crate::setters::setters;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};

/// Settings of GRASP; by default 8 starts, alpha 0.3 and seed 1.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Grasp {
    /// Number of starts, at least 1.
    pub starts: usize,
    /// Width of the restricted candidate list: rules within this share of the span
    /// from the best to the worst are eligible. 0 is greedy, 1 is random.
    pub alpha: f64,
    /// Seed of the random choices.
    pub seed: u64,
}

impl Default for Grasp {
    fn default() -> Self {
        Self {
            starts: 8,
            alpha: 0.3,
            seed: 1,
        }
    }
}

setters!(Grasp {
    /// With this number of starts.
    fn with_starts(starts: usize);
    /// With this width of the restricted candidate list, from 0 (greedy) to 1 (random).
    fn with_alpha(alpha: f64);
    /// With this seed of the random choices.
    fn with_seed(seed: u64);
});

/// What GRASP found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct GraspOutcome {
    /// Best assignment found; `None` if the search was cut short before the first was scored.
    pub best: Option<RuleAssignment>,
    /// Aggregate of the best assignment.
    pub value: f64,
    /// Number of starts that reached a local optimum.
    pub starts: usize,
    /// Number of those that ended in the best assignment.
    pub hits: usize,
    /// Moves made by all local searches.
    pub moves: usize,
    /// Whether it was stopped or used up its runs before the last start ended.
    pub cut: bool,
}

/// Scores that were computed once, by assignment.
pub(super) type Memo = HashMap<RuleAssignment, Score>;

impl Grasp {
    /// Checks the settings.
    ///
    /// # Errors
    /// No starts, or an alpha outside [0, 1].
    pub fn checked(self) -> Result<Self> {
        if self.starts == 0 {
            let cure = "give 1 or more";
            return Err(Error::usage("'starts'", "0 starts are too few", cure));
        }
        if !(0.0..=1.0).contains(&self.alpha) {
            return Err(Error::usage(
                "'alpha'",
                format!("{} is not between 0 and 1", shown_number(self.alpha)),
                "give 0 (greedy) to 1 (random)",
            ));
        }
        Ok(self)
    }

    /// Upper estimate of the robot passes per pattern that the search takes; `auto` compares it
    /// with the enumeration.
    pub(super) fn estimated_passes(&self, robots: usize) -> f64 {
        let rules = Rule::all().len();
        // Local searches that start near a greedy solution end after a few moves.
        const MOVES: usize = 3;
        let neighbours = robots * (rules - 1) + robots * robots.saturating_sub(1) / 2;
        // Not in integers: the user may request any number of starts.
        self.starts as f64 * ((robots * rules + MOVES * neighbours) * robots) as f64
    }

    /// Upper estimate of the assignments scored on a line of `robots` robots.
    pub(super) fn estimated_scores(&self, robots: usize) -> f64 {
        self.estimated_passes(robots) / robots.max(1) as f64
    }

    /// Upper estimates per pattern of what the search takes in addition to an enumeration,
    /// whose scores it reuses: runs of parts of the line, and robot passes if those are shared.
    pub(super) fn estimated_parts(&self, robots: usize) -> (f64, f64) {
        let rules = Rule::all().len() as f64;
        let (mut runs, mut passes) = (0.0, 0.0);
        for depth in 1..robots {
            // Every start extends one partial assignment; there are few short ones.
            let beginnings = rules.powi(depth as i32 - 1).min(self.starts as f64);
            runs += beginnings * rules;
            passes += beginnings * (rules + (depth - 1) as f64);
        }
        (runs, passes)
    }

    /// Runs the search in at most `most` runs (the first score may exceed them); `memo` caches
    /// scores.
    pub(super) fn run(
        &self,
        evaluator: &Evaluator,
        risk: Risk,
        memo: &mut Memo,
        most: u64,
        environment: &Environment,
    ) -> Result<GraspOutcome> {
        let mut walk = Walk {
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
        };
        let mut outcome = GraspOutcome {
            best: None,
            value: f64::NEG_INFINITY,
            starts: 0,
            hits: 0,
            moves: 0,
            cut: false,
        };
        // One rule for all robots is the obvious first attempt, so the result is never worse
        // than that.
        let robots = evaluator.station().robots().len();
        let uniform = Rule::all().map(|rule| RuleAssignment::new(vec![rule; robots]));
        let mut uniform: Vec<RuleAssignment> = uniform.collect();
        let each = evaluator.pattern_count() as f64 * evaluator.runs_per_value();
        let afforded = (most as f64 / each) as usize;
        if afforded < uniform.len() {
            outcome.cut = true;
            uniform.truncate(afforded.max(1));
        }
        outcome.cut |= walk.values(&uniform, true)?.is_none();
        let starts = if outcome.cut { 0 } else { self.starts };
        for start in 0..starts {
            let mut rng = random_stream(self.seed, start as u64);
            let Some((assignment, value, moves)) = walk.one_start(self.alpha, &mut rng)? else {
                outcome.cut = true;
                break;
            };
            environment.progress.advance(1);
            outcome.starts += 1;
            outcome.moves += moves;
            if outcome.best.as_ref() == Some(&assignment) {
                outcome.hits += 1;
            } else if value > outcome.value {
                environment
                    .progress
                    .incumbent(&format!("{assignment} {value:.4}"));
                outcome.best = Some(assignment);
                outcome.value = value;
                outcome.hits = 1;
            }
        }
        // The unfinished start may have scored something better on its way.
        if outcome.cut
            && let Some((best, value)) = best_scored(walk.memo, risk)
        {
            outcome.best = Some(best.clone());
            outcome.value = value;
        }
        Ok(outcome)
    }
}

/// The best of the assignments scored so far, with its aggregate; of equal ones the first in
/// registry order.
fn best_scored(memo: &Memo, risk: Risk) -> Option<(&RuleAssignment, f64)> {
    let scored = memo.iter();
    let scored = scored.map(|(assignment, score)| (assignment, risk.aggregate(&score.values)));
    let scored = scored.filter(|(_, value)| !value.is_nan());
    scored.max_by(|(a, value), (b, other)| value.total_cmp(other).then_with(|| b.cmp(a)))
}

struct Walk<'w, 'a> {
    /// The evaluator's run count at which the search has used up its runs.
    last_run: u64,
    evaluator: &'w Evaluator<'a>,
    for_parts: Evaluator<'a>,
    parts: Memo,
    risk: Risk,
    memo: &'w mut Memo,
    environment: &'w Environment<'w>,
}

impl Walk<'_, '_> {
    /// A local optimum, its value and the moves to it; `None` if cut short.
    fn one_start(
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Pattern, grid};
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

    /// What a start may score: six options per robot, and three times all neighbours.
    #[test]
    fn estimates_follow_from_the_sizes() {
        let grasp = Grasp::default();
        assert_eq!(grasp.estimated_passes(1), 8.0 * (6 + 3 * 5) as f64);
        assert_eq!(grasp.estimated_passes(2), 8.0 * ((12 + 3 * 11) * 2) as f64);
        assert_eq!(grasp.estimated_passes(4), 8.0 * ((24 + 3 * 26) * 4) as f64);
        assert_eq!(grasp.estimated_scores(1), 8.0 * 21.0);
        assert_eq!(grasp.estimated_scores(2), 8.0 * 45.0);
        assert_eq!(grasp.estimated_parts(1), (0.0, 0.0));
        assert_eq!(grasp.estimated_parts(2), (6.0, 6.0));
        // Six partial assignments of one robot, and of two robots at most as many as there are
        // starts.
        assert_eq!(grasp.estimated_parts(3), (6.0 + 36.0, 6.0 + 6.0 * 7.0));
        assert_eq!(grasp.estimated_parts(4), (42.0 + 48.0, 48.0 + 8.0 * 8.0));
        let few = Grasp { starts: 3, ..grasp };
        assert_eq!(few.estimated_parts(3), (6.0 + 18.0, 6.0 + 3.0 * 7.0));
    }

    #[test]
    fn settings_are_checked() {
        let grasp = Grasp::default();
        assert!(grasp.checked().is_ok());
        let starts = usize::MAX;
        assert!(Grasp { starts, ..grasp }.estimated_passes(100) > 1e19);
        let refused = |grasp: Grasp, setting: &str| {
            let message = grasp.checked().unwrap_err().to_string();
            assert!(message.starts_with(setting), "{message}");
        };
        refused(Grasp { starts: 0, ..grasp }, "'starts': ");
        for alpha in [-0.1, 1.1, f64::NAN] {
            refused(Grasp { alpha, ..grasp }, "'alpha': ");
        }
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
        Walk {
            last_run: u64::MAX,
            for_parts: evaluator.with_objective(evaluator.objective()),
            evaluator,
            parts: Memo::new(),
            risk: Risk::Mean,
            memo,
            environment: &Environment::QUIET,
        }
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
