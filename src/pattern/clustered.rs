//! Clustered feeds.

use super::feed::FeedShape;
use super::item::{MOST_ITEMS, Pattern};
use super::random::across;
use crate::error::{Error, Result, shown_number};
use rand::RngExt;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Exp1, StandardNormal};

/// An item is further downstream or upstream of its cluster's centre than this many standard
/// deviations only with a probability of one in a billion.
const TAIL: f64 = 6.0;

/// `count` items of `density` [1/m] in clusters. The centres form a Poisson process, the number of
/// items in a cluster is Poisson, and the distances from the centre are normal (Thomas, "A
/// generalization of Poisson's binomial limit for use in ecology", Biometrika 36, 1949, DOI
/// 10.1093/biomet/36.1-2.18). An item outside the belt is reflected at the edge, which keeps the
/// density across the belt uniform. The first item is at x0 = 0.
pub(super) fn clustered(
    width: f64,
    density: f64,
    count: usize,
    shape: &FeedShape,
    rng: &mut ChaCha8Rng,
) -> Result<Pattern> {
    // All clusters that reach the start are drawn, even if few items are kept.
    if density * 2.0 * TAIL * shape.cluster_spread > MOST_ITEMS as f64 {
        return Err(Error::usage(
            "'cluster_spread'",
            format!(
                "{} m is too wide for {} items per metre",
                shown_number(shape.cluster_spread),
                shown_number(density)
            ),
            "give a smaller spread or a lower 'flow'",
        ));
    }
    let per_metre = density / shape.cluster_size;
    // Clusters downstream of the start also reach into the pattern.
    let mut centre = TAIL * shape.cluster_spread;
    let mut places: Vec<(f64, f64)> = Vec::with_capacity(count);
    let mut end = f64::NEG_INFINITY;
    while centre > end {
        centre -= rng.sample::<f64, _>(Exp1) / per_metre;
        let middle = across(width, rng);
        // The arrivals of a Poisson process with rate 1 up to the mean are a Poisson number.
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
            // Clusters further upstream do not contribute to the first `count` items.
            let (_, last, _) = places.select_nth_unstable_by(count - 1, |a, b| b.0.total_cmp(&a.0));
            end = last.0 - TAIL * shape.cluster_spread;
        }
    }
    places.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.total_cmp(&b.1)));
    places.truncate(count);
    let first = places.first().map_or(0.0, |place| place.0);
    places.iter_mut().for_each(|place| place.0 -= first);
    Pattern::numbered(places)
}

/// Reflects `y` [m] at the edges of a belt of `width` [m] until it lies between them.
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
