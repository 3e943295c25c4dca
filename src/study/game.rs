//! A line as a game: robots are the players, rules are their actions.

use super::notes::{Note, set_notes};
use super::optimize::DEFAULT_BALANCED;
use super::patterns::{ScoredPatterns, ScoredSet};
use crate::error::Result;
use crate::optimize::Environment;
use crate::optimize::game::{LineGame, PayoffKind, check_size};
use crate::pattern::PatternSource;
use crate::setters::setters;
use crate::sim::Conditions;
use crate::station::Station;

/// The settings of a game.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct GameOptions {
    seed: u64,
    patterns: ScoredPatterns,
    conditions: Conditions,
    payoff: PayoffKind,
}

impl Default for GameOptions {
    /// Each robot's own picks per minute on the balanced set with seed 1, nothing going wrong.
    fn default() -> Self {
        Self {
            seed: 1,
            patterns: PatternSource::Balanced(DEFAULT_BALANCED).into(),
            conditions: Conditions::default(),
            payoff: PayoffKind::Own,
        }
    }
}

setters!(GameOptions {
    /// With this master seed.
    fn with_seed(seed: u64);
    /// With payoffs from these patterns.
    fn with_patterns(patterns: ScoredPatterns);
    /// Under these conditions, with random events from the master seed.
    fn with_conditions(conditions: Conditions);
    /// With this payoff of each robot.
    fn with_payoff(payoff: PayoffKind);
});

/// A game whose settings are checked and whose patterns are drawn.
#[derive(Debug)]
pub struct GameStudy<'a> {
    station: &'a Station,
    options: &'a GameOptions,
    conditions: Conditions,
    set: ScoredSet,
}

/// A game with the payoffs of all its profiles.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PlayedGame {
    /// The game; [`equilibria`](crate::optimize::game::equilibria) and the functions beside it
    /// solve it.
    pub line: LineGame,
    /// Number of patterns planned; the game has fewer if the work was stopped.
    pub planned: usize,
    /// Remarks on the result.
    pub notes: Vec<Note>,
}

/// Simulates every rule assignment of `station` and makes a game of them. On a stop request, the
/// game on the patterns so far is returned.
///
/// # Errors
/// Too many robots, settings that do not fit the line, a set that cannot be generated or read, or
/// [`Interrupted`](crate::error::ErrorKind::Interrupted) before the first pattern is done.
pub fn game(
    station: &Station,
    options: &GameOptions,
    environment: &Environment,
) -> Result<PlayedGame> {
    GameStudy::new(station, options)?.run(environment)
}

impl<'a> GameStudy<'a> {
    /// Checks the settings and draws the patterns.
    ///
    /// # Errors
    /// Too many robots, settings that do not fit the line, or a set that cannot be generated or
    /// read.
    pub fn new(station: &'a Station, options: &'a GameOptions) -> Result<Self> {
        check_size(station)?;
        let conditions = options.conditions.with_seed(options.seed);
        conditions.check()?;
        let set = options.patterns.draw(station, options.seed, &conditions)?;
        Ok(Self {
            station,
            options,
            conditions,
            set,
        })
    }

    /// The patterns from which payoffs are computed.
    pub fn set(&self) -> &ScoredSet {
        &self.set
    }

    /// Simulates every rule assignment.
    ///
    /// # Errors
    /// [`Interrupted`](crate::error::ErrorKind::Interrupted) before the first pattern is done.
    pub fn run(&self, environment: &Environment) -> Result<PlayedGame> {
        let (set, conditions) = (self.set.scored(), &self.conditions);
        let payoff = self.options.payoff;
        let line = LineGame::new(self.station, &set.patterns, payoff, conditions, environment)?;
        let notes = set_notes(
            self.station,
            set,
            conditions,
            line.independent,
            line.patterns,
        );
        Ok(PlayedGame {
            line,
            planned: set.patterns.len(),
            notes,
        })
    }
}
