//! Maximal Poisson disk patterns.
//!
//! Bridson, "Fast Poisson disk sampling in arbitrary dimensions", SIGGRAPH 2007 sketches (DOI
//! 10.1145/1278780.1278807), followed by two steps that make the sample *maximal*: no further item
//! would fit. The first throws darts at the uncovered area, represented by squares that are
//! repeatedly subdivided (Ebeida et al., "A simple algorithm for maximal Poisson-disk sampling in
//! high dimensions", Computer Graphics Forum 31, 2012, DOI 10.1111/j.1467-8659.2012.03059.x), so
//! that the added items are as random as the others. The second is deterministic: an uncovered
//! region has a corner where two circles of radius r around items cross, or where such a circle
//! meets the border of the strip, and all these points are checked.

mod density;
mod sampler;

pub(super) use density::radius_of;

use super::grid::{check_count, check_length, check_spacing, check_width};
use super::item::{Item, MOST_ITEMS, Pattern};
use crate::error::{Error, Result, shown_number};
use rand::rngs::ChaCha8Rng;
use sampler::Sampler;

/// Items keep this multiple of the radius, so that rounding cannot bring a distance below the
/// radius when the pattern is shifted.
const MARGIN: f64 = 1.0 + 1e-9;
/// Maximum number of background cells, enough for the largest pattern, to limit memory use.
const MOST_CELLS: f64 = 5.0 * MOST_ITEMS as f64;

/// `count` items on a belt of `width` [m], no two closer than `radius` [m], so dense that no
/// further item would fit between them. The first item is at x0 = 0.
///
/// # Errors
/// If the width or the radius is not a positive length, or there are no items or too many.
pub fn poisson_disk(
    width: f64,
    radius: f64,
    count: usize,
    rng: &mut ChaCha8Rng,
) -> Result<Pattern> {
    check_width(width)?;
    check_spacing("radius", radius)?;
    check_count(count)?;
    // A maximal sample has about 0.7 items per square radius, and its border acts as if the strip
    // were about one radius wider. The extra length keeps the upstream end, where the strip is cut,
    // outside the kept items.
    let mut length = radius * (count as f64 * radius / (0.62 * (width + radius)) + 4.0);
    check_length(count, length)?;
    let mut points = loop {
        // Even a few items are the start of a sample over the whole width.
        if 2.0 * (length / radius + 1.0) * (width / radius + 1.0) > MOST_CELLS {
            return Err(Error::usage(
                "'radius'",
                format!(
                    "{} m is too fine for a belt {} m wide",
                    shown_number(radius),
                    shown_number(width)
                ),
                "give a larger radius, fewer items or a narrower belt",
            ));
        }
        let points = Sampler::new(length, width, radius * MARGIN, rng).run();
        if points.len() > count {
            break points;
        }
        length *= 1.25;
    };
    points.sort_by(|a, b| b[0].total_cmp(&a[0]));
    points.truncate(count);
    let first = points.first().map_or(0.0, |p| p[0]);
    let items = points
        .iter()
        .enumerate()
        .map(|(i, p)| Item::at((i + 1).to_string(), p[0] - first, p[1] - width / 2.0))
        .collect();
    Pattern::new(items)
}

#[cfg(test)]
mod tests {
    use super::sampler::Point;
    use super::sampler::tests::uncovered;
    use super::*;
    use crate::pattern::random_stream;

    fn draw(width: f64, radius: f64, count: usize, seed: u64) -> Pattern {
        poisson_disk(width, radius, count, &mut random_stream(seed, 0)).unwrap()
    }

    #[test]
    fn no_two_items_are_closer_than_the_radius() {
        for (width, radius) in [(1.05, 0.15), (0.4, 0.2), (0.1, 0.3), (2.0, 0.05)] {
            let pattern = draw(width, radius, 400, 3);
            let items = pattern.items();
            assert_eq!(items.len(), 400);
            assert_eq!(items[0].x0, 0.0);
            for (i, a) in items.iter().enumerate() {
                assert!(a.y.abs() <= width / 2.0 + 1e-12);
                for b in &items[..i] {
                    let distance = (a.x0 - b.x0).hypot(a.y - b.y);
                    assert!(distance >= radius, "{distance} < {radius}");
                }
            }
        }
    }

    #[test]
    fn no_further_item_would_fit() {
        for seed in 0..20 {
            let (width, radius) = (0.7, 0.1);
            let pattern = draw(width, radius, 200, seed);
            let items = pattern.items();
            // One radius short of the last item the strip was cut, not filled.
            let end = items[199].x0 + radius;
            for i in 0..600 {
                for j in 0..=140 {
                    let (x, y) = (end * i as f64 / 600.0, width * (j as f64 / 140.0 - 0.5));
                    let nearest = items
                        .iter()
                        .map(|item| (item.x0 - x).hypot(item.y - y))
                        .fold(f64::INFINITY, f64::min);
                    assert!(nearest < radius * MARGIN, "a gap at ({x}, {y}): {nearest}");
                }
            }
        }
    }

    /// The same for patterns, which are cut at the last item and shifted so that the first is at 0.
    #[test]
    fn patterns_are_maximal_up_to_the_edges_of_the_belt() {
        for (width, radius) in [(0.7, 0.1), (1.05, 0.3), (0.2, 0.25), (0.01, 0.5)] {
            for seed in 0..10 {
                let pattern = draw(width, radius, 60, seed);
                let points: Vec<Point> = pattern
                    .items()
                    .iter()
                    .map(|item| [item.x0, item.y + width / 2.0])
                    .collect();
                let from = points[59][0] + radius * MARGIN;
                let gap = uncovered(&points, from, [0.0, width], radius * MARGIN);
                assert_eq!(gap, None, "width {width}, radius {radius}, seed {seed}");
            }
        }
    }

    #[test]
    fn the_same_seed_draws_the_same_pattern_for_ever() {
        assert_eq!(draw(1.05, 0.2, 29, 7), draw(1.05, 0.2, 29, 7));
        assert_ne!(draw(1.05, 0.2, 29, 7), draw(1.05, 0.2, 29, 8));
    }

    #[test]
    fn narrow_strips_and_single_items_work() {
        assert_eq!(draw(0.01, 0.5, 1, 1).len(), 1);
        assert_eq!(draw(0.01, 0.5, 50, 1).len(), 50);
        // A sample that would not fit into memory is rejected before it is started.
        for (width, radius, count, problem) in [
            (1.0, 0.1, 0, "'count': 0 items is not a valid pattern size"),
            (1.0, f64::NAN, 5, "'radius': NaN m is not a valid distance"),
            (1e3, 1e-4, 5, "'radius': 0.0001 m is too fine for a belt"),
            (1.0, 0.1, usize::MAX, "items is not a valid pattern size"),
            (1e-3, 1e3, 10_000, "'count': 10000 items would take"),
        ] {
            let drawn = poisson_disk(width, radius, count, &mut random_stream(1, 0));
            let message = drawn.unwrap_err().to_string();
            assert!(message.contains(problem), "{message}");
        }
    }
}
