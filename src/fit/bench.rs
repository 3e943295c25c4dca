//! An arm, its measured times, and the kinds of fit to them.

use super::arm_result::{FitError, MoveResidual};
use super::law_fit::{LawEstimate, Prior, estimate_law};
use super::model::{DWELL, GRASP, LIFT, Leg, Observation, RAMP, SLOWNESS, arm_of, predict};
use super::options::{FitLaw, FitOptions};
use super::robust::Task;
use super::table::{Groups, TableEstimate, no_table_because};
use crate::error::{Error, Result};
use crate::station::Robot;

/// Fewer moves do not tell a law from its errors.
pub(super) const LEAST_MOVES: usize = 12;
/// Fewer times of a bin or of failed grasps do not tell a dwell.
pub(super) const LEAST_OF_KIND: usize = LEAST_MOVES / 2;
/// Number of parts that are held out in turn.
const PARTS: usize = 5;

/// The law, as estimated from some observations.
pub(super) enum Fitted {
    Law(LawEstimate),
    Table(TableEstimate, Groups),
}

/// What is fitted, and what was found out about it.
pub(super) struct Choice {
    pub(super) fitted: Fitted,
    /// Whether the law was rejected.
    pub(super) rejected: bool,
}

/// What is known about an arm before and beside its fit.
pub(super) struct Bench<'a> {
    pub(super) robot: &'a Robot,
    pub(super) observations: Vec<Observation>,
    /// Number of moves.
    pub(super) rows: usize,
    pub(super) prior: Prior,
    pub(super) options: &'a FitOptions,
    law: LawEstimate,
}

fn no_law(robot: &Robot) -> Error {
    Error::input(
        format!("robot `{}`", robot.name),
        "no law fits its times, not even badly",
        "check that places are in metres, times in seconds, and that they belong together",
    )
}

/// What the station says about the arm.
fn prior_of(robot: &Robot, observations: &[Observation], options: &FitOptions, step: f64) -> Prior {
    let law = &robot.arm.law;
    let speed = law.top_speed().unwrap_or_else(|| robot.cruising_speed());
    let mut parameters = vec![0.0; DWELL + robot.bins.len()];
    parameters[SLOWNESS] = 1.0 / speed;
    parameters[RAMP] = law.ramp();
    parameters[LIFT] = 2.0 * options.lift.unwrap_or(robot.arm.lift);
    parameters[GRASP] = robot.grasp_time;
    let mut bins = Vec::new();
    for (index, bin) in robot.bins.iter().enumerate() {
        parameters[DWELL + index] = robot.grasp_time + bin.release_time;
        let own = observations.iter().filter(|o| o.leg.bin() == Some(index));
        if own.count() >= LEAST_OF_KIND {
            bins.push(index);
        }
    }
    let failed = |o: &&Observation| matches!(o.leg, Leg::Chase(_));
    Prior {
        parameters,
        bins,
        has_grasp: observations.iter().filter(failed).count() >= LEAST_OF_KIND,
        step,
    }
}

impl<'a> Bench<'a> {
    /// The times of `robot` in this number of moves, whose stamps have this step [s] or 0.
    ///
    /// # Errors
    /// No law fits them at all.
    pub(super) fn new(
        robot: &'a Robot,
        observations: Vec<Observation>,
        (rows, step): (usize, f64),
        options: &'a FitOptions,
    ) -> Result<Self> {
        let prior = prior_of(robot, &observations, options, step);
        let law = estimate_law(&observations, &prior, options).ok_or_else(|| no_law(robot))?;
        Ok(Self {
            robot,
            observations,
            rows,
            prior,
            options,
            law,
        })
    }

