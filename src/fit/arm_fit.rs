//! The fit of one arm: its law, its dwell times, and how well they reproduce the recorded times.
//! `bench.rs` has its parts, `describe.rs` makes figures with intervals of it, and `remarks.rs` says
//! what is doubtful about them.

use super::arm_result::{ArmFit, FittedLaw, MoveResidual};
use super::bench::{Bench, Fitted, LEAST_MOVES};
use super::intervals::resampled;
use super::model::Observation;
use super::options::FitOptions;
use super::remarks::remarks;
use super::resolution::step_of;
use super::robust::{TUKEY, median, scale_of};
use super::timed_move::TimedMove;
use crate::error::{Error, Result};
use crate::station::Robot;

/// A larger share of outliers is no longer one of outliers.
const MOST_OUTLIERS: f64 = 0.3;

/// Fits the law of `robot`, which has this index, to its moves.
///
/// # Errors
/// Too few moves, a table for times that none can be made of, or times that follow no law.
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
    if median(observations.iter().map(|o| o.time).collect()) <= 0.0 {
        return Err(Error::input(
            format!("robot `{}`", robot.name),
            "half of its times or more are 0",
            "check that the stamps of departure, grasp and release are those of different moments",
        ));
    }
    let step = step_of(moves);
    let size = (moves.len(), step.unwrap_or(0.0));
    let bench = Bench::new(robot, observations, size, options)?;
    let choice = bench.choose()?;
    let fitted = &choice.fitted;
    let residual = |o: &Observation| o.time - bench.predicted(fitted, o);
    let known: Vec<f64> = bench.observations.iter().map(residual).collect();
    let finite: Vec<f64> = known.iter().copied().filter(|r| r.is_finite()).collect();
    let scale = match fitted {
        Fitted::Law(law) => law.estimate.scale,
        Fitted::Table(..) => scale_of(&finite, bench.prior.step),
    };
    let timed = bench.observations.iter().zip(&known);
    let residuals: Vec<MoveResidual> = timed
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
            format!("robot `{}`", bench.robot.name),
            format!(
                "{outliers} of {} times are far from any law ({} % at most are outliers)",
                residuals.len(),
                100.0 * MOST_OUTLIERS
            ),
            "check that places, times and their units belong together, or that this is the \
             station",
        ));
    }
    let drawn = (bench.options.resamples, bench.options.seed);
    let resamples = resampled(&bench.observations, bench.rows, drawn, |observations| {
        bench.refit(fitted, observations)
    });
    let [error, error_without_outliers] = bench.held_out(fitted, &residuals);
    let mut fit = ArmFit {
        robot: index,
        moves: moves.len(),
        law: FittedLaw::Table,
        arm: bench.robot.arm.clone(),
        grasp_time: 0.0,
        release_times: Vec::new(),
        parameters: Vec::new(),
        table: Vec::new(),
        measured: 0..0,
        scale,
        step,
        error,
        error_without_outliers,
        residuals,
        notes: Vec::new(),
    };
    match fitted {
        Fitted::Law(law) => bench.describe_law(&mut fit, law, &resamples),
        Fitted::Table(table, _) => bench.describe_table(&mut fit, table, &resamples),
    }
    fit.notes.extend(remarks(&bench, &fit, choice.rejected));
    Ok(fit)
}
