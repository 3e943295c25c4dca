//! What the fit of one arm gives.

use super::intervals::HalfOpen;
use super::parameter::FittedParameter;
use crate::kinematics::{Arm, TravelLaw};
use crate::stats::quantile;
use std::ops::Range;

/// Digits of what goes into a station file: more than any recording determines.
const DIGITS: usize = 7;

/// Which law was fitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum FittedLaw {
    /// Constant speed.
    Speed,
    /// Speed and acceleration.
    Trapezoid,
    /// A monotone table.
    Table,
}

impl FittedLaw {
    /// The name in files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// How far predicted times are from recorded ones [s].
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct FitError {
    /// The median of their sizes [s].
    pub median: f64,
    /// What 95 % of them are below [s].
    pub worst: f64,
    /// Number of recorded times that were compared, each held out from the fit that predicts it.
    pub count: usize,
}

impl FitError {
    /// The error of times that are off by these sizes [s].
    pub(super) fn of(mut sizes: Vec<f64>) -> Self {
        sizes.sort_unstable_by(f64::total_cmp);
        let share = |share| match sizes.is_empty() {
            true => 0.0,
            false => quantile(&sizes, share),
        };
        Self {
            median: share(0.5),
            worst: share(0.95),
            count: sizes.len(),
        }
    }
}

/// One recorded time and what the fit says.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct MoveResidual {
    /// Line of the file, or number of the task.
    pub line: u64,
    /// What was timed: `out`, `back`, `whole`, `chase` or `chase_home`.
    pub leg: &'static str,
    /// Length of its way in the plane [m]: of two ways the longer one, of a chase at departure.
    pub way: f64,
    /// The recorded time [s].
    pub time: f64,
    /// By how much it is longer than predicted [s].
    pub residual: f64,
    /// Whether it was taken for an outlier.
    pub is_outlier: bool,
}

/// The fit of one arm.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ArmFit {
    /// Index of the robot.
    pub robot: usize,
    /// Number of its moves.
    pub moves: usize,
    /// The law.
    pub law: FittedLaw,
    /// The fitted arm.
    pub arm: Arm,
    /// Dwell time at the grasp [s].
    pub grasp_time: f64,
    /// Dwell time at the release into each bin [s].
    pub release_times: Vec<f64>,
    /// The parameters with their intervals.
    pub parameters: Vec<FittedParameter>,
    /// For a table, the interval of the time at each point [s].
    pub table: Vec<Option<HalfOpen>>,
    /// For a table, the indices of the points that were measured; the others are extrapolated.
    pub measured: Range<usize>,
    /// Standard deviation of the times that are no outliers, robustly [s].
    pub scale: f64,
    /// The step of which all recorded stamps are multiples [s], if there is one.
    pub step: Option<f64>,
    /// How well recorded times are predicted, outliers included, by fits that did not use them.
    pub error: FitError,
    /// The same without outliers.
    pub error_without_outliers: FitError,
    /// Every recorded time.
    pub residuals: Vec<MoveResidual>,
    /// What a reader must know about the figures.
    pub notes: Vec<String>,
}

impl ArmFit {
    /// Number of recorded times that were taken for outliers.
    pub fn outliers(&self) -> usize {
        self.residuals.iter().filter(|r| r.is_outlier).count()
    }
}

/// A number with the digits that go into a station file.
pub(super) fn tidy(value: f64) -> f64 {
    format!("{value:.0$e}", DIGITS - 1).parse().unwrap_or(value)
}

/// The arm with values of so many digits.
pub(super) fn rounded_arm(arm: &Arm) -> Arm {
    let law = match &arm.law {
        TravelLaw::Constant { speed } => TravelLaw::Constant {
            speed: tidy(*speed),
        },
        TravelLaw::Trapezoid {
            speed,
            acceleration,
            deceleration,
        } => TravelLaw::Trapezoid {
            speed: tidy(*speed),
            acceleration: tidy(*acceleration),
            deceleration: tidy(*deceleration),
        },
        TravelLaw::Table(points) => TravelLaw::Table(points.clone()),
    };
    Arm {
        law,
        lift: tidy(arm.lift),
    }
}
