//! The rule for each robot that picks best across a set of patterns, scored again on fresh
//! patterns and beside other strategies.

use super::blueprint::policy_distance;
use super::inputs::{check_strategies, patterns_hash};
use super::notes::{Note, set_notes};
use super::options::{StudyOptions, check_distinct};
use super::patterns::{ScoredPatterns, ScoredSet, independent_events, with_draws};
use crate::error::{Error, Result};
use crate::optimize::{
    Environment, Evaluator, Grasp, Limits, Objective, Optimum, Risk, Rival, Search, SearchKind,
    SpeedScan, StopReason, Validation, ValidationOptions, chosen_flow, find_optimum, rivals,
    validate,
};
use crate::pattern::{PatternSet, PatternSource, Recipe};
use crate::sim::Conditions;
use crate::station::{Station, station_hash};
use crate::strategies::Blueprint;
use std::time::Instant;

/// Default number of fresh patterns on which the winner is scored.
const MOST_FRESH: usize = 1000;
/// Maximum number of items in all of them; if they have more, there are fewer patterns.
const ITEMS_OF_FRESH: f64 = 150_000.0;
/// Minimum default number of fresh patterns, however long they are.
const FEWEST_FRESH: usize = 10;
/// Maximum number of fresh patterns after the time limit.
const FRESH_IN_A_HURRY: usize = 24;
/// Number of grids, and of Poisson disk patterns, of the default set.
pub(super) const DEFAULT_BALANCED: usize = 120;

/// The settings of a search and of the validation of its winner. By default the picking rate on
/// the balanced set is maximised within the usual number of runs, and the winner is validated and
/// bounded.
pub type OptimizeOptions = StudyOptions<OptimizeSettings>;

/// What only the settings of a search have.
#[derive(Debug, Clone)]
pub struct OptimizeSettings {
    patterns: ScoredPatterns,
    objective: Objective,
    search: Search,
    fresh: Option<usize>,
}

impl Default for OptimizeSettings {
    fn default() -> Self {
        Self {
            patterns: PatternSource::Balanced(DEFAULT_BALANCED).into(),
            objective: Objective::PickingRate,
            search: Search::default(),
            fresh: None,
        }
    }
}

impl OptimizeOptions {
    /// With assignments scored on these patterns.
    #[must_use]
    pub fn with_patterns(mut self, patterns: ScoredPatterns) -> Self {
        self.own.patterns = patterns;
        self
    }

    /// With this figure maximised.
    #[must_use]
    pub fn with_objective(mut self, objective: Objective) -> Self {
        self.own.objective = objective;
        self
    }

    /// With this search method.
    #[must_use]
    pub fn with_kind(mut self, kind: SearchKind) -> Self {
        self.own.search.kind = kind;
        self
    }

    /// With these settings of GRASP; its seed is the master seed.
    #[must_use]
    pub fn with_grasp(mut self, grasp: Grasp) -> Self {
        self.own.search.grasp = grasp;
        self
    }

    /// With the figures of the patterns combined in this way.
    #[must_use]
    pub fn with_risk(mut self, risk: Risk) -> Self {
        self.own.search.risk = risk;
        self
    }

    /// With this resolution of the speed limits that break ties.
    #[must_use]
    pub fn with_scan(mut self, scan: SpeedScan) -> Self {
        self.own.search.scan = Some(scan);
        self
    }

    /// With these limits on the search.
    #[must_use]
    pub fn with_limits(mut self, limits: Limits) -> Self {
        self.own.search.limits = limits;
        self
    }

    /// With the winner scored on this number of fresh patterns; 0 for none. By default 1000,
    /// fewer if they are long.
    #[must_use]
    pub fn with_validation(mut self, patterns: usize) -> Self {
        self.own.fresh = Some(patterns);
        self
    }
}

/// A search whose settings are checked and whose patterns are drawn.
#[derive(Debug)]
pub struct OptimizeStudy<'a> {
    station: &'a Station,
    options: &'a OptimizeOptions,
    conditions: Conditions,
    search: Search,
    set: ScoredSet,
    strategies: Vec<Blueprint>,
    /// Number of fresh patterns to score the winner on.
    fresh: usize,
}

