//! One quantity of the line varied: belt speed, robots, spacing, reach, or the threshold of
//! detections.

use super::blueprint::policy_distance;
use super::inputs::{check_same_training, check_strategies, patterns_hash};
use super::notes::{Note, RobustNote, RobustScope, condition_notes, detection_notes};
use super::part::PartProgress;
use super::patterns::with_detection_draws;
use super::robust::{LineSearch, RobustGt, RobustTraining};
use super::sweep_options::{DEFAULT_GRID, SweepOptions};
use super::tuning::{RIVAL, TunedRival, tune, tuning_set};
use super::values::{self, LineAt};
use crate::error::{Error, Result, shown};
use crate::experiment::{
    Axis, Method, Setting, Sweep, ThresholdChoices, choose_thresholds, sweep_in_shard,
    sweep_settings,
};
use crate::files;
use crate::optimize::Environment;
use crate::pattern::{PatternSet, PatternSource, Recipe};
use crate::planning::Allowance;
use crate::shards::{Ledger, Shard};
use crate::sim::Conditions;
use crate::station::{Station, station_hash};
use crate::strategies::StrategySpec;
use std::sync::Arc;

/// A sweep whose settings are checked and whose patterns are drawn.
pub struct SweepStudy<'a> {
    station: &'a Station,
    options: &'a SweepOptions,
    conditions: Conditions,
    lines: Vec<LineAt>,
    strategies: Vec<Arc<StrategySpec>>,
    source: PatternSource,
    recipe: Recipe,
    set: PatternSet,
    notes: Vec<Note>,
}

/// What a sweep found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Swept {
    /// The methods at the values that were completed before a stop request.
    pub sweep: Sweep,
    /// The threshold of detections for each method; `None` without a wanted purity, and if the user
    /// stopped the sweep before they were chosen.
    pub thresholds: Option<ThresholdChoices>,
    /// Remarks on what was left out, and on how the figures are to be read.
    pub notes: Vec<Note>,
}

/// Runs robust GT (game theory) and other strategies at every value of a quantity of the line,
/// on the same patterns. On a stop request, the completed values are returned.
///
/// # Errors
/// An invalid range, settings that do not fit a line, a pattern that cannot be generated or
/// read, or [`Interrupted`](crate::error::ErrorKind::Interrupted) before the first value is
/// complete.
pub fn sweep(
    station: &Station,
    options: &SweepOptions,
    environment: &Environment,
) -> Result<Swept> {
    SweepStudy::new(station, options)?.run(environment)
}

impl<'a> SweepStudy<'a> {
    /// Checks the settings and draws the patterns.
    ///
    /// # Errors
    /// An invalid range, settings that do not fit a line, or a pattern that cannot be generated
    /// or read.
    pub fn new(station: &'a Station, options: &'a SweepOptions) -> Result<Self> {
        let conditions = options.checked_conditions()?;
        let axis = options.own.values.axis;
        if axis != Axis::Robots {
            // There, other numbers of robots are run.
            conditions.check_on(station)?;
        }
        let mut lines = values::lines(&options.own.values, station)?;
        let mut chosen = None;
        for line in &lines {
            check_robots(options, line)?;
            let robots = line.station.robots().len();
            let (strategies, _) = match &chosen {
                Some(chosen) => chosen,
                // Names do not depend on the number of robots.
                None => chosen.insert(
                    options
                        .own
                        .methods
                        .strategies(&options.strategies, robots)?,
                ),
            };
            for strategy in strategies {
                strategy.check_on(&line.station)?;
            }
            options.own.methods.training.check(robots)?;
        }
        let (strategies, note) = chosen.unwrap_or_default();
        // A different seed from the training set's.
        let seed = options.seed.wrapping_add(1);
        let usual = DEFAULT_GRID.1;
        let (source, mut recipe) = options.own.patterns.recipe(station, seed, usual)?;
        let mut set = source.build(&recipe)?;
        set.check_on(station)?;
        let generated = !source.is_recorded();
        if axis == Axis::MinDetection {
            check_training(options, generated, &set)?;
            lines = values::thresholds(&options.own.values, station, &set.patterns)?;
        }
        let is_usual = options.own.patterns.items().is_none() && recipe.items == usual;
        if generated && is_usual && axis != Axis::Speed {
            // These are scored by what they pick in the steady state.
            recipe.items = values::items(&lines, &set.patterns, recipe.items)?;
            set = source.build(&recipe)?;
        }
        if axis == Axis::MinDetection {
            set = with_detection_draws(set, &source, &conditions);
        }
        Ok(Self {
            station,
            options,
            conditions,
            lines,
            strategies,
            source,
            recipe,
            set,
            notes: note.into_iter().collect(),
        })
    }

