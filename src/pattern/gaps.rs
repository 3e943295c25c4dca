//! Feeds with stretches of empty belt.

use super::feed::FeedShape;
use super::item::Pattern;
use super::random::across;
use crate::error::Result;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::Exp1;

/// `count` items of `density` [1/m] on a belt that alternates between fed and empty stretches, both
/// of exponential length. The fed stretches are a Poisson process; together this is an interrupted
/// Poisson process (Kuczura, "The interrupted Poisson process as an overflow process", Bell System
/// Technical Journal 52, 1973, DOI 10.1002/j.1538-7305.1973.tb01971.x). The density is that of the
/// whole belt, empty stretches included. The first item is at x0 = 0.
pub(super) fn gaps(
    width: f64,
    density: f64,
    count: usize,
    shape: &FeedShape,
    rng: &mut ChaCha8Rng,
) -> Result<Pattern> {
    let fed_share = 1.0 - shape.gap_share;
    let fed_length = shape.gap_length * fed_share / shape.gap_share;
    let fed_density = density / fed_share;
    let exponential = |mean: f64, rng: &mut ChaCha8Rng| mean * rng.sample::<f64, _>(Exp1);
    let mut along = 0.0;
    let mut left = exponential(fed_length, rng);
    let mut places = Vec::with_capacity(count);
    while places.len() < count {
        places.push((along, across(width, rng)));
        let mut step = exponential(1.0 / fed_density, rng);
        while step > left {
            // The process is memoryless: the rest of the step can be redrawn.
            along -= left + exponential(shape.gap_length, rng);
            left = exponential(fed_length, rng);
            step = exponential(1.0 / fed_density, rng);
        }
        along -= step;
        left -= step;
    }
    Pattern::numbered(places)
}