/// What a search found.
#[derive(Debug)]
#[non_exhaustive]
pub struct Optimized {
    /// The best assignments. If the user stopped the search, or only what follows it, its stop
    /// reason is [`StopReason::Interrupted`].
    pub optimum: Optimum,
    /// The settings of the search.
    pub search: Search,
    /// The winner on fresh patterns, and their description.
    pub validation: Option<(Validation, String)>,
    /// The strategies beside the winner, if there are any.
    pub rivals: Option<ScoredRivals>,
    /// Remarks on what was left out, and on how the figures are to be read.
    pub notes: Vec<Note>,
}

/// Strategies scored beside the winner, on the same patterns.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ScoredRivals {
    /// The winner, then the strategies.
    pub rivals: Vec<Rival>,
    /// How the strategies are written.
    pub names: Vec<String>,
    /// The description of the patterns.
    pub patterns: String,
    /// Number of patterns on which each was scored.
    pub count: usize,
}

/// Finds the assignment of rules that picks best across a set of patterns, scores it again on
/// fresh patterns, bounds it, and scores other strategies beside it. On a stop request, the
/// best so far is returned.
///
/// # Errors
/// Settings that do not fit the line, a set that cannot be generated or read, or
/// [`Interrupted`](crate::error::ErrorKind::Interrupted) before there is a result.
pub fn optimize(
    station: &Station,
    options: &OptimizeOptions,
    environment: &Environment,
) -> Result<Optimized> {
    OptimizeStudy::new(station, options)?.run(environment)
}

impl<'a> OptimizeStudy<'a> {
    /// Checks the settings and draws the patterns.
    ///
    /// # Errors
    /// Settings that do not fit the line, or a set that cannot be generated or read.
    pub fn new(station: &'a Station, options: &'a OptimizeOptions) -> Result<Self> {
        options.own.search.risk.checked()?;
        let conditions = options.conditions.with_seed(options.seed);
        conditions.check()?;
        let set = options
            .own
            .patterns
            .draw(station, options.seed, &conditions)?;
        let fresh = match options.own.fresh {
            Some(count) => count,
            // Fewer long patterns are as informative.
            None => {
                let items = set.source.expected_items(&set.recipe)?;
                let afforded = ITEMS_OF_FRESH / items.max(1.0);
                (afforded as usize).clamp(FEWEST_FRESH, MOST_FRESH)
            }
        };
        set.source.check_fresh(&set.recipe, fresh)?;
        let robots = station.robots().len();
        check_distinct(&options.strategies, robots)?;
        let strategies = options.strategies.iter();
        let strategies = strategies.map(|strategy| {
            strategy.check_on(station)?;
            strategy.alone(robots)
        });
        let search = &options.own.search;
        let grasp = search.grasp.with_seed(options.seed).checked()?;
        Ok(Self {
            station,
            options,
            conditions,
            search: search.with_grasp(grasp),
            set,
            strategies: strategies.collect::<Result<_>>()?,
            fresh,
        })
    }

    /// The patterns on which assignments are scored.
    pub fn set(&self) -> &ScoredSet {
        &self.set
    }

    /// Checks that all shards are made on the same line and patterns.
    fn check_inputs(&self, environment: &Environment) -> Result<()> {
        let ledger = environment.ledger;
        ledger.check_input("the station", || Ok(station_hash(self.station)))?;
        let patterns = &self.set.scored().patterns;
        ledger.check_input("the patterns", || Ok(patterns_hash(patterns)))?;
        let strategies = self.strategies.iter();
        check_strategies(strategies.map(Blueprint::name), environment)
    }

