//! Methods compared on cases: robust GT (game theory), greedy GT, the built-in policy and any
//! strategy.

use super::blueprint::policy_distance;
use super::inputs::{check_same_training, check_strategies, patterns_hash};
use super::notes::{Note, condition_notes, detection_notes};
use super::options::{MethodSettings, StudyOptions};
use super::robust::LineSearch;
use super::tuning::{RIVAL, tune, tuning_set};
use crate::error::{Error, Result, known_names, shown};
use crate::experiment::{
    Case, Comparison, Draws, Method, add_bounds, compare_in_shard, compare_methods,
};
use crate::files;
use crate::optimize::Environment;
use crate::planning::Allowance;
use crate::sim::Conditions;
use crate::station::{Station, station_hash};
use crate::strategies::{self, HAS_POLICY, POLICY, StrategySpec};
use std::sync::Arc;

/// The highest accepted number of patterns per case; more are treated as a typing mistake.
const MOST_REPLICATES: usize = 100_000;

/// The settings of a comparison. By default it has 100 patterns of each random case, robust GT
/// (game theory), greedy GT, the built-in policy and the bound.
pub type CompareOptions = StudyOptions<CompareSettings>;

/// What only the settings of a comparison have.
#[derive(Debug, Clone)]
pub struct CompareSettings {
    methods: MethodSettings,
    replicates: usize,
    policy: bool,
    reference: String,
}

impl Default for CompareSettings {
    fn default() -> Self {
        Self {
            methods: MethodSettings {
                greedy: true,
                ..MethodSettings::default()
            },
            replicates: 100,
            policy: true,
            reference: "robust_gt".into(),
        }
    }
}

impl AsMut<MethodSettings> for CompareSettings {
    fn as_mut(&mut self) -> &mut MethodSettings {
        &mut self.methods
    }
}

impl CompareOptions {
    /// With this number of patterns of each random case; if something can go wrong, of runs of
    /// each case.
    #[must_use]
    pub fn with_replicates(mut self, replicates: usize) -> Self {
        self.own.replicates = replicates;
        self
    }

    /// With the built-in policy or without it; it is always left out if another policy is
    /// compared or if the line is far from its training.
    #[must_use]
    pub fn with_policy(mut self, policy: bool) -> Self {
        self.own.policy = policy;
        self
    }

    /// With the others compared against this method, by its name in files: `robust_gt`,
    /// `greedy_gt`, a strategy as it is written, or `rival`.
    #[must_use]
    pub fn with_reference(mut self, method: &str) -> Self {
        method.clone_into(&mut self.own.reference);
        self
    }
}

/// A comparison whose settings are checked.
#[derive(Debug)]
pub struct CompareStudy<'a> {
    station: &'a Station,
    cases: &'a [Case],
    options: &'a CompareOptions,
    conditions: Conditions,
    strategies: Vec<Arc<StrategySpec>>,
    greedy: bool,
    /// The place of the method that the others are compared against.
    reference: usize,
    notes: Vec<Note>,
}

/// What a comparison found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Compared {
    /// The methods on the cases that were completed before a stop request.
    pub comparison: Comparison,
    /// Number of completed cases whose bounds were computed, or were not asked for.
    pub bounded: usize,
    /// Remarks on what was left out, and on how the figures are to be read.
    pub notes: Vec<Note>,
}

/// Compares robust GT (game theory) with greedy GT, the built-in policy and other strategies on
/// `cases`, with paired differences. On a stop request, the completed cases are returned.
///
/// # Errors
/// Settings that do not fit the line, a pattern that cannot be generated or read, or
/// [`Interrupted`](crate::error::ErrorKind::Interrupted) before the first case is complete.
pub fn compare(
    station: &Station,
    cases: &[Case],
    options: &CompareOptions,
    environment: &Environment,
) -> Result<Compared> {
    CompareStudy::new(station, cases, options)?.run(environment)
}

