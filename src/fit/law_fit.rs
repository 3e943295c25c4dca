//! The estimate of one arm's law: which parameters the times determine, and which law fits.

use super::model::{
    DWELL, GRASP, LIFT, Leg, Observation, Parameters, RAMP, SLOWNESS, longest_path,
};
use super::options::{FitLaw, FitOptions};
use super::robust::{Estimate, TUKEY, Task, median};
use nalgebra::DMatrix;

/// Least number of observations at top speed for which it can be told.
const LEAST_CRUISING: usize = 5;
/// A parameter more must lower the loss by this: half of what twice the logarithm of the likelihood
/// ratio exceeds by chance with a probability of 0.001 (Wilks 1938, DOI 10.1214/aoms/1177732360).
const WORTH: f64 = 0.5 * 10.828;
/// The same for a probability of 0.05: what a value may cost that is not excluded.
const EXCLUDED: f64 = 0.5 * 3.841;
/// A parameter whose standard error is more than this share of it is not determined.
const LARGEST_ERROR: f64 = 0.5;

/// The estimate of a law with parameters, and what it rests on.
#[derive(Debug, Clone)]
pub(super) struct LawEstimate {
    pub estimate: Estimate,
    /// The indices of the parameters that were estimated.
    pub free: Vec<usize>,
    /// Whether the lift could be told apart from the rest.
    pub has_lift: bool,
    /// What the top speed is at least [m/s], if it is not known because no move tells it.
    pub least_speed: Option<f64>,
    /// Whether the arm accelerates.
    pub accelerates: bool,
    /// The indices of free parameters that the observations do not determine, because they can be
    /// traded for each other or for the lift.
    pub undetermined: Vec<usize>,
}

/// What the parameters are if the times do not say it.
#[derive(Debug, Clone)]
pub(super) struct Prior {
    pub parameters: Parameters,
    /// The bins that something was put into.
    pub bins: Vec<usize>,
    /// Whether a failed grasp tells the grasp time.
    pub has_grasp: bool,
}

/// Estimates the law of an arm from its observations.
///
/// Parameters that the observations do not determine keep their prior values: first the lift, which
/// is confounded with the acceleration if all moves are long, and with the dwell if nobody says when
/// the grasp began; the top speed, if no move is long enough to reach it.
pub(super) fn estimate_law(
    observations: &[Observation],
    prior: &Prior,
    options: &FitOptions,
) -> Option<LawEstimate> {
    let lift_is_free = options.lift.is_none();
    let estimate = |accelerates, lift_is_free| {
        estimate_as(observations, prior, options, (accelerates, lift_is_free))
    };
    match options.law {
        FitLaw::Speed => estimate(false, lift_is_free),
        FitLaw::Trapezoid => estimate(true, lift_is_free),
        FitLaw::Auto | FitLaw::Table => {
            let pair = |is_free| (estimate(false, is_free), estimate(true, is_free));
            let (constant, trapezoid) = match pair(lift_is_free) {
                (Some(constant), Some(trapezoid)) => (constant, trapezoid),
                (constant, trapezoid) => return trapezoid.or(constant),
            };
            if is_better(observations, &trapezoid, &constant) {
                return Some(trapezoid);
            }
            if !constant.has_lift {
                return Some(constant);
            }
            // At top speed, a lift and a ramp add the same time to every move, so a free lift takes
            // up the ramp. With the lift that is known of the arm, the rest is its ramp.
            let (Some(plain), Some(ramped)) = pair(false) else {
                return Some(constant);
            };
            let known = if is_better(observations, &ramped, &plain) {
                ramped
            } else {
                plain
            };
            // Unless the times are too short for that lift.
            if is_better(observations, &constant, &known) {
                Some(constant)
            } else {
                Some(known)
            }
        }
    }
}

/// Whether the times fit `one` better than `other` by more than one parameter would by chance.
fn is_better(observations: &[Observation], one: &LawEstimate, other: &LawEstimate) -> bool {
    let task = Task {
        observations,
        free: &other.free,
    };
    let same = task.refine(&other.estimate.parameters, one.estimate.scale);
    same.loss - one.estimate.loss > WORTH
}

