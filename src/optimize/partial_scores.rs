//! Scores of assignments on more and more patterns. What the line left after each beginning is kept
//! pattern by pattern, so that an assignment is simulated from the first robot on at which it differs
//! from those before it.

use super::environment::{Environment, Progress};
use super::evaluator::{Evaluation, Evaluator, Score};
use super::objective::{Objective, Risk};
use crate::dispatch::RuleAssignment;
use crate::error::{Result, counted};
use crate::pattern::random_stream;
use crate::sim::PrefixGraph;
use rand::seq::SliceRandom;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};
use std::sync::atomic::{AtomicU64, Ordering};

/// Memory for what lines left after beginnings, over all patterns [bytes].
const MEMORY: usize = 600_000_000;
/// The stream of the search's seed that orders the patterns; its starts have those from 0 on.
const ORDER_STREAM: u64 = u64::MAX;

/// Objective and picked share on one pattern.
type OnPattern = (f64, f64);

/// What is known of assignments: their scores on the first of the patterns, more for some than for
/// others. Assignments of a part of the line are scored with the other robots idle.
pub(super) struct PartialScores<'w, 'a> {
    evaluator: &'w Evaluator<'a>,
    for_parts: Evaluator<'a>,
    /// The patterns in the order in which they are used.
    places: Vec<usize>,
    /// The line on each of them; `None` where assignments cannot share passes.
    lines: Vec<Option<PrefixGraph<'w>>>,
    known: HashMap<RuleAssignment, Vec<OnPattern>>,
    /// The evaluator's run count at which the search has used up its runs.
    last_run: u64,
}

impl<'w, 'a> PartialScores<'w, 'a> {
    /// Nothing but the scores of `enumeration`, if there is one; at most `most` runs. `seed` decides
    /// which patterns are used first.
    pub(super) fn new(
        evaluator: &'w Evaluator<'a>,
        enumeration: Option<&Evaluation>,
        seed: u64,
        most: u64,
    ) -> Self {
        let mut places = evaluator.places();
        places.shuffle(&mut random_stream(seed, ORDER_STREAM));
        let shares = !matches!(evaluator.objective(), Objective::MaxSpeed(_))
            && evaluator.independent_patterns() == evaluator.pattern_count();
        let line = |&place: &usize| {
            let scene = shares.then(|| evaluator.scene(place))?;
            PrefixGraph::new(scene, MEMORY / places.len())
        };
        let lines = places.iter().map(line).collect();
        let mut known = HashMap::new();
        if let Some(evaluation) = enumeration {
            for (assignment, score) in evaluation.assignments.iter().zip(&evaluation.scores) {
                // The enumeration is over the same patterns, in ascending order.
                let rank = |place: &usize| evaluation.patterns.binary_search(place).unwrap_or(0);
                let value = |place| (score.values[rank(place)], score.picked_share);
                known.insert(assignment.clone(), places.iter().map(value).collect());
            }
        }
        Self {
            evaluator,
            // A part of the line rarely picks everything at any speed, so its speed limit says
            // nothing about it; its picked share does.
            for_parts: match evaluator.objective() {
                Objective::MaxSpeed(_) => evaluator.with_objective(Objective::PickedShare),
                other => evaluator.with_objective(other),
            },
            places,
            lines,
            known,
            last_run: evaluator.runs().saturating_add(most),
        }
    }

    /// Number of robots of the line.
    pub(super) fn robots(&self) -> usize {
        self.evaluator.station().robots().len()
    }

    /// Number of patterns.
    pub(super) fn patterns(&self) -> usize {
        self.places.len()
    }

    /// Number of assignments that the runs left are about enough for on `count` patterns.
    pub(super) fn afforded(&self, count: usize) -> usize {
        let left = self.last_run.saturating_sub(self.evaluator.runs());
        (left as f64 / (count as f64 * self.evaluator.runs_per_value())) as usize
    }

    /// The values on the first patterns, as many as are known; of no pattern if none is.
    pub(super) fn known(&self, assignment: &RuleAssignment) -> Vec<f64> {
        let known = self.known.get(assignment).map_or(&[][..], |known| known);
        known.iter().map(|(value, _)| *value).collect()
    }

    /// The assignments of the whole line that are scored on `count` patterns or more, in registry
    /// order.
    pub(super) fn scored_on(&self, count: usize) -> Vec<RuleAssignment> {
        let robots = self.robots();
        let scored = self.known.iter();
        let scored = scored.filter(|(a, known)| a.rules().len() == robots && known.len() >= count);
        let mut scored: Vec<RuleAssignment> = scored.map(|(a, _)| a.clone()).collect();
        scored.sort_unstable();
        scored
    }

    /// The aggregate of an assignment over the first `count` patterns, on which it must be known.
    pub(super) fn aggregate(&self, assignment: &RuleAssignment, count: usize, risk: Risk) -> f64 {
        let known = &self.known[assignment];
        if count < self.places.len() {
            let mut values: Vec<f64> = known[..count].iter().map(|(value, _)| *value).collect();
            return risk.aggregate_in(&mut values);
        }
        // Summed in the order of the ranking, so that both agree to the last bit.
        risk.aggregate_in(
            &mut self
                .in_order(known)
                .map(|(value, _)| value)
                .collect::<Vec<_>>(),
        )
    }

