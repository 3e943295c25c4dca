//! GRASP: greedy randomised adaptive search.
//!
//! Feo and Resende, "Greedy randomized adaptive search procedures", Journal of Global
//! Optimization 6, 1995 (DOI 10.1007/BF01096763). Each start builds an assignment robot by
//! robot, choosing at random among the rules that score nearly as well as the best, climbs to a
//! local optimum and follows a path to that of another start. Starts judge on a sample of the
//! patterns. What they scored is then screened over more and more patterns, and the search ends
//! where no neighbour is better over all of them.

use super::environment::Environment;
use super::evaluator::{Evaluation, Evaluator};
use super::grasp_walk::Walk;
use super::objective::Risk;
use super::partial_scores::PartialScores;
use crate::dispatch::{Rule, RuleAssignment};
use crate::error::{Error, Result, shown_number};
use crate::pattern::random_stream;
use crate::setters::setters;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;

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
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct GraspOutcome {
    /// Best assignment found; `None` if the search was cut short before the first was scored.
    pub best: Option<RuleAssignment>,
    /// Aggregate of the best assignment.
    pub value: f64,
    /// Number of starts that reached a local optimum.
    pub starts: usize,
    /// Number of those that scored the best assignment on their way.
    pub hits: usize,
    /// Moves made by all local searches.
    pub moves: usize,
    /// Whether it was stopped or used up its runs before the last start ended.
    pub cut: bool,
}

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

    /// Runs the search in at most `most` runs (the first score may exceed them), with the scores of
    /// `enumeration` if there is one. Also returns what it scored on all patterns.
    pub(super) fn run(
        &self,
        evaluator: &Evaluator,
        risk: Risk,
        enumeration: Option<&Evaluation>,
        most: u64,
        environment: &Environment,
    ) -> Result<(GraspOutcome, Evaluation)> {
        let mut scores = PartialScores::new(evaluator, enumeration, self.seed, most);
        let outcome = self.starts(Walk::new(&mut scores, risk, environment), environment)?;
        Ok((outcome, scores.into_evaluation()))
    }

    /// Runs all starts, and then settles which of what they scored is best.
    fn starts(&self, mut walk: Walk, environment: &Environment) -> Result<GraspOutcome> {
        let mut outcome = GraspOutcome {
            best: None,
            value: f64::NEG_INFINITY,
            starts: 0,
            hits: 0,
            moves: 0,
            cut: !walk.score_uniform()?,
        };
        let mut met = Vec::new();
        let mut elites: Vec<RuleAssignment> = Vec::new();
        let starts = if outcome.cut { 0 } else { self.starts };
        for start in 0..starts {
            let mut rng = random_stream(self.seed, start as u64);
            let Some(moves) = self.start(&mut walk, &mut elites, &mut rng)? else {
                outcome.cut = true;
                break;
            };
            environment.progress.advance(1);
            if let Some((best, value)) = walk.incumbent() {
                environment
                    .progress
                    .incumbent(&format!("{best} {value:.4}"));
            }
            outcome.starts += 1;
            outcome.moves += moves;
            met.push(walk.met());
        }
        if !outcome.cut {
            match walk.settle()? {
                Some(moves) => outcome.moves += moves,
                None => outcome.cut = true,
            }
        }
        if let Some((best, value)) = walk.incumbent() {
            outcome.hits = met.iter().filter(|met| met.contains(best)).count();
            outcome.best = Some(best.clone());
            outcome.value = *value;
        }
        Ok(outcome)
    }

    /// One start: its local optimum is linked to one of the `elites`, which it joins, and the better of
    /// both is screened. Returns the moves; `None` if cut short.
    fn start(
        &self,
        walk: &mut Walk,
        elites: &mut Vec<RuleAssignment>,
        rng: &mut ChaCha8Rng,
    ) -> Result<Option<usize>> {
        let Some((mut end, mut moves)) = walk.one_start(self.alpha, rng)? else {
            return Ok(None);
        };
        let others: Vec<&RuleAssignment> = elites.iter().filter(|elite| **elite != end).collect();
        if !others.is_empty() {
            let elite = others[rng.random_range(0..others.len())].clone();
            let Some(between) = walk.relink(&end, &elite)? else {
                return Ok(None);
            };
            let Some((linked, more)) = walk.climb(between)? else {
                return Ok(None);
            };
            moves += more;
            let mut ends = vec![end.clone(), linked.clone()];
            ends.dedup();
            if walk.screen(ends)?.is_none() {
                return Ok(None);
            }
            end = linked;
        } else if walk.screen(vec![end.clone()])?.is_none() {
            return Ok(None);
        }
        if !elites.contains(&end) {
            elites.push(end);
        }
        Ok(Some(moves))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
