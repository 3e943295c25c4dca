//! Every entrant on every instance.

use super::entrant::{Entrant, Foresight, for_robots};
use super::instance::{Instance, load_instances};
use super::judge::{Attempts, Solution, judge, read};
use super::manifest::{FoundBound, MANIFEST};
use super::program::OutsideProgram;
use super::timed::TimedStrategy;
use crate::checker::Terms;
use crate::decision::Outcome;
use crate::error::{Error, Result, counted, shown};
use crate::files;
use crate::optimize::{Environment, Silent};
use crate::setters::setters;
use crate::shards::none_complete;
use crate::sim::{Conditions, Scene, simulate_while};
use crate::station::station_hash;
use crate::strategies::{self, Blueprint};
use crate::study::{BlueprintOptions, BoundStudy, BoundStudyOptions, blueprint, check_strategies};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Who takes part on which instances, and how.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct BenchmarkOptions {
    seed: u64,
    update_hz: f64,
    only: Vec<String>,
    track: Foresight,
    strategies: Vec<String>,
    program: Option<OutsideProgram>,
    picks: Option<PathBuf>,
    bounds: bool,
}

impl Default for BenchmarkOptions {
    /// Seed 1, decisions at the exact time, all instances, online; nobody takes part but the best known
    /// solutions.
    fn default() -> Self {
        Self {
            seed: 1,
            update_hz: 0.0,
            only: Vec::new(),
            track: Foresight::Online,
            strategies: Vec::new(),
            program: None,
            picks: None,
            bounds: false,
        }
    }
}

setters!(BenchmarkOptions {
    /// With this master seed.
    fn with_seed(seed: u64);
    /// With decisions of strategies at multiples of 1 / `update_hz` [s]; 0 for the exact time.
    fn with_update_hz(update_hz: f64);
    /// With these instances only, by name, in which `*` stands for any characters; all if there is none.
    fn with_only(only: Vec<String>);
    /// With strategies that know this much.
    fn with_track(track: Foresight);
    /// With these strategies, as [`parse`](crate::strategies::parse) reads them.
    fn with_strategies(strategies: Vec<String>);
    /// With this outside program, or without one.
    fn with_program(program: impl Into<Option<OutsideProgram>>);
    /// With the files of picks in this folder, or without.
    fn with_picks(picks: impl Into<Option<PathBuf>>);
    /// With bounds computed anew, and with their schedules, or without.
    fn with_bounds(bounds: bool);
});

impl BenchmarkOptions {
    /// Who takes part; the best known solutions if nobody else does.
    fn entrants(&self) -> Vec<Entrant> {
        let strategies = self.strategies.iter();
        let strategies = strategies.map(|text| Entrant::Strategy(text.clone(), self.track));
        let program = self.program.iter().cloned().map(Entrant::Program);
        let picks = self.picks.iter().cloned().map(Entrant::Picks);
        let bound = self.bounds.then_some(Entrant::Bound);
        let all: Vec<_> = strategies
            .chain(program)
            .chain(picks)
            .chain(bound)
            .collect();
        match all.is_empty() {
            true => vec![Entrant::Best],
            false => all,
        }
    }
}

/// One entrant on one instance.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Entry {
    /// Index of the instance.
    pub instance: usize,
    /// Index of the entrant.
    pub entrant: usize,
    /// The solution, or why there is none.
    pub solved: std::result::Result<Solution, String>,
    /// Whether the run is possible, but above a bound: one of the two must be wrong.
    pub contradicts: bool,
    /// Whether it is a best known solution that is not what the list says, or not possible.
    pub lost: bool,
    /// The bound, if it was computed anew.
    pub bound: Option<FoundBound>,
    /// Number of decisions; for those who write whole runs, of picks.
    pub decisions: u64,
    /// The time that they took.
    pub spent: Duration,
}

/// What came of a benchmark.
#[derive(Debug)]
#[non_exhaustive]
pub struct BenchmarkResult {
    /// Who took part.
    pub entrants: Vec<Entrant>,
    /// By instance, then by entrant; fewer than all if the user stopped.
    pub entries: Vec<Entry>,
}

