//! What no strategy can exceed on one pattern.

use super::notes::{Note, failure_note};
use crate::checker;
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::planning::bound::{Bound, BoundObjective, BoundOptions, upper_bound};
use crate::setters::setters;
use crate::sim::{Conditions, Scene};
use crate::station::Station;

/// The highest accepted number of iterations; more are treated as a typing mistake.
const MOST_ITERATIONS: usize = 1_000_000;

/// The settings of a bound.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct BoundStudyOptions {
    seed: u64,
    conditions: Conditions,
    weight: bool,
    slot_s: Option<f64>,
    iterations: usize,
}

impl Default for BoundStudyOptions {
    /// Seed 1, nothing going wrong, picks only, slots of a suitable length, 200 iterations.
    fn default() -> Self {
        let usual = BoundOptions::default();
        Self {
            seed: 1,
            conditions: Conditions::default(),
            weight: false,
            slot_s: usual.slot_s,
            iterations: usual.iterations,
        }
    }
}

setters!(BoundStudyOptions {
    /// With this master seed, which decides what the camera reports.
    fn with_seed(seed: u64);
    /// Under these conditions, with random events from the master seed.
    fn with_conditions(conditions: Conditions);
    /// With the sum of the picked items' weights bounded as well, or not.
    fn with_weight(weight: bool);
    /// With at most this number of price updates; the rate and the end take as many again.
    fn with_iterations(iterations: usize);
});

impl BoundStudyOptions {
    /// With slots of this length [s].
    #[must_use]
    pub fn with_slot(mut self, slot_s: f64) -> Self {
        self.slot_s = Some(slot_s);
        self
    }

    /// Checks the settings that do not depend on the line.
    ///
    /// # Errors
    /// A number of iterations out of range.
    pub fn check(&self) -> Result<()> {
        if (1..=MOST_ITERATIONS).contains(&self.iterations) {
            return Ok(());
        }
        Err(Error::usage(
            "'iterations'",
            format!("{} iterations", self.iterations),
            format!("give 1 to {MOST_ITERATIONS}"),
        ))
    }
}

/// A bound whose settings are checked and whose pattern fits on its line.
#[derive(Debug)]
pub struct BoundStudy<'a> {
    scene: Scene<'a>,
    options: &'a BoundStudyOptions,
}

/// The bounds of a pattern.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PatternBounds {
    /// The bound on the number of picks.
    pub picks: Bound,
    /// The bound on the sum of weights, if asked for.
    pub weight: Option<Bound>,
    /// Remarks on the result.
    pub notes: Vec<Note>,
}

/// Bounds what any strategy can pick from `pattern`, even one that knows the future. On a stop
/// request, the bound so far is returned; it holds, too.
///
/// # Errors
/// Settings out of range, an item beside the belt, or a pattern for which no bound can be
/// computed.
pub fn bound(
    station: &Station,
    pattern: &Pattern,
    options: &BoundStudyOptions,
    environment: &Environment,
) -> Result<PatternBounds> {
    let study = BoundStudy::new(station, pattern, options)?;
    let mut found = study.run(environment)?;
    found.notes.splice(0..0, study.notes());
    Ok(found)
}

impl<'a> BoundStudy<'a> {
    /// Checks the settings and puts `pattern` on `station`.
    ///
    /// # Errors
    /// Settings out of range, or an item beside the belt.
    pub fn new(
        station: &'a Station,
        pattern: &'a Pattern,
        options: &'a BoundStudyOptions,
    ) -> Result<Self> {
        options.check()?;
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
        failure_note(&self.scene).into_iter().collect()
    }

    /// Finds the bounds. The independent checker verifies the schedules that come with them. The
    /// notes are on the result only.
    ///
    /// # Errors
    /// A pattern for which no bound can be computed, or
    /// [`Refuted`](crate::error::ErrorKind::Refuted) by the checker.
    pub fn run(&self, environment: &Environment) -> Result<PatternBounds> {
        let picks = self.bound(BoundObjective::Picks, environment)?;
        let weight = match self.options.weight {
            true => Some(self.bound(BoundObjective::Weight, environment)?),
            false => None,
        };
        for found in [Some(&picks), weight.as_ref()].into_iter().flatten() {
            if let Some(schedule) = &found.schedule {
                checker::check(self.scene.station(), self.scene.pattern(), schedule)?;
            }
        }
        let notes = self.result_notes(&picks);
        Ok(PatternBounds {
            picks,
            weight,
            notes,
        })
    }

    fn bound(&self, objective: BoundObjective, environment: &Environment) -> Result<Bound> {
        let options = BoundOptions {
            slot_s: self.options.slot_s,
            iterations: self.options.iterations,
            // A schedule for the undisturbed line may fail on the disturbed one.
            schedule: !self.scene.conditions().disturbances.may_fail(),
            ..BoundOptions::in_full(objective, self.scene.pattern().len())
        };
        let progress = environment.progress;
        let mut begun = false;
        let found = upper_bound(&self.scene, &options, &mut |_, expected| {
            if !begun {
                progress.begin("bounding", expected as u64, "steps");
                begun = true;
            }
            progress.advance(1);
            !environment.stopped()
        });
        progress.end();
        found
    }

    fn result_notes(&self, picks: &Bound) -> Vec<Note> {
        let conditions = self.scene.conditions();
        let disturbances = &conditions.disturbances;
        let undisturbed = disturbances.may_fail().then(|| Note::UndisturbedBound {
            camera: conditions.camera_x.is_some() && disturbances.position_noise > 0.0,
        });
        let coarse = picks.coarse.then_some(Note::CoarseBound);
        undisturbed.into_iter().chain(coarse).collect()
    }
}
