//! Items at random: the Poisson process.

use super::item::Pattern;
use crate::error::Result;
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::Exp1;

/// A uniformly random position across a belt of `width` [m].
pub(super) fn across(width: f64, rng: &mut ChaCha8Rng) -> f64 {
    width * (rng.random::<f64>() - 0.5)
}

/// Items of a Poisson process of `density` [1/m]: distances along the belt are exponential, so that
/// the arrival times also form a Poisson process. Positions across the belt are uniform. The first
/// item is at x0 = 0.
pub(super) fn random(
    width: f64,
    density: f64,
    count: usize,
    rng: &mut ChaCha8Rng,
) -> Result<Pattern> {
    let mut along = 0.0;
    let places = (0..count).map(|i| {
        if i > 0 {
            along -= rng.sample::<f64, _>(Exp1) / density;
        }
        (along, across(width, rng))
    });
    Pattern::numbered(places.collect())
}