fn estimate_as(
    observations: &[Observation],
    prior: &Prior,
    options: &FitOptions,
    (accelerates, lift_is_free): (bool, bool),
) -> Option<LawEstimate> {
    let mut has_lift = lift_is_free;
    loop {
        let free = free_parameters(prior, accelerates, has_lift);
        let task = Task {
            observations,
            free: &free,
        };
        let starts = starts(observations, prior, accelerates, has_lift);
        let estimate = task.solve(&starts)?;
        if has_lift && !is_determined(&task, &estimate, LIFT, median_reach(observations)) {
            has_lift = false;
            continue;
        }
        let lift_is_known = has_lift || options.lift.is_some();
        let undetermined = undetermined(&task, &estimate, lift_is_known);
        let told = !accelerates || is_speed_told(&task, &estimate);
        if !told {
            return Some(without_speed(&task, &estimate, has_lift, undetermined));
        }
        return Some(LawEstimate {
            estimate,
            free,
            has_lift,
            least_speed: None,
            accelerates,
            undetermined,
        });
    }
}

/// The same estimate of an arm that never reaches its top speed.
fn never_cruising(task: &Task, estimate: &Estimate) -> (Vec<usize>, Estimate) {
    let free: Vec<usize> = task
        .free
        .iter()
        .copied()
        .filter(|i| *i != SLOWNESS)
        .collect();
    let mut start = estimate.parameters.clone();
    start[SLOWNESS] = 0.0;
    let slower = Task {
        observations: task.observations,
        free: &free,
    };
    let refined = slower.refine(&start, estimate.scale);
    (free, refined)
}

/// Whether the observations tell the top speed: several moves reach it, and an arm without a limit
/// fits worse than by chance.
fn is_speed_told(task: &Task, estimate: &Estimate) -> bool {
    let residuals = task.residuals(&estimate.parameters);
    let inliers = task.observations.iter().zip(&residuals);
    let inliers = inliers.filter(|(_, r)| r.abs() < TUKEY * estimate.scale);
    let cruising = inliers.filter(|(o, _)| longest_path(&estimate.parameters, &o.leg).1);
    let unlimited = never_cruising(task, estimate).1;
    cruising.count() >= LEAST_CRUISING && unlimited.loss - estimate.loss > WORTH
}

/// The estimate of an arm whose top speed no move tells, with what it is at least: the lowest speed
/// that the observations do not exclude, by the profile of the loss.
fn without_speed(
    task: &Task,
    estimate: &Estimate,
    has_lift: bool,
    undetermined: Vec<usize>,
) -> LawEstimate {
    let (free, unlimited) = never_cruising(task, estimate);
    let residuals = task.residuals(&unlimited.parameters);
    let inliers = task.observations.iter().zip(&residuals);
    let inliers = inliers.filter(|(_, r)| r.abs() < TUKEY * unlimited.scale);
    let lengths = inliers.map(|(o, _)| longest_path(&unlimited.parameters, &o.leg).0);
    let longest = lengths.fold(0.0, f64::max);
    let peak = (2.0 * longest / unlimited.parameters[RAMP]).sqrt();
    let limited = Task {
        observations: task.observations,
        free: &free,
    };
    let mut least_speed = peak;
    for step in 1..50 {
        let speed = peak * (1.0 - 0.02 * f64::from(step));
        let mut start = unlimited.parameters.clone();
        start[SLOWNESS] = 1.0 / speed;
        if limited.refine(&start, unlimited.scale).loss - unlimited.loss > EXCLUDED {
            break;
        }
        least_speed = speed;
    }
    LawEstimate {
        estimate: unlimited,
        free,
        has_lift,
        least_speed: Some(least_speed),
        accelerates: true,
        undetermined,
    }
}

fn free_parameters(prior: &Prior, accelerates: bool, has_lift: bool) -> Vec<usize> {
    let mut free = vec![SLOWNESS];
    if accelerates {
        free.push(RAMP);
    }
    if has_lift {
        free.push(LIFT);
    }
    if prior.has_grasp {
        free.push(GRASP);
    }
    free.extend(prior.bins.iter().map(|bin| DWELL + bin));
    free
}