impl BenchmarkResult {
    /// Whether the result is what a benchmark should give: the best known solutions are what the list says,
    /// no run is above a bound, and some run is valid.
    ///
    /// # Errors
    /// [`Refuted`](crate::error::ErrorKind::Refuted): how many runs are otherwise.
    pub fn check(&self) -> Result<()> {
        let count =
            |wrong: &dyn Fn(&Entry) -> bool| self.entries.iter().filter(|e| wrong(e)).count();
        let above = count(&|entry| entry.contradicts);
        if above > 0 {
            return Err(Error::contradiction(
                "the benchmark",
                format!("{} above a certified bound", counted(above, "run")),
                "report this: either the bound or the checker is wrong",
            ));
        }
        let lost = count(&|entry| entry.lost);
        if lost > 0 {
            return Err(Error::contradiction(
                "the benchmark",
                format!(
                    "{} not possible, or not what {MANIFEST} says",
                    counted(lost, "best known solution")
                ),
                "correct what is listed as failed",
            ));
        }
        let asked = |entry: &Entry| self.entrants[entry.entrant] != Entrant::Best;
        let valid = |entry: &Entry| entry.solved.is_ok();
        if count(&asked) > 0 && count(&valid) == 0 {
            return Err(Error::contradiction(
                "the benchmark",
                "no run is valid",
                "see why each of them failed",
            ));
        }
        Ok(())
    }
}

/// A benchmark that is read and checked.
#[derive(Debug)]
pub struct BenchmarkStudy<'a> {
    instances: Vec<Instance>,
    entrants: Vec<Entrant>,
    options: &'a BenchmarkOptions,
}

/// A strategy on each of the lines by the hash of the station, or why it is not for it.
type OnLines = HashMap<String, std::result::Result<Blueprint, String>>;

impl<'a> BenchmarkStudy<'a> {
    /// Reads the instances in `folder` that `options` name, and checks who takes part.
    ///
    /// # Errors
    /// Instances that cannot be read, a strategy that cannot be read or is for none of their lines, one that
    /// takes part twice, or a folder of picks without a file for any instance.
    pub fn new(folder: &Path, options: &'a BenchmarkOptions) -> Result<Self> {
        let instances = load_instances(folder, &options.only)?;
        let mut names = HashSet::new();
        for text in &options.strategies {
            // Written in different ways, a strategy is the same on every line or on none.
            let first = &instances[0].station;
            let alone = strategy_on(text, first)?.alone(first.robots().len());
            let name = alone.map_or_else(|_| text.clone(), |blueprint| blueprint.name().to_owned());
            if !names.insert(name) {
                return Err(Error::usage(
                    "'strategy'",
                    format!("`{}` is given twice", shown(text)),
                    "give each strategy once",
                ));
            }
            check_strategy(text, &instances)?;
        }
        if let Some(picks) = &options.picks {
            let mut files = instances.iter().map(|instance| picks_file(picks, instance));
            if !files.any(|file| file.is_file()) {
                let first = &instances[0].name;
                return Err(Error::usage(
                    "'picks'",
                    format!("{} has no file of picks for any instance", picks.display()),
                    format!("name them after the instances, such as {first}.csv"),
                ));
            }
        }
        Conditions::at_update_hz(options.update_hz).check()?;
        Ok(Self {
            instances,
            entrants: options.entrants(),
            options,
        })
    }

    /// The chosen instances.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// Number of runs: instances times entrants.
    pub fn planned(&self) -> usize {
        self.instances.len() * self.entrants.len()
    }

