//! One strategy on one pattern, and what is checked of the run.

use super::blueprint::{BlueprintOptions, blueprint};
use super::notes::{Note, detection_notes, failure_note, outage_note};
use crate::checker;
use crate::clearance::{self, Clearance};
use crate::decision::{Observer, Outcome};
use crate::error::Result;
use crate::experiment::{ClassBound, class_bounds};
use crate::optimize::{Environment, bound_beside};
use crate::pattern::Pattern;
use crate::planning::Allowance;
use crate::planning::bound::Bound;
use crate::setters::setters;
use crate::sim::{Conditions, Scene, Trace, class_runs, simulate_observed};
use crate::station::Station;
use crate::strategies::{Blueprint, StrategySpec};

/// The settings of a run, and what is found out about it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct SimulateOptions {
    seed: u64,
    conditions: Conditions,
    allowance: Allowance,
    trace: bool,
    check: bool,
    clearance: bool,
    bound: bool,
}

impl Default for SimulateOptions {
    /// Seed 1, nothing going wrong, with the bound; no trace, no check, no clearance.
    fn default() -> Self {
        Self {
            seed: 1,
            conditions: Conditions::default(),
            allowance: Allowance::default(),
            trace: false,
            check: false,
            clearance: false,
            bound: true,
        }
    }
}

setters!(SimulateOptions {
    /// With this master seed.
    fn with_seed(seed: u64);
    /// Under these conditions, with random events from the master seed.
    fn with_conditions(conditions: Conditions);
    /// With this budget of one decision, unless the strategy itself sets it.
    fn with_allowance(allowance: Allowance);
    /// With every event of the run, or without.
    fn with_trace(trace: bool);
    /// With the run verified by the independent checker, or not.
    fn with_check(check: bool);
    /// With the smallest distance between two arms, or without.
    fn with_clearance(clearance: bool);
    /// With the bound that no strategy can exceed, or without.
    fn with_bound(bound: bool);
});

impl SimulateOptions {
    /// How a strategy is put on the line for this run.
    pub fn blueprint(&self) -> BlueprintOptions {
        BlueprintOptions::default()
            .with_seed(self.seed)
            .with_update_hz(self.conditions.update_hz)
            .with_allowance(self.allowance)
    }
}

/// A run whose pattern fits on its line.
#[derive(Debug)]
pub struct SimulateStudy<'a> {
    scene: Scene<'a>,
    options: &'a SimulateOptions,
}

/// A run, and what was found out about it.
#[derive(Debug)]
#[non_exhaustive]
pub struct SimulatedRun<'a> {
    /// The full name of the strategy.
    pub strategy: String,
    /// The picks and what was missed.
    pub outcome: Outcome,
    /// Every event, if asked for.
    pub trace: Option<Trace<'a>>,
    /// The smallest distance between two arms, if asked for and if there are two.
    pub clearance: Option<Clearance>,
    /// What no strategy can exceed, if asked for.
    pub bound: Option<Bound>,
    /// The same for each wanted class; empty if no item has a class that matters.
    pub class_bounds: Vec<ClassBound>,
    /// Remarks on the settings.
    pub notes: Vec<Note>,
}

/// Runs `strategy` on `pattern`, and checks the run as far as `options` ask for it.
///
/// # Errors
/// Settings or a strategy that do not fit the line, an item beside the belt, an illegal action,
/// [`Refuted`](crate::error::ErrorKind::Refuted) by the checker, or
/// [`Interrupted`](crate::error::ErrorKind::Interrupted).
pub fn simulate_and_check<'a>(
    station: &'a Station,
    pattern: &'a Pattern,
    strategy: &StrategySpec,
    options: &'a SimulateOptions,
    environment: &Environment,
) -> Result<SimulatedRun<'a>> {
    let blueprint = blueprint(strategy, station, &options.blueprint(), environment)?;
    SimulateStudy::new(station, pattern, options)?.run(&blueprint, environment)
}

impl<'a> SimulateStudy<'a> {
    /// Puts `pattern` on `station`.
    ///
    /// # Errors
    /// An item beside the belt, or invalid conditions.
    pub fn new(
        station: &'a Station,
        pattern: &'a Pattern,
        options: &'a SimulateOptions,
    ) -> Result<Self> {
        let conditions = options.conditions.with_seed(options.seed);
        let scene = Scene::under(station, pattern, conditions)?;
        Ok(Self { scene, options })
    }

    /// The pattern on the station.
    pub fn scene(&self) -> &Scene<'a> {
        &self.scene
    }

    /// Remarks on the settings.
    pub fn notes(&self) -> Vec<Note> {
        let conditions = self.scene.conditions();
        let items = std::iter::once(self.scene.pattern().items());
        let detections = detection_notes(conditions, items);
        let outages = outage_note(conditions, self.options.bound);
        failure_note(&self.scene)
            .into_iter()
            .chain(detections)
            .chain(outages)
            .collect()
    }

    /// Runs the strategy that `blueprint` makes.
    ///
    /// # Errors
    /// An illegal action, [`Refuted`](crate::error::ErrorKind::Refuted) by the checker, or
    /// [`Interrupted`](crate::error::ErrorKind::Interrupted) before the run and its bound are complete.
    pub fn run(
        &self,
        blueprint: &Blueprint,
        environment: &Environment,
    ) -> Result<SimulatedRun<'a>> {
        let (scene, options) = (&self.scene, self.options);
        let (station, pattern) = (scene.station(), scene.pattern());
        let mut strategy = blueprint.make();
        let mut trace = options.trace.then(|| Trace::new(station, pattern));
        let observer = trace.as_mut().map(|trace| trace as &mut dyn Observer);
        let outcome = simulate_observed(scene, strategy.as_mut(), observer, || {
            !environment.stopped()
        })?;
        if options.check {
            checker::check(station, pattern, &outcome)?;
        }
        let clearance = match options.clearance {
            true => clearance::smallest(station, &outcome),
            false => None,
        };
        let bound = match options.bound {
            true => Some(bound_beside(scene, outcome.figures.picked, environment)?),
            false => None,
        };
        let class_bounds = match options.bound {
            true => class_bounds(scene, &[&class_runs(scene, &outcome)], environment)?,
            false => Vec::new(),
        };
        Ok(SimulatedRun {
            strategy: strategy.name(),
            outcome,
            trace,
            clearance,
            bound,
            class_bounds,
            notes: self.notes(),
        })
    }
}
