//! Intervals of what was estimated, by bootstrap of the rows (Efron 1979, DOI
//! 10.1214/aos/1176344552): every resample is estimated from the estimate on, with its scale.

use super::model::Observation;
use crate::pattern::random_stream;
use crate::stats::{CONFIDENCE, quantile};
use rand::RngExt as _;
use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// An interval whose upper end may be open.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct HalfOpen {
    /// Lower end.
    pub low: f64,
    /// Upper end; `None` if nothing limits the value.
    pub high: Option<f64>,
}

impl HalfOpen {
    /// Whether `value` lies in the interval, ends included.
    pub fn contains(&self, value: f64) -> bool {
        self.low <= value && self.high.is_none_or(|high| value <= high)
    }

    /// The least interval that also contains `value`, which may be infinite.
    pub(super) fn including(self, value: f64) -> Self {
        let high = self.high.map(|high| high.max(value));
        Self {
            low: self.low.min(value).max(0.0),
            high: high.filter(|high| high.is_finite()),
        }
    }
}

/// What `estimate` makes of each resample of `rows` rows with their `observations`, in order.
pub(super) fn resampled<T: Send>(
    observations: &[Observation],
    rows: usize,
    (count, seed): (usize, u64),
    estimate: impl Fn(&[Observation]) -> T + Sync,
) -> Vec<T> {
    let mut by_row: Vec<Vec<Observation>> = vec![Vec::new(); rows];
    for observation in observations {
        by_row[observation.row].push(*observation);
    }
    let by_row: Vec<_> = by_row.into_iter().filter(|row| !row.is_empty()).collect();
    let draw = |index: usize| {
        // One stream per resample, whatever thread draws it.
        let mut rng = random_stream(seed, index as u64);
        let drawn = (0..by_row.len()).map(|_| rng.random_range(0..by_row.len() as u32));
        let drawn: Vec<Observation> = drawn
            .flat_map(|row| by_row[row as usize].iter().copied())
            .collect();
        estimate(&drawn)
    };
    (0..count).into_par_iter().map(draw).collect()
}

/// The factor by which an interval from a sample of `rows` rows with this number of free parameters is
/// too narrow.
pub(super) fn widening(rows: usize, parameters: usize) -> f64 {
    let tail = (1.0 - CONFIDENCE) / 2.0;
    let freedom = rows.saturating_sub(parameters).max(1) as f64;
    let normal = Normal::standard().inverse_cdf(1.0 - tail);
    let student = StudentsT::new(0.0, 1.0, freedom).map_or(normal, |t| t.inverse_cdf(1.0 - tail));
    (rows as f64 / freedom).sqrt() * student / normal
}

/// The 95 % interval of `values`, which may be infinite, around the estimate `centre`: percentiles,
/// corrected for the share of resamples below the estimate (bias-corrected: Efron 1981, DOI
/// 10.2307/3314608), not narrower than the normal interval, and wider by
/// [`widening`].
pub(super) fn percentile_interval(
    mut values: Vec<f64>,
    centre: f64,
    (rows, parameters): (usize, usize),
) -> Option<HalfOpen> {
    if values.is_empty() {
        return None;
    }
    values.sort_unstable_by(f64::total_cmp);
    let tail = (1.0 - CONFIDENCE) / 2.0;
    let normal = Normal::standard().inverse_cdf(1.0 - tail);
    let wider = widening(rows, parameters);
    let below = values.iter().filter(|value| **value < centre).count() as f64;
    let equal = values.iter().filter(|value| **value == centre).count() as f64;
    // Half of those that are equal count as below; the ends have no normal quantile.
    let share = (below + 0.5 * equal + 0.5) / (values.len() as f64 + 1.0);
    let shift = 2.0 * Normal::standard().inverse_cdf(share);
    let end = |share: f64| {
        let corrected = Normal::standard().cdf(Normal::standard().inverse_cdf(share) + shift);
        centre + wider * (quantile(&values, corrected) - centre)
    };
    // With few resamples percentiles are rough: the interval also has what the standard deviation of
    // the resamples says.
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares = values.iter().map(|value| (value - mean).powi(2));
    let deviation = (squares.sum::<f64>() / values.len() as f64).sqrt();
    let half = wider * normal * deviation;
    let [low, high] = match half.is_finite() {
        true => [
            end(tail).min(centre - half),
            end(1.0 - tail).max(centre + half),
        ],
        false => [end(tail), end(1.0 - tail)],
    };
    Some(HalfOpen {
        low: low.max(0.0),
        high: high.is_finite().then_some(high),
    })
}
