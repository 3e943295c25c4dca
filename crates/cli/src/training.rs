//! What the optimiser finds for a line before the verb's own work: robust GT (game theory) and
//! the bases of strategies that look ahead.

use super::args::{Common, TrainingArgs};
use super::pattern_set;
use super::settings::other_luck;
use pickline::dispatch::RuleAssignment;
use pickline::error::{Error, Result, shown, shown_number};
use pickline::experiment::{Case, training_set};
use pickline::optimize::{
    Environment, Evaluator, Grasp, Limits, MostRuns, Objective, Optimum, Ranked, Risk, Search,
    SearchKind, SpeedScan, optimize,
};
use pickline::pattern::{PatternSet, PatternSource, Recipe, TrainingSet};
use pickline::planning::{Allowance, Budget};
use pickline::policy::Outside;
use pickline::sim::Conditions;
use pickline::station::Station;
use pickline::strategies::{Blueprint, Parsed, Setup};
use std::cell::OnceCell;

/// The flag that names the training set.
const FLAG: &str = "--train-patterns";
/// Number of best assignments that serve as bases.
const BASES: usize = 4;
/// Number of grids, and of Poisson disk patterns, on which bases are found without other
/// training: their exact order does not matter.
const FEW_PATTERNS: usize = 10;
/// Lines of more robots than this are long: nearly all assignments are then tied on so few
/// patterns, and breaking ties by speed limits would take most of the time for an order that
/// no longer matters.
const LONG: usize = 6;
/// Number of items in each of them, and in each pattern of the balanced set.
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

/// The default training patterns of robust GT.
pub enum Judged {
    /// The paper's balanced set, as in its comparison.
    AsInThePaper,
    /// Patterns like those that are scored.
    Kind(TrainingSet),
}

/// A line for which assignments are searched.
#[derive(Clone, Copy)]
pub struct Line<'a> {
    station: &'a Station,
    seed: u64,
    conditions: Conditions,
    environment: Environment<'a>,
}

impl<'a> Line<'a> {
    /// A line with the settings that all verbs share.
    pub fn new(common: &Common, station: &'a Station, environment: &Environment<'a>) -> Self {
        Self {
            station,
            seed: common.seed,
            conditions: Conditions::at_update_hz(common.update_hz),
            environment: *environment,
        }
    }

    /// The same line with `conditions` while robust GT is found, but with different luck from
    /// that used for scoring strategies.
    pub fn under(self, conditions: &Conditions) -> Self {
        Self {
            conditions: other_luck(conditions),
            ..self
        }
    }

    fn recipe(&self, items: usize) -> Recipe {
        Recipe {
            belt: *self.station.belt(),
            items,
            shape: Default::default(),
            attributes: Default::default(),
            seed: self.seed,
        }
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
        let search = Search {
            kind: SearchKind::Auto,
            grasp: Grasp {
                seed: self.seed,
                ..Grasp::default()
            },
            risk: Risk::Mean,
            scan,
            limits: Limits { runs, until: None },
        };
        let optimum = optimize(&evaluator, &search, &self.environment)?;
        if self.environment.stopped() {
            return Err(Error::interrupted());
        }
        Ok(optimum)
    }

