//! The assignment that picks best over all patterns that a source draws, with the probability that it
//! is: assignments race on common patterns and are dropped as soon as they are not the best.

use super::notes::{Note, set_notes};
use super::patterns::ScoredPatterns;
use crate::dispatch::{RULES, RuleAssignment};
use crate::error::{Error, Result, counted};
use crate::optimize::{
    Deadline, Dropped, Environment, Evaluator, FIRST_OBSERVATIONS, Objective, Selection,
    SelectionOptions,
};
use crate::pattern::{PatternSet, PatternSource, Recipe, random_stream};
use crate::setters::setters;
use crate::sim::{AssignmentTree, Conditions};
use crate::station::Station;
use crate::stats;
use rand::RngExt;
use std::time::Instant;

/// Patterns in a batch, whose mean is one observation: enough that it is about normal, and even, as
/// grids and Poisson disks take turns in the balanced set.
const BATCH: usize = 10;
/// The longest line: all of its 6^N assignments begin.
const MOST_ROBOTS: usize = 6;
/// The stream of the master seed that draws the seeds of the batches.
const BATCH_STREAM: u64 = u64::MAX - 1;

/// The settings of a race. By default the picking rate on patterns like those of the balanced set, with
/// 95 % and up to 100,000 patterns.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct RaceOptions {
    seed: u64,
    patterns: ScoredPatterns,
    conditions: Conditions,
    objective: Objective,
    selection: SelectionOptions,
    max_patterns: usize,
    until: Option<Instant>,
}

impl RaceOptions {
    /// Differences from `delta` on, in units of the objective, matter.
    pub fn new(delta: f64) -> Self {
        Self {
            seed: 1,
            patterns: PatternSource::Balanced(super::optimize::DEFAULT_BALANCED).into(),
            conditions: Conditions::default(),
            objective: Objective::PickingRate,
            selection: SelectionOptions::new(delta),
            max_patterns: 100_000,
            until: None,
        }
    }

    /// With this probability of selecting the best.
    #[must_use]
    pub fn with_confidence(mut self, confidence: f64) -> Self {
        self.selection = self.selection.with_confidence(confidence);
        self
    }
}

setters!(RaceOptions {
    /// With this master seed, from which the patterns and everything else random is drawn.
    fn with_seed(seed: u64);
    /// With patterns drawn as these are.
    fn with_patterns(patterns: ScoredPatterns);
    /// Under these conditions, with random events from the master seed.
    fn with_conditions(conditions: Conditions);
    /// With this figure maximised.
    fn with_objective(objective: Objective);
    /// With at most this number of patterns.
    fn with_max_patterns(max_patterns: usize);
    /// With this time at which it must end.
    fn with_until(until: impl Into<Option<Instant>>);
});

/// Why a race ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum RaceStop {
    /// A single assignment was left.
    Separated,
    /// Those that were left scored the same on every pattern so far.
    Equal,
    /// The patterns were used up.
    MaxPatterns,
    /// The time was up.
    TimeLimit,
    /// The user stopped it.
    Interrupted,
}

impl RaceStop {
    /// The name in files: the variant's in snake case.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether the best was selected, so that the guarantee holds.
    pub fn is_selected(self) -> bool {
        matches!(self, Self::Separated | Self::Equal)
    }
}

/// An assignment that is left, or was dropped.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Racer {
    /// The rule of each robot, upstream first.
    pub assignment: RuleAssignment,
    /// Patterns on which it was scored.
    pub patterns: usize,
    /// Mean of the objective over them.
    pub mean: f64,
    /// How far the mean is below the highest one on the same patterns.
    pub behind: f64,
}

/// How a race ended.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Raced {
    /// Why it ended.
    pub stop: RaceStop,
    /// Those that are left, the best first.
    pub survivors: Vec<Racer>,
    /// Those that were dropped, the last one first.
    pub dropped: Vec<Racer>,
    /// Patterns that were drawn.
    pub patterns: usize,
    /// Patterns after which it would have ended.
    pub max_patterns: usize,
    /// Passes of one robot that were simulated.
    pub passes: u64,
    /// Passes of one robot in an enumeration of all assignments on as many patterns.
    pub enumeration_passes: u64,
    /// What was to be guaranteed.
    pub selection: SelectionOptions,
    /// Number of patterns in an observation.
    pub batch: usize,
    /// The patterns, in words.
    pub description: String,
    /// Remarks on how the figures are to be read.
    pub notes: Vec<Note>,
}