    /// The patterns that are run at every value.
    pub fn set(&self) -> &PatternSet {
        &self.set
    }

    /// The first and the last value, with the line at each; the values between them are no
    /// more unusual. `None` for a single value.
    pub fn ends(&self) -> Option<[(f64, &Station); 2]> {
        match &self.lines[..] {
            [first, .., last] => Some([first, last].map(|line| (line.value, &line.station))),
            _ => None,
        }
    }

    /// Whether it is the paper's own sweep, whose results can be shown next to these.
    pub fn is_papers_case(&self) -> bool {
        self.options.own.values.axis == Axis::Speed
            && self.source == PatternSource::Grid(DEFAULT_GRID.0)
            && self.recipe.items == DEFAULT_GRID.1
            && self.station.robots().len() == 2
    }

    /// Runs the sweep.
    ///
    /// # Errors
    /// A pattern that does not fit on the belt, an illegal action, or
    /// [`Interrupted`](crate::error::ErrorKind::Interrupted) before the first value is
    /// complete.
    pub fn run(&self, environment: &Environment) -> Result<Swept> {
        let conditions = self.conditions.with_seed(self.recipe.seed);
        let patterns = &self.set.patterns;
        self.check_inputs(environment)?;
        if let Some(shard) = environment.ledger.shard() {
            return self.run_shard(shard, &conditions, environment);
        }
        let (settings, trained) = match self.options.own.values.axis {
            Axis::Speed => self.speeds(&conditions, environment)?,
            _ => self.settings(&self.lines, environment)?,
        };
        let mut notes = trained;
        notes.extend(self.notes.iter().cloned());
        notes.extend(distances(&settings));
        let sweep = sweep_settings(
            &settings,
            patterns,
            &conditions,
            self.options.bound,
            environment,
        )?;
        let generated = !self.source.is_recorded();
        let without_own = generated && self.recipe.attributes.p_grasp.is_none();
        let bounded = self.options.bound;
        notes.extend(condition_notes(&self.conditions, without_own, bounded));
        let items = patterns.iter().map(|pattern| pattern.items());
        notes.extend(detection_notes(&self.conditions, items));
        let thresholds = self.thresholds(&settings, &sweep, environment)?;
        Ok(Swept {
            sweep,
            thresholds,
            notes,
        })
    }

    /// The line at every belt speed, with the methods of its own speed.
    fn speeds(
        &self,
        conditions: &Conditions,
        environment: &Environment,
    ) -> Result<(Vec<Setting>, Vec<Note>)> {
        let own = LineAt {
            value: self.station.belt().speed,
            station: self.station.clone(),
            min_detection: None,
        };
        let (own, trained) = self.settings(&[own], environment)?;
        let (options, patterns) = (&self.options.own.values, &self.set.patterns);
        let settings = values::speeds(options, &own[0], patterns, conditions, environment)?;
        Ok((settings, trained))
    }

    /// Checks that all shards are made on the same line, patterns and policies.
    fn check_inputs(&self, environment: &Environment) -> Result<()> {
        let ledger = environment.ledger;
        ledger.check_input("the station", || Ok(station_hash(self.station)))?;
        ledger.check_input("the list of values", || {
            let lines = self.lines.iter();
            let lines = lines.map(|line| format!("{} {}", line.value, station_hash(&line.station)));
            Ok(files::fingerprint(lines.collect::<Vec<_>>().join("\n")))
        })?;
        check_same_training(&self.options.own.methods.training, environment)?;
        let wanted = self
            .options
            .own
            .purity
            .and(self.options.threshold_patterns());
        if let Some(set) = wanted {
            let hash = || Ok(patterns_hash(&set.patterns));
            ledger.check_input("the patterns for thresholds", hash)?;
        }
        ledger.check_input("the patterns", || Ok(patterns_hash(&self.set.patterns)))?;
        let strategies = self.strategies.iter();
        check_strategies(strategies.map(|strategy| strategy.text()), environment)
    }

    /// Runs what `shard` owns: all methods at neighbouring values and patterns, so that it searches for
    /// robust GT on few lines only.
    fn run_shard(
        &self,
        shard: Shard,
        conditions: &Conditions,
        environment: &Environment,
    ) -> Result<Swept> {
        let patterns = &self.set.patterns;
        let each = patterns.len();
        let fast = match self.options.own.values.axis {
            Axis::Speed => Some(self.speeds(conditions, environment)?.0),
            _ => None,
        };
        let count = fast.as_ref().map_or(self.lines.len(), Vec::len);
        let own = shard.neighbours(count * each);
        for place in 0..count {
            let first = place * each;
            let (from, to) = (own.start.max(first), own.end.min(first + each));
            if from >= to {
                continue;
            }
            let searched;
            let setting = match &fast {
                Some(settings) => &settings[place],
                None => {
                    searched = self.settings(&self.lines[place..=place], environment)?.0;
                    &searched[0]
                }
            };
            let value = format!("sweeping {}", setting.value);
            environment
                .progress
                .begin(&value, (to - from) as u64, "patterns");
            let own = (&patterns[..], from - first..to - first);
            sweep_in_shard(setting, own, conditions, self.options.bound, environment)?;
            environment.progress.end();
        }
        Err(Error::sharded())
    }