    /// Robust GT: as given, or the best on the requested training set, otherwise on
    /// `judged`.
    ///
    /// # Errors
    /// Rules that do not fit the line, an unavailable set, [`Interrupted`](pickline::error::ErrorKind).
    pub fn robust(
        &self,
        training: &TrainingArgs,
        judged: impl FnOnce() -> Result<Judged>,
    ) -> Result<Robust> {
        if let Some(text) = &training.robust {
            let robots = self.station.robots().len();
            let rules = text
                .parse::<RuleAssignment>()
                .map_err(|e| e.at("--robust"))?;
            let rules = rules.for_robots(robots).map_err(|e| e.at("--robust"))?;
            return Ok(Robust {
                rules,
                note: "robust GT as given (--robust)".into(),
                best_few: OnceCell::new(),
            });
        }
        let judged = match &training.train_patterns {
            None => Some(judged()?),
            Some(_) => None,
        };
        let kind = match judged {
            Some(Judged::Kind(kind)) => kind,
            paper => {
                let set = self.named_set(training)?;
                let scan = Some(SpeedScan::default());
                let rate = Objective::PickingRate;
                let (conditions, why) = match paper {
                    Some(_) => (self.plain(), self.paper_note()),
                    None => (self.conditions, String::new()),
                };
                let optimum = self.train(&set, &conditions, rate, scan, MostRuns::Usual)?;
                let on = on(&set, &optimum, &conditions);
                return Ok(Robust {
                    rules: optimum.ranking.best().assignment.clone(),
                    note: format!("robust GT is the best on {on}{why}"),
                    best_few: OnceCell::from(best_few(&optimum)),
                });
            }
        };
        let (objective, by) = if mean_items(&kind.set) >= LONG_PATTERN {
            (Objective::PickedShare, "picked share")
        } else {
            (Objective::PickingRate, "picking rate")
        };
        let runs = MostRuns::Passes(PASSES);
        // The assignment with the highest mean, without a scan over speeds: a user who compares
        // it with other rules on the same kind of patterns wants to see the best.
        let optimum = self.train(&kind.set, &self.conditions, objective, None, runs)?;
        let told = if kind.seen {
            "the very patterns used here, which favours it; --train-patterns names \
             others"
                .to_owned()
        } else {
            on(&kind.set, &optimum, &self.conditions)
        };
        Ok(Robust {
            rules: optimum.ranking.leader.clone(),
            note: format!("robust GT has the highest mean {by} on {told}"),
            best_few: OnceCell::from(best_few(&optimum)),
        })
    }

    /// Conditions with every item known and nothing going wrong.
    fn plain(&self) -> Conditions {
        Conditions::at_update_hz(self.conditions.update_hz)
    }

    /// The note for a training as in the paper.
    fn paper_note(&self) -> String {
        let plain = if self.conditions.describe().is_empty() {
            ""
        } else {
            ", with every item known and nothing going wrong"
        };
        format!(", as in the paper{plain}; {FLAG} names another set")
    }

    /// The set of `--train-patterns`, or the balanced one.
    fn named_set(&self, training: &TrainingArgs) -> Result<PatternSet> {
        let text = training.train_patterns.as_deref().unwrap_or("balanced");
        let source = text.parse::<PatternSource>().map_err(|e| e.at(FLAG))?;
        let items = training.train_items.unwrap_or(ITEMS);
        if let PatternSource::Feed {
            feed, flow: None, ..
        } = &source
            && feed.file().is_none()
        {
            return Err(Error::input(
                format!("{FLAG} {}", shown(text)),
                format!("the feed {feed} needs its own flow here"),
                format!("include it in the set, for example {FLAG} random:60/min:5"),
            ));
        }
        let set = source.build(&self.recipe(items))?;
        for (label, pattern) in set.labels.iter().zip(&set.patterns) {
            let on_belt = pattern.check_on(self.station);
            on_belt.map_err(|error| error.inside(&format!("{FLAG}: {label}")))?;
        }
        Ok(set)
    }

    /// Training patterns like those of `source` under `judged`, but with another seed.
    ///
    /// # Errors
    /// As for [`PatternSource::training_set`].
    pub fn like(
        &self,
        source: &PatternSource,
        training: &TrainingArgs,
        judged: &Recipe,
    ) -> Result<Judged> {
        let recipe = Recipe {
            items: training.train_items.unwrap_or(judged.items),
            seed: self.seed,
            ..*judged
        };
        let count = how_many(source.expected_items(&recipe)?);
        let set = source.training_set(&recipe, count)?;
        Ok(Judged::Kind(self.with_draws(set)))
    }