impl Raced {
    /// The selected assignment, or the best so far.
    pub fn best(&self) -> &Racer {
        &self.survivors[0]
    }

    /// The least probability that the selected assignment is the best, if that is better than all others
    /// by the indifference zone; `None` if the race ended before that was known.
    pub fn probability(&self) -> Option<f64> {
        self.stop.is_selected().then_some(self.selection.confidence)
    }
}

/// A race whose settings are checked.
#[derive(Debug)]
pub struct RaceStudy<'a> {
    station: &'a Station,
    options: &'a RaceOptions,
    source: PatternSource,
    recipe: Recipe,
    description: String,
}

/// What a race has cost so far.
#[derive(Default)]
struct Cost {
    passes: u64,
    /// Passes of an enumeration on the same patterns.
    enumeration: u64,
    /// Patterns on which the robots are independent.
    independent: usize,
}

/// Races all assignments of a short line.
///
/// # Errors
/// As for [`RaceStudy::new`] and [`RaceStudy::run`].
pub fn race(station: &Station, options: &RaceOptions, environment: &Environment) -> Result<Raced> {
    RaceStudy::new(station, options)?.run(environment)
}

impl<'a> RaceStudy<'a> {
    /// Checks the settings.
    ///
    /// # Errors
    /// A line that is too long to enumerate, patterns that are not drawn at random, too few of them for
    /// the first observations, or settings that are not valid.
    pub fn new(station: &'a Station, options: &'a RaceOptions) -> Result<Self> {
        let robots = station.robots().len();
        if robots > MOST_ROBOTS {
            return Err(Error::usage(
                "'delta'",
                format!(
                    "the {}^{robots} assignments of {robots} robots are too many to race",
                    RULES.len()
                ),
                format!("leave it out to search with GRASP; up to {MOST_ROBOTS} robots can race"),
            ));
        }
        options.selection.checked()?;
        let least = FIRST_OBSERVATIONS * BATCH;
        if options.max_patterns < least {
            return Err(Error::usage(
                "'max_patterns'",
                format!("{} is too small a number of patterns", options.max_patterns),
                format!("give {least} or more, on which every assignment is scored at first"),
            ));
        }
        let conditions = options.conditions.with_seed(options.seed);
        conditions.check()?;
        let (source, recipe) = options.patterns.drawn_as(station, options.seed)?;
        let study = Self {
            station,
            options,
            source,
            recipe,
            description: String::new(),
        };
        // A first batch shows what is wrong with the patterns and how they fit on the line.
        let set = study.batch(0)?;
        let evaluator = study.evaluator(&set, 0)?;
        let description = format!(
            "batches of {}, each with a seed drawn from {}",
            set.description, options.seed
        );
        drop(evaluator);
        Ok(Self {
            description,
            ..study
        })
    }

    /// The patterns, in words.
    pub fn description(&self) -> &str {
        &self.description
    }

    /// The patterns of batch `number`, the same in every race with this seed.
    fn batch(&self, number: usize) -> Result<PatternSet> {
        let mut seeds = random_stream(self.options.seed, BATCH_STREAM);
        let seed = seeds.random::<u64>().wrapping_add(number as u64);
        let recipe = Recipe {
            seed,
            ..self.recipe.clone()
        };
        let set = self.source.draw_fresh(&recipe, BATCH)?.ok_or_else(|| {
            Error::usage(
                "'patterns'",
                format!(
                    "{} are not drawn at random, so more cannot be drawn",
                    self.source
                ),
                "race on patterns such as balanced, poisson:0.2, or random with 'flow'",
            )
        })?;
        set.check_on(self.station)?;
        Ok(set)
    }

    /// The evaluator of a batch, with random events of its own.
    fn evaluator<'s>(&'s self, set: &'s PatternSet, number: usize) -> Result<Evaluator<'s>> {
        let seed = self.options.seed.wrapping_add((number * BATCH) as u64);
        let conditions = self.options.conditions.with_seed(seed);
        Evaluator::new(
            self.station,
            &set.patterns,
            self.options.objective,
            &conditions,
        )
    }

