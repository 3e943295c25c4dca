//! Convex polygons with corners in counterclockwise order.

use super::segment::Segment;
use nalgebra::Point2;

/// A convex polygon [m]. With fewer than three corners it has no area.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polygon {
    corners: Vec<Point2<f64>>,
}

impl Polygon {
    /// The convex hull of `points`, by Andrew's monotone chain
    /// (doi:10.1016/0020-0190(79)90072-3).
    pub(super) fn hull(mut points: Vec<Point2<f64>>) -> Self {
        points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
        points.dedup();
        if points.len() < 3 {
            return Self { corners: points };
        }
        let mut corners: Vec<Point2<f64>> = Vec::new();
        for upper in [false, true] {
            let start = corners.len();
            let mut add = |point: Point2<f64>| {
                while corners.len() >= start + 2 {
                    let [a, b] = [corners[corners.len() - 2], corners[corners.len() - 1]];
                    if (b - a).perp(&(point - b)) > 0.0 {
                        break;
                    }
                    corners.pop();
                }
                corners.push(point);
            };
            if upper {
                points.iter().rev().copied().for_each(&mut add);
            } else {
                points.iter().copied().for_each(&mut add);
            }
            // The last point of each chain is the first of the other.
            corners.pop();
        }
        Self { corners }
    }

    /// The corners, in counterclockwise order.
    pub(super) fn corners(&self) -> &[Point2<f64>] {
        &self.corners
    }

    fn edges(&self) -> impl Iterator<Item = Segment> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        let pairs = self.corners.iter().zip(next);
        pairs.map(|(&from, &to)| Segment { from, to })
    }

    /// The intersection of the two polygons, by clipping edge by edge (Sutherland and Hodgman 1974,
    /// doi:10.1145/360767.360802). At most one of them may have no area.
    pub(super) fn intersection(&self, other: &Self) -> Self {
        if other.corners.len() < 3 {
            return match self.corners.len() {
                0..3 => Self::hull(Vec::new()),
                _ => other.intersection(self),
            };
        }
        let mut corners = self.corners.clone();
        for edge in other.edges() {
            let side = |point: &Point2<f64>| (edge.to - edge.from).perp(&(point - edge.from));
            let mut kept = Vec::with_capacity(corners.len() + 1);
            for (i, point) in corners.iter().enumerate() {
                let before = &corners[(i + corners.len() - 1) % corners.len()];
                let (a, b) = (side(before), side(point));
                if (a < 0.0) != (b < 0.0) {
                    kept.push(before + (point - before) * (a / (a - b)));
                }
                if b >= 0.0 {
                    kept.push(*point);
                }
            }
            corners = kept;
        }
        Self { corners }
    }

    /// The enclosed area [m^2], never negative.
    pub(super) fn area(&self) -> f64 {
        let Some(&first) = self.corners.first() else {
            return 0.0;
        };
        let fan = self
            .edges()
            .map(|edge| (edge.from - first).perp(&(edge.to - first)));
        0.5 * fan.sum::<f64>()
    }

    /// The smallest and largest coordinates along x and y [m].
    pub(super) fn bounds(&self) -> [[f64; 2]; 2] {
        let range = |of: fn(&Point2<f64>) -> f64| {
            let all = self.corners.iter().map(of);
            let none = [f64::INFINITY, f64::NEG_INFINITY];
            all.fold(none, |[low, high], v| [low.min(v), high.max(v)])
        };
        [range(|point| point.x), range(|point| point.y)]
    }

    /// Distance between two disjoint polygons [m].
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let pairs = self
            .edges()
            .flat_map(|a| other.edges().map(move |b| (a, b)));
        let distances = pairs.map(|(a, b)| a.nearest(&b).distance);
        distances.fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64, side: f64) -> Polygon {
        let corner = |dx: f64, dy: f64| Point2::new(x + side * dx, y + side * dy);
        // The midpoint is not a corner.
        Polygon::hull(vec![
            corner(0.0, 0.0),
            corner(1.0, 1.0),
            corner(0.5, 0.5),
            corner(1.0, 0.0),
            corner(0.0, 1.0),
        ])
    }

    #[test]
    fn squares_share_what_they_share() {
        let one = square(0.0, 0.0, 2.0);
        assert_eq!(one.corners().len(), 4);
        assert_eq!(one.area(), 4.0);
        let other = square(1.0, 1.5, 2.0);
        let both = one.intersection(&other);
        assert!((both.area() - 0.5).abs() < 1e-12);
        assert_eq!(both.bounds(), [[1.0, 2.0], [1.5, 2.0]]);
        let far = square(5.0, 6.0, 1.0);
        assert_eq!(one.intersection(&far).area(), 0.0);
        assert!((one.distance(&far) - 5.0).abs() < 1e-12);
    }
}
