//! What the optimiser finds for a line before the study's own work: robust GT (game theory) and
//! the bases of strategies that look ahead.

use super::notes::{Note, RobustBasis, RobustNote};
use super::patterns::{independent_events, with_draws};
use crate::dispatch::RuleAssignment;
use crate::error::{Error, Result, shown};
use crate::experiment::{Case, training_set};
use crate::optimize::{
    Environment, Evaluator, Grasp, Limits, MostRuns, Objective, Optimum, Ranked, Search, SpeedScan,
    find_optimum,
};
use crate::pattern::{
    Attributes, ClassShares, Pattern, PatternSet, PatternSource, Recipe, TrainingSet,
};
use crate::planning::Allowance;
use crate::shards::Ledger;
use crate::sim::Conditions;
use crate::station::Station;
use crate::strategies::{Blueprint, Setup, StrategySpec};
use serde::{Deserialize, Serialize};
use std::cell::OnceCell;

/// Number of best assignments that serve as bases.
const BASES: usize = 4;
/// Number of grids, and of Poisson disk patterns, on which bases are found without other
/// training: their exact order does not matter.
const FEW_PATTERNS: usize = 10;
/// Lines of more robots than this are long: nearly all assignments are then tied on so few
/// patterns, and breaking ties by speed limits would take most of the time for an order that
/// no longer matters.
const LONG: usize = 6;
/// Number of items in each of them, and in each pattern of a named set.
const ITEMS: usize = 150;
/// Maximum number of training patterns for robust GT, of the kind that is scored.
const OF_THE_KIND: usize = 60;
/// Maximum number of items in all of them, unless [`FEWEST_OF_THE_KIND`] have more.
const ITEMS_OF_THE_KIND: f64 = 150_000.0;
/// Minimum number of these patterns, however long they are.
const FEWEST_OF_THE_KIND: usize = 4;
/// Maximum number of robot passes for finding one robust GT on them; a sweep does this for
/// every line.
const PASSES: u64 = 1_000_000;
/// Patterns of at least this mean number of items are scored by the picked share. In the steady
/// state a line picks that share of the flow, whereas the picking rate also depends on how long
/// the last items take.
const LONG_PATTERN: f64 = 300.0;

/// How robust GT (game theory) is found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum RobustTraining {
    /// By a search on patterns like those that are scored, but with other seeds.
    LikeScored {
        /// Number of items in each of them; `None` for as many as in those that are scored.
        items: Option<usize>,
    },
    /// By a search on the paper's balanced set, with every item known and nothing going wrong.
    Paper {
        /// Number of items in each pattern; `None` for 150.
        items: Option<usize>,
    },
    /// By a search on these patterns.
    On(PatternSet),
    /// Not at all: this is the assignment.
    Given(RuleAssignment),
}

impl Default for RobustTraining {
    fn default() -> Self {
        Self::LikeScored { items: None }
    }
}

/// The patterns of a source, `set`, for training, with `items` items in each or 150, drawn for a
/// station from a seed.
///
/// # Errors
/// A set that cannot be read or generated, or that does not fit on the belt.
pub fn training_patterns(
    set: &str,
    items: Option<usize>,
    (station, seed): (&Station, u64),
) -> Result<PatternSet> {
    let source = set.parse::<PatternSource>();
    let source = source.map_err(|error| error.at("'training'"))?;
    if let PatternSource::Feed {
        feed, flow: None, ..
    } = &source
        && feed.file().is_none()
    {
        return Err(Error::usage(
            format!("'training' {}", shown(set)),
            format!("the feed {feed} needs its own flow here"),
            "include it in the set, for example 'training' random:60/min:5",
        ));
    }
    let set = source.build(&recipe(station, items.unwrap_or(ITEMS), seed))?;
    set.check_on(station)
        .map_err(|error| error.inside("'training'"))?;
    Ok(set)
}

impl RobustTraining {
    /// What the texts of an assignment, `robust`, or of a source of patterns, `set`, ask for. Without
    /// both, the search is on the paper's set, if `paper`, or on patterns like those that are scored.
    /// `items`, station and seed are as for [`training_patterns`].
    ///
    /// # Errors
    /// Rules or a set that cannot be read, or that do not fit the station; a set or a number of items
    /// next to rules.
    pub fn named(
        robust: Option<&str>,
        set: Option<&str>,
        items: Option<usize>,
        paper: bool,
        (station, seed): (&Station, u64),
    ) -> Result<Self> {
        let Some(rules) = robust else {
            return Ok(match set {
                Some(set) => Self::On(training_patterns(set, items, (station, seed))?),
                None if paper => Self::Paper { items },
                None => Self::LikeScored { items },
            });
        };
        let useless = [
            ("'training'", set.is_some()),
            ("'train_items'", items.is_some()),
        ];
        if let Some((setting, _)) = useless.into_iter().find(|(_, is_given)| *is_given) {
            return Err(Error::usage(
                setting,
                "there is nothing to train, as 'robust' gives the assignment",
                "leave one of the two out",
            ));
        }
        Self::given(rules)
    }