    /// Runs the race.
    ///
    /// # Errors
    /// [`Interrupted`](crate::error::ErrorKind::Interrupted), or a time limit, before every assignment
    /// was scored once.
    pub fn run(&self, environment: &Environment) -> Result<Raced> {
        let robots = self.station.robots().len();
        let assignments: Vec<RuleAssignment> = RuleAssignment::all(robots).collect();
        let mut selection = Selection::new(assignments.len(), self.options.selection)?;
        let deadline = Deadline {
            other: environment.stop,
            at: self.options.until,
        };
        let within = Environment {
            stop: &deadline,
            ..*environment
        };
        let most = self.options.max_patterns / BATCH;
        let progress = environment.progress;
        progress.begin("racing", (most * BATCH) as u64, "patterns");
        let mut cost = Cost::default();
        let tree = AssignmentTree::all(robots);
        // Where they are not independent, assignments share no passes.
        let apart = (tree.assignments().len() * robots) as u64;
        while !selection.is_over() && selection.observations() < most {
            let number = selection.observations();
            let set = self.batch(number)?;
            let evaluator = self.evaluator(&set, number)?;
            let racing = selection
                .survivors()
                .iter()
                .map(|&s| assignments[s].clone());
            let evaluation = evaluator.evaluate(racing.collect(), &within)?;
            if !evaluation.is_whole(&evaluator) {
                break;
            }
            let independent = evaluator.independent_patterns();
            cost.passes += evaluator.passes();
            cost.enumeration += (independent * tree.passes()) as u64;
            cost.enumeration += (BATCH - independent) as u64 * apart;
            cost.independent += independent;
            let values = evaluation
                .scores
                .iter()
                .map(|score| stats::mean(&score.values));
            let left = selection.survivors().len();
            selection.observe(&values.collect::<Vec<_>>());
            if selection.survivors().len() < left || selection.is_over() {
                let leader = &assignments[selection.leader()];
                let count = counted(selection.survivors().len(), "assignment");
                progress.incumbent(&format!("{leader}, {count} left"));
            }
        }
        progress.end();
        if selection.observations() == 0 && !selection.is_over() {
            return Err(match environment.stopped() {
                true => Error::interrupted(),
                false => Error::usage(
                    "'until'",
                    "the time limit passed before every assignment was scored",
                    "give a longer time limit",
                ),
            });
        }
        let stop = match selection.is_over() {
            true if selection.survivors().len() == 1 => RaceStop::Separated,
            true => RaceStop::Equal,
            false if environment.stopped() => RaceStop::Interrupted,
            false if deadline.passed() => RaceStop::TimeLimit,
            false => RaceStop::MaxPatterns,
        };
        self.outcome(stop, &selection, &assignments, &cost)
    }

    /// What comes of a race that ended like this.
    fn outcome(
        &self,
        stop: RaceStop,
        selection: &Selection,
        assignments: &[RuleAssignment],
        cost: &Cost,
    ) -> Result<Raced> {
        let means: Vec<f64> = selection.means().collect();
        let highest = means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let patterns = selection.observations() * BATCH;
        let left = selection.survivors().iter().zip(&means);
        let mut survivors: Vec<Racer> = left
            .map(|(&system, &mean)| Racer {
                assignment: assignments[system].clone(),
                patterns,
                mean,
                behind: highest - mean,
            })
            .collect();
        // Stable, so that equal ones stay in registry order.
        survivors.sort_by(|a, b| b.mean.total_cmp(&a.mean));
        let racer = |dropped: &Dropped| Racer {
            assignment: assignments[dropped.system].clone(),
            patterns: dropped.after * BATCH,
            mean: dropped.mean,
            behind: dropped.behind,
        };
        let mut dropped: Vec<Racer> = selection.dropped().iter().map(racer).collect();
        dropped.sort_by(|a, b| {
            let order = b.patterns.cmp(&a.patterns);
            order.then_with(|| a.behind.total_cmp(&b.behind))
        });
        let conditions = self.options.conditions.with_seed(self.options.seed);
        let (set, independent) = (self.batch(0)?, cost.independent);
        Ok(Raced {
            stop,
            survivors,
            dropped,
            patterns,
            max_patterns: self.options.max_patterns,
            passes: cost.passes,
            enumeration_passes: cost.enumeration,
            selection: selection.options(),
            batch: BATCH,
            description: self.description.clone(),
            notes: set_notes(self.station, &set, &conditions, independent, patterns),
        })
    }
}
