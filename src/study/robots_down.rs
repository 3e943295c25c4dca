//! What a line still does with one of its robots halted.

use super::blueprint::policy_distance;
use super::notes::{Note, RobustNote, RobustScope, condition_notes};
use super::options::{MethodSettings, StudyOptions};
use super::patterns::ScoredPatterns;
use super::robust::{LineSearch, RobustTraining};
use super::sweep_options::DEFAULT_GRID;
use super::tuning::{tune, tuning_set};
use super::values::{self, LineAt};
use crate::error::Result;
use crate::experiment::{Method, RobotsDown, halt_each_robot};
use crate::optimize::Environment;
use crate::pattern::{PatternSet, PatternSource, Recipe};
use crate::planning::Allowance;
use crate::sim::Conditions;
use crate::station::Station;
use crate::strategies::StrategySpec;
use std::sync::Arc;

/// The settings of a study of halted robots. By default it has the grid of 0.15 m, long enough for a
/// steady state, and robust GT (game theory). There is no bound: it would be that of the line with
/// all robots.
pub type RobotsDownOptions = StudyOptions<RobotsDownSettings>;

/// What only the settings of a study of halted robots have.
#[derive(Debug, Clone)]
pub struct RobotsDownSettings {
    methods: MethodSettings,
    scored: ScoredPatterns,
}

impl Default for RobotsDownSettings {
    fn default() -> Self {
        Self {
            methods: MethodSettings::default(),
            scored: PatternSource::Grid(DEFAULT_GRID.0).into(),
        }
    }
}

impl AsMut<MethodSettings> for RobotsDownSettings {
    fn as_mut(&mut self) -> &mut MethodSettings {
        &mut self.methods
    }
}

impl RobotsDownOptions {
    /// With these patterns.
    #[must_use]
    pub fn with_scored_patterns(mut self, patterns: ScoredPatterns) -> Self {
        self.own.scored = patterns;
        self
    }
}

/// A study of halted robots whose settings are checked and whose patterns are drawn.
pub struct RobotsDownStudy<'a> {
    station: &'a Station,
    options: &'a RobotsDownOptions,
    strategies: Vec<Arc<StrategySpec>>,
    source: PatternSource,
    recipe: Recipe,
    set: PatternSet,
    note: Option<Note>,
}

/// What a study of halted robots found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct HaltedLine {
    /// The methods with no robot halted, then with each.
    pub robots_down: RobotsDown,
    /// Remarks on how the figures are to be read.
    pub notes: Vec<Note>,
}

/// Runs robust GT (game theory) and other strategies with no robot halted, then with each of them
/// down for the whole run, on the same patterns. On a stop request, what is complete is returned.
///
/// # Errors
/// Settings that do not fit the line, a pattern that cannot be generated or read, or
/// [`Interrupted`](crate::error::ErrorKind::Interrupted) before the whole line has been run.
pub fn robots_down(
    station: &Station,
    options: &RobotsDownOptions,
    environment: &Environment,
) -> Result<HaltedLine> {
    RobotsDownStudy::new(station, options)?.run(environment)
}

impl<'a> RobotsDownStudy<'a> {
    /// Checks the settings and draws the patterns.
    ///
    /// # Errors
    /// Settings that do not fit the line, or a pattern that cannot be generated or read.
    pub fn new(station: &'a Station, options: &'a RobotsDownOptions) -> Result<Self> {
        options.conditions.check_on(station)?;
        let robots = station.robots().len();
        let (strategies, note) = options
            .own
            .methods
            .strategies(&options.strategies, robots)?;
        for strategy in &strategies {
            strategy.check_on(station)?;
        }
        options.own.methods.training.check(robots)?;
        // A different seed from the training set's.
        let seed = options.seed.wrapping_add(1);
        let usual = DEFAULT_GRID.1;
        let (source, mut recipe) = options.own.scored.recipe(station, seed, usual)?;
        let mut set = source.build(&recipe)?;
        let generated = !source.is_recorded();
        if generated && options.own.scored.items().is_none() && recipe.items == usual {
            let line = LineAt {
                value: robots as f64,
                station: station.clone(),
                min_detection: None,
            };
            recipe.items = values::items(&[line], &set.patterns, recipe.items)?;
            set = source.build(&recipe)?;
        }
        Ok(Self {
            station,
            options,
            strategies,
            source,
            recipe,
            set,
            note,
        })
    }

    /// The patterns that are run with every robot.
    pub fn set(&self) -> &PatternSet {
        &self.set
    }

    /// Runs the study.
    ///
    /// # Errors
    /// A pattern that does not fit on the belt, an illegal action, or
    /// [`Interrupted`](crate::error::ErrorKind::Interrupted) before the whole line has been run.
    pub fn run(&self, environment: &Environment) -> Result<HaltedLine> {
        let conditions = self.options.conditions.with_seed(self.options.seed);
        let (methods, mut notes) = self.find_methods(&conditions, environment)?;
        let scored = conditions.with_seed(self.recipe.seed);
        let patterns = &self.set.patterns;
        let robots_down = halt_each_robot(self.station, &methods, patterns, &scored, environment)?;
        let generated = !self.source.is_recorded();
        notes.extend(condition_notes(&conditions, generated, false));
        Ok(HaltedLine { robots_down, notes })
    }

    /// The methods, which are found for the line with all robots: that is what runs when one halts.
    fn find_methods(
        &self,
        conditions: &Conditions,
        environment: &Environment,
    ) -> Result<(Vec<Method>, Vec<Note>)> {
        let (station, settings) = (self.station, &self.options.own.methods);
        let line = LineSearch::new(
            station,
            self.options.seed,
            conditions.update_hz,
            environment,
        );
        let trained = line.clone().under(conditions);
        let robust = trained.robust(&settings.training, |items| {
            trained.like(&self.source, items, &self.recipe)
        })?;
        let mut notes = vec![Note::Robust(RobustNote {
            basis: robust.basis.clone(),
            scope: match settings.training {
                RobustTraining::Given(_) => None,
                _ => Some(RobustScope::WholeLine),
            },
        })];
        notes.extend(self.note.clone());
        let mut methods = vec![Method::Robust(robust.rules.clone())];
        if settings.greedy {
            methods.push(Method::greedy(station.robots().len())?);
        }
        for strategy in &self.strategies {
            let blueprint = line.put(strategy, &robust.best_few, Allowance::default())?;
            let distance = policy_distance(&blueprint, station);
            notes.extend(distance.map(|distance| Note::Distance(distance.to_string())));
            methods.push(Method::Strategy(blueprint));
        }
        if settings.tune {
            let set = tuning_set(&settings.training, |items| {
                trained.like(&self.source, items, &self.recipe)
            })?;
            let rival = tune(station, &set, trained.conditions(), environment)?;
            let tuned = rival.blueprint(station.robots().len())?;
            notes.push(Note::Rival(rival.remark));
            methods.push(Method::Strategy(tuned));
        }
        Ok((methods, notes))
    }
}
