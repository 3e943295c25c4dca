//! The starts of GRASP: each constructs an assignment and climbs to a local optimum. They judge on a
//! sample of the patterns; which of all that they scored is best is then screened over more and more
//! patterns, and over all of them in the end.

use super::environment::Environment;
use super::objective::Risk;
use super::partial_scores::PartialScores;
use super::screening::{may_win, most_going_on, next_count};
use crate::dispatch::{Rule, RuleAssignment};
use crate::error::Result;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use std::collections::{BTreeSet, HashSet};

/// Number of patterns on which starts judge.
const SAMPLE: usize = 12;

/// The starts of one search: they share scores and a limit on runs.
pub(super) struct Walk<'s, 'w, 'a> {
    scores: &'s mut PartialScores<'w, 'a>,
    risk: Risk,
    /// Number of patterns on which starts judge.
    sample: usize,
    environment: &'s Environment<'s>,
    /// The best assignment that is scored on all patterns, and its aggregate.
    incumbent: Option<(RuleAssignment, f64)>,
    /// What was scored since the current start began.
    met: HashSet<RuleAssignment>,
    /// What was scored so far.
    all_met: BTreeSet<RuleAssignment>,
}

impl<'s, 'w, 'a> Walk<'s, 'w, 'a> {
    /// Starts that add to `scores`, within its runs.
    pub(super) fn new(
        scores: &'s mut PartialScores<'w, 'a>,
        risk: Risk,
        environment: &'s Environment<'s>,
    ) -> Self {
        Self {
            sample: SAMPLE.min(scores.patterns()),
            scores,
            risk,
            environment,
            incumbent: None,
            met: HashSet::new(),
            all_met: BTreeSet::new(),
        }
    }

    /// The best of the assignments that are scored on all patterns, with its aggregate; of equal ones
    /// the first in registry order.
    pub(super) fn incumbent(&self) -> Option<&(RuleAssignment, f64)> {
        self.incumbent.as_ref()
    }

    /// What was scored since the current start began.
    pub(super) fn met(&mut self) -> HashSet<RuleAssignment> {
        std::mem::take(&mut self.met)
    }

    /// Scores one rule for all robots, which is the obvious first attempt. Returns whether there are
    /// runs for all of these on all patterns; if not, as many are scored as there are runs for, and at
    /// least one.
    pub(super) fn score_uniform(&mut self) -> Result<bool> {
        let robots = self.scores.robots();
        let uniform = Rule::all().map(|rule| RuleAssignment::new(vec![rule; robots]));
        let mut uniform: Vec<RuleAssignment> = uniform.collect();
        let patterns = self.scores.patterns();
        let afforded = self.scores.afforded(patterns);
        if afforded >= uniform.len() && self.values(&uniform, self.sample)?.is_some() {
            return Ok(self.screen(uniform)?.is_some());
        }
        uniform.truncate(afforded.max(1));
        if !self.scores.extend(&uniform, patterns, self.environment)? {
            uniform.truncate(1);
            if !self.scores.insist(&uniform[0], self.environment)? {
                return Ok(false);
            }
        }
        self.decide(&uniform);
        Ok(false)
    }

