//! Matches detections to items: by position first, and by the tracker's id if the position is
//! ambiguous.
//!
//! The detections of one picture are assigned to the known items together, because a picture shows
//! an item once: global nearest neighbour association, with a gate on the squared Mahalanobis
//! distance (Bar-Shalom, Daum and Huang, *The probabilistic data association filter*, IEEE Control
//! Systems 29(6), 2009, doi:10.1109/MCS.2009.934469).
//!
//! This module defines the cost of a pair and which pairs are possible. `assignment` finds the
//! cheapest assignment, and `picture` matches the detections of a picture to the items.

mod assignment;
mod picture;

use assignment::{CandidatePair, assign};
pub(crate) use picture::{Association, Match, associate};

/// A covariance of a position, `[xx, xy, yy]` [m^2].
pub(crate) type Covariance = [f64; 3];

/// Detections of an item lie within this many standard deviations of it.
const DEVIATIONS: f64 = 3.0;
/// An item under its own id may have moved on the belt: its gate is wider by this factor.
const KNOWN: f64 = 3.0;
/// An item may be off by this share of the belt's travel since it was seen: the belt slips, and its
/// speed is not exact.
const DRIFT: f64 = 0.01;
/// Upper limit of standard deviations [m]: beyond it all neighbours would merge.
const WIDEST: f64 = 0.05;
/// Positions that differ by less than this [m] are the same, whatever the tolerance.
const SAME: f64 = 1e-4;
/// Two items that a gripper can pick separately are at least this far apart [m].
const CLOSEST: f64 = 0.005;
/// Extra cost if the tracker knows the item under another id.
const RENUMBERED: f64 = 1.0;
/// Cost of treating a detection as a new item: slightly more than anything in the gate.
const NEW: f64 = DEVIATIONS * DEVIATIONS + RENUMBERED + 0.5;
/// The same cost if the picture has another detection so near that both may show one item: then
/// only an item much nearer than the gate is cheaper.
const DOUBLED: f64 = 3.0;

/// How the tracker's ids of a detection and an item compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Number {
    /// The item was seen under the detection's id.
    Same,
    /// The item was seen under other ids only.
    Other,
    /// The detection or the item has no id.
    Unknown,
}

/// How far from an item its detections may lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AssociationGate {
    /// Three standard deviations of the errors that no covariance includes [m].
    tolerance: f64,
}

impl AssociationGate {
    /// The gate for this tolerance [m].
    pub(crate) fn new(tolerance: f64) -> Self {
        Self {
            tolerance: tolerance.max(SAME),
        }
    }

    /// Two boxes of one picture that are at most this far apart [m] show one item.
    pub(crate) fn doubled(self) -> f64 {
        CLOSEST.min(self.tolerance)
    }

    /// The greatest distance along the belt [m] at which a detection without a known id can match
    /// an item. `widest` [m^2] is the largest variance of any item.
    pub(crate) fn reach(self, seen: Option<Covariance>, widest: f64) -> f64 {
        let variance = largest_variance(seen) + widest;
        (2.0 * self.tolerance.powi(2) + DEVIATIONS.powi(2) * variance).sqrt()
    }

    /// The squared distance between a detection and an item, in standard deviations. They are `off`
    /// [m] apart along and across the belt, which has travelled `way` [m] since the item was last
    /// seen.
    pub(crate) fn squared_distance(
        self,
        off: [f64; 2],
        seen: Option<Covariance>,
        known: Option<Covariance>,
        way: f64,
    ) -> f64 {
        let variance = |gate: f64| (gate / DEVIATIONS).powi(2);
        let own = variance(self.tolerance);
        let drift = variance((DRIFT * way.abs()).min(self.tolerance));
        let [a, b] = [seen, known].map(|covariance| limited(covariance.unwrap_or_default()));
        let (xx, xy, yy) = (own + drift + a[0] + b[0], a[1] + b[1], own + a[2] + b[2]);
        let [dx, dy] = off;
        (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / (xx * yy - xy * xy)
    }
}

/// Whether a squared distance is within the gate.
fn is_inside(squared_distance: f64) -> bool {
    squared_distance <= DEVIATIONS * DEVIATIONS
}

/// Whether a squared distance is within twice the gate: near enough to be confused.
pub(crate) fn is_near(squared_distance: f64) -> bool {
    squared_distance <= (2.0 * DEVIATIONS).powi(2)
}

/// Whether a squared distance is within half the gate: so near that two items are probably one.
pub(crate) fn is_close(squared_distance: f64) -> bool {
    squared_distance <= (0.5 * DEVIATIONS).powi(2)
}

/// The cost of matching a detection to an item at a squared distance, or none if it is too far
/// away. The position decides. An id counts only beyond the gate, where it beats a new item, and as
/// a tie-break between items that are equally near.
pub(crate) fn cost(squared_distance: f64, number: Number, may_move: bool) -> Option<f64> {
    let gate = DEVIATIONS * DEVIATIONS;
    match number {
        Number::Same if !is_inside(squared_distance) => {
            let is_near = may_move && squared_distance <= KNOWN * KNOWN * gate;
            is_near.then_some(gate)
        }
        _ if !is_inside(squared_distance) => None,
        Number::Other => Some(squared_distance + RENUMBERED),
        Number::Same | Number::Unknown => Some(squared_distance),
    }
}

/// The cost of matching a detection to none of the known items.
pub(crate) fn cost_of_new(is_doubled: bool) -> f64 {
    if is_doubled { DOUBLED } else { NEW }
}

/// The largest variance in any direction [m^2], limited by `WIDEST`.
pub(crate) fn largest_variance(covariance: Option<Covariance>) -> f64 {
    let [xx, xy, yy] = covariance.unwrap_or_default();
    let most = 0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy);
    most.min(WIDEST * WIDEST)
}

