//! The estimate of one arm's law: which parameters the times determine, and which law fits.

use super::determined::{
    EXCLUDED, WORTH, depends_on_speed, is_determined, is_limit_told, is_speed_told, median_reach,
    never_cruising, undetermined,
};
use super::model::{
    DWELL, GRASP, LIFT, Leg, Observation, Parameters, RAMP, SLOWNESS, longest_path,
};
use super::options::{FitLaw, FitOptions};
use super::robust::{Estimate, TUKEY, Task, median};

/// The lowest speed that is not excluded is sought to this share of the highest one.
const LEAST_SPEED_STEP: f64 = 5e-4;

/// The estimate of a law with parameters, and what it rests on.
#[derive(Debug, Clone)]
pub(super) struct LawEstimate {
    pub estimate: Estimate,
    /// The indices of the parameters that were estimated.
    pub free: Vec<usize>,
    /// Whether the lift could be told apart from the rest.
    pub has_lift: bool,
    /// The parameters with the lowest top speed that is not excluded, if no move tells it.
    pub slowest: Option<Parameters>,
    /// Whether the arm accelerates.
    pub accelerates: bool,
    /// The indices of free parameters that the observations do not determine, because they can be
    /// traded for each other or for the lift.
    pub undetermined: Vec<usize>,
}

impl LawEstimate {
    /// The same law with other parameters.
    pub(super) fn with(&self, parameters: Parameters) -> Self {
        Self {
            estimate: Estimate {
                parameters,
                ..self.estimate
            },
            ..self.clone()
        }
    }

    /// The same law with other values that the times do not exclude: with the parameter of this index
    /// moved by `rounding` either way, and at the lowest top speed.
    pub(super) fn not_excluded(&self, index: usize, rounding: f64) -> Vec<Self> {
        let moved = [-rounding, rounding].map(|by| {
            let mut parameters = self.estimate.parameters.clone();
            parameters[index] = (parameters[index] + by).max(0.0);
            self.with(parameters)
        });
        let slowest = self.slowest.clone();
        moved
            .into_iter()
            .chain(slowest.map(|parameters| self.with(parameters)))
            .collect()
    }
}

/// What the parameters are if the times do not say it.
#[derive(Debug, Clone)]
pub(super) struct Prior {
    pub parameters: Parameters,
    /// The bins that something was put into.
    pub bins: Vec<usize>,
    /// Whether a failed grasp tells the grasp time.
    pub has_grasp: bool,
    /// Step of the stamps [s]; 0 if they have none.
    pub step: f64,
}

/// Estimates the law of an arm from its observations.
///
/// Parameters that the observations do not determine keep their prior values: first the lift, which
/// is confounded with the acceleration if all moves are long, and with the dwell if nobody says when
/// the grasp began; the top speed, if no move is long enough to reach it. A constant speed that was
/// not asked for is determined only if an arm that never reaches its top speed fits worse.
pub(super) fn estimate_law(
    observations: &[Observation],
    prior: &Prior,
    options: &FitOptions,
) -> Option<LawEstimate> {
    let mut law = best_law(observations, prior, options)?;
    if law.accelerates {
        return Some(law);
    }
    let free = law.free.clone();
    let task = Task {
        observations,
        free: &free,
        step: prior.step,
    };
    let is_asked_for = options.law == FitLaw::Speed;
    let is_told = || is_asked_for || is_limit_told(&task, &law.estimate, options.lift.is_some());
    if !law.undetermined.contains(&SLOWNESS) && !is_told() {
        law.undetermined.push(SLOWNESS);
    }
    if law.undetermined.contains(&SLOWNESS)
        && let Some(estimate) = at_prior_speed(&task, &law.estimate, prior)
    {
        law.estimate = estimate;
        law.free.retain(|index| *index != SLOWNESS);
    }
    Some(law)
}

/// The estimate with the speed of the prior, if the times fit that as well as any other: one of
/// many that can be traded for the dwell would not be plausible.
fn at_prior_speed(task: &Task, estimate: &Estimate, prior: &Prior) -> Option<Estimate> {
    let others = task.free.iter().copied();
    let others: Vec<usize> = others.filter(|index| *index != SLOWNESS).collect();
    let task = Task {
        free: &others,
        ..*task
    };
    let mut start = estimate.parameters.clone();
    start[SLOWNESS] = prior.parameters[SLOWNESS];
    let at_prior = task.refine(&with_median_dwells(&task, start), estimate.scale);
    let mut start = prior.parameters.clone();
    start[RAMP] = 0.0;
    let from_prior = task.refine(&with_median_dwells(&task, start), estimate.scale);
    let best = match from_prior.loss < at_prior.loss {
        true => from_prior,
        false => at_prior,
    };
    (best.loss - estimate.loss <= WORTH).then_some(best)
}