    /// Scores `assignments`, either all of the whole line or all of a part, on the first `count`
    /// patterns where they are not known. Returns false if stopped, or if too few runs are left.
    pub(super) fn extend(
        &mut self,
        assignments: &[RuleAssignment],
        count: usize,
        environment: &Environment,
    ) -> Result<bool> {
        let mut groups: BTreeMap<usize, Vec<&RuleAssignment>> = BTreeMap::new();
        for assignment in assignments {
            let known = self.known.get(assignment).map_or(0, Vec::len);
            if known < count {
                groups.entry(known).or_default().push(assignment);
            }
        }
        let runs = groups
            .iter()
            .map(|(from, group)| (count - from) * group.len());
        let whole = assignments
            .first()
            .is_some_and(|a| a.rules().len() == self.robots());
        let each = match whole {
            true => self.evaluator.runs_per_value(),
            false => self.for_parts.runs_per_value(),
        };
        let left = self.last_run.saturating_sub(self.evaluator.runs());
        if runs.sum::<usize>() as f64 * each > left as f64 {
            return Ok(false);
        }
        for (from, mut group) in groups {
            group.sort_unstable();
            group.dedup();
            let within = Within {
                outer: environment.progress,
                assignments: group.len(),
                patterns: count - from,
                done: AtomicU64::new(0),
            };
            let environment = Environment {
                progress: &within,
                ..*environment
            };
            let found = if self.lines[0].is_some() {
                self.along_lines(&group, from, count, &environment)
            } else {
                let left = self.last_run.saturating_sub(self.evaluator.runs());
                self.one_by_one(&group, (from, count), left, &environment)?
            };
            let Some(found) = found else {
                return Ok(false);
            };
            for (place, assignment) in group.into_iter().enumerate() {
                let values = found.iter().map(|on_pattern| on_pattern[place]);
                self.known
                    .entry(assignment.clone())
                    .or_default()
                    .extend(values);
            }
        }
        Ok(true)
    }

    /// Scores one assignment on all patterns, however many runs that takes: without it there would be
    /// no result. Returns false if stopped.
    pub(super) fn insist(
        &mut self,
        assignment: &RuleAssignment,
        environment: &Environment,
    ) -> Result<bool> {
        let last = std::mem::replace(&mut self.last_run, u64::MAX);
        let one = std::slice::from_ref(assignment);
        let scored = self.extend(one, self.places.len(), environment);
        self.last_run = last;
        scored
    }

    /// What is scored on all patterns, in registry order.
    pub(super) fn into_evaluation(self) -> Evaluation {
        let assignments = self.scored_on(self.places.len());
        let score = |assignment: &RuleAssignment| {
            let (values, shares): (Vec<f64>, Vec<f64>) =
                self.in_order(&self.known[assignment]).unzip();
            Score {
                picked_share: shares.iter().sum::<f64>() / shares.len() as f64,
                values,
            }
        };
        Evaluation {
            scores: assignments.iter().map(score).collect(),
            patterns: match assignments.is_empty() {
                true => Vec::new(),
                false => self.evaluator.places(),
            },
            assignments,
        }
    }

    /// What is known on all patterns, by their places in the set.
    fn in_order(&self, known: &[OnPattern]) -> impl Iterator<Item = OnPattern> {
        let mut order: Vec<(usize, OnPattern)> = self
            .places
            .iter()
            .copied()
            .zip(known.iter().copied())
            .collect();
        order.sort_unstable_by_key(|(place, _)| *place);
        order.into_iter().map(|(_, on_pattern)| on_pattern)
    }

    /// Scores of `group` on patterns `from..to`, by pattern, from the first changed robot on.
    fn along_lines(
        &mut self,
        group: &[&RuleAssignment],
        from: usize,
        to: usize,
        environment: &Environment,
    ) -> Option<Vec<Vec<OnPattern>>> {
        let (evaluator, objective) = (self.evaluator, self.evaluator.objective());
        let on_line = |line: &mut Option<PrefixGraph>| {
            let line = line.as_mut()?;
            let before = line.passes();
            let mut found = Vec::with_capacity(group.len());
            for assignment in group {
                if environment.stopped() {
                    break;
                }
                let figures = line.figures(assignment.rules());
                let value = objective.of_run(&figures).unwrap_or_default();
                found.push((value, figures.picked_share()));
            }
            evaluator.count(found.len() as u64, line.passes() - before);
            environment.progress.advance(1);
            (found.len() == group.len()).then_some(found)
        };
        self.lines[from..to].par_iter_mut().map(on_line).collect()
    }

