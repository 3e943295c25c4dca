//! A line of identical robots on alternating sides of the belt.

use super::geometry::{Belt, Robot, check_count, distance, dwell, position, positive};
use crate::error::Result;
use nalgebra::Point2;

/// Identical robots at equal spacing on alternating sides, the first at y < 0 (Jermann et al.:
/// identical agents "lined up on both sides of the conveyor belt in alternating fashion").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Number of robots.
    pub robots: usize,
    /// x of the first base [m].
    pub first_base_x: f64,
    /// Distance between neighbouring bases along x [m].
    pub spacing: f64,
    /// Distance of the bases from the belt's edge, outwards [m].
    pub base_offset: f64,
    /// Distance of the bins from the belt's edge, outwards, at the base's x [m].
    pub bin_offset: f64,
    /// Length of belt after the last base x + reach [m].
    pub tail: f64,
    /// Reach of each robot [m].
    pub reach: f64,
    /// End-effector speed of each robot [m/s].
    pub speed: f64,
    /// Dwell time at the grasp [s].
    pub grasp_time: f64,
    /// Dwell time at the release [s].
    pub release_time: f64,
}

impl Line {
    /// Checks the line's own values, so that errors name them rather than the values derived from
    /// them. `place` turns a key such as `line.reach` into the place that messages name.
    ///
    /// # Errors
    /// The first invalid value.
    pub(super) fn check(&self, place: &dyn Fn(&str) -> String) -> Result<()> {
        check_count(place, self.robots)?;
        position(place, "line.first_base_x", self.first_base_x)?;
        distance(place, "line.spacing", self.spacing)?;
        position(place, "line.base_offset", self.base_offset)?;
        position(place, "line.bin_offset", self.bin_offset)?;
        distance(place, "line.tail", self.tail)?;
        positive(place, "line.reach", self.reach)?;
        positive(place, "line.speed", self.speed)?;
        dwell(place, "line.grasp_time", self.grasp_time)?;
        dwell(place, "line.release_time", self.release_time)
    }

    /// x of the base of the robot with this index [m].
    fn base_x(&self, index: usize) -> f64 {
        self.first_base_x + index as f64 * self.spacing
    }

    /// Belt length derived from the line [m].
    pub fn belt_length(&self) -> f64 {
        self.base_x(self.robots.saturating_sub(1)) + self.reach + self.tail
    }

    /// The robots `r1`, `r2`, ... along a belt of the given width [m].
    pub fn place(&self, width: f64) -> Vec<Robot> {
        (0..self.robots)
            .map(|i| {
                let x = self.base_x(i);
                let side = if i % 2 == 0 { -1.0 } else { 1.0 };
                let edge = width / 2.0;
                Robot {
                    name: format!("r{}", i + 1),
                    base: Point2::new(x, side * (edge + self.base_offset)),
                    bin: Point2::new(x, side * (edge + self.bin_offset)),
                    reach: self.reach,
                    speed: self.speed,
                    grasp_time: self.grasp_time,
                    release_time: self.release_time,
                }
            })
            .collect()
    }

    /// The belt of this line, with the given speed [m/s] and width [m].
    pub fn belt(&self, speed: f64, width: f64) -> Belt {
        Belt {
            speed,
            length: self.belt_length(),
            width,
        }
    }
}
