//! What observations determine: which parameters of a law they tell, and which can be traded for
//! others.

use super::model::{LIFT, Leg, Observation, RAMP, SLOWNESS, longest_path, predict};
use super::robust::{Estimate, SINGULAR, TUKEY, Task, median};
use nalgebra::DMatrix;

/// A parameter more must lower the loss by this: half of what twice the logarithm of the likelihood
/// ratio exceeds by chance with a probability of 0.001 (Wilks 1938, DOI 10.1214/aoms/1177732360).
pub(super) const WORTH: f64 = 0.5 * 10.828;
/// What a value may cost that is not excluded: half of what twice the logarithm of the likelihood
/// ratio exceeds by chance with a probability of 0.05 (Wilks 1938, DOI 10.1214/aoms/1177732360).
pub(super) const EXCLUDED: f64 = 0.5 * 3.841;
/// Least number of observations at top speed for which it can be told.
const LEAST_CRUISING: usize = 5;
/// A parameter whose standard error is more than this share of it is not determined.
const LARGEST_ERROR: f64 = 0.5;
/// What rounded stamps may move a parameter by, in its standard errors, where both count alike: the
/// half of a 95 % interval.
const ROUNDING_ERRORS: f64 = 1.96;
/// A larger share of a parameter in what can be traded is more than rounding.
const TRADED: f64 = 1e-6;
/// Standard errors up to this ratio are alike.
const SAME_ERROR: f64 = 1.5;

/// The same estimate of an arm that never reaches its top speed.
pub(super) fn never_cruising(task: &Task, estimate: &Estimate) -> (Vec<usize>, Estimate) {
    let free: Vec<usize> = task
        .free
        .iter()
        .copied()
        .filter(|i| *i != SLOWNESS)
        .collect();
    let mut start = estimate.parameters.clone();
    start[SLOWNESS] = 0.0;
    let slower = Task {
        free: &free,
        ..*task
    };
    let refined = slower.refine(&start, estimate.scale);
    (free, refined)
}

/// Whether the observations tell the top speed: several moves reach it, and an arm without a limit
/// fits worse than by chance.
pub(super) fn is_speed_told(task: &Task, estimate: &Estimate) -> bool {
    let residuals = task.residuals(&estimate.parameters);
    let inliers = task.observations.iter().zip(&residuals);
    let inliers = inliers.filter(|(_, r)| r.abs() < TUKEY * estimate.scale);
    let cruising = inliers.filter(|(o, _)| longest_path(&estimate.parameters, &o.leg).1);
    let unlimited = never_cruising(task, estimate).1;
    cruising.count() >= LEAST_CRUISING && unlimited.loss - estimate.loss > WORTH
}

/// Whether the observations tell a constant speed: an arm that never reaches a top speed fits worse
/// than by chance, whatever its lift, unless that is known.
pub(super) fn is_limit_told(task: &Task, constant: &Estimate, lift_is_known: bool) -> bool {
    let mut free: Vec<usize> = task.free.to_vec();
    free.retain(|index| *index != SLOWNESS && *index != LIFT);
    free.push(RAMP);
    if !lift_is_known {
        free.push(LIFT);
    }
    let ramped = Task {
        free: &free,
        ..*task
    };
    let reach = median_reach(task.observations);
    let mut slopes = vec![0.0; constant.parameters.len()];
    let time = predict(&constant.parameters, &Leg::Out(reach), &mut slopes);
    let lifts = [constant.parameters[LIFT], 0.2 * reach, reach, 4.0 * reach];
    let losses = lifts[..if lift_is_known { 1 } else { 4 }]
        .iter()
        .map(|lift| {
            let mut start = constant.parameters.clone();
            start[SLOWNESS] = 0.0;
            start[RAMP] = 0.5 * time * time / (reach + lift).max(1e-6);
            start[LIFT] = *lift;
            ramped.refine(&start, constant.scale).loss
        });
    losses.fold(f64::INFINITY, f64::min) - constant.loss > WORTH
}

