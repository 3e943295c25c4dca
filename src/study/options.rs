//! The settings that studies have in common.

use super::notes::Note;
use super::robust::RobustTraining;
use crate::error::{Error, Result, shown};
use crate::sim::Conditions;
use crate::strategies::StrategySpec;
use std::sync::Arc;

/// The settings of a study: what all studies have, and in `S` what only one kind of them has.
/// It is used by the names [`CompareOptions`](super::CompareOptions),
/// [`SweepOptions`](super::SweepOptions) and [`OptimizeOptions`](super::OptimizeOptions).
///
/// By default the seed is 1, nothing goes wrong, there are no strategies besides those that the
/// study itself brings, and results are bounded.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct StudyOptions<S> {
    pub(super) seed: u64,
    pub(super) conditions: Conditions,
    pub(super) strategies: Vec<Arc<StrategySpec>>,
    pub(super) bound: bool,
    /// What only this kind of study has.
    pub(super) own: S,
}

impl<S: Default> Default for StudyOptions<S> {
    fn default() -> Self {
        Self {
            seed: 1,
            conditions: Conditions::default(),
            strategies: Vec::new(),
            bound: true,
            own: S::default(),
        }
    }
}

impl<S> StudyOptions<S> {
    /// With this master seed. Assignments are searched with it; the cases of a comparison, the
    /// patterns of a sweep and fresh patterns use the seeds after it.
    #[must_use]
    pub fn with_seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Under these conditions, with random events from the master seed.
    #[must_use]
    pub fn with_conditions(mut self, conditions: Conditions) -> Self {
        self.conditions = conditions;
        self
    }

    /// With another strategy, scored on the same patterns as the study's own.
    #[must_use]
    pub fn with_strategy(mut self, strategy: impl Into<StrategySpec>) -> Self {
        self.strategies.push(Arc::new(strategy.into()));
        self
    }

    /// With a certified bound on what any strategy can do, or without it.
    #[must_use]
    pub fn with_bound(mut self, bound: bool) -> Self {
        self.bound = bound;
        self
    }
}

/// Settings of studies that run several methods: comparisons and sweeps.
#[derive(Debug, Clone, Default)]
pub struct MethodSettings {
    pub(super) station_strategy: Option<Arc<StrategySpec>>,
    pub(super) training: RobustTraining,
    pub(super) greedy: bool,
    pub(super) tune: bool,
}

impl<S: AsMut<MethodSettings>> StudyOptions<S> {
    /// With the strategy that the station file names, before the others and unless it is one
    /// of them.
    #[must_use]
    pub fn with_station_strategy(mut self, strategy: Option<StrategySpec>) -> Self {
        self.own.as_mut().station_strategy = strategy.map(Arc::new);
        self
    }

    /// With robust GT (game theory) from this training.
    #[must_use]
    pub fn with_training(mut self, training: RobustTraining) -> Self {
        self.own.as_mut().training = training;
        self
    }

    /// With greedy GT, the assignment that is best on each pattern by itself, or without it: by
    /// default with it in a comparison, without it in a sweep. A comparison always leaves it out
    /// if it would take minutes.
    #[must_use]
    pub fn with_greedy(mut self, greedy: bool) -> Self {
        self.own.as_mut().greedy = greedy;
        self
    }

    /// With the best of what line software ships, tuned on training patterns, or without it. Its name is
    /// `rival`.
    #[must_use]
    pub fn with_tune(mut self, tune: bool) -> Self {
        self.own.as_mut().tune = tune;
        self
    }
}

impl MethodSettings {
    /// The strategy of the station file, unless it is one of `given`, and those, for a line of `robots`
    /// robots; with a note if it was added.
    ///
    /// # Errors
    /// As for [`check_distinct`].
    pub(super) fn strategies(
        &self,
        given: &[Arc<StrategySpec>],
        robots: usize,
    ) -> Result<(Vec<Arc<StrategySpec>>, Option<Note>)> {
        check_distinct(given, robots)?;
        let saved = self.station_strategy.as_ref();
        let saved = saved.filter(|saved| given.iter().all(|s| s.text() != saved.text()));
        let note = saved.map(|saved| Note::StationStrategy(saved.text().to_owned()));
        Ok((saved.into_iter().chain(given).cloned().collect(), note))
    }
}

/// The names of the methods that studies bring, which no strategy may have.
const TAKEN: [&str; 3] = ["robust_gt", "greedy_gt", "rival"];

/// Checks that no two strategies on a line of `robots` robots would have the same name in results, nor one
/// the name of another method.
///
/// # Errors
/// [`Usage`](crate::error::ErrorKind::Usage): one is given twice, or has such a name; and as for
/// [`StrategySpec::alone`].
pub(super) fn check_distinct(given: &[Arc<StrategySpec>], robots: usize) -> Result<()> {
    let mut names: Vec<String> = Vec::with_capacity(given.len());
    for strategy in given {
        let name = strategy.alone(robots)?.name().to_owned();
        let wrong = |problem: &str, cure: &str| {
            let text = shown(strategy.text());
            Err(Error::usage(
                "'strategy'",
                format!("`{text}` {problem}"),
                cure,
            ))
        };
        if TAKEN.contains(&name.as_str()) {
            return wrong("is the name of another method", "give it another name");
        }
        if names.contains(&name) {
            let cure = "give each strategy once, and different ones of your own different names";
            return wrong("is given twice", cure);
        }
        names.push(name);
    }
    Ok(())
}