    /// The law or table to use.
    ///
    /// # Errors
    /// A table is asked for, and none can be made.
    pub(super) fn choose(&self) -> Result<Choice> {
        let ways = Groups::of_ways(&self.observations);
        let groups = ways
            .clone()
            .or_else(|| Groups::of_reaches(&self.observations));
        let rejected = groups.is_some_and(|groups| {
            let residuals = self.task().residuals(&self.law.estimate.parameters);
            let size = (self.law.free.len(), self.prior.step);
            groups.reject(&self.observations, &residuals, size)
        });
        let fitted = match (self.options.law, ways) {
            (FitLaw::Table, None) => {
                return Err(Error::input(
                    format!("robot `{}`", self.robot.name),
                    format!(
                        "no table can be fitted: {}",
                        no_table_because(&self.observations)
                    ),
                    "give grasp_s for 30 or more moves, in a CSV file, or fit another 'law'",
                ));
            }
            (FitLaw::Auto, Some(groups)) if rejected || !self.is_arm() => self.table(groups),
            (FitLaw::Table, Some(groups)) => self.table(groups),
            _ => Fitted::Law(self.law.clone()),
        };
        Ok(Choice { fitted, rejected })
    }

    /// Whether the law is that of an arm. Of times that do not depend on the length it is not: the
    /// speed or the lift is then as large as can be, and only a table holds what was measured.
    fn is_arm(&self) -> bool {
        // A top speed that no move tells has no limit in the estimate.
        let slowest = self.law.slowest.as_ref();
        let fitted = Robot {
            arm: arm_of(slowest.unwrap_or(&self.law.estimate.parameters)),
            ..self.robot.clone()
        };
        fitted.check_arm("").is_empty()
    }

    fn table(&self, groups: Groups) -> Fitted {
        let parameters = &self.law.estimate.parameters;
        let table = groups.table(&self.observations, self.lift(), &parameters[DWELL..]);
        Fitted::Table(table, groups)
    }

    pub(super) fn task(&self) -> Task<'_> {
        Task {
            observations: &self.observations,
            free: &self.law.free,
            step: self.prior.step,
        }
    }

    /// `2 h` of a table: that of the station, since a table cannot tell it.
    pub(super) fn lift(&self) -> f64 {
        self.prior.parameters[LIFT]
    }

    /// What `fitted` predicts for an observation [s]; infinite if it predicts nothing.
    pub(super) fn predicted(&self, fitted: &Fitted, observation: &Observation) -> f64 {
        match fitted {
            Fitted::Law(law) => {
                let mut slopes = vec![0.0; law.estimate.parameters.len()];
                predict(&law.estimate.parameters, &observation.leg, &mut slopes)
            }
            Fitted::Table(table, _) => {
                let time = table.predict(&observation.leg, self.lift());
                time.unwrap_or(f64::INFINITY)
            }
        }
    }

    /// The same kind of fit to other observations, such as a resample.
    pub(super) fn refit(&self, fitted: &Fitted, observations: &[Observation]) -> Fitted {
        match fitted {
            Fitted::Law(law) => {
                let task = Task {
                    observations,
                    free: &law.free,
                    step: self.prior.step,
                };
                let old = &law.estimate;
                let estimate = task.refine(&old.parameters, old.scale);
                Fitted::Law(LawEstimate {
                    estimate,
                    ..law.clone()
                })
            }
            Fitted::Table(table, groups) => {
                let table = groups.table(observations, self.lift(), &table.dwell);
                Fitted::Table(table, groups.clone())
            }
        }
    }

    /// How well each of five parts of the moves is predicted by a fit to the others: all times, and
    /// those that are no outliers.
    pub(super) fn held_out(&self, fitted: &Fitted, residuals: &[MoveResidual]) -> [FitError; 2] {
        let mut sizes = [Vec::new(), Vec::new()];
        for part in 0..PARTS {
            let (test, train): (Vec<_>, Vec<_>) = self
                .observations
                .iter()
                .zip(residuals)
                .partition(|(o, _)| o.row % PARTS == part);
            let train: Vec<Observation> = train.into_iter().map(|(o, _)| *o).collect();
            let other = self.refit(fitted, &train);
            for (observation, residual) in test {
                let size = (observation.time - self.predicted(&other, observation)).abs();
                // A table predicts no time of an arm that chases its item.
                if size.is_finite() {
                    sizes[0].push(size);
                    if !residual.is_outlier {
                        sizes[1].push(size);
                    }
                }
            }
        }
        sizes.map(FitError::of)
    }
}