/// The free parameters that the observations do not determine. Without a known lift these are also the
/// acceleration, and the dwell unless the ways out tell it from the ways back.
pub(super) fn undetermined(task: &Task, estimate: &Estimate, lift_is_known: bool) -> Vec<usize> {
    let time = median_time(task.observations);
    let has_out = task
        .observations
        .iter()
        .any(|o| matches!(o.leg, Leg::Out(_)));
    let is_doubtful = |&index: &usize| match index {
        // Judged before.
        LIFT => false,
        SLOWNESS => !is_slope_determined(task, estimate, lift_is_known),
        RAMP => !lift_is_known || !is_determined(task, estimate, RAMP, 0.0),
        _ => (!lift_is_known && !has_out) || !is_determined(task, estimate, index, time),
    };
    task.free.iter().copied().filter(is_doubtful).collect()
}

/// Whether the observations determine the top speed, once it is reached: how the times grow with the
/// lengths. A lift that is not known, and was left out because it is not determined, may be any: if
/// the speed is known less well with it, it rests on a guess.
fn is_slope_determined(task: &Task, estimate: &Estimate, lift_is_known: bool) -> bool {
    if !is_determined(task, estimate, SLOWNESS, 0.0) {
        return false;
    }
    if lift_is_known || task.free.contains(&RAMP) {
        return true;
    }
    let mut free = task.free.to_vec();
    free.push(LIFT);
    let lifted = Task {
        free: &free,
        ..*task
    };
    let error = |task: &Task| {
        let place = task.free.iter().position(|index| *index == SLOWNESS)?;
        standard_error(&task.information(estimate), place, estimate.scale)
    };
    let errors = error(task).zip(error(&lifted));
    errors.is_some_and(|(fixed, free)| free <= SAME_ERROR * fixed)
}

/// Whether the value of this parameter at the lowest top speed that is not excluded is another one
/// than at the highest.
pub(super) fn depends_on_speed(
    task: &Task,
    unlimited: &[f64],
    slowest: &[f64],
    index: usize,
) -> bool {
    let size = match index {
        RAMP => 0.0,
        LIFT => median_reach(task.observations),
        _ => median_time(task.observations),
    };
    let largest = LARGEST_ERROR * unlimited[index].max(size);
    (slowest[index] - unlimited[index]).abs() > largest
}

/// Whether the observations determine this parameter: its standard error is at most half of `size`,
/// or of its value if that is larger.
pub(super) fn is_determined(task: &Task, estimate: &Estimate, index: usize, size: f64) -> bool {
    let Some(place) = task.free.iter().position(|&free| free == index) else {
        return true;
    };
    let information = task.information(estimate);
    let Some(error) = standard_error(&information, place, estimate.scale) else {
        return false;
    };
    let rounding = task.rounding(estimate)[place] / ROUNDING_ERRORS;
    error.max(rounding) <= LARGEST_ERROR * estimate.parameters[index].max(size)
}

/// The standard error of the parameter at `place` in the information matrix; none if it has no
/// influence, or can be traded for others. Of others that can be traded for each other it may be
/// independent.
fn standard_error(information: &DMatrix<f64>, place: usize, scale: f64) -> Option<f64> {
    let diagonal = information.diagonal();
    let largest = diagonal.max();
    let kept: Vec<usize> = (0..diagonal.len())
        .filter(|&i| diagonal[i] > 1e-12 * largest)
        .collect();
    let own = kept.iter().position(|&i| i == place)?;
    let unit = |i: usize, j: usize| {
        let (a, b) = (kept[i], kept[j]);
        information[(a, b)] / (diagonal[a] * diagonal[b]).sqrt()
    };
    let scaled = DMatrix::from_fn(kept.len(), kept.len(), unit);
    let eigen = scaled.symmetric_eigen();
    let mut variance = 0.0;
    for (k, value) in eigen.eigenvalues.iter().enumerate() {
        let share = eigen.eigenvectors[(own, k)].powi(2);
        match *value < SINGULAR {
            true if share > TRADED => return None,
            true => {}
            false => variance += share / value,
        }
    }
    Some(scale * (variance / diagonal[place]).sqrt())
}

pub(super) fn median_reach(observations: &[Observation]) -> f64 {
    median(observations.iter().map(|o| o.leg.reach()).collect())
}

fn median_time(observations: &[Observation]) -> f64 {
    median(observations.iter().map(|o| o.time).collect())
}