    /// The same in the way of the evaluator, in at most `most` runs.
    fn one_by_one(
        &self,
        group: &[&RuleAssignment],
        (from, to): (usize, usize),
        most: u64,
        environment: &Environment,
    ) -> Result<Option<Vec<Vec<OnPattern>>>> {
        let whole = group[0].rules().len() == self.robots();
        let evaluator = if whole {
            self.evaluator
        } else {
            &self.for_parts
        };
        let places = &self.places[from..to];
        let some = evaluator.on_places(places);
        let list = group.iter().map(|&a| a.clone()).collect();
        let evaluation = some.evaluate_within(list, most, environment)?;
        if !evaluation.is_whole(&some) {
            return Ok(None);
        }
        let on_place = |place: &usize| {
            let rank = evaluation.patterns.binary_search(place).unwrap_or(0);
            let scores = evaluation.scores.iter();
            scores
                .map(|score| (score.values[rank], score.picked_share))
                .collect()
        };
        Ok(Some(places.iter().map(on_place).collect()))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Pattern, grid};
    use crate::sim::Conditions;
    use crate::station::{Station, built_in};

    fn station(speed: f64) -> Station {
        let station = built_in("paper").unwrap().station(Some(3)).unwrap();
        station.with_belt_speed(speed).unwrap()
    }

    fn patterns() -> Vec<Pattern> {
        let spacings = [0.15, 0.17, 0.19, 0.21, 0.25, 0.3];
        spacings.map(|s| grid(1.05, s, 24).unwrap()).to_vec()
    }

    /// Piece by piece, with and without shared passes and on top of an enumeration, scores are those
    /// of the evaluator; passes are counted, and fewer where beginnings are known.
    #[test]
    fn scores_grow_to_those_of_the_evaluator() {
        let (station, patterns) = (station(0.15), patterns());
        let quiet = Environment::QUIET;
        let all: Vec<RuleAssignment> = RuleAssignment::all(3).step_by(7).collect();
        for (objective, risk) in [
            (Objective::PickingRate, Risk::Mean),
            (Objective::WeightedRate, Risk::Cvar(0.4)),
            (Objective::PickedShare, Risk::Worst),
        ] {
            let new =
                || Evaluator::new(&station, &patterns, objective, &Conditions::default()).unwrap();
            let plain = new();
            let expected = plain.evaluate(all.clone(), &quiet).unwrap();
            let evaluator = new();
            let mut scores = PartialScores::new(&evaluator, None, 3, u64::MAX);
            for (some, count) in [(&all[..9], 2), (&all[5..], 4), (&all[..], 6)] {
                assert!(scores.extend(some, count, &quiet).unwrap());
                assert!(some.iter().all(|a| scores.known(a).len() >= count));
            }
            assert_eq!(evaluator.runs(), (all.len() * 6) as u64);
            assert!(evaluator.passes() < plain.passes());
            for (place, assignment) in all.iter().enumerate() {
                let value = risk.aggregate(&expected.scores[place].values);
                assert_eq!(scores.aggregate(assignment, 6, risk), value);
            }
            let found = scores.into_evaluation();
            assert_eq!(found.assignments, expected.assignments);
            assert_eq!(
                (found.scores, found.patterns),
                (expected.scores.clone(), expected.patterns.clone())
            );
            // What is known costs nothing.
            let evaluator = new();
            let mut scores = PartialScores::new(&evaluator, Some(&expected), 3, 0);
            assert!(scores.extend(&all, 6, &quiet).unwrap());
            assert_eq!(evaluator.runs(), 0);
            assert!(
                !scores
                    .extend(&["LD,LD,SD".parse().unwrap()], 1, &quiet)
                    .unwrap()
            );
        }
    }

    /// The seed decides which patterns come first, and a part of the line is scored with the others
    /// idle.
    #[test]
    fn patterns_come_in_the_order_of_the_seed() {
        let (station, patterns) = (station(0.15), patterns());
        let plain = Conditions::default();
        let evaluator = Evaluator::new(&station, &patterns, Objective::PickingRate, &plain);
        let evaluator = evaluator.unwrap();
        let part: RuleAssignment = "SPT,FIFO".parse().unwrap();
        let one = std::slice::from_ref(&part);
        let values = |seed| {
            let mut scores = PartialScores::new(&evaluator, None, seed, u64::MAX);
            assert!(scores.extend(one, 6, &Environment::QUIET).unwrap());
            let (scored, known) = (scores.scored_on(1), scores.known(&part));
            // No assignment of the whole line.
            assert!(scored.is_empty());
            known
        };
        let mut orders: Vec<Vec<f64>> = (0..4).map(values).collect();
        assert!(orders.windows(2).any(|pair| pair[0] != pair[1]));
        orders
            .iter_mut()
            .for_each(|order| order.sort_by(f64::total_cmp));
        let expected = evaluator
            .evaluate(vec![part.clone()], &Environment::QUIET)
            .unwrap();
        let mut expected = expected.scores[0].values.clone();
        expected.sort_by(f64::total_cmp);
        assert!(orders.iter().all(|order| *order == expected));
    }
}
