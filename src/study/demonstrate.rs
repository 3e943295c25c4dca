//! Episodes of a strategy as data for learning offline.

use super::blueprint::{BlueprintOptions, blueprint};
use crate::decision::observation::Layout;
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::rl::{Demonstration, Reward};
use crate::setters::setters;
use crate::sim::{Conditions, Scene};
use crate::station::Station;
use crate::strategies::StrategySpec;
use rayon::prelude::*;

/// What episodes are recorded of, and how they are shown.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct DemonstrateOptions {
    seed: u64,
    conditions: Conditions,
    layout: Layout,
    reward: Reward,
}

impl Default for DemonstrateOptions {
    /// Seed 1, nothing going wrong, the paper's observation and reward.
    fn default() -> Self {
        Self {
            seed: 1,
            conditions: Conditions::default(),
            layout: Layout::PAPER,
            reward: Reward::PAPER,
        }
    }
}

setters!(DemonstrateOptions {
    /// With this seed of the search for bases of a look-ahead that names none.
    fn with_seed(seed: u64);
    /// Under these conditions; the pattern with index i has their seed plus i, as in the environment.
    fn with_conditions(conditions: Conditions);
    /// With observations and actions of this shape.
    fn with_layout(layout: Layout);
    /// With this reward.
    fn with_reward(reward: Reward);
});

/// Episodes of a strategy, one for each pattern.
#[derive(Debug)]
#[non_exhaustive]
pub struct Demonstrations {
    /// The full name of the strategy.
    pub strategy: String,
    /// The episodes, in the order of the patterns.
    pub episodes: Vec<Demonstration>,
}

/// Plays `strategy` on every pattern as an episode of the environment.
///
/// # Errors
/// No pattern, settings or a strategy that do not fit the line, an item beside the belt, an illegal
/// action, an episode of which nothing is an action of the environment, or
/// [`Interrupted`](crate::error::ErrorKind::Interrupted).
pub fn demonstrate(
    station: &Station,
    patterns: &[&Pattern],
    strategy: &StrategySpec,
    options: &DemonstrateOptions,
    environment: &Environment,
) -> Result<Demonstrations> {
    options.reward.check()?;
    if patterns.is_empty() {
        let cure = "give at least one";
        return Err(Error::usage("'patterns'", "there is no pattern", cure));
    }
    let placed = BlueprintOptions::default()
        .with_seed(options.seed)
        .with_update_hz(options.conditions.update_hz);
    let made = blueprint(strategy, station, &placed, environment)?;
    environment
        .progress
        .begin("recording", patterns.len() as u64, "patterns");
    let play = |(place, pattern): (usize, &&Pattern)| {
        if environment.stopped() {
            return Err(Error::interrupted());
        }
        let inside = |error: Error| error.inside(&format!("pattern {place}"));
        let scene = Scene::under(station, pattern, options.conditions.of_place(place));
        let scene = scene.map_err(inside)?;
        let mut strategy = made.make();
        let rules = (options.layout, options.reward);
        let go_on = || !environment.stopped();
        let played = Demonstration::play(&scene, strategy.as_mut(), rules, go_on);
        let played = played.map_err(inside)?;
        if played.actions.is_empty() {
            let problem = if played.left_out == 0 {
                "nobody has a decision to make"
            } else {
                "nothing that the strategy does is an action of the environment"
            };
            return Err(Error::input(
                format!("pattern {place}"),
                problem,
                "use patterns with items within reach of a robot, more slots, or waiting as an action",
            ));
        }
        environment.progress.advance(1);
        Ok(played)
    };
    let episodes = patterns.par_iter().enumerate().map(play);
    // Whichever fails first, the first pattern's error is told.
    let episodes: Vec<Result<_>> = episodes.collect();
    let episodes = episodes.into_iter().collect::<Result<_>>()?;
    environment.progress.end();
    Ok(Demonstrations {
        strategy: made.name().to_owned(),
        episodes,
    })
}