    /// The assignment with this text.
    ///
    /// # Errors
    /// A text that is none.
    pub fn given(rules: &str) -> Result<Self> {
        let rules = rules.parse();
        rules
            .map(Self::Given)
            .map_err(|error: Error| error.at("'robust'"))
    }

    /// Checks that there are patterns to train on, and that an assignment that was given is for
    /// this number of robots.
    ///
    /// # Errors
    /// A set without patterns, or rules for another number of robots.
    pub(super) fn check(&self, robots: usize) -> Result<()> {
        match self {
            Self::Given(rules) => given(rules, robots).map(|_| ()),
            Self::On(set) if set.patterns.is_empty() => Err(Error::usage(
                "'training'",
                "the set has no pattern to find robust GT (game theory) on",
                "give a set of one or more patterns",
            )),
            _ => Ok(()),
        }
    }
}

/// `rules`, if there is one for each robot.
fn given(rules: &RuleAssignment, robots: usize) -> Result<RuleAssignment> {
    let rules = rules.clone().for_robots(robots);
    rules.map_err(|error| error.at("'robust'"))
}

/// How training patterns are generated for `station`.
fn recipe(station: &Station, items: usize, seed: u64) -> Recipe {
    Recipe {
        belt: *station.belt(),
        items,
        shape: Default::default(),
        attributes: Default::default(),
        seed,
    }
}

/// A line for which assignments are searched.
#[derive(Clone)]
pub(super) struct LineSearch<'a> {
    station: &'a Station,
    seed: u64,
    conditions: Conditions,
    environment: Environment<'a>,
}

impl<'a> LineSearch<'a> {
    /// A search for `station` with every item known and nothing going wrong, at decisions every
    /// 1 / `update_hz` [s].
    pub(super) fn new(
        station: &'a Station,
        seed: u64,
        update_hz: f64,
        environment: &Environment<'a>,
    ) -> Self {
        Self {
            station,
            seed,
            conditions: Conditions::at_update_hz(update_hz),
            // The whole search is one piece of shared work.
            environment: Environment {
                ledger: Ledger::PLAIN,
                ..*environment
            },
        }
    }

    /// The same with `conditions` while robust GT is found, but with random events that
    /// are independent of those used for scoring strategies.
    pub(super) fn under(self, conditions: &Conditions) -> Self {
        Self {
            conditions: independent_events(conditions),
            ..self
        }
    }

    fn recipe(&self, items: usize) -> Recipe {
        recipe(self.station, items, self.seed)
    }

    /// Searches for the optimum on `set`, breaking ties by speed limits as `scan` says.
    fn train(
        &self,
        set: &PatternSet,
        conditions: &Conditions,
        objective: Objective,
        scan: Option<SpeedScan>,
        runs: MostRuns,
    ) -> Result<Optimum> {
        let evaluator = Evaluator::new(self.station, &set.patterns, objective, conditions)?;
        let search = Search::default()
            .with_grasp(Grasp::default().with_seed(self.seed))
            .with_scan(scan)
            .with_limits(Limits::default().with_runs(runs));
        let optimum = find_optimum(&evaluator, &search, &self.environment)?;
        if self.environment.stopped() {
            return Err(Error::interrupted());
        }
        Ok(optimum)
    }

    /// Robust GT: as given, or the best on its training set; `like_scored` makes one of about
    /// the given number of items a pattern.
    ///
    /// # Errors
    /// Rules that do not fit the line, an unavailable set, [`Interrupted`](crate::error::ErrorKind::Interrupted).
    pub(super) fn robust(
        &self,
        training: &RobustTraining,
        like_scored: impl FnOnce(Option<usize>) -> Result<TrainingSet>,
    ) -> Result<RobustGt> {
        match training {
            RobustTraining::Given(rules) => Ok(RobustGt {
                rules: given(rules, self.station.robots().len())?,
                basis: RobustBasis::Given,
                best_few: OnceCell::new(),
            }),
            RobustTraining::On(set) => {
                self.best_on(set, &self.conditions, |on| RobustBasis::Best { on })
            }
            RobustTraining::Paper { items } => {
                let source = PatternSource::Balanced(PAPER_PATTERNS);
                let set = source.build(&self.recipe(items.unwrap_or(ITEMS)))?;
                let undisturbed = !self.conditions.describe().is_empty();
                self.best_on(&set, &self.plain(), |on| RobustBasis::PaperBest {
                    on,
                    undisturbed,
                })
            }
            RobustTraining::LikeScored { items } => self.best_mean(&like_scored(*items)?),
        }
    }