    /// Runs the search and scores its winner.
    ///
    /// # Errors
    /// An illegal action of a strategy, or
    /// [`Interrupted`](crate::error::ErrorKind::Interrupted) before there is a result.
    pub fn run(&self, environment: &Environment) -> Result<Optimized> {
        let set = self.set.scored();
        self.check_inputs(environment)?;
        let evaluator = self.evaluator(set, &self.conditions)?;
        let mut optimum = find_optimum(&evaluator, &self.search, environment)?;
        let until = self.search.limits.until;
        let short = until.is_some_and(|until| Instant::now() >= until);
        let count = match short {
            true => self.fresh.min(FRESH_IN_A_HURRY),
            false => self.fresh,
        };
        let fresh = self.draw_fresh(count, environment)?;
        let conditions = independent_events(&self.conditions);
        let on_fresh = fresh
            .as_ref()
            .map(|fresh| self.evaluator(fresh, &conditions));
        let on_fresh = on_fresh.transpose()?;
        let validation = match (&fresh, &on_fresh) {
            (Some(fresh), Some(on)) => {
                let certify = !short && self.options.bound;
                let validation = self.validate(on, &optimum, certify, environment)?;
                validation.map(|validation| (validation, fresh.description.clone()))
            }
            _ => None,
        };
        let scored = match (&fresh, &on_fresh) {
            (Some(fresh), Some(on)) => (fresh, on),
            _ => (set, &evaluator),
        };
        let rivals = self.score_rivals(scored, &optimum, environment)?;
        if environment.ledger.shard().is_some() {
            return Err(match environment.stopped() {
                true => Error::interrupted(),
                false => Error::sharded(),
            });
        }
        let mut notes = self.notes(&evaluator, &optimum);
        if short {
            let fresh = FRESH_IN_A_HURRY;
            notes.push(Note::TimeLimit { fresh });
        }
        if environment.stopped() {
            notes.push(Note::Interrupted);
            // Even if the search was complete and only later work was interrupted.
            optimum.stop = StopReason::Interrupted;
        } else if validation.is_none() && self.fresh > 0 {
            notes.push(Note::NotValidated(self.set.source.to_string()));
        }
        Ok(Optimized {
            optimum,
            search: self.search,
            validation,
            rivals,
            notes,
        })
    }

    /// Patterns that were not used in the search, drawn with the next seed.
    fn draw_fresh(&self, count: usize, environment: &Environment) -> Result<Option<PatternSet>> {
        if count == 0 || environment.stopped() {
            return Ok(None);
        }
        let recipe = Recipe {
            seed: self.set.recipe.seed.wrapping_add(1),
            ..self.set.recipe.clone()
        };
        let fresh = self.set.source.draw_fresh(&recipe, count)?;
        if fresh.is_some() || !self.conditions.is_random() {
            return Ok(fresh);
        }
        // The same patterns with different random events are also fresh.
        Ok(Some(with_draws(self.set.drawn(), count)))
    }

    /// The evaluator that scores assignments and strategies on `set`.
    fn evaluator<'s>(
        &'s self,
        set: &'s PatternSet,
        conditions: &Conditions,
    ) -> Result<Evaluator<'s>> {
        let objective = self.options.own.objective;
        Evaluator::new(self.station, &set.patterns, objective, conditions)
    }

    /// Scores the winner on the fresh patterns of `evaluator`.
    fn validate(
        &self,
        evaluator: &Evaluator,
        optimum: &Optimum,
        certify: bool,
        environment: &Environment,
    ) -> Result<Option<Validation>> {
        let best = optimum.ranking.best();
        let options =
            ValidationOptions::new(self.search.risk, independent_events(&self.conditions))
                .with_flow(chosen_flow(self.options.own.objective, best))
                .with_certify(certify);
        validate(evaluator, &best.assignment, &options, environment)
    }

    /// Scores the strategies and the winner on a set, the patterns of its evaluator.
    fn score_rivals(
        &self,
        (set, evaluator): (&PatternSet, &Evaluator),
        optimum: &Optimum,
        environment: &Environment,
    ) -> Result<Option<ScoredRivals>> {
        if self.strategies.is_empty() || environment.stopped() {
            return Ok(None);
        }
        let best = &optimum.ranking.best().assignment;
        let risk = self.search.risk;
        let rivals = rivals(evaluator, best, &self.strategies, risk, environment)?;
        let names = self.strategies.iter().map(|s| s.name().to_owned());
        Ok(rivals.map(|rivals| ScoredRivals {
            rivals,
            names: names.collect(),
            patterns: set.description.clone(),
            count: set.patterns.len(),
        }))
    }

    /// Notes on the set, the chosen flow and the strategies.
    fn notes(&self, evaluator: &Evaluator, optimum: &Optimum) -> Vec<Note> {
        let count = evaluator.pattern_count();
        let independent = evaluator.independent_patterns();
        let set = self.set.scored();
        let mut notes = set_notes(self.station, set, &self.conditions, independent, count);
        if matches!(self.options.own.objective, Objective::MaxSpeed(_)) {
            let best = optimum.ranking.best();
            notes.push(match chosen_flow(self.options.own.objective, best) {
                Some(_) if optimum.patterns < count => Note::NoFlowYet,
                Some(flow) => Note::ChosenFlow(flow),
                None => Note::NoFlow,
            });
        }
        let distances = self.strategies.iter();
        let distances = distances.filter_map(|s| policy_distance(s, self.station));
        notes.extend(distances.map(|distance| Note::Distance(distance.to_string())));
        notes
    }
}
