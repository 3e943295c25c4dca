//! The conveyor.

use crate::kinematics;
use nalgebra::Point2;

/// The conveyor. It covers `0 <= x <= length`, `|y| <= width / 2` and moves along +x.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belt {
    /// Speed along +x [m/s].
    pub speed: f64,
    /// Length along x [m].
    pub length: f64,
    /// Width along y [m].
    pub width: f64,
}

impl Belt {
    /// Distance from a place to the nearest point of the belt [m]; 0 on the belt.
    pub(super) fn distance_to(&self, place: Point2<f64>) -> f64 {
        let dx = place.x - place.x.clamp(0.0, self.length);
        let dy = (place.y.abs() - self.width / 2.0).max(0.0);
        kinematics::distance(dx, dy)
    }
}
