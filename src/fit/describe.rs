//! The figures of a fit: values with intervals, and why there are none where the moves do not tell
//! them.

use super::arm_result::{ArmFit, FittedLaw, rounded_arm, tidy};
use super::bench::{Bench, Fitted, LEAST_OF_KIND};
use super::intervals::{HalfOpen, percentile_interval, widening};
use super::law_fit::LawEstimate;
use super::model::{DWELL, GRASP, LIFT, Leg, Observation, RAMP, SLOWNESS, arm_of, longest_path};
use super::options::FitLaw;
use super::parameter::{FittedParameter, doubtful, known, with_interval};
use super::profile::Profile;
use super::table::TableEstimate;
use crate::error::rounded;
use crate::kinematics::{Arm, TravelLaw};

/// Why a parameter has no figure.
const SPEED_UNKNOWN: &str = "the lengths of these moves do not tell it";
const RAMP_OR_LIFT: &str = "these moves do not tell it from the lift";
const RAMP_OR_SPEED: &str = "these moves do not tell it from the top speed";
const DWELL_OR_WAY: &str = "these moves do not tell it from the time of the ways";

impl Bench<'_> {
    pub(super) fn describe_law(&self, fit: &mut ArmFit, law: &LawEstimate, resamples: &[Fitted]) {
        let draws: Vec<&LawEstimate> = resamples
            .iter()
            .filter_map(|draw| match draw {
                Fitted::Law(law) => Some(law),
                Fitted::Table(..) => None,
            })
            .collect();
        let size = (self.rows, law.free.len());
        let rounding = self.rounding(law);
        let mut varied = Vec::new();
        let profile = self.profile(law, &mut varied);
        // The interval of a figure that follows from the parameter with this index.
        let interval = |index: usize, of: &dyn Fn(&LawEstimate) -> f64| {
            let values = draws.iter().map(|draw| of(draw)).collect();
            let interval = percentile_interval(values, of(law), size)?;
            let ends = profile.ends(index).map(|parameters| law.with(parameters));
            let others = law.not_excluded(index, rounding[index]);
            let others = others.into_iter().chain(ends);
            Some(others.fold(interval, |interval, other| interval.including(of(&other))))
        };
        let judged = |parameter: FittedParameter, index: usize, reason: &str| match law
            .undetermined
            .contains(&index)
        {
            true => doubtful(parameter, reason),
            false => parameter,
        };
        let parameters = &law.estimate.parameters;
        fit.law = match law.accelerates {
            true => FittedLaw::Trapezoid,
            false => FittedLaw::Speed,
        };
        let mut used = parameters.clone();
        match &law.slowest {
            None => {
                let speed = |law: &LawEstimate| 1.0 / law.estimate.parameters[SLOWNESS];
                let found = known("speed", "m/s", speed(law), interval(SLOWNESS, &speed));
                fit.parameters.push(judged(found, SLOWNESS, SPEED_UNKNOWN));
            }
            Some(slowest) => {
                let peak = self.peak_speed(parameters, fit);
                used[SLOWNESS] = 1.0 / peak.max(1.0 / self.prior.parameters[SLOWNESS]);
                describe_unknown_speed(fit, 1.0 / slowest[SLOWNESS], 1.0 / used[SLOWNESS]);
            }
        }
        if law.accelerates {
            let acceleration = |law: &LawEstimate| 2.0 / law.estimate.parameters[RAMP];
            let found = acceleration(law);
            let found = known(
                "acceleration",
                "m/s^2",
                found,
                interval(RAMP, &acceleration),
            );
            let lift_is_known = law.has_lift || self.options.lift.is_some();
            fit.parameters.push(match law.undetermined.contains(&RAMP) {
                true if lift_is_known => doubtful(found, RAMP_OR_SPEED),
                true => doubtful(found, RAMP_OR_LIFT),
                false => FittedParameter {
                    remark: "taken to be the deceleration as well".into(),
                    ..found
                },
            });
        }
        let lift = |law: &LawEstimate| 0.5 * law.estimate.parameters[LIFT];
        fit.parameters.push(match law.has_lift {
            true => {
                let found = known("lift", "m", lift(law), interval(LIFT, &lift));
                judged(found, LIFT, RAMP_OR_SPEED)
            }
            false => self.given_lift("these moves do not tell it from the rest"),
        });
        fit.arm = rounded_arm(&arm_of(&used));
        self.describe_dwell(fit, &used[DWELL..], used[GRASP], &|bin, estimated| {
            let dwell = |law: &LawEstimate| law.estimate.parameters[DWELL + bin];
            let estimated = with_interval(estimated, |_| interval(DWELL + bin, &dwell));
            judged(estimated, DWELL + bin, DWELL_OR_WAY)
        });
        if self.prior.has_grasp {
            let grasp = |law: &LawEstimate| law.estimate.parameters[GRASP];
            let found = known("grasp_time", "s", grasp(law), interval(GRASP, &grasp));
            fit.parameters.push(judged(found, GRASP, DWELL_OR_WAY));
        }
    }

    /// The profile of the loss of `law`; `varied` becomes the parameters that vary in it.
    fn profile<'a>(&'a self, law: &'a LawEstimate, varied: &'a mut Vec<usize>) -> Profile<'a> {
        let given = self.options.lift.is_some();
        let is_chosen = self.options.law == FitLaw::Auto;
        let wider = widening(self.rows, law.free.len());
        Profile::new(&self.task(), law, (given, is_chosen), wider, varied)
    }

    /// By how much rounded stamps may have moved each parameter of `law`, by its index; 0 for those
    /// that were not estimated.
    fn rounding(&self, law: &LawEstimate) -> Vec<f64> {
        let mut moved = vec![0.0; law.estimate.parameters.len()];
        for (index, by) in law.free.iter().zip(self.task().rounding(&law.estimate)) {
            moved[*index] = by;
        }
        moved
    }

    /// The lift that was given, or that of the station for this reason.
    fn given_lift(&self, reason: &str) -> FittedParameter {
        let remark = match self.options.lift {
            Some(_) => "given".to_owned(),
            None => format!("that of the station: {reason}"),
        };
        FittedParameter {
            name: "lift".into(),
            unit: "m",
            value: Some(0.5 * self.lift()),
            interval: None,
            remark,
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
            let mut name = "grasp_time + release_time".to_owned();
            if robot.bins.len() > 1 {
                name += &format!(", bin {}", bin.name);
            }
            if !self.prior.bins.contains(&index) {
                fit.release_times.push(bin.release_time);
                fit.parameters.push(self.unused_bin(name, index));
                continue;
            }
            fit.release_times
                .push(tidy((dwell[index] - fit.grasp_time).max(0.0)));
            let estimated = known(&name, "s", dwell[index], None);
            fit.parameters.push(judged(index, estimated));
        }
        if !self.prior.bins.is_empty() && !self.prior.has_grasp {
            fit.notes.push(
                "a pick tells only the sum of grasp and release time: the grasp time is the \
                 station's, or the sum if that is less"
                    .into(),
            );
        }
    }

    /// What is said of the bin with this index, into which too little was released.
    fn unused_bin(&self, name: String, index: usize) -> FittedParameter {
        let own = |o: &&Observation| o.leg.bin() == Some(index);
        let times = match self.observations.iter().filter(own).count() {
            0 => "no time ends there".to_owned(),
            some => format!(
                "only {} there, and {LEAST_OF_KIND} are needed",
                match some {
                    1 => "1 time ends".to_owned(),
                    _ => format!("{some} times end"),
                }
            ),
        };
        FittedParameter {
            name,
            unit: "s",
            value: None,
            interval: None,
            remark: format!(
                "{times}: the release time of the station, {} s, is kept",
                self.robot.bins[index].release_time
            ),
        }
    }

    pub(super) fn describe_table(
        &self,
        fit: &mut ArmFit,
        table: &TableEstimate,
        resamples: &[Fitted],
    ) {
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
            let interval = percentile_interval(values, value, size)?;
            // A median of rounded times may be off by half a step.
            let half = 0.5 * self.prior.step;
            Some(interval.including(value - half).including(value + half))
        };
        fit.measured = table.measured.clone();
        let points = table.points.iter().enumerate();
        let intervals = points.map(|(index, &(length, time))| {
            let is_measured = table.measured.contains(&index);
            is_measured.then(|| interval(time, &|draw| draw.time(length)))?
        });
        fit.table = intervals.collect();
        let lift = self.given_lift("a table of times does not tell it");
        fit.parameters.push(lift);
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
                false => doubtful(estimated, DWELL_OR_WAY),
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