    /// Runs and judges every entrant on every instance. If the user stops, the runs that are over are returned.
    ///
    /// # Errors
    /// [`Interrupted`](crate::error::ErrorKind::Interrupted) before any run is over; a failure that is no
    /// entrant's, such as a folder for temporary files that cannot be written.
    pub fn run(&self, environment: &Environment) -> Result<BenchmarkResult> {
        let ledger = environment.ledger;
        self.check_inputs(environment)?;
        let count = self.entrants.len();
        let pairs = (0..self.planned()).filter(|place| ledger.owns(*place));
        let pairs: Vec<usize> = pairs.collect();
        let made = pairs.iter().filter(|place| ledger.makes("runs", **place));
        let lines = self.put_strategies(made.map(|place| place / count), environment)?;
        let progress = environment.progress;
        progress.begin("benchmark", pairs.len() as u64, "runs");
        let one = |place: &usize| {
            if environment.stopped() {
                return Ok(None);
            }
            let (instance, entrant) = (place / count, place % count);
            let entry = ledger.unit("runs", *place, || {
                self.entry(instance, entrant, &lines, environment)
            });
            progress.advance(1);
            match entry {
                Err(error) if error.is_interrupted() || environment.stopped() => Ok(None),
                entry => entry,
            }
        };
        // One after the other, so that no thread is left with all the long ones.
        let entries: Result<Vec<Option<Entry>>> =
            pairs.par_iter().with_max_len(1).map(one).collect();
        progress.end();
        let entries = entries?;
        if ledger.shard().is_some() {
            // A shard is whole or not at all.
            return Err(match entries.iter().all(Option::is_some) {
                true => Error::sharded(),
                false => Error::interrupted(),
            });
        }
        let entries: Vec<Entry> = entries.into_iter().flatten().collect();
        if entries.is_empty() && ledger.is_partial() {
            return Err(none_complete("run"));
        }
        if entries.is_empty() {
            return Err(Error::interrupted());
        }
        Ok(BenchmarkResult {
            entrants: self.entrants.clone(),
            entries,
        })
    }

    /// Checks that all shards are made on the same instances and policies.
    fn check_inputs(&self, environment: &Environment) -> Result<()> {
        let names = self.instances.iter().map(|instance| &*instance.name);
        let names: Vec<&str> = names.collect();
        let ledger = environment.ledger;
        ledger.check_input("the list of instances", || Ok(names.join(" ")))?;
        for instance in &self.instances {
            ledger.check_input(&instance.name, || {
                let (items, known) = (instance.pattern.items(), &instance.known);
                let station = station_hash(&instance.station);
                Ok(files::fingerprint(format!("{station} {items:?} {known:?}")))
            })?;
        }
        let strategies = self.options.strategies.iter();
        check_strategies(strategies.map(String::as_str), environment)
    }

    /// For each entrant, its strategy on the lines of these instances; none of those who are no strategies.
    fn put_strategies(
        &self,
        instances: impl Iterator<Item = usize>,
        environment: &Environment,
    ) -> Result<Vec<OnLines>> {
        let mut stations: Vec<_> = instances.map(|i| &self.instances[i].station).collect();
        stations.sort_by_key(|station| station_hash(station));
        stations.dedup_by_key(|station| station_hash(station));
        let total = self.options.strategies.len() * stations.len();
        let progress = environment.progress;
        progress.begin("strategies", total as u64, "lines");
        // Its own progress would replace this one.
        let quiet = Environment {
            progress: &Silent,
            ..*environment
        };
        let options = BlueprintOptions::default()
            .with_seed(self.options.seed)
            .with_update_hz(self.options.update_hz);
        let put = |entrant: &Entrant| {
            let Entrant::Strategy(text, _) = entrant else {
                return Ok(OnLines::new());
            };
            let on = |station: &&_| {
                let found = strategy_on(text, station)
                    .and_then(|spec| blueprint(&spec, station, &options, &quiet));
                progress.advance(1);
                match found {
                    Err(error) if error.is_interrupted() => Err(error),
                    found => Ok((
                        station_hash(station),
                        found.map_err(|error| one_line(&error)),
                    )),
                }
            };
            stations.par_iter().map(on).collect()
        };
        let lines = self.entrants.iter().map(put).collect();
        progress.end();
        lines
    }