/// The covariance, reduced if it is so wide that neighbours would merge.
fn limited(covariance: Covariance) -> Covariance {
    let [xx, xy, yy] = covariance;
    let most = 0.5 * (xx + yy) + (0.5 * (xx - yy)).hypot(xy);
    let share = if most > WIDEST * WIDEST {
        WIDEST * WIDEST / most
    } else {
        1.0
    };
    covariance.map(|value| share * value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(off: [f64; 2], seen: Option<Covariance>, way: f64) -> f64 {
        let gate = AssociationGate::new(0.02);
        gate.squared_distance(off, seen, None, way).sqrt()
    }

    #[test]
    fn the_gate_is_the_tolerance_where_nothing_else_is_known() {
        assert!((distance([0.02, 0.0], None, 0.0) - 3.0).abs() < 1e-12);
        assert!((distance([0.012, 0.016], None, 0.0) - 3.0).abs() < 1e-12);
        // With zero tolerance, the same position.
        let exact = AssociationGate::new(0.0);
        assert!(exact.squared_distance([1e-5, 0.0], None, None, 0.0) < 1.0);
        assert!(exact.squared_distance([1e-3, 0.0], None, None, 0.0) > 9.0);
    }

    #[test]
    fn covariances_and_the_way_since_widen_it() {
        // 10 mm across the belt, nothing along it.
        let across = Some([0.0, 0.0, 1e-4]);
        assert!(distance([0.0, 0.03], across, 0.0) < 3.0);
        assert!((distance([0.02, 0.0], across, 0.0) - 3.0).abs() < 1e-12);
        // Along a diagonal.
        let diagonal = Some([1e-4, 0.99e-4, 1e-4]);
        assert!(distance([0.025, 0.025], diagonal, 0.0) < 3.0);
        assert!(distance([0.025, -0.025], diagonal, 0.0) > 3.0);
        // 1 % of 2 m, along the belt only, and at most the tolerance.
        assert!(distance([0.028, 0.0], None, 2.0) < 3.0);
        assert!(distance([0.0, 0.021], None, 2.0) > 3.0);
        assert!(distance([0.029, 0.0], None, 500.0) > 3.0);
        // A useless covariance merges no neighbours.
        assert!(distance([0.2, 0.0], Some([1.0, 0.0, 1.0]), 0.0) > 3.0);
    }

    #[test]
    fn everything_in_the_gate_is_within_reach() {
        let gate = AssociationGate::new(0.02);
        for seen in [None, Some([4e-4, 1e-4, 1e-3]), Some([1.0, 0.9, 1.0])] {
            for known in [None, Some([9e-4, 0.0, 1e-5])] {
                let reach = gate.reach(seen, largest_variance(known));
                for degree in 0..360 {
                    let (sin, cos) = f64::from(degree).to_radians().sin_cos();
                    let off = [reach * cos, reach * sin].map(|off| 1.000_001 * off);
                    let squared = gate.squared_distance(off, seen, known, 1e3);
                    assert!(squared > 9.0, "{seen:?} {known:?} {degree}");
                }
            }
        }
    }

    #[test]
    fn the_place_comes_first_and_the_id_second() {
        // Within the gate a known id counts little, beyond it everything.
        assert!(cost(2.0, Number::Same, true) < cost(2.0, Number::Other, true));
        assert!(cost(0.5, Number::Other, true) < cost(8.0, Number::Same, true));
        assert_eq!(cost(9.1, Number::Other, true), None);
        assert_eq!(cost(9.1, Number::Unknown, true), None);
        assert!(cost(80.0, Number::Same, true).is_some());
        assert_eq!(cost(82.0, Number::Same, true), None);
        assert_eq!(cost(9.1, Number::Same, false), None);
        // Nothing in the gate costs more than a new item.
        for number in [Number::Same, Number::Other, Number::Unknown] {
            assert!(cost(9.0, number, true).unwrap() < cost_of_new(false));
        }
        assert!(cost(80.0, Number::Same, true).unwrap() < cost_of_new(false));
    }
}
