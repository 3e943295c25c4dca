//! The fit of one arm: its law, its dwell times, their intervals, and how well they reproduce the
//! recorded times.

use super::arm_result::{ArmFit, FitError, FittedLaw, MoveResidual, rounded_arm, tidy};
use super::intervals::{HalfOpen, percentile_interval, resampled};
use super::law_fit::{LawEstimate, Prior, estimate_law};
use super::model::{
    DWELL, GRASP, LIFT, Leg, Observation, RAMP, SLOWNESS, arm_of, longest_path, predict,
};
use super::options::{FitLaw, FitOptions};
use super::parameter::{FittedParameter, doubtful, known, with_interval};
use super::robust::{TUKEY, Task, scale_of};
use super::table::{Groups, TableEstimate};
use super::timed_move::TimedMove;
use crate::error::{Error, Result, rounded};
use crate::kinematics::{Arm, TravelLaw};
use crate::station::Robot;
use crate::stats::quantile;

/// Fewer moves do not tell a law from its errors.
pub(super) const LEAST_MOVES: usize = 12;
/// Number of parts that are held out in turn.
const PARTS: usize = 5;
/// A larger share of outliers is no longer one of outliers.
const MOST_OUTLIERS: f64 = 0.3;

/// The law, as estimated from some observations.
enum Fitted {
    Law(LawEstimate),
    Table(TableEstimate, Groups),
}

/// What is known about an arm before and beside its fit.
struct Bench<'a> {
    robot: &'a Robot,
    observations: Vec<Observation>,
    rows: usize,
    prior: Prior,
    options: &'a FitOptions,
    law: LawEstimate,
}

/// Fits the law of `robot`, which has this index, to its moves.
///
/// # Errors
/// Too few moves, or a table for times that none can be made of.
pub(super) fn fit_arm(
    robot: &Robot,
    index: usize,
    moves: &[TimedMove],
    options: &FitOptions,
) -> Result<ArmFit> {
    let observations = moves.iter().enumerate();
    let observations = observations.flat_map(|(row, m)| m.observations(robot, row));
    let observations: Vec<Observation> = observations.collect();
    if moves.len() < LEAST_MOVES {
        return Err(Error::input(
            format!("robot `{}`", robot.name),
            match moves.len() {
                1 => "1 move is too few for a law".to_owned(),
                count => format!("{count} moves are too few for a law"),
            },
            format!("give {LEAST_MOVES} or more, better 100, over all lengths of way"),
        ));
    }
    let prior = prior_of(robot, &observations, options);
    let law = estimate_law(&observations, &prior, options).ok_or_else(|| no_law(robot))?;
    let bench = Bench {
        robot,
        rows: moves.len(),
        observations,
        prior,
        options,
        law,
    };
    let (fitted, rejected) = bench.choose()?;
    bench.finish(index, moves, &fitted, rejected)
}

fn no_law(robot: &Robot) -> Error {
    Error::input(
        format!("robot `{}`", robot.name),
        "no law fits its times, not even badly",
        "check that places are in metres, times in seconds, and that they belong together",
    )
}

/// What the station says about the arm.
fn prior_of(robot: &Robot, observations: &[Observation], options: &FitOptions) -> Prior {
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
        if own.count() >= LEAST_MOVES / 2 {
            bins.push(index);
        }
    }
    let failed = |o: &&Observation| matches!(o.leg, Leg::Chase(_));
    Prior {
        parameters,
        bins,
        has_grasp: observations.iter().filter(failed).count() >= LEAST_MOVES / 2,
    }
}

