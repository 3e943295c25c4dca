//! Clustered feeds.

use super::feed::{FeedShape, across, numbered};
use super::item::{MOST_ITEMS, Pattern};
use crate::error::{Error, Result, shown_number};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Exp1, StandardNormal};

/// An item further from its cluster's centre than this many standard deviations is one in
/// a thousand million.
const TAIL: f64 = 6.0;

/// `count` items of `density` [1/m] in clusters: the centres are a Poisson process, the
/// number of items in a cluster is Poisson, their distances from its centre are normal
/// (Thomas, "A generalization of Poisson's binomial limit for use in ecology", Biometrika
/// 36, 1949, DOI 10.1093/biomet/36.1-2.18). An item beside the belt is reflected at its
/// edge, which keeps the density even across. The first is at x0 = 0.
pub(super) fn clustered(
    width: f64,
    density: f64,
    count: usize,
    shape: &FeedShape,
    rng: &mut ChaCha8Rng,
) -> Result<Pattern> {
    // All clusters that reach the start are drawn, however few items are kept.
    if density * 2.0 * TAIL * shape.cluster_spread > MOST_ITEMS as f64 {
        return Err(Error::input(
            "--cluster-spread",
            format!(
                "{} m is too wide for {} items a metre",
                shown_number(shape.cluster_spread),
                shown_number(density)
            ),
            "give a smaller spread or a lower --flow",
        ));
    }
    let per_metre = density / shape.cluster_size;
    // Clusters downstream of the start reach into the pattern, too.
    let mut centre = TAIL * shape.cluster_spread;
    let mut places: Vec<(f64, f64)> = Vec::with_capacity(count);
    let mut end = f64::NEG_INFINITY;
    while centre > end {
        centre -= rng.sample::<f64, _>(Exp1) / per_metre;
        let middle = across(width, rng);
        // Arrivals of a Poisson process of rate 1 up to the mean: a Poisson number.
        let mut sum = rng.sample::<f64, _>(Exp1);
        while sum <= shape.cluster_size {
            let along = centre + shape.cluster_spread * rng.sample::<f64, _>(StandardNormal);
            let aside = middle + shape.cluster_spread * rng.sample::<f64, _>(StandardNormal);
            if along <= 0.0 {
                places.push((along, reflected(aside, width)));
            }
            sum += rng.sample::<f64, _>(Exp1);
        }
        if end == f64::NEG_INFINITY && places.len() >= count {
            // Clusters further upstream than this add nothing to the first `count`.
            let (_, last, _) = places.select_nth_unstable_by(count - 1, |a, b| b.0.total_cmp(&a.0));
            end = last.0 - TAIL * shape.cluster_spread;
        }
    }
    places.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
    places.truncate(count);
    let first = places.first().map_or(0.0, |place| place.0);
    places.iter_mut().for_each(|place| place.0 -= first);
    numbered(places)
}

/// `y` [m] reflected at the edges of a belt of `width` [m] until it lies between them.
fn reflected(y: f64, width: f64) -> f64 {
    let turn = (y / width + 0.5).rem_euclid(2.0);
    width * (if turn > 1.0 { 2.0 - turn } else { turn } - 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflection_keeps_items_on_the_belt() {
        for (y, expected) in [
            (0.3, 0.3),
            (0.6, 0.4),
            (-0.7, -0.3),
            (1.6, -0.4),
            (-0.5, -0.5),
        ] {
            assert!((reflected(y, 1.0) - expected).abs() < 1e-12, "{y}");
        }
    }
}
