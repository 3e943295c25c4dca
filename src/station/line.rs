//! A line of identical robots on alternating sides of the belt.

use super::belt::Belt;
use super::check;
use super::robot::{Bin, Robot};
use crate::error::Result;
use crate::kinematics::Arm;
use nalgebra::{Point2, Vector2};

/// Identical robots at equal spacing on alternating sides, the first at y < 0 (Jermann et al.:
/// identical agents "lined up on both sides of the conveyor belt in alternating fashion").
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Number of robots.
    pub robots: usize,
    /// x of the first base [m].
    pub first_base_x: f64,
    /// Distance between neighbouring bases along x [m].
    pub spacing: f64,
    /// Distance of the bases from the belt's edge, outwards [m].
    pub base_offset: f64,
    /// Where the bins are.
    pub bins: LineBins,
    /// Where each robot rests, relative to its base [m], y away from the belt; `None` for its first
    /// bin.
    pub rest: Option<Vector2<f64>>,
    /// Length of belt after the last base x + reach [m].
    pub tail: f64,
    /// Reach of each robot [m].
    pub reach: f64,
    /// How each arm travels.
    pub arm: Arm,
    /// Dwell time at the grasp [s].
    pub grasp_time: f64,
    /// Dwell time at the release [s], into a bin that has none of its own.
    pub release_time: f64,
}

/// The bins of every robot of a line.
#[derive(Debug, Clone, PartialEq)]
pub enum LineBins {
    /// One bin at the base's x, at this distance from the belt's edge, outwards [m].
    AtEdge(f64),
    /// Bins whose positions are relative to the base [m], y away from the belt.
    AtBase(Vec<Bin>),
}

impl Line {
    /// Checks the line's own values, so that errors name them rather than the values derived from
    /// them. `place` turns a key such as `line.reach` into the place that messages name.
    ///
    /// # Errors
    /// The first invalid value.
    pub(super) fn check(&self, place: &dyn Fn(&str) -> String) -> Result<()> {
        check::count(place, self.robots)?;
        check::position(place, "line.first_base_x", self.first_base_x)?;
        check::distance(place, "line.spacing", self.spacing)?;
        check::position(place, "line.base_offset", self.base_offset)?;
        if let LineBins::AtEdge(offset) = self.bins {
            check::position(place, "line.bin_offset", offset)?;
        }
        for coordinate in self.rest.iter().flat_map(|rest| [rest.x, rest.y]) {
            check::position(place, "line.rest", coordinate)?;
        }
        check::distance(place, "line.tail", self.tail)?;
        check::positive(place, "line.reach", self.reach)?;
        check::dwell(place, "line.grasp_time", self.grasp_time)?;
        check::dwell(place, "line.release_time", self.release_time)
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
                let base = Point2::new(x, side * (edge + self.base_offset));
                let beside = |offset: Vector2<f64>| base + Vector2::new(offset.x, side * offset.y);
                let bins = match &self.bins {
                    LineBins::AtEdge(offset) => {
                        let at = Point2::new(x, side * (edge + offset));
                        vec![Bin::only(at, self.release_time)]
                    }
                    LineBins::AtBase(bins) => bins
                        .iter()
                        .map(|bin| Bin {
                            at: beside(bin.at.coords),
                            ..bin.clone()
                        })
                        .collect(),
                };
                Robot {
                    name: format!("r{}", i + 1),
                    base,
                    reach: self.reach,
                    arm: self.arm.clone(),
                    grasp_time: self.grasp_time,
                    rest: self
                        .rest
                        .map_or_else(|| bins.first().map_or(base, |bin| bin.at), beside),
                    bins,
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