    /// Training patterns like those of `cases`.
    ///
    /// # Errors
    /// As for [`training_set`].
    pub fn like_cases(&self, cases: &[Case], training: &TrainingArgs) -> Result<Judged> {
        let items = training.train_items;
        let each = |case: &Case| case.expected_items(self.station.belt(), items);
        let expected: Vec<f64> = cases.iter().map(each).collect::<Result<_>>()?;
        let count = how_many(expected.iter().sum::<f64>() / expected.len().max(1) as f64);
        let set = training_set(cases, self.station.belt(), items, count, self.seed)?;
        Ok(Judged::Kind(self.with_draws(set)))
    }

    /// If something can go wrong, runs a small set of patterns with several draws of luck.
    fn with_draws(&self, training: TrainingSet) -> TrainingSet {
        let few = training.set.patterns.len() < OF_THE_KIND;
        if !(few && self.conditions.disturbances.any()) {
            return training;
        }
        TrainingSet {
            set: pattern_set::with_draws(training.set, OF_THE_KIND),
            ..training
        }
    }

    /// `strategy` on this line.
    ///
    /// `known` holds assignments that a search has already found; `allowance` is the budget of
    /// one decision if the strategy itself does not set it.
    ///
    /// # Errors
    /// As for [`Parsed::on`], and [`Interrupted`](pickline::error::ErrorKind).
    pub fn put(
        &self,
        strategy: &Parsed,
        known: &OnceCell<Vec<RuleAssignment>>,
        allowance: Allowance,
    ) -> Result<Blueprint> {
        let robots = self.station.robots().len();
        let bases = || {
            if let Some(found) = known.get() {
                return Ok(found.clone());
            }
            let few = PatternSource::Balanced(FEW_PATTERNS).build(&self.recipe(ITEMS))?;
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
        strategy.on(&setup)
    }
}

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
        text += &format!(" ({}, with different luck)", conditions.join("; "));
    }
    text
}

/// Robust GT and other results of its search.
pub struct Robust {
    pub rules: RuleAssignment,
    /// Where it comes from, as a note for a report.
    pub note: String,
    /// The best few assignments, if known.
    pub best_few: OnceCell<Vec<RuleAssignment>>,
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

/// The budget per decision from `--budget-ms`.
///
/// # Errors
/// An invalid time.
pub fn budget(ms: Option<f64>) -> Result<Option<Budget>> {
    let read = |ms: f64| {
        Budget::milliseconds(ms).ok_or_else(|| {
            let (least, most) = Budget::MILLISECONDS.into_inner();
            Error::input(
                "--budget-ms",
                format!("{} is not a valid time for a decision", shown_number(ms)),
                format!("give milliseconds, from {least} to {most}"),
            )
        })
    };
    ms.map(read).transpose()
}

/// The full form of a strategy, if its name is short for it.
pub fn full_name(blueprint: &Blueprint) -> Option<String> {
    let full = blueprint.make().name();
    (full != blueprint.name()).then(|| format!("{} is {full}", blueprint.name()))
}

/// How a line differs from what a policy was trained on.
pub struct Distance {
    /// The differences as text.
    pub text: String,
    /// Whether the difference is too large for the policy's scores to mean much.
    pub far: bool,
}

/// How `station` differs from what `blueprint` was trained on; `None` if it does not differ, or
/// if nothing was trained.
pub fn distance(blueprint: &Blueprint, station: &Station) -> Option<Distance> {
    let outside = blueprint.trained()?.outside(station);
    let far = outside.iter().any(Outside::is_far);
    let facts: Vec<String> = outside.iter().map(Outside::to_string).collect();
    let how = if far {
        "is far from its training"
    } else {
        "is a little outside its training"
    };
    (!facts.is_empty()).then(|| Distance {
        text: format!(
            "{}: this line {how}: {}",
            blueprint.name(),
            facts.join(", ")
        ),
        far,
    })
}
