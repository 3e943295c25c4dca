//! Nonlinear least squares that outliers do not bend.
//!
//! The method of Levenberg and Marquardt (Levenberg 1944, DOI 10.1090/qam/10666; Marquardt 1963, DOI
//! 10.1137/0111030) with weights, first those of Huber's loss (Huber 1964, DOI
//! 10.1214/aoms/1177703732), then, with the scale of the residuals that this gives, those of Tukey's
//! biweight (Beaton and Tukey 1974, DOI 10.1080/00401706.1974.10489171): an M-estimate from a robust
//! start with a robust scale (Yohai 1987, DOI 10.1214/aos/1176350366).

use super::model::{Observation, Parameters, predict};
use nalgebra::{DMatrix, DVector};

/// Huber's threshold in scales: 95 % efficient for normal errors.
const HUBER: f64 = 1.345;
/// Tukey's threshold in scales, from which on a residual counts for nothing: likewise.
pub(super) const TUKEY: f64 = 4.685;
/// Factor from the median absolute deviation to the standard deviation of normal errors.
const MAD: f64 = 1.4826;
/// Least scale [s], below the resolution of any clock: exact times have none.
const LEAST_SCALE: f64 = 1e-7;
/// Variance of the difference of two rounded stamps, in squared steps.
const ROUNDING_VARIANCE: f64 = 1.0 / 6.0;
/// Smaller eigenvalues of an information matrix with a diagonal of 1 count as 0.
pub(super) const SINGULAR: f64 = 1e-9;
/// Most iterations; ten are usual.
const MOST_STEPS: usize = 60;

/// How a residual counts.
#[derive(Debug, Clone, Copy)]
enum Loss {
    Huber,
    Tukey,
}

impl Loss {
    /// The loss of a residual in scales, near 0 that of least squares, and its weight.
    fn of(self, residual: f64) -> (f64, f64) {
        let size = residual.abs();
        match self {
            Self::Huber if size <= HUBER => (0.5 * size * size, 1.0),
            Self::Huber => (HUBER * (size - 0.5 * HUBER), HUBER / size),
            Self::Tukey if size < TUKEY => {
                let rest = 1.0 - (size / TUKEY).powi(2);
                let most = TUKEY * TUKEY / 6.0;
                (most * (1.0 - rest.powi(3)), rest * rest)
            }
            Self::Tukey => (TUKEY * TUKEY / 6.0, 0.0),
        }
    }
}

/// What is estimated from: measured times, and which parameters are free.
#[derive(Debug, Clone, Copy)]
pub(super) struct Task<'a> {
    pub observations: &'a [Observation],
    /// The indices of the free parameters.
    pub free: &'a [usize],
    /// Step of the stamps [s]; 0 if they have none.
    pub step: f64,
}

/// An estimate.
#[derive(Debug, Clone)]
pub(super) struct Estimate {
    pub parameters: Parameters,
    /// Standard deviation of the residuals that are no outliers, robustly [s].
    pub scale: f64,
    /// Sum of the losses, in scales.
    pub loss: f64,
}