    /// The assignment that is best on a named set.
    fn best_on(
        &self,
        set: &PatternSet,
        conditions: &Conditions,
        basis: impl FnOnce(String) -> RobustBasis,
    ) -> Result<RobustGt> {
        let scan = Some(SpeedScan::default());
        let rate = Objective::PickingRate;
        let optimum = self.train(set, conditions, rate, scan, MostRuns::Usual)?;
        Ok(RobustGt {
            rules: optimum.ranking.best().assignment.clone(),
            basis: basis(on(set, &optimum, conditions)),
            best_few: OnceCell::from(best_few(&optimum)),
        })
    }

    /// The assignment with the highest mean, without a scan over speeds: a user who compares
    /// it with other rules on the same kind of patterns wants to see the best.
    fn best_mean(&self, training: &TrainingSet) -> Result<RobustGt> {
        let (objective, figure) = if mean_items(&training.set) >= LONG_PATTERN {
            (Objective::PickedShare, "picked share")
        } else {
            (Objective::PickingRate, "picking rate")
        };
        let runs = MostRuns::Passes(PASSES);
        let optimum = self.train(&training.set, &self.conditions, objective, None, runs)?;
        let on = (!training.seen).then(|| on(&training.set, &optimum, &self.conditions));
        Ok(RobustGt {
            rules: optimum.ranking.leader.clone(),
            basis: RobustBasis::HighestMean {
                figure: figure.to_owned(),
                on,
            },
            best_few: OnceCell::from(best_few(&optimum)),
        })
    }

    /// Conditions with every item known and nothing going wrong.
    fn plain(&self) -> Conditions {
        Conditions::at_update_hz(self.conditions.update_hz)
    }

    /// Training patterns like those of `source`, which are scored as `scored` says, but with
    /// another seed.
    ///
    /// # Errors
    /// As for [`PatternSource::training_set`].
    pub(super) fn like(
        &self,
        source: &PatternSource,
        items: Option<usize>,
        scored: &Recipe,
    ) -> Result<TrainingSet> {
        let recipe = Recipe {
            items: items.unwrap_or(scored.items),
            seed: self.seed,
            ..scored.clone()
        };
        let count = how_many(source.expected_items(&recipe)?);
        let set = source.training_set(&recipe, count)?;
        Ok(self.with_repeated_runs(set))
    }

    /// Patterns on which the threshold of detections is chosen: those that are named, otherwise
    /// patterns like those of `source`.
    ///
    /// # Errors
    /// As for [`LineSearch::like`].
    pub(super) fn for_thresholds(
        &self,
        named: Option<&PatternSet>,
        source: &PatternSource,
        scored: &Recipe,
    ) -> Result<PatternSet> {
        let set = match named {
            Some(set) => set.clone(),
            None => self.like(source, None, scored)?.set,
        };
        let chance = &self.conditions.disturbances;
        let draws = |pattern: &Pattern| chance.draws_detections(pattern.items());
        let few = set.patterns.len() < OF_THE_KIND;
        Ok(match few && set.patterns.iter().any(draws) {
            true => with_draws(&set, OF_THE_KIND),
            false => set,
        })
    }

    /// The conditions under which it searches.
    pub(super) fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// Training patterns like those of `cases`.
    ///
    /// # Errors
    /// As for [`training_set`].
    pub(super) fn like_cases(&self, cases: &[Case], items: Option<usize>) -> Result<TrainingSet> {
        let each = |case: &Case| case.expected_items(self.station.belt(), items);
        let expected: Vec<f64> = cases.iter().map(each).collect::<Result<_>>()?;
        let count = how_many(expected.iter().sum::<f64>() / expected.len().max(1) as f64);
        let set = training_set(cases, self.station.belt(), items, count, self.seed)?;
        Ok(self.with_repeated_runs(set))
    }

    /// If something can go wrong, runs a small set of patterns with several draws of random events.
    fn with_repeated_runs(&self, training: TrainingSet) -> TrainingSet {
        let few = training.set.patterns.len() < OF_THE_KIND;
        if !(few && self.conditions.is_random()) {
            return training;
        }
        TrainingSet {
            set: with_draws(&training.set, OF_THE_KIND),
            ..training
        }
    }

