//! The distance between two segments in the plane.

use nalgebra::{Point2, Vector2};

/// The segment from `from` to `to` [m], which may coincide.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Segment {
    pub from: Point2<f64>,
    pub to: Point2<f64>,
}

/// The nearest points of two segments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Nearest {
    /// Distance between the segments [m].
    pub distance: f64,
    /// One point on each segment [m].
    pub points: [Point2<f64>; 2],
}

impl Segment {
    fn direction(&self) -> Vector2<f64> {
        self.to - self.from
    }

    /// The point of this segment that is nearest to `point`.
    fn towards(&self, point: Point2<f64>) -> Point2<f64> {
        let direction = self.direction();
        let square = direction.norm_squared();
        if square == 0.0 {
            return self.from;
        }
        let share = (point - self.from).dot(&direction) / square;
        self.from + direction * share.clamp(0.0, 1.0)
    }

    /// The crossing with `other`; `None` if the segments do not cross or only touch.
    fn crossing(&self, other: &Self) -> Option<Point2<f64>> {
        let side = |of: &Self, point: Point2<f64>| of.direction().perp(&(point - of.from));
        let (a, b) = (side(other, self.from), side(other, self.to));
        let (c, d) = (side(self, other.from), side(self, other.to));
        // Compare signs, because the product of two small values may underflow.
        let apart = |one: f64, two: f64| (one > 0.0 && two < 0.0) || (one < 0.0 && two > 0.0);
        (apart(a, b) && apart(c, d)).then(|| self.from + self.direction() * (a / (a - b)))
    }

    /// The nearest points of this segment and `other`.
    pub(super) fn nearest(&self, other: &Self) -> Nearest {
        if let Some(point) = self.crossing(other) {
            return Nearest {
                distance: 0.0,
                points: [point, point],
            };
        }
        // If segments do not cross, an end of one of them is nearest.
        let pairs = [
            [self.from, other.towards(self.from)],
            [self.to, other.towards(self.to)],
            [self.towards(other.from), other.from],
            [self.towards(other.to), other.to],
        ];
        let mut best = pairs[0];
        let mut least = (best[0] - best[1]).norm_squared();
        for pair in &pairs[1..] {
            let square = (pair[0] - pair[1]).norm_squared();
            if square < least {
                (best, least) = (*pair, square);
            }
        }
        Nearest {
            distance: least.sqrt(),
            points: best,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn segment(from: [f64; 2], to: [f64; 2]) -> Segment {
        Segment {
            from: from.into(),
            to: to.into(),
        }
    }

    #[test]
    fn segments_are_as_far_apart_as_their_nearest_points() {
        let flat = segment([0.0, 0.0], [2.0, 0.0]);
        for (other, expected) in [
            // Crossing, touching at an end, collinear and overlapping.
            (segment([1.0, -1.0], [1.0, 1.0]), 0.0),
            (segment([1.0, 0.0], [1.0, 1.0]), 0.0),
            (segment([1.0, 0.0], [3.0, 0.0]), 0.0),
            // Collinear with a gap, parallel, nearest at an end, a single point.
            (segment([2.5, 0.0], [3.0, 0.0]), 0.5),
            (segment([0.5, 0.3], [1.5, 0.3]), 0.3),
            (segment([5.0, 4.0], [9.0, 9.0]), 5.0),
            (segment([1.0, 0.2], [1.0, 0.2]), 0.2),
        ] {
            let found = flat.nearest(&other);
            assert!((found.distance - expected).abs() < 1e-12, "{other:?}");
            let back = other.nearest(&flat);
            assert!((back.distance - expected).abs() < 1e-12, "{other:?}");
            let [a, b] = found.points;
            assert!(((a - b).norm() - expected).abs() < 1e-12, "{other:?}");
        }
    }
}