impl Bench<'_> {
    /// The law or table to use, and whether the law was rejected.
    fn choose(&self) -> Result<(Fitted, bool)> {
        let law = || Fitted::Law(self.law.clone());
        let groups = Groups::of(&self.observations);
        let rejected = groups.as_ref().is_some_and(|groups| {
            let residuals = self.task().residuals(&self.law.estimate.parameters);
            groups.reject(&self.observations, &residuals, self.law.free.len())
        });
        let table = |groups: Groups| {
            let parameters = &self.law.estimate.parameters;
            let table = groups.table(&self.observations, self.lift(), &parameters[DWELL..]);
            Fitted::Table(table, groups)
        };
        Ok(match (self.options.law, groups) {
            (FitLaw::Table, Some(groups)) => (table(groups), rejected),
            (FitLaw::Auto, Some(groups)) if rejected => (table(groups), rejected),
            (FitLaw::Table, None) => {
                return Err(Error::input(
                    format!("robot `{}`", self.robot.name),
                    "there are too few ways with the time of the grasp for a table",
                    "give grasp_s for 30 or more moves, or fit another 'law'",
                ));
            }
            _ => (law(), rejected),
        })
    }

    fn task(&self) -> Task<'_> {
        Task {
            observations: &self.observations,
            free: &self.law.free,
        }
    }

    /// `2 h` of a table: that of the station, since a table cannot tell it.
    fn lift(&self) -> f64 {
        self.prior.parameters[LIFT]
    }

    /// What `fitted` predicts for an observation [s]; infinite if it predicts nothing.
    fn predicted(&self, fitted: &Fitted, observation: &Observation) -> f64 {
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
    fn refit(&self, fitted: &Fitted, observations: &[Observation]) -> Fitted {
        match fitted {
            Fitted::Law(law) => {
                let task = Task {
                    observations,
                    free: &law.free,
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

    fn finish(
        &self,
        index: usize,
        moves: &[TimedMove],
        fitted: &Fitted,
        rejected: bool,
    ) -> Result<ArmFit> {
        let residual = |o: &Observation| o.time - self.predicted(fitted, o);
        let known: Vec<f64> = self.observations.iter().map(residual).collect();
        let finite: Vec<f64> = known.iter().copied().filter(|r| r.is_finite()).collect();
        let scale = match fitted {
            Fitted::Law(law) => law.estimate.scale,
            Fitted::Table(..) => scale_of(&finite),
        };
        let residuals: Vec<MoveResidual> = self
            .observations
            .iter()
            .zip(&known)
            .map(|(o, &residual)| MoveResidual {
                line: moves[o.row].line,
                leg: o.leg.name(),
                way: o.leg.reach(),
                time: o.time,
                residual,
                is_outlier: residual.abs() >= TUKEY * scale,
            })
            .collect();
        let outliers = residuals.iter().filter(|r| r.is_outlier).count();
        if outliers as f64 > MOST_OUTLIERS * residuals.len() as f64 {
            return Err(Error::input(
                format!("robot `{}`", self.robot.name),
                format!(
                    "{outliers} of {} times are far from any law ({} % at most are outliers)",
                    residuals.len(),
                    100.0 * MOST_OUTLIERS
                ),
                "check that places, times and their units belong together, or that this is the \
                 station",
            ));
        }
        let drawn = (self.options.resamples, self.options.seed);
        let resamples = resampled(&self.observations, self.rows, drawn, |observations| {
            self.refit(fitted, observations)
        });
        let mut fit = ArmFit {
            robot: index,
            moves: moves.len(),
            law: FittedLaw::Table,
            arm: self.robot.arm.clone(),
            grasp_time: 0.0,
            release_times: Vec::new(),
            parameters: Vec::new(),
            table: Vec::new(),
            scale,
            error: self.held_out(fitted, &residuals),
            residuals,
            notes: Vec::new(),
        };
        match fitted {
            Fitted::Law(law) => self.describe_law(&mut fit, law, &resamples),
            Fitted::Table(table, _) => self.describe_table(&mut fit, table, &resamples),
        }
        if rejected && fit.law != FittedLaw::Table {
            let text = "the law does not fit: the residuals depend on the length of the way";
            fit.notes.push(text.into());
        }
        Ok(fit)
    }

    /// How well each of five parts of the moves is predicted by a fit to the others.
    fn held_out(&self, fitted: &Fitted, residuals: &[MoveResidual]) -> FitError {
        let mut errors = Vec::new();
        for part in 0..PARTS {
            let (test, train): (Vec<_>, Vec<_>) = self
                .observations
                .iter()
                .zip(residuals)
                .partition(|(o, _)| o.row % PARTS == part);
            let train: Vec<Observation> = train.into_iter().map(|(o, _)| *o).collect();
            let other = self.refit(fitted, &train);
            let kept = test.into_iter().filter(|(_, r)| !r.is_outlier);
            let off = kept.map(|(o, _)| (o.time - self.predicted(&other, o)).abs());
            errors.extend(off.filter(|off| off.is_finite()));
        }
        errors.sort_unstable_by(f64::total_cmp);
        let share = |share| {
            if errors.is_empty() {
                0.0
            } else {
                quantile(&errors, share)
            }
        };
        FitError {
            median: share(0.5),
            worst: share(0.95),
            count: errors.len(),
        }
    }

    fn describe_law(&self, fit: &mut ArmFit, law: &LawEstimate, resamples: &[Fitted]) {
        let draws: Vec<&LawEstimate> = resamples
            .iter()
            .filter_map(|draw| match draw {
                Fitted::Law(law) => Some(law),
                Fitted::Table(..) => None,
            })
            .collect();
        let size = (self.rows, law.free.len());
        let interval = |value: f64, of: &dyn Fn(&LawEstimate) -> f64| {
            let values = draws.iter().map(|draw| of(draw)).collect();
            percentile_interval(values, value, size)
        };
        let parameters = &law.estimate.parameters;
        fit.law = match law.accelerates {
            true => FittedLaw::Trapezoid,
            false => FittedLaw::Speed,
        };
        let mut used = parameters.clone();
        match law.least_speed {
            None => {
                let speed = |law: &LawEstimate| 1.0 / law.estimate.parameters[SLOWNESS];
                let found = speed(law);
                fit.parameters
                    .push(known("speed", "m/s", found, interval(found, &speed)));
            }
            Some(least) => {
                let peak = self.peak_speed(parameters, fit);
                used[SLOWNESS] = 1.0 / peak.max(1.0 / self.prior.parameters[SLOWNESS]);
                describe_unknown_speed(fit, least, 1.0 / used[SLOWNESS]);
            }
        }
        if law.accelerates {
            let acceleration = |law: &LawEstimate| 2.0 / law.estimate.parameters[RAMP];
            let found = acceleration(law);
            let estimated = known(
                "acceleration",
                "m/s^2",
                found,
                interval(found, &acceleration),
            );
            fit.parameters.push(match law.undetermined.contains(&RAMP) {
                true => doubtful(estimated),
                false => FittedParameter {
                    remark: "taken to be the deceleration as well".into(),
                    ..estimated
                },
            });
        }
        let lift = |law: &LawEstimate| 0.5 * law.estimate.parameters[LIFT];
        fit.parameters.push(match law.has_lift {
            true => known("lift", "m", lift(law), interval(lift(law), &lift)),
            false => self.given_lift(),
        });
        fit.arm = rounded_arm(&arm_of(&used));
        self.describe_dwell(fit, &used[DWELL..], used[GRASP], &|bin, estimated| {
            let dwell = |law: &LawEstimate| law.estimate.parameters[DWELL + bin];
            let estimated = with_interval(estimated, |own| interval(own, &dwell));
            match law.undetermined.contains(&(DWELL + bin)) {
                true => doubtful(estimated),
                false => estimated,
            }
        });
        if self.prior.has_grasp {
            let grasp = |law: &LawEstimate| law.estimate.parameters[GRASP];
            let found = grasp(law);
            let estimated = known("grasp_time", "s", found, interval(found, &grasp));
            fit.parameters
                .push(match law.undetermined.contains(&GRASP) {
                    true => doubtful(estimated),
                    false => estimated,
                });
        }
    }

    fn given_lift(&self) -> FittedParameter {
        let remark = match self.options.lift {
            Some(_) => "given",
            None => "that of the station: these moves do not tell it from the rest",
        };
        FittedParameter {
            name: "lift".into(),
            unit: "m",
            value: Some(0.5 * self.lift()),
            interval: None,
            remark: remark.into(),
        }
    }

    /// The highest speed [m/s] on the moves that are no outliers, with these parameters.
    fn peak_speed(&self, parameters: &[f64], fit: &ArmFit) -> f64 {
        let kept = self.observations.iter().zip(&fit.residuals);
        let kept = kept.filter(|(_, residual)| !residual.is_outlier);
        let lengths = kept.map(|(o, _)| longest_path(parameters, &o.leg).0);
        (2.0 * lengths.fold(0.0, f64::max) / parameters[RAMP]).sqrt()
    }

    /// Enters the dwell times, of which moves tell the sum at grasp and release; `judged` adds the
    /// interval of a bin's.
    fn describe_dwell(
        &self,
        fit: &mut ArmFit,
        dwell: &[f64],
        grasp: f64,
        judged: &dyn Fn(usize, FittedParameter) -> FittedParameter,
    ) {
        let used = self.prior.bins.iter().map(|bin| dwell[*bin]);
        let shortest = used.fold(f64::INFINITY, f64::min);
        fit.grasp_time = tidy(grasp.min(shortest));
        let robot = self.robot;
        for (index, bin) in robot.bins.iter().enumerate() {
            if !self.prior.bins.contains(&index) {
                fit.release_times.push(bin.release_time);
                continue;
            }
            fit.release_times
                .push(tidy((dwell[index] - fit.grasp_time).max(0.0)));
            let mut name = "grasp_time + release_time".to_owned();
            if robot.bins.len() > 1 {
                name += &format!(", bin {}", bin.name);
            }
            let estimated = known(&name, "s", dwell[index], None);
            fit.parameters.push(judged(index, estimated));
        }
        if self.prior.bins.is_empty() {
            let text = "no move ends in a bin: grasp and release time are those of the station";
            fit.notes.push(text.into());
        } else if !self.prior.has_grasp {
            fit.notes.push(
                "a pick tells only the sum of grasp and release time: the grasp time is the \
                 station's, or the sum if that is less"
                    .into(),
            );
        }
    }

    fn describe_table(&self, fit: &mut ArmFit, table: &TableEstimate, resamples: &[Fitted]) {
        let draws: Vec<&TableEstimate> = resamples
            .iter()
            .filter_map(|draw| match draw {
                Fitted::Table(table, _) => Some(table),
                Fitted::Law(_) => None,
            })
            .collect();
        let size = (self.rows, table.points.len() + self.prior.bins.len());
        let interval = |value: f64, of: &dyn Fn(&TableEstimate) -> f64| {
            let values = draws.iter().map(|draw| of(draw)).collect();
            percentile_interval(values, value, size)
        };
        let points = table.points.iter();
        fit.table = points
            .map(|&(length, time)| interval(time, &|draw| draw.time(length)))
            .collect();
        fit.parameters.push(FittedParameter {
            remark: "that of the station: a table of times does not tell it".into(),
            ..self.given_lift()
        });
        fit.arm = Arm {
            law: TravelLaw::Table(
                table
                    .points
                    .iter()
                    .map(|&(l, t)| (tidy(l), tidy(t)))
                    .collect(),
            ),
            lift: 0.5 * self.lift(),
        };
        let grasp = self.prior.parameters[GRASP];
        let has_out = |o: &Observation| matches!(o.leg, Leg::Out(_));
        let is_known = self.observations.iter().any(has_out);
        self.describe_dwell(fit, &table.dwell, grasp, &|bin, estimated| {
            let estimated = with_interval(estimated, |own| interval(own, &|draw| draw.dwell[bin]));
            match is_known {
                true => estimated,
                false => doubtful(estimated),
            }
        });
    }
}

/// Enters that the top speed is unknown but at least `least` [m/s], and `used` instead.
fn describe_unknown_speed(fit: &mut ArmFit, least: f64, used: f64) {
    fit.parameters.push(FittedParameter {
        name: "speed".into(),
        unit: "m/s",
        value: None,
        interval: Some(HalfOpen {
            low: least,
            high: None,
        }),
        remark: "no move is long enough to tell the top speed".into(),
    });
    fit.notes.push(format!(
        "the top speed is unknown: {} m/s, the station's or that of the longest move, is used, which \
         changes no time within the recorded lengths",
        rounded(used, 4)
    ));
}