    /// `strategy` on this line.
    ///
    /// `known` holds assignments that a search has already found; `allowance` is the budget of
    /// one decision if the strategy itself does not set it.
    ///
    /// # Errors
    /// As for [`StrategySpec::on`], and [`Interrupted`](crate::error::ErrorKind::Interrupted).
    pub(super) fn put(
        &self,
        strategy: &StrategySpec,
        known: &OnceCell<Vec<RuleAssignment>>,
        allowance: Allowance,
    ) -> Result<Blueprint> {
        let robots = self.station.robots().len();
        let bases = || {
            if let Some(found) = known.get() {
                return Ok(found.clone());
            }
            // Without their classes, no robot may have a bin for the items.
            let kinds = Attributes::default().with_classes(ClassShares::even(self.station));
            let recipe = self.recipe(ITEMS).with_attributes(kinds);
            let few = PatternSource::Balanced(FEW_PATTERNS).build(&recipe)?;
            let scan = (robots <= LONG).then(SpeedScan::default);
            // Failures need not be modelled here: the plan reacts to them when it runs.
            let plain = self.plain();
            let rate = Objective::PickingRate;
            let found = best_few(&self.train(&few, &plain, rate, scan, MostRuns::Usual)?);
            Ok(known.get_or_init(|| found).clone())
        };
        let setup = Setup {
            robots,
            bases: &bases,
            allowance,
        };
        let blueprint = strategy.on(&setup)?;
        blueprint.make().check_station(self.station)?;
        Ok(blueprint)
    }
}

/// Number of grids, and of Poisson disk patterns, in the paper's balanced set.
const PAPER_PATTERNS: usize = 120;

/// The number of training patterns for robust GT, if each has `items` items.
fn how_many(items: f64) -> usize {
    let afforded = (ITEMS_OF_THE_KIND / items.max(1.0)) as usize;
    afforded.clamp(FEWEST_OF_THE_KIND, OF_THE_KIND)
}

fn mean_items(set: &PatternSet) -> f64 {
    let items: usize = set.patterns.iter().map(|pattern| pattern.len()).sum();
    items as f64 / set.patterns.len().max(1) as f64
}

/// The patterns and conditions with which `optimum` was found, as text.
fn on(set: &PatternSet, optimum: &Optimum, conditions: &Conditions) -> String {
    let mut text = set.description.clone();
    if optimum.patterns < set.patterns.len() {
        text += &format!(" ({} of them, within its budget of runs)", optimum.patterns);
    }
    let conditions = conditions.describe();
    if !conditions.is_empty() {
        text += &format!(
            " ({}, with independent random numbers)",
            conditions.join("; ")
        );
    }
    text
}

/// Robust GT and other results of its search.
#[derive(Serialize, Deserialize)]
pub(super) struct RobustGt {
    /// The rule of each robot, upstream first.
    pub rules: RuleAssignment,
    /// Where it comes from.
    pub basis: RobustBasis,
    /// The best few assignments, if known.
    #[serde(with = "best_if_known")]
    pub best_few: OnceCell<Vec<RuleAssignment>>,
}

/// The best few assignments in the record of a shard: nothing where they are not known.
mod best_if_known {
    use crate::dispatch::RuleAssignment;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::cell::OnceCell;

    pub(super) fn serialize<S: Serializer>(
        best: &OnceCell<Vec<RuleAssignment>>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        best.get().serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<OnceCell<Vec<RuleAssignment>>, D::Error> {
        let best = Option::<Vec<RuleAssignment>>::deserialize(deserializer)?;
        Ok(best.map_or_else(OnceCell::new, OnceCell::from))
    }
}

impl RobustGt {
    /// Where it comes from, as a note on a result.
    pub(super) fn note(&self) -> Note {
        Note::Robust(RobustNote {
            basis: self.basis.clone(),
            scope: None,
        })
    }
}

/// The best few assignments that differ in what they pick. For example, FIFO and PP are the
/// same rule if all items weigh the same, and a duplicate base only costs time.
fn best_few(optimum: &Optimum) -> Vec<RuleAssignment> {
    let mut found: Vec<&Ranked> = Vec::new();
    let same = |a: &Ranked, b: &Ranked| {
        (a.mean, a.worst, a.picked_share) == (b.mean, b.worst, b.picked_share)
    };
    for entry in &optimum.ranking.entries {
        if found.len() < BASES && !found.iter().any(|other| same(other, entry)) {
            found.push(entry);
        }
    }
    found.iter().map(|entry| entry.assignment.clone()).collect()
}