    /// The thresholds of detections for the wanted purity, chosen on training patterns; `None` if
    /// they are not asked for or the user stops the work. `fresh` is the sweep of `settings` on the
    /// scored patterns.
    fn thresholds(
        &self,
        settings: &[Setting],
        fresh: &Sweep,
        environment: &Environment,
    ) -> Result<Option<ThresholdChoices>> {
        let Some(purity) = self.options.own.purity else {
            return Ok(None);
        };
        let within = PartProgress {
            whole: environment.progress,
            part: "choosing thresholds".into(),
        };
        let environment = Environment {
            progress: &within,
            // The units of the ledger are those of the scored patterns.
            ledger: Ledger::PLAIN,
            ..*environment
        };
        let line = self.search(self.station, &environment);
        let line = line.under(&self.conditions);
        let named = self.options.threshold_patterns();
        let set = line.for_thresholds(named, &self.source, &self.recipe)?;
        let conditions = line.conditions();
        let trained = sweep_settings(settings, &set.patterns, conditions, false, &environment);
        let is_whole = |sweep: &Sweep| sweep.values.len() == sweep.planned;
        match trained {
            Ok(trained) if is_whole(&trained) && is_whole(fresh) => {
                let on = set.description;
                Ok(Some(choose_thresholds(purity, on, &trained, fresh)))
            }
            Ok(_) => Ok(None),
            Err(error) if error.is_interrupted() => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Robust GT (game theory) of one line.
    fn robust(&self, line: &LineAt, environment: &Environment) -> Result<RobustGt> {
        let least = line.min_detection.unwrap_or(self.conditions.min_detection);
        let conditions = self.conditions.clone().with_min_detection(least);
        let line = self.search(&line.station, environment).under(&conditions);
        let training = match &self.options.own.methods.training {
            RobustTraining::LikeScored { items }
                if self.is_papers_case() && self.conditions.describe().is_empty() =>
            {
                &RobustTraining::Paper { items: *items }
            }
            training => training,
        };
        line.robust(training, |items| {
            line.like(&self.source, items, &self.recipe)
        })
    }

    fn search<'s>(&self, station: &'s Station, environment: &Environment<'s>) -> LineSearch<'s> {
        let update_hz = self.conditions.update_hz;
        LineSearch::new(station, self.options.seed, update_hz, environment)
    }

    /// The methods on every line, and notes on where robust GT and the rival come from; they are found
    /// for each line separately.
    fn settings(
        &self,
        lines: &[LineAt],
        environment: &Environment,
    ) -> Result<(Vec<Setting>, Vec<Note>)> {
        let axis = self.options.own.values.axis;
        let scope = match (&self.options.own.methods.training, axis) {
            (RobustTraining::Given(_), _) => None,
            (_, Axis::Speed) => Some(RobustScope::OwnSpeed),
            (_, Axis::MinDetection) => Some(RobustScope::EveryThreshold),
            _ => Some(RobustScope::EveryLine),
        };
        let mut settings = Vec::with_capacity(lines.len());
        let mut note = None;
        let mut rivals = Vec::new();
        for (place, line) in lines.iter().enumerate() {
            let (value, count) = (line.value, lines.len());
            let within = PartProgress {
                whole: environment.progress,
                part: format!("{} {value} ({}/{count})", axis.name(), place + 1),
            };
            let environment = Environment {
                progress: &within,
                ..*environment
            };
            let ledger = environment.ledger;
            let name = format!("robust GT at {value}");
            let robust = ledger.shared(&name, || self.robust(line, &environment))?;
            let mut methods = self.methods(&line.station, &robust, &environment)?;
            if self.options.own.methods.tune {
                let name = format!("{RIVAL} at {value}");
                let rival = ledger.shared(&name, || self.rival(line, &environment))?;
                let robots = line.station.robots().len();
                methods.push(Method::Strategy(rival.blueprint(robots)?));
                rivals.push((value, rival));
            }
            note = Some(Note::Robust(RobustNote {
                basis: robust.basis,
                scope,
            }));
            settings.push(Setting {
                value,
                station: line.station.clone(),
                min_detection: line.min_detection,
                methods,
            });
        }
        let notes = note.into_iter().chain(rival_note(axis, &rivals));
        Ok((settings, notes.collect()))
    }

    /// The best of what line software ships on one line.
    fn rival(&self, line: &LineAt, environment: &Environment) -> Result<TunedRival> {
        let least = line.min_detection.unwrap_or(self.conditions.min_detection);
        let conditions = self.conditions.clone().with_min_detection(least);
        let search = self.search(&line.station, environment).under(&conditions);
        let training = &self.options.own.methods.training;
        let set = tuning_set(training, |items| {
            search.like(&self.source, items, &self.recipe)
        })?;
        tune(&line.station, &set, search.conditions(), environment)
    }

    /// The methods on one line.
    fn methods(
        &self,
        station: &Station,
        robust: &RobustGt,
        environment: &Environment,
    ) -> Result<Vec<Method>> {
        let search = self.search(station, environment);
        let mut methods = vec![Method::Robust(robust.rules.clone())];
        if self.options.own.methods.greedy {
            methods.push(Method::greedy(station.robots().len())?);
        }
        for strategy in &self.strategies {
            let blueprint = search.put(strategy, &robust.best_few, Allowance::default())?;
            methods.push(Method::Strategy(blueprint));
        }
        Ok(methods)
    }
}

/// What the rival is at each value; of a single line, also how it compares with the others.
fn rival_note(axis: Axis, rivals: &[(f64, TunedRival)]) -> Option<Note> {
    let text = match rivals {
        [] => return None,
        [(_, rival)] => rival.remark.clone(),
        rivals => {
            let each = rivals.iter();
            let each: Vec<String> = each
                .map(|(at, rival)| format!("{at} {}", rival.text))
                .collect();
            format!(
                "{RIVAL} is the best of what line software ships, tuned for every value of {}: {}",
                axis.name(),
                each.join(", ")
            )
        }
    };
    Some(Note::Rival(text))
}

/// Checks that the line at a value has the robots that are down.
fn check_robots(options: &SweepOptions, line: &LineAt) -> Result<()> {
    let axis = options.own.values.axis.name();
    let place = format!("'sweep_axis' {axis} at {}", line.value);
    let there = options.conditions.check_on(&line.station);
    there.map_err(|error| error.inside(&place))
}

/// Checks that there are patterns to choose a threshold on, other than those that are scored.
///
/// # Errors
/// The scored patterns are recorded and no others are named, or those that are named are among them
/// or have no `p_detection`.
fn check_training(options: &SweepOptions, generated: bool, scored: &PatternSet) -> Result<()> {
    if options.own.purity.is_none() {
        return Ok(());
    }
    if let Some(set) = options.threshold_patterns() {
        let mut labelled = set.labels.iter().zip(&set.patterns);
        return match labelled.find(|(_, pattern)| scored.patterns.contains(pattern)) {
            None => check_detections(set, generated),
            Some((label, _)) => Err(Error::usage(
                format!("'training': {}", shown(label)),
                "is one of the patterns that are swept, which would not be fresh",
                "name other patterns",
            )),
        };
    }
    if generated {
        return Ok(());
    }
    Err(Error::usage(
        "'purity'",
        "there are no patterns to choose the threshold on: recorded patterns have no fresh ones like \
         them",
        "name other recorded patterns with 'training' SET",
    ))
}

/// Checks that a threshold can be chosen on `set`.
///
/// # Errors
/// None of its items has a `p_detection`.
fn check_detections(set: &PatternSet, scored_are_generated: bool) -> Result<()> {
    let mut items = set.patterns.iter().flat_map(|pattern| pattern.items());
    if items.any(|item| item.p_detection.is_some()) {
        return Ok(());
    }
    Err(Error::usage(
        "'training'",
        "no item of these patterns has a p_detection, so no threshold can be chosen on them",
        match scored_are_generated {
            true => {
                "name patterns with this column, or leave it out for patterns like those scored"
            }
            false => "name recorded patterns with this column",
        },
    ))
}

/// For every policy, at how many values the line differs from its training, and how it differs
/// at the first of them.
fn distances(settings: &[Setting]) -> Vec<Note> {
    let methods = settings.first().map_or(0, |setting| setting.methods.len());
    let of_method = |method: usize| {
        let found: Vec<(f64, String)> = settings
            .iter()
            .filter_map(|setting| match &setting.methods[method] {
                Method::Strategy(blueprint) => {
                    let found = policy_distance(blueprint, &setting.station)?;
                    Some((setting.value, found.to_string()))
                }
                _ => None,
            })
            .collect();
        let (first, distance) = found.first()?.clone();
        Some(Note::DistanceAtValues {
            count: found.len(),
            all: settings.len(),
            first,
            distance,
        })
    };
    (0..methods).filter_map(of_method).collect()
}
