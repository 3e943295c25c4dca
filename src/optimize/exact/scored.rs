//! The assignments that branch and bound scored on all patterns.

use crate::dispatch::RuleAssignment;
use crate::optimize::{Evaluation, Evaluator, Risk, Score};

/// Maximum number of assignments that are kept beside those known before.
const MOST_KEPT: usize = 1000;

/// Assignments with their scores: those known before, and the best of the others.
pub(super) struct Scored {
    known: Evaluation,
    /// With the values combined.
    found: Vec<(f64, RuleAssignment, Score)>,
    /// The best figure so far.
    pub best: f64,
}

impl Scored {
    /// Those of `known`.
    pub(super) fn new(known: Evaluation, risk: Risk) -> Self {
        let figure = |leader: usize| risk.aggregate(&known.scores[leader].values);
        Self {
            best: known.leader(risk).map_or(f64::NEG_INFINITY, figure),
            known,
            found: Vec::new(),
        }
    }

    /// Whether a prefix whose completions do not exceed `most` is of no interest: it is worse than the best,
    /// or no better and there are enough as good ones.
    pub(super) fn cannot_gain_by(&self, most: f64) -> bool {
        most < self.best || (most == self.best && self.worst_kept() == Some(self.best))
    }

    /// The figure of the worst that is kept, if no more are kept.
    fn worst_kept(&self) -> Option<f64> {
        self.found.get(MOST_KEPT - 1).map(|(figure, ..)| *figure)
    }

    /// Adds an assignment with this figure.
    pub(super) fn add(&mut self, assignment: RuleAssignment, score: Score, figure: f64) {
        self.best = self.best.max(figure);
        // The best first, earlier ones before later ones.
        let place = self.found.partition_point(|(other, ..)| *other >= figure);
        if place < MOST_KEPT {
            self.found.insert(place, (figure, assignment, score));
            self.found.truncate(MOST_KEPT);
        }
    }

    /// All of them, in registry order.
    pub(super) fn into_evaluation(self, evaluator: &Evaluator) -> Evaluation {
        let found = self
            .found
            .into_iter()
            .map(|(_, assignment, score)| (assignment, score));
        let known = self.known.assignments.into_iter().zip(self.known.scores);
        let mut all: Vec<_> = known.chain(found).collect();
        all.sort_by(|a, b| a.0.cmp(&b.0));
        all.dedup_by(|a, b| a.0 == b.0);
        let (assignments, scores) = all.into_iter().unzip();
        Evaluation {
            assignments,
            scores,
            patterns: evaluator.places(),
        }
    }
}