/// The parameters with dwells and grasp time, where they are free, moved by the median residual: far
/// from the times, the loss says nothing of which way is better.
fn with_median_dwells(task: &Task, mut parameters: Parameters) -> Parameters {
    let residuals = task.residuals(&parameters);
    for &index in task.free.iter().filter(|index| **index >= GRASP) {
        let depends = |leg: &Leg| match leg.bin() {
            Some(bin) => DWELL + bin == index,
            None => index == GRASP && matches!(leg, Leg::Chase(_)),
        };
        let own = task.observations.iter().zip(&residuals);
        let own = own.filter(|(observation, _)| depends(&observation.leg));
        let own: Vec<f64> = own.map(|(_, residual)| *residual).collect();
        if !own.is_empty() {
            parameters[index] = (parameters[index] + median(own)).max(0.0);
        }
    }
    parameters
}

fn best_law(
    observations: &[Observation],
    prior: &Prior,
    options: &FitOptions,
) -> Option<LawEstimate> {
    let lift_is_free = options.lift.is_none();
    // Whether the times fit `one` better than `other` by more than one parameter would by chance.
    let is_better = |one: &LawEstimate, other: &LawEstimate| {
        let task = Task {
            observations,
            free: &other.free,
            step: prior.step,
        };
        let same = task.refine(&other.estimate.parameters, one.estimate.scale);
        same.loss - one.estimate.loss > WORTH
    };
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
            if is_better(&trapezoid, &constant) {
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
            let mut known = match is_better(&ramped, &plain) {
                true => ramped,
                false => plain,
            };
            // Times that tell the lift of a constant speed tell the speed without it.
            let is_told = !constant.undetermined.contains(&SLOWNESS);
            known
                .undetermined
                .retain(|index| known.accelerates || *index != SLOWNESS || !is_told);
            // Unless the times are too short for that lift.
            if is_better(&constant, &known) {
                Some(constant)
            } else {
                Some(known)
            }
        }
    }
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
            step: prior.step,
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
            let lift = (has_lift, lift_is_known);
            return Some(without_speed(&task, &estimate, lift, undetermined));
        }
        return Some(LawEstimate {
            estimate,
            free,
            has_lift,
            slowest: None,
            accelerates,
            undetermined,
        });
    }
}

/// The estimate of an arm whose top speed no move tells, with the lowest that the observations do not
/// exclude, by the profile of the loss. A lift that is not known may be any in it.
fn without_speed(
    task: &Task,
    estimate: &Estimate,
    (has_lift, lift_is_known): (bool, bool),
    mut undetermined: Vec<usize>,
) -> LawEstimate {
    let (free, unlimited) = never_cruising(task, estimate);
    let residuals = task.residuals(&unlimited.parameters);
    let inliers = task.observations.iter().zip(&residuals);
    let inliers = inliers.filter(|(_, r)| r.abs() < TUKEY * unlimited.scale);
    let lengths = inliers.map(|(o, _)| longest_path(&unlimited.parameters, &o.leg).0);
    let longest = lengths.fold(0.0, f64::max);
    let peak = (2.0 * longest / unlimited.parameters[RAMP]).sqrt();
    let mut varied = free.clone();
    if !lift_is_known {
        varied.push(LIFT);
    }
    let limited = Task {
        free: &varied,
        ..*task
    };
    let start = &unlimited.parameters;
    let least_loss = limited.refine(start, unlimited.scale).loss;
    let with_speed = |start: &[f64], speed: f64| {
        let mut start = start.to_vec();
        start[SLOWNESS] = 1.0 / speed;
        limited.refine(&start, unlimited.scale)
    };
    let mut slowest = with_speed(start, peak).parameters;
    let mut step = 0.02 * peak;
    for _ in 0..60 {
        let speed = 1.0 / slowest[SLOWNESS] - step;
        if speed <= 0.0 || step < LEAST_SPEED_STEP * peak {
            break;
        }
        let slower = with_speed(&slowest, speed);
        match slower.loss - least_loss > EXCLUDED {
            true => step *= 0.5,
            false => slowest = slower.parameters,
        }
    }
    let traded = free.iter().copied().filter(|index| {
        !undetermined.contains(index) && depends_on_speed(task, start, &slowest, *index)
    });
    let traded: Vec<usize> = traded.collect();
    undetermined.extend(traded);
    LawEstimate {
        estimate: unlimited,
        free,
        has_lift,
        slowest: Some(slowest),
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
