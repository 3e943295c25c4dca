//! Values of a parameter that the times do not exclude, by the profile of the loss: the parameter is
//! moved until the best fit with all others free is worse than chance allows (Venzon and Moolgavkar
//! 1988, DOI 10.2307/2347496).
//!
//! Near the speed that is only just reached, the times say much less of higher speeds than of lower
//! ones. Resamples around one estimate show that only in part; the profile does.

use super::determined::EXCLUDED;
use super::law_fit::LawEstimate;
use super::model::{LIFT, Parameters, RAMP, SLOWNESS};
use super::robust::{Estimate, Task};

/// The first step away from the estimate, as a share of the parameter,
const FIRST_STEP: f64 = 0.005;
/// and if that is less [s, m, s/m or s^2/m].
const LEAST_STEP: f64 = 1e-4;
/// The steps double so often at most: by far enough for any value.
const MOST_DOUBLINGS: usize = 24;
/// Bisections of the last step.
const BISECTIONS: usize = 8;

/// The fits to a task with one parameter held.
pub(super) struct Profile<'a> {
    task: Task<'a>,
    best: Estimate,
    /// Where a search begins that found nothing from the neighbouring value on: at the lowest top
    /// speed that is not excluded, if no move tells it. An arm that never reaches its top speed
    /// takes the same time at any.
    slowest: Option<&'a Parameters>,
    /// What a fit may be worse by.
    allowance: f64,
}

impl<'a> Profile<'a> {
    /// The profile of `law`, whose task this is. `wider` is by what factor intervals are widened for
    /// the number of parameters. `free` becomes the parameters that vary: also the lift, if that is
    /// neither known nor estimated; the top speed, if no move tells it; and, if the law was chosen, the
    /// acceleration of an arm that may have one.
    pub(super) fn new(
        task: &Task<'a>,
        law: &'a LawEstimate,
        (lift_is_known, is_chosen): (bool, bool),
        wider: f64,
        free: &'a mut Vec<usize>,
    ) -> Self {
        free.clone_from(&law.free);
        if !law.has_lift && !lift_is_known {
            free.push(LIFT);
        }
        if !law.accelerates && is_chosen {
            free.push(RAMP);
        }
        if law.slowest.is_some() {
            free.push(SLOWNESS);
        }
        let task = Task { free, ..*task };
        let scale = law.estimate.scale;
        let starts = [Some(&law.estimate.parameters), law.slowest.as_ref()];
        let fits = starts.into_iter().flatten();
        let fits = fits.map(|start| task.refine(start, scale));
        let best = fits.min_by(|a, b| a.loss.total_cmp(&b.loss));
        Self {
            task,
            best: best.unwrap_or_else(|| law.estimate.clone()),
            slowest: law.slowest.as_ref(),
            allowance: EXCLUDED * wider * wider,
        }
    }

    /// The best parameters at the lowest and the highest value of the parameter with this index that the
    /// times do not exclude.
    pub(super) fn ends(&self, index: usize) -> [Parameters; 2] {
        [-1.0, 1.0].map(|direction| self.end(index, direction))
    }

    fn end(&self, index: usize, direction: f64) -> Parameters {
        let varied = self.task.free.iter().copied();
        let varied: Vec<usize> = varied.filter(|free| *free != index).collect();
        let task = Task {
            free: &varied,
            ..self.task
        };
        let at = |start: &Parameters, value: f64| {
            let starts = [Some(start), self.slowest].into_iter().flatten();
            let mut fits = starts.map(|start| {
                let mut start = start.clone();
                start[index] = value;
                task.refine(&start, self.best.scale)
            });
            let kept = fits.find(|fit| fit.loss - self.best.loss <= self.allowance);
            kept.map(|fit| fit.parameters)
        };
        let mut kept = self.best.parameters.clone();
        let mut step = (FIRST_STEP * kept[index]).max(LEAST_STEP);
        let mut excluded = None;
        for _ in 0..MOST_DOUBLINGS {
            let value = (kept[index] + direction * step).max(0.0);
            match at(&kept, value) {
                Some(_) if value == kept[index] => break,
                Some(parameters) => kept = parameters,
                None => {
                    excluded = Some(value);
                    break;
                }
            }
            step *= 2.0;
        }
        let Some(mut excluded) = excluded else {
            return kept;
        };
        for _ in 0..BISECTIONS {
            let value = f64::midpoint(kept[index], excluded);
            match at(&kept, value) {
                Some(parameters) => kept = parameters,
                None => excluded = value,
            }
        }
        kept
    }
}
