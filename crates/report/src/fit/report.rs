//! The figures of a fit.

use crate::provenance::Provenance;
use pickline::fit::{ArmFit, FitError, FittedParameter, HalfOpen, LineFit, MoveResidual};
use pickline::kinematics::TravelLaw;
use pickline::station::Station;
use serde::Serialize;

/// The fit of a line, as printed; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct FitReport {
    /// Each robot that has moves, upstream first.
    pub robots: Vec<ArmFitReport>,
    /// Names of the robots without moves, which stay as they are.
    pub without_moves: Vec<String>,
    /// Number of rows or tasks that could not be used.
    pub unused: usize,
    /// Columns of the file that were ignored.
    pub ignored_columns: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
}

/// The fit of one robot.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ArmFitReport {
    /// Name of the robot.
    pub name: String,
    /// The law: speed, trapezoid or table.
    pub law: &'static str,
    /// Number of moves.
    pub moves: usize,
    /// Number of recorded times.
    pub times: usize,
    /// How many of the times were taken for outliers.
    pub outliers: usize,
    /// Their share of the times.
    pub outlier_share: f64,
    /// Lines of the outliers in the file, or numbers of their tasks.
    pub outlier_lines: Vec<u64>,
    /// Standard deviation of the other times around the law, robustly [s].
    pub scale_s: f64,
    /// The step of which all stamps are multiples [s]; `None` if there is none.
    pub stamp_step_s: Option<f64>,
    /// The error of predicted times, outliers included.
    pub error: PredictionReport,
    /// The error of predicted times that are no outliers.
    pub error_without_outliers: PredictionReport,
    /// The parameters.
    pub parameters: Vec<ParameterReport>,
    /// The points of a table; empty for other laws.
    pub table: Vec<TablePointReport>,
    /// What a reader must know about the figures.
    pub notes: Vec<String>,
    /// Every recorded time.
    pub residuals: Vec<ResidualReport>,
}

/// How far predicted times are from recorded ones that the fit did not use.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct PredictionReport {
    /// Median [s].
    pub median_s: f64,
    /// 95 % are less [s].
    pub p95_s: f64,
    /// Number of times, each held out from the fit that predicts it.
    pub held_out: usize,
}

/// One parameter of a robot.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ParameterReport {
    /// Its name, as in a station file.
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// Its value; `None` if the moves do not determine it.
    pub value: Option<f64>,
    /// Its 95 % interval; `None` if it was not estimated.
    pub interval: Option<HalfOpen>,
    /// What it was taken from, or why it is not determined; may be empty.
    pub remark: String,
}

/// One point of a table.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct TablePointReport {
    /// Length of the path [m].
    pub length_m: f64,
    /// Time [s].
    pub time_s: f64,
    /// Its 95 % interval [s].
    pub interval: Option<HalfOpen>,
    /// Whether no move was so short or so long: the time continues the slope of the measured ones.
    pub extrapolated: bool,
}

/// One recorded time.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ResidualReport {
    /// Line of the file, or number of the task.
    pub line: u64,
    /// What was timed.
    pub leg: &'static str,
    /// Length of its way in the plane [m].
    pub way_m: f64,
    /// The recorded time [s].
    pub time_s: f64,
    /// By how much it is longer than predicted [s]; `None` for what a table cannot predict.
    pub residual_s: Option<f64>,
    /// Whether it was taken for an outlier.
    pub outlier: bool,
}

impl FitReport {
    /// The report of `fit` on `station`.
    pub fn new(station: &Station, fit: &LineFit, made: Provenance) -> Self {
        let name = |index: usize| station.robots()[index].name.clone();
        let arms = fit.arms.iter().enumerate();
        let without = arms.clone().filter(|(_, arm)| arm.is_none());
        let without_moves = without.map(|(index, _)| name(index)).collect();
        let arms = arms.filter_map(|(index, arm)| Some((name(index), arm.as_ref()?)));
        Self {
            robots: arms
                .map(|(name, arm)| ArmFitReport::new(name, arm))
                .collect(),
            without_moves,
            unused: 0,
            ignored_columns: Vec::new(),
            made,
        }
    }

    /// The same for a source of which this number of rows could not be used and these columns were
    /// ignored.
    #[must_use]
    pub fn of_source(self, unused: usize, ignored_columns: Vec<String>) -> Self {
        Self {
            unused,
            ignored_columns,
            ..self
        }
    }
}

impl ArmFitReport {
    fn new(name: String, fit: &ArmFit) -> Self {
        let points = match &fit.arm.law {
            TravelLaw::Table(points) => points.as_slice(),
            _ => &[],
        };
        let table = points.iter().zip(&fit.table).enumerate();
        let outliers = fit.residuals.iter().filter(|residual| residual.is_outlier);
        let mut outlier_lines: Vec<u64> = outliers.map(|residual| residual.line).collect();
        outlier_lines.dedup();
        Self {
            name,
            law: fit.law.name(),
            moves: fit.moves,
            times: fit.residuals.len(),
            outliers: fit.outliers(),
            outlier_share: fit.outliers() as f64 / fit.residuals.len().max(1) as f64,
            outlier_lines,
            scale_s: fit.scale,
            stamp_step_s: fit.step,
            error: PredictionReport::new(fit.error),
            error_without_outliers: PredictionReport::new(fit.error_without_outliers),
            parameters: fit.parameters.iter().map(ParameterReport::new).collect(),
            table: table
                .map(
                    |(index, (&(length_m, time_s), &interval))| TablePointReport {
                        length_m,
                        time_s,
                        interval,
                        extrapolated: !fit.measured.contains(&index),
                    },
                )
                .collect(),
            notes: fit.notes.clone(),
            residuals: fit.residuals.iter().map(ResidualReport::new).collect(),
        }
    }
}

impl PredictionReport {
    fn new(error: FitError) -> Self {
        Self {
            median_s: error.median,
            p95_s: error.worst,
            held_out: error.count,
        }
    }
}

impl TablePointReport {
    /// What a reader must know about the point; may be empty.
    pub(super) fn remark(&self) -> &'static str {
        match self.extrapolated {
            true => "extrapolated from its neighbours, not measured",
            false => "",
        }
    }
}

impl ParameterReport {
    fn new(parameter: &FittedParameter) -> Self {
        Self {
            name: parameter.name.clone(),
            unit: parameter.unit,
            value: parameter.value,
            interval: parameter.interval,
            remark: parameter.remark.clone(),
        }
    }
}

impl ResidualReport {
    fn new(residual: &MoveResidual) -> Self {
        Self {
            line: residual.line,
            leg: residual.leg,
            way_m: residual.way,
            time_s: residual.time,
            residual_s: Some(residual.residual).filter(|value| value.is_finite()),
            outlier: residual.is_outlier,
        }
    }
}