impl<'a> CompareStudy<'a> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Settings that do not fit the line, or a pattern that cannot be generated or read.
    pub fn new(
        station: &'a Station,
        cases: &'a [Case],
        options: &'a CompareOptions,
    ) -> Result<Self> {
        if !(1..=MOST_REPLICATES).contains(&options.own.replicates) {
            return Err(Error::usage(
                "'replicates'",
                format!("{} patterns per case", options.own.replicates),
                format!("give 1 to {MOST_REPLICATES}"),
            ));
        }
        if cases.is_empty() {
            return Err(Error::usage(
                "'cases'",
                "there is no case to compare on",
                "give one or more",
            ));
        }
        options.conditions.check_on(station)?;
        let robots = station.robots().len();
        let mut study = Self {
            station,
            cases,
            options,
            conditions: options.conditions.with_seed(options.seed),
            strategies: Vec::new(),
            greedy: false,
            reference: 0,
            notes: Vec::new(),
        };
        study.choose_strategies()?;
        for strategy in &study.strategies {
            // Report an error before the long search for robust GT.
            strategy.check_on(station)?;
        }
        options.own.methods.training.check(robots)?;
        study.choose_greedy()?;
        study.check_detections()?;
        study.reference = study.find_reference()?;
        Ok(study)
    }

    /// Number of methods, robust GT included.
    pub fn methods(&self) -> usize {
        let tuned = usize::from(self.options.own.methods.tune);
        1 + usize::from(self.greedy) + self.strategies.len() + tuned
    }

    /// The seed of the first pattern of each random case: the training uses the master seed.
    pub fn first_seed(&self) -> u64 {
        self.options.seed.wrapping_add(1)
    }

    /// The built-in policy, the strategy of the station file and the others, in this order.
    fn choose_strategies(&mut self) -> Result<()> {
        let own = &self.options.own;
        let (strategies, note) = own
            .methods
            .strategies(&self.options.strategies, self.station.robots().len())?;
        self.strategies = strategies;
        self.notes.extend(note);
        // The paper's third column, unless another policy replaces it or the line is far from
        // its training.
        let is_policy = |strategy: &Arc<StrategySpec>| strategies::is_policy(strategy.text());
        if !HAS_POLICY || !own.policy || self.strategies.iter().any(is_policy) {
            return Ok(());
        }
        let policy = strategies::parse(POLICY)?;
        let alone = policy.alone(self.station.robots().len())?;
        match policy_distance(&alone, self.station).filter(|distance| distance.is_far()) {
            Some(distance) => self.notes.push(Note::PolicyLeftOut {
                distance: distance.to_string(),
                policy: POLICY,
            }),
            None => self.strategies.insert(0, Arc::new(policy)),
        }
        Ok(())
    }

    /// Takes greedy GT if it can be found on the patterns of the cases in about a minute.
    fn choose_greedy(&mut self) -> Result<()> {
        let robots = self.station.robots().len();
        let (mut items, mut most) = (0.0, 0);
        for case in self.cases {
            // One of a random case, otherwise all.
            let drawn = case.patterns(self.station.belt(), 1, self.options.seed)?;
            let length: usize = drawn.iter().map(|(_, pattern)| pattern.len()).sum();
            let times = match case.is_random() {
                true => self.options.own.replicates,
                false => 1,
            };
            let patterns = times * drawn.len();
            items += times as f64 * length as f64;
            most = most.max(patterns);
        }
        if !self.options.own.methods.greedy {
            return Ok(());
        }
        match Method::greedy_limit(robots, most, items) {
            None => self.greedy = true,
            Some(replicates) => self.notes.push(Note::GreedyLeftOut { robots, replicates }),
        }
        Ok(())
    }

    /// Notes if detections cannot be wrong, or none is below the threshold.
    fn check_detections(&mut self) -> Result<()> {
        let conditions = &self.conditions;
        if conditions.disturbances.misdetections || conditions.min_detection > 0.0 {
            let belt = self.station.belt();
            let patterns = self.cases.iter();
            // The patterns of a case are alike, so one is enough.
            let patterns = patterns.map(|case| case.patterns(belt, 1, self.first_seed()));
            let patterns = patterns.collect::<Result<Vec<_>>>()?.concat();
            let items = patterns.iter().map(|(_, pattern)| pattern.items());
            self.notes.extend(detection_notes(conditions, items));
        }
        Ok(())
    }

    /// The place of the method that the others are compared against.
    fn find_reference(&self) -> Result<usize> {
        let mut ids = vec!["robust_gt"];
        ids.extend(self.greedy.then_some("greedy_gt"));
        ids.extend(self.strategies.iter().map(|strategy| strategy.text()));
        ids.extend(self.options.own.methods.tune.then_some(RIVAL));
        let reference = &self.options.own.reference;
        ids.iter().position(|id| id == reference).ok_or_else(|| {
            Error::usage(
                "'reference'",
                format!("`{}` is not one of the compared methods", shown(reference)),
                known_names(reference, &ids),
            )
        })
    }

    /// Checks that all shards are made on the same line, patterns and policies.
    fn check_inputs(&self, environment: &Environment) -> Result<()> {
        let ledger = environment.ledger;
        ledger.check_input("the station", || Ok(station_hash(self.station)))?;
        let strategies = self.strategies.iter();
        check_strategies(strategies.map(|strategy| strategy.text()), environment)?;
        check_same_training(&self.options.own.methods.training, environment)?;
        // What the cases are; the files that they name are read below.
        let cases = || Ok(files::fingerprint(format!("{:?}", self.cases)));
        ledger.check_input("the list of cases", cases)?;
        for case in self.cases {
            // The patterns of a random case follow from its first.
            let drawn = case.patterns(self.station.belt(), 1, self.first_seed())?;
            let patterns = drawn.iter().map(|(_, pattern)| pattern);
            let name = format!("case {}", case.name);
            ledger.check_input(&name, || Ok(patterns_hash(patterns)))?;
        }
        Ok(())
    }

    /// Runs the comparison.
    ///
    /// # Errors
    /// A pattern that does not fit on the belt, an illegal action, or [`Interrupted`](crate::error::ErrorKind::Interrupted)
    /// before the first case is complete.
    pub fn run(&self, environment: &Environment) -> Result<Compared> {
        self.check_inputs(environment)?;
        let (methods, mut notes) = self.find_methods(environment)?;
        let draws = Draws {
            replicates: self.options.own.replicates,
            first_seed: self.first_seed(),
            conditions: &self.conditions,
        };
        if environment.ledger.shard().is_some() {
            let how = (draws, self.options.bound);
            compare_in_shard(self.station, &methods, self.cases, how, environment)?;
            return Err(Error::sharded());
        }
        let mut comparison =
            compare_methods(self.station, methods, self.cases, draws, environment)?;
        let mut bounded = comparison.cases.len();
        if self.options.bound {
            add_bounds(&mut comparison, self.station, draws, environment)?;
            let with_bound = comparison.cases.iter().filter(|case| case.bound.is_some());
            bounded = with_bound.count();
        }
        let holds = |case: &Case| case.is_generated() && case.attributes.p_grasp.is_none();
        let without_own = self.cases.iter().all(holds);
        let with_bound = self.options.bound;
        notes.extend(condition_notes(&self.conditions, without_own, with_bound));
        Ok(Compared {
            comparison,
            bounded,
            notes,
        })
    }

    /// The methods, the one that the others are compared against first, and what there is to
    /// say about them.
    fn find_methods(&self, environment: &Environment) -> Result<(Vec<Method>, Vec<Note>)> {
        let (station, options) = (self.station, self.options);
        let update_hz = self.conditions.update_hz;
        let line = LineSearch::new(station, options.seed, update_hz, environment);
        let line = line.under(&self.conditions);
        let robust = environment.ledger.shared("robust GT", || {
            line.robust(&options.own.methods.training, |items| {
                line.like_cases(self.cases, items)
            })
        })?;
        let mut notes = vec![robust.note()];
        notes.extend(self.notes.iter().cloned());
        let mut methods = vec![Method::Robust(robust.rules)];
        if self.greedy {
            methods.push(Method::greedy(station.robots().len())?);
        }
        for strategy in &self.strategies {
            let blueprint = line.put(strategy, &robust.best_few, Allowance::default())?;
            let full = blueprint.make().name();
            if full != blueprint.name() {
                let name = blueprint.name().to_owned();
                notes.push(Note::FullName { name, full });
            }
            let distance = policy_distance(&blueprint, station);
            notes.extend(distance.map(|distance| Note::Distance(distance.to_string())));
            methods.push(Method::Strategy(blueprint));
        }
        if options.own.methods.tune {
            let training = &options.own.methods.training;
            let rival = environment.ledger.shared(RIVAL, || {
                let set = tuning_set(training, |items| line.like_cases(self.cases, items))?;
                tune(station, &set, line.conditions(), environment)
            })?;
            methods.push(Method::Strategy(rival.blueprint(station.robots().len())?));
            notes.push(Note::Rival(rival.remark));
        }
        methods[..=self.reference].rotate_right(1);
        Ok((methods, notes))
    }
}
