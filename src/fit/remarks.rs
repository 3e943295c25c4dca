//! What a reader must know about the figures of a fit as a whole.

use super::arm_result::{ArmFit, FittedLaw};
use super::bench::Bench;
use super::model::Observation;
use super::options::FitLaw;
use super::robust::median;
use super::table::no_table_because;
use crate::error::rounded;
use crate::station::Robot;
use crate::stats::quantile;

/// A law whose median error is a larger share of the median time explains little.
const POOR: f64 = 0.1;

/// The remarks on a `fit`, whose law was `rejected` or not.
pub(super) fn remarks(bench: &Bench, fit: &ArmFit, rejected: bool) -> Vec<String> {
    let observations = &bench.observations;
    let mut remarks = Vec::new();
    if fit.law != FittedLaw::Table && rejected {
        let mut text =
            "the law does not fit: the residuals depend on the length of the way".to_owned();
        if bench.options.law == FitLaw::Auto {
            text += &format!(
                "; no table is fitted, because {}",
                no_table_because(observations)
            );
        }
        remarks.push(text);
    }
    if let Some(step) = fit.step {
        let step = milliseconds(step);
        remarks.push(format!(
            "all stamps are multiples of {step} ms, apart from one shift: a time may be off by that \
             much, and intervals allow for it; finer stamps would tell more"
        ));
    }
    if let Some(text) = alike(bench, fit) {
        remarks.push(text);
    }
    if let Some(text) = poor(observations, fit) {
        remarks.push(text);
    }
    let fitted = Robot {
        arm: fit.arm.clone(),
        ..bench.robot.clone()
    };
    let doubts = fitted.check_arm("").into_iter().map(|doubt| {
        format!(
            "{}: do the times grow with the lengths of the ways ('chart' times), and are both in the \
             right unit?",
            doubt.problem
        )
    });
    remarks.extend(doubts);
    remarks
}

/// That the ways are too much alike, if they do not tell the top speed and the acceleration.
fn alike(bench: &Bench, fit: &ArmFit) -> Option<String> {
    let is_unknown = |name: &str| {
        let mut named = fit.parameters.iter().filter(|p| p.name == name);
        named.all(|p| p.value.is_none() && p.interval.is_none())
    };
    if fit.law == FittedLaw::Table || !is_unknown("speed") {
        return None;
    }
    let mut ways: Vec<f64> = bench.observations.iter().map(|o| o.leg.reach()).collect();
    ways.sort_unstable_by(f64::total_cmp);
    Some(format!(
        "speed and acceleration are unknown: the ways, most of them {} to {} m long, are too much \
         alike, or their times too scattered; the fitted arm holds for such ways only; record shorter \
         and longer ones, or give 'law' and 'lift' if they are known",
        rounded(quantile(&ways, 0.05), 3),
        rounded(quantile(&ways, 0.95), 3)
    ))
}

/// That the law explains little, if it does, and rounded stamps are not why.
fn poor(observations: &[Observation], fit: &ArmFit) -> Option<String> {
    let typical = median(observations.iter().map(|o| o.time).collect());
    let error = fit.error.median;
    let is_rounding = fit.step.is_some_and(|step| error <= step);
    (error > POOR * typical && !is_rounding).then(|| {
        format!(
            "the law explains little: half of the times are off by {} ms or more, and the median time \
             is {} ms; see the times over the lengths ('chart' times): are from, meet and bin of a row \
             of the same move, all in the axes of the station, and does depart_s say when the arm \
             leaves, not when it is told to?",
            milliseconds(error),
            milliseconds(typical)
        )
    })
}

fn milliseconds(seconds: f64) -> String {
    rounded(1e3 * seconds, 3)
}