    fn entry(
        &self,
        instance: usize,
        entrant: usize,
        lines: &[OnLines],
        environment: &Environment,
    ) -> Result<Entry> {
        let of = &self.instances[instance];
        let (mut bound, mut spent, mut decisions) = (None, Duration::ZERO, None);
        let mut terms = Terms::default();
        let found = match &self.entrants[entrant] {
            Entrant::Strategy(_, track) => match &lines[entrant][&station_hash(&of.station)] {
                Ok(blueprint) => {
                    let conditions = self.conditions(of, *track);
                    terms = terms
                        .with_camera_x(conditions.camera_x)
                        .with_update_hz(self.options.update_hz);
                    let scene = Scene::under(&of.station, &of.pattern, conditions)?;
                    let mut watch = TimedStrategy::new(blueprint.make());
                    let go_on = || !environment.stopped();
                    let outcome = simulate_while(&scene, &mut watch, go_on);
                    spent = watch.spent;
                    decisions = Some(watch.decisions);
                    outcome.map(|outcome| attempts(&outcome))
                }
                Err(reason) => {
                    return Ok(Entry {
                        instance,
                        entrant,
                        solved: Err(reason.clone()),
                        contradicts: false,
                        lost: false,
                        bound,
                        decisions: 0,
                        spent,
                    });
                }
            },
            Entrant::Program(program) => {
                let text = program.run(of, environment.stop);
                text.and_then(|(text, took)| {
                    spent = took;
                    read(of, &text, "its picks")
                })
            }
            Entrant::Picks(folder) => from_file(of, &picks_file(folder, of)),
            Entrant::Best => from_file(of, &of.best_file()),
            Entrant::Bound => {
                let options = BoundStudyOptions::default().with_seed(self.options.seed);
                let quiet = Environment {
                    progress: &Silent,
                    ..*environment
                };
                let found = BoundStudy::new(&of.station, &of.pattern, &options)?;
                let found = found.run(&quiet)?.picks;
                if environment.stopped() {
                    return Err(Error::interrupted());
                }
                bound = Some(FoundBound {
                    picks: found.value as usize,
                    rate: found.rate,
                });
                let none = || Error::input("the bound", "has no schedule", "there is none");
                found.schedule.as_ref().map(attempts).ok_or_else(none)
            }
        };
        let judged = match found.and_then(|attempts| judge(of, attempts, terms)) {
            Err(error) if error.is_interrupted() => return Err(error),
            judged => judged.map_err(|error| one_line(&error)),
        };
        let mut contradicts = false;
        let solved = judged.and_then(|solution| {
            let mut known = of.known.clone();
            if let Some(found) = bound {
                known.tighten(found);
            }
            if let Some(problem) = known.excess(&solution.figures) {
                contradicts = true;
                return Err(problem);
            }
            let mistake = match self.entrants[entrant] {
                Entrant::Best => of.known.mistake(&solution.figures),
                _ => None,
            };
            mistake.map_or(Ok(solution), Err)
        });
        // Of a new benchmark, nothing is known.
        let is_known = of.known.picked.is_some() || of.best_file().exists();
        let is_best = self.entrants[entrant] == Entrant::Best;
        let lost = is_best && is_known && solved.is_err() && !contradicts;
        let picks = solved
            .as_ref()
            .map_or(0, |solution| solution.figures.picked);
        Ok(Entry {
            instance,
            entrant,
            solved,
            contradicts,
            lost,
            bound,
            decisions: decisions.unwrap_or(picks as u64),
            spent,
        })
    }

    /// What is known on a track.
    fn conditions(&self, instance: &Instance, track: Foresight) -> Conditions {
        let camera_x = match track {
            Foresight::Online => 0.0,
            Foresight::Clairvoyant => instance.far_camera(),
        };
        Conditions::at_update_hz(self.options.update_hz).with_camera_x(camera_x)
    }
}

/// Checks that `text` is a strategy, and for the line of some instance.
fn check_strategy(text: &str, instances: &[Instance]) -> Result<()> {
    let mut first = None;
    for instance in instances {
        let spec = strategy_on(text, &instance.station)?;
        match spec.check_on(&instance.station) {
            Ok(()) => return Ok(()),
            Err(error) => first = first.or(Some(error)),
        }
    }
    first.map_or(Ok(()), Err)
}

fn strategy_on(text: &str, station: &crate::station::Station) -> Result<strategies::StrategySpec> {
    strategies::parse(&for_robots(text, station.robots().len()))
}

fn picks_file(folder: &Path, instance: &Instance) -> PathBuf {
    folder.join(format!("{}.csv", instance.name))
}

fn from_file(instance: &Instance, file: &Path) -> Result<Attempts> {
    if !file.exists() {
        let cure = "name the files of picks after the instances";
        let place = file.display().to_string();
        return Err(Error::path(place, "does not exist", cure));
    }
    read(
        instance,
        &files::read_text(file)?,
        &file.display().to_string(),
    )
}

fn attempts(outcome: &Outcome) -> Attempts {
    outcome.picks.iter().map(|pick| (*pick, None)).collect()
}

/// Place and problem of an error.
fn one_line(error: &Error) -> String {
    let problem = error.problem();
    let text = match error.place() {
        Some(place) if !problem.starts_with(place) => format!("{place}: {problem}"),
        _ => problem,
    };
    text.lines().next().unwrap_or_default().to_owned()
}