/// The free parameters that the observations do not determine. Without a known lift these are also the
/// acceleration, and the dwell unless the ways out tell it from the ways back.
fn undetermined(task: &Task, estimate: &Estimate, lift_is_known: bool) -> Vec<usize> {
    let times = task.observations.iter().map(|o| o.time).collect();
    let time = median(times);
    let has_out = task
        .observations
        .iter()
        .any(|o| matches!(o.leg, Leg::Out(_)));
    let is_doubtful = |&index: &usize| match index {
        // The top speed is judged by how many moves reach it.
        SLOWNESS | LIFT => false,
        RAMP => !lift_is_known || !is_determined(task, estimate, RAMP, 0.0),
        _ => (!lift_is_known && !has_out) || !is_determined(task, estimate, index, time),
    };
    task.free.iter().copied().filter(is_doubtful).collect()
}

/// Whether the observations determine this parameter: its standard error is at most half of `size`,
/// or of its value if that is larger.
fn is_determined(task: &Task, estimate: &Estimate, index: usize, size: f64) -> bool {
    let Some(place) = task.free.iter().position(|&free| free == index) else {
        return true;
    };
    let information = task.information(estimate);
    let Some(error) = standard_error(&information, place, estimate.scale) else {
        return false;
    };
    error <= LARGEST_ERROR * estimate.parameters[index].max(size)
}

/// The standard error of the parameter at `place` in the information matrix; none if the matrix is
/// singular, in units in which its diagonal is 1, but for parameters without any influence.
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
    let eigen = scaled.clone().symmetric_eigen();
    if eigen.eigenvalues.min() < 1e-9 {
        return None;
    }
    let inverse = scaled.try_inverse()?;
    Some(scale * (inverse[(own, own)] / diagonal[place]).sqrt())
}

fn median_reach(observations: &[Observation]) -> f64 {
    median(observations.iter().map(|o| o.leg.reach()).collect())
}

/// Where the search begins: the prior, and arms that take the median time for the median way, all
/// of it at top speed, half of it, or none.
fn starts(
    observations: &[Observation],
    prior: &Prior,
    accelerates: bool,
    has_lift: bool,
) -> Vec<Parameters> {
    let mut plain = prior.parameters.clone();
    plain[RAMP] = 0.0;
    let legs = |o: &&Observation| o.leg.bin().is_none();
    let outs: Vec<&Observation> = observations.iter().filter(legs).collect();
    let basis = if outs.is_empty() {
        observations.iter().collect()
    } else {
        outs
    };
    let reach = median(basis.iter().map(|o| o.leg.reach()).collect()).max(1e-3);
    let dwell = |o: &Observation| o.leg.bin().map_or(0.0, |bin| plain[DWELL + bin]);
    let ways = |o: &Observation| match o.leg.bin() {
        Some(_) if !matches!(o.leg, Leg::Back(..)) => 2.0,
        _ => 1.0,
    };
    let time = median(
        basis
            .iter()
            .map(|o| (o.time - dwell(o)) / ways(o))
            .collect(),
    );
    let time = time
        .max(0.1 * median(basis.iter().map(|o| o.time).collect()))
        .max(1e-4);
    let mut starts = Vec::new();
    let lifts = [prior.parameters[LIFT], 0.2 * reach];
    for &lift in &lifts[..if has_lift { 2 } else { 1 }] {
        let length = reach + lift;
        let slowness = time / length;
        let mut push = |slowness: f64, ramp: f64| {
            let mut start = prior.parameters.clone();
            start[SLOWNESS] = slowness;
            start[RAMP] = if accelerates { ramp } else { 0.0 };
            start[LIFT] = lift;
            starts.push(start);
        };
        push(slowness, 0.02 * time * slowness);
        if accelerates {
            // Half of the time at top speed.
            push(0.5 * slowness, 0.5 * time * slowness);
            // Top speed is reached only just, or never.
            let ramp = 0.5 * time * time / length;
            push((0.5 * ramp / length).sqrt(), ramp);
            push(0.3 * (0.5 * ramp / length).sqrt(), ramp);
        }
    }
    starts.push(match accelerates {
        true => prior.parameters.clone(),
        false => plain,
    });
    starts
}