impl Task<'_> {
    /// The residual [s] of every observation.
    pub(super) fn residuals(&self, parameters: &[f64]) -> Vec<f64> {
        let mut slopes = vec![0.0; parameters.len()];
        let residual = |o: &Observation| o.time - predict(parameters, &o.leg, &mut slopes);
        self.observations.iter().map(residual).collect()
    }

    fn scale(&self, parameters: &[f64]) -> f64 {
        scale_of(&self.residuals(parameters), self.step)
    }

    /// The estimate from the best of `starts`, with the scale of its residuals.
    pub(super) fn solve(&self, starts: &[Parameters]) -> Option<Estimate> {
        let rough = starts.iter().map(|start| {
            let scale = self.scale(start);
            self.descend(start, scale, Loss::Huber).parameters
        });
        let quality = |at: &Parameters| self.residuals(at).iter().map(|r| r.abs()).sum::<f64>();
        let rough = rough.filter(|at| quality(at).is_finite());
        let mut best = rough.min_by(|a, b| quality(a).total_cmp(&quality(b)))?;
        for _ in 0..2 {
            let scale = self.scale(&best);
            best = self.descend(&best, scale, Loss::Huber).parameters;
        }
        let mut estimate = self.refine(&best, self.scale(&best));
        for _ in 0..2 {
            let scale = self.scale(&estimate.parameters);
            estimate = self.refine(&estimate.parameters, scale);
        }
        Some(estimate)
    }

    /// The M-estimate with Tukey's loss and this scale [s], from a start that is near.
    pub(super) fn refine(&self, start: &[f64], scale: f64) -> Estimate {
        self.descend(start, scale, Loss::Tukey)
    }

    fn loss(&self, parameters: &[f64], scale: f64, loss: Loss) -> f64 {
        let residuals = self.residuals(parameters);
        residuals.iter().map(|r| loss.of(r / scale).0).sum()
    }

    /// The weighted normal equations at these parameters: `J^T W J` and `J^T W r`.
    fn normal_equations(
        &self,
        parameters: &[f64],
        scale: f64,
        loss: Loss,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let count = self.free.len();
        let mut matrix = DMatrix::zeros(count, count);
        let mut vector = DVector::zeros(count);
        let mut slopes = vec![0.0; parameters.len()];
        for observation in self.observations {
            let residual = observation.time - predict(parameters, &observation.leg, &mut slopes);
            let weight = loss.of(residual / scale).1;
            if weight == 0.0 {
                continue;
            }
            for (i, &a) in self.free.iter().enumerate() {
                let weighted = weight * slopes[a];
                vector[i] += weighted * residual;
                for (j, &b) in self.free.iter().enumerate().take(i + 1) {
                    matrix[(i, j)] += weighted * slopes[b];
                }
            }
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        (matrix, vector)
    }

    /// `J^T W J` with Tukey's weights, whose inverse times the squared scale is the covariance of the
    /// estimate.
    pub(super) fn information(&self, estimate: &Estimate) -> DMatrix<f64> {
        let Estimate {
            parameters, scale, ..
        } = estimate;
        self.normal_equations(parameters, *scale, Loss::Tukey).0
    }

    /// By how much rounded stamps may have moved the estimate of each free parameter, in their order:
    /// if every time was off by half a step, in the direction that moves the parameter most.
    pub(super) fn rounding(&self, estimate: &Estimate) -> Vec<f64> {
        let count = self.free.len();
        let mut moved = vec![0.0; count];
        if self.step == 0.0 {
            return moved;
        }
        let parameters = &estimate.parameters;
        let information = self.information(estimate);
        let unit: Vec<f64> = information.diagonal().iter().map(|d| d.sqrt()).collect();
        let scaled = DMatrix::from_fn(count, count, |i, j| match unit[i] * unit[j] {
            // A parameter without influence.
            0.0 => 0.0,
            product => information[(i, j)] / product,
        });
        let Ok(inverse) = scaled.pseudo_inverse(SINGULAR) else {
            return moved;
        };
        let mut slopes = vec![0.0; parameters.len()];
        for observation in self.observations {
            let residual = observation.time - predict(parameters, &observation.leg, &mut slopes);
            let weight = Loss::Tukey.of(residual / estimate.scale).1;
            for i in (0..count).filter(|i| unit[*i] > 0.0) {
                let influence = (0..count).filter(|j| unit[*j] > 0.0);
                let influence = influence.map(|j| inverse[(i, j)] * slopes[self.free[j]] / unit[j]);
                moved[i] += (weight * influence.sum::<f64>() / unit[i]).abs() * 0.5 * self.step;
            }
        }
        moved
    }

    fn descend(&self, start: &[f64], scale: f64, loss: Loss) -> Estimate {
        let mut at = start.to_vec();
        let mut value = self.loss(&at, scale, loss);
        let mut damping = 1e-6;
        for _ in 0..MOST_STEPS {
            let (matrix, vector) = self.normal_equations(&at, scale, loss);
            let mut moved = None;
            while damping < 1e9 {
                if let Some(next) = self.step(&at, &matrix, &vector, damping) {
                    let next_value = self.loss(&next, scale, loss);
                    if next_value < value {
                        moved = Some((next, next_value));
                        break;
                    }
                }
                damping *= 8.0;
            }
            let Some((next, next_value)) = moved else {
                break;
            };
            let gain = value - next_value;
            (at, value) = (next, next_value);
            damping = (damping / 10.0).max(1e-12);
            if gain <= 1e-9 * value {
                break;
            }
        }
        Estimate {
            parameters: at,
            scale,
            loss: value,
        }
    }

    /// The parameters after a damped step; none of them is negative.
    fn step(
        &self,
        at: &[f64],
        matrix: &DMatrix<f64>,
        vector: &DVector<f64>,
        damping: f64,
    ) -> Option<Parameters> {
        let mut damped = matrix.clone();
        let largest = matrix.diagonal().max();
        for i in 0..self.free.len() {
            // A parameter without influence stays.
            damped[(i, i)] += damping * matrix[(i, i)].max(1e-9 * largest);
        }
        let mut vector = vector.clone();
        for i in 0..self.free.len() {
            // One that is 0 and should be negative stays, too.
            if at[self.free[i]] == 0.0 && vector[i] < 0.0 {
                damped.fill_row(i, 0.0);
                damped.fill_column(i, 0.0);
                damped[(i, i)] = 1.0;
                vector[i] = 0.0;
            }
        }
        let step = damped.cholesky()?.solve(&vector);
        let mut next = at.to_vec();
        for (i, &index) in self.free.iter().enumerate() {
            next[index] = (next[index] + step[i]).max(0.0);
        }
        next.iter().all(|value| value.is_finite()).then_some(next)
    }
}

/// The robust standard deviation of residuals around 0 [s]; not less than that of times between
/// stamps with this step [s].
pub(super) fn scale_of(residuals: &[f64], step: f64) -> f64 {
    let sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
    let rounding = ROUNDING_VARIANCE.sqrt() * step;
    (MAD * median(sizes)).max(LEAST_SCALE).max(rounding)
}

/// The median; 0 of nothing.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    match values.len() {
        0 => 0.0,
        count if count % 2 == 1 => values[count / 2],
        count => f64::midpoint(values[count / 2 - 1], values[count / 2]),
    }
}