    /// A local optimum on the sample and the moves to it; `None` if cut short.
    pub(super) fn one_start(
        &mut self,
        alpha: f64,
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<(RuleAssignment, usize)>> {
        match self.construct(self.scores.robots(), alpha, rng)? {
            Some(begun) => self.climb(begun),
            None => Ok(None),
        }
    }

    /// The local optimum on the sample that the best neighbours lead to from `current`, and the moves
    /// to it; `None` if cut short.
    pub(super) fn climb(
        &mut self,
        mut current: RuleAssignment,
    ) -> Result<Option<(RuleAssignment, usize)>> {
        let Some(values) = self.values(std::slice::from_ref(&current), self.sample)? else {
            return Ok(None);
        };
        let mut value = values[0];
        let mut moves = 0;
        loop {
            let neighbours = neighbours(&current);
            let Some(values) = self.values(&neighbours, self.sample)? else {
                return Ok(None);
            };
            match first_highest(&values) {
                Some(best) if values[best] > value => {
                    current = neighbours[best].clone();
                    value = values[best];
                    moves += 1;
                }
                _ => return Ok(Some((current, moves))),
            }
        }
    }

    /// Path relinking (Resende and Ribeiro 2005, DOI 10.1007/0-387-25383-1_2): the best assignment on
    /// a way from one to the other. Each step gives one robot the rule that it has in `to`, the one
    /// that makes most of the sample. `None` if cut short.
    pub(super) fn relink(
        &mut self,
        from: &RuleAssignment,
        to: &RuleAssignment,
    ) -> Result<Option<RuleAssignment>> {
        let mut at = from.clone();
        let mut best: Option<(RuleAssignment, f64)> = None;
        loop {
            let mut steps = Vec::new();
            for (robot, &rule) in to.rules().iter().enumerate() {
                if at.rules()[robot] != rule {
                    let mut rules = at.rules().to_vec();
                    rules[robot] = rule;
                    steps.push(RuleAssignment::new(rules));
                }
            }
            // The last step is the other end.
            if steps.len() <= 1 {
                return Ok(Some(best.map_or_else(|| from.clone(), |(best, _)| best)));
            }
            let Some(values) = self.values(&steps, self.sample)? else {
                return Ok(None);
            };
            let chosen = first_highest(&values).unwrap_or(0);
            at = steps[chosen].clone();
            if best
                .as_ref()
                .is_none_or(|(_, value)| values[chosen] > *value)
            {
                best = Some((at.clone(), values[chosen]));
            }
        }
    }

    /// Screens everything that the starts scored, and then neighbours of the best until none is
    /// better. Returns the moves; `None` if cut short.
    pub(super) fn settle(&mut self) -> Result<Option<usize>> {
        let all = self.all_met.iter().cloned().collect();
        if self.screen(all)?.is_none() {
            return Ok(None);
        }
        let mut moves = 0;
        while let Some((best, _)) = self.incumbent.clone() {
            let neighbours = neighbours(&best);
            if self.values(&neighbours, self.sample)?.is_none() {
                return Ok(None);
            }
            match self.screen(neighbours)? {
                None => return Ok(None),
                Some(false) => break,
                Some(true) => moves += 1,
            }
        }
        Ok(Some(moves))
    }

    /// Screens `field`, scored on the sample, against the incumbent. Returns whether there is a new
    /// incumbent; `None` if cut short.
    pub(super) fn screen(&mut self, mut field: Vec<RuleAssignment>) -> Result<Option<bool>> {
        let patterns = self.scores.patterns();
        let mut count = self.sample;
        loop {
            if self.values(&field, count)?.is_none() {
                return Ok(None);
            }
            if count == patterns {
                return Ok(Some(self.decide(&field)));
            }
            let next = next_count(count, patterns);
            field = self.going_on(field, count, next);
            count = next;
            if field.is_empty() {
                return Ok(Some(false));
            }
        }
    }

    /// Those of `field`, scored on `count` patterns, that are worth scoring on `next` patterns, the
    /// best first.
    fn going_on(
        &self,
        field: Vec<RuleAssignment>,
        count: usize,
        next: usize,
    ) -> Vec<RuleAssignment> {
        let patterns = self.scores.patterns();
        let value = |a: &RuleAssignment| self.scores.aggregate(a, count, self.risk);
        let mut ranked: Vec<(f64, RuleAssignment)> =
            field.into_iter().map(|a| (value(&a), a)).collect();
        ranked.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(&b.1)));
        let first = ranked.first().map(|(value, a)| (*value, a.clone()));
        let held = self.incumbent.as_ref().map(|(a, _)| (value(a), a.clone()));
        // The leader so far is the incumbent unless one of the field is ahead of it.
        let Some((_, leader)) = held
            .into_iter()
            .chain(first)
            .reduce(|a, b| if b.0 > a.0 { b } else { a })
        else {
            return Vec::new();
        };
        let lead = self.scores.known(&leader);
        let beaten = self.incumbent.as_ref().map(|(_, value)| *value);
        let held = self.incumbent.as_ref().map(|(a, _)| a);
        let going = ranked
            .into_iter()
            .map(|(_, a)| a)
            .filter(|a| Some(a) != held);
        let going = going.filter(|a| {
            let values = self.scores.known(a);
            *a == leader
                || may_win(
                    self.risk,
                    &values[..count],
                    &lead[..count],
                    beaten,
                    patterns,
                )
        });
        let most = most_going_on(self.scores.robots(), self.sample, next);
        going.take(most).collect()
    }

    /// Makes the best of `field`, scored on all patterns, the incumbent if it is better. Returns
    /// whether it is.
    fn decide(&mut self, field: &[RuleAssignment]) -> bool {
        let patterns = self.scores.patterns();
        let mut better = false;
        for assignment in field {
            let value = self.scores.aggregate(assignment, patterns, self.risk);
            let held = self.incumbent.as_ref();
            if held.is_none_or(|(a, best)| value > *best || (value == *best && assignment < a)) {
                better |= held.is_none_or(|(_, best)| value > *best);
                self.incumbent = Some((assignment.clone(), value));
            }
        }
        better
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
        for _ in 0..robots {
            let options: Vec<RuleAssignment> = Rule::all()
                .map(|rule| RuleAssignment::new([&rules[..], &[rule]].concat()))
                .collect();
            let Some(values) = self.values(&options, self.sample)? else {
                return Ok(None);
            };
            let eligible = restricted(&values, alpha);
            let choice = eligible[rng.random_range(0..eligible.len())];
            rules = options[choice].rules().to_vec();
        }
        Ok(Some(RuleAssignment::new(rules)))
    }

    /// The aggregate of each assignment over the first `count` patterns; `None` if stopped or if too
    /// few runs are left.
    fn values(&mut self, assignments: &[RuleAssignment], count: usize) -> Result<Option<Vec<f64>>> {
        if !self.scores.extend(assignments, count, self.environment)? {
            return Ok(None);
        }
        let robots = self.scores.robots();
        for whole in assignments.iter().filter(|a| a.rules().len() == robots) {
            if self.met.insert(whole.clone()) {
                self.all_met.insert(whole.clone());
            }
        }
        let value = |a: &RuleAssignment| self.scores.aggregate(a, count, self.risk);
        Ok(Some(assignments.iter().map(value).collect()))
    }
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
    use crate::optimize::{Evaluator, Grasp, Objective};
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

    fn scores<'w, 'a>(evaluator: &'w Evaluator<'a>, most: u64) -> PartialScores<'w, 'a> {
        PartialScores::new(evaluator, None, 5, most)
    }

    /// With few patterns the sample is all of them: a start ends where no neighbour is better, and
    /// the best of all that was scored is found.
    #[test]
    fn starts_climb_to_local_optima() {
        let (station, patterns) = (station(2), patterns());
        let evaluator = evaluator(&station, &patterns);
        let grasp = Grasp {
            starts: 12,
            alpha: 1.0,
            seed: 5,
        };
        let (quiet, mean) = (Environment::QUIET, Risk::Mean);
        let (found, all) = grasp.run(&evaluator, mean, None, u64::MAX, &quiet).unwrap();
        let mut scores = scores(&evaluator, u64::MAX);
        let mut walk = Walk::new(&mut scores, mean, &quiet);
        let (mut moves, mut climbed) = (0, 0);
        for start in 0..12 {
            let began = walk.construct(2, 1.0, &mut random_stream(5, start));
            let began = began.unwrap().unwrap();
            let end = walk.one_start(1.0, &mut random_stream(5, start));
            let (end, steps) = end.unwrap().unwrap();
            assert_eq!(steps == 0, began == end, "{began} to {end}");
            let values = walk.values(&[neighbours(&end), vec![end.clone()]].concat(), 4);
            let values = values.unwrap().unwrap();
            let (own, around) = values.split_last().unwrap();
            assert!(around.iter().all(|near| near <= own), "{end}");
            moves += steps;
            climbed += usize::from(steps > 0);
        }
        assert!(climbed > 1 && moves > 1, "{climbed} {moves}");
        assert!(
            found.moves >= moves && found.starts == 12 && found.hits > 1,
            "{found:?}"
        );
        let values = all.scores.iter().map(|score| mean.aggregate(&score.values));
        let best = values.fold(f64::NEG_INFINITY, f64::max);
        assert_eq!((found.value, found.cut), (best, false));
        let place = all
            .assignments
            .iter()
            .position(|a| Some(a) == found.best.as_ref());
        assert_eq!(mean.aggregate(&all.scores[place.unwrap()].values), best);
    }

    /// The way from one assignment to another leads over what differs, one robot at a time.
    #[test]
    fn paths_take_the_best_step_between_two_ends() {
        let (station, patterns) = (station(3), patterns());
        let evaluator = evaluator(&station, &patterns);
        let mut scores = scores(&evaluator, u64::MAX);
        let quiet = Environment::QUIET;
        let mut walk = Walk::new(&mut scores, Risk::Mean, &quiet);
        let read = |text: &str| text.parse::<RuleAssignment>().unwrap();
        let (from, to) = (read("LPT,LD,LPT"), read("SPT,LD,FIFO"));
        let between = [read("SPT,LD,LPT"), read("LPT,LD,FIFO")];
        let values = walk.values(&between, 4).unwrap().unwrap();
        let better = first_highest(&values).unwrap();
        let found = walk.relink(&from, &to).unwrap().unwrap();
        assert_eq!(found, between[better]);
        // Between neighbours there is nothing.
        assert_eq!(walk.relink(&from, &between[0]).unwrap(), Some(from.clone()));
        assert_eq!(walk.relink(&from, &from).unwrap(), Some(from));
    }

    /// Scores are had up to the last run that they need; the first one of all in any case.
    #[test]
    fn runs_are_enough_up_to_the_last_one() {
        let (station, patterns) = (station(2), patterns());
        let rules: Vec<RuleAssignment> = Rule::all()
            .map(|rule| RuleAssignment::new(vec![rule]))
            .collect();
        let need = (rules.len() * patterns.len()) as u64;
        let quiet = Environment::QUIET;
        for (runs, enough) in [(need, true), (need - 1, false), (0, false)] {
            let evaluator = evaluator(&station, &patterns);
            let mut scores = scores(&evaluator, runs);
            let mut walk = Walk::new(&mut scores, Risk::Mean, &quiet);
            let values = walk.values(&rules, 4).unwrap();
            assert_eq!(
                values.map(|values| values.len()),
                enough.then_some(rules.len())
            );
            assert_eq!(evaluator.runs(), if enough { need } else { 0 });
        }
        for (runs, scored) in [(4 * 3 + 1, 3), (4, 1), (3, 1), (0, 1)] {
            let evaluator = evaluator(&station, &patterns);
            let mut scores = scores(&evaluator, runs);
            let mut walk = Walk::new(&mut scores, Risk::Mean, &quiet);
            assert!(!walk.score_uniform().unwrap());
            assert!(walk.incumbent().is_some());
            let all = scores.into_evaluation().assignments;
            assert_eq!(all.len(), scored, "{runs}");
        }
    }
}
