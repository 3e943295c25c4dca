//! One item as one robot sees it.

use crate::kinematics;
use crate::station::{Robot, Station};

/// An item that a robot can still reach, with its departure window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// Index of the item in its pattern (furthest downstream first).
    pub item: u32,
    /// Position along the travel at time 0, as reported [m].
    pub x0: f64,
    /// Position across the belt, as reported [m].
    pub y: f64,
    /// Object-specific reward.
    pub weight: f64,
    /// First departure at which the robot, knowing of the item, meets it in its
    /// workspace [s].
    pub open: f64,
    /// Last such departure [s].
    pub close: f64,
}

impl Candidate {
    /// Whether this item is further downstream than `other`, or as far with a lower
    /// index.
    #[inline(always)]
    pub fn is_before(&self, other: &Self) -> bool {
        self.x0 > other.x0 || (self.x0 == other.x0 && self.item < other.item)
    }
}

/// A robot about to decide, and when: what turns a [`Candidate`] into figures.
///
/// The figures are computed when asked for, so a rule pays only for what it ranks by.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// The deciding robot.
    pub robot: &'a Robot,
    /// Belt speed [m/s].
    pub belt_speed: f64,
    /// Time of the decision [s].
    pub time: f64,
}

impl<'a> Moment<'a> {
    /// Robot `index` of `station` deciding at `time` [s].
    pub fn new(station: &'a Station, index: usize, time: f64) -> Self {
        Self {
            robot: &station.robots()[index],
            belt_speed: station.belt().speed,
            time,
        }
    }

    /// Position of the item along the travel now [m].
    #[inline(always)]
    pub fn x(&self, candidate: &Candidate) -> f64 {
        candidate.x0 + self.belt_speed * self.time
    }

    /// Time from the bin to the meeting point [s].
    #[inline(always)]
    pub fn travel_time(&self, candidate: &Candidate) -> f64 {
        kinematics::travel_time(
            self.x(candidate) - self.robot.bin.x,
            candidate.y - self.robot.bin.y,
            self.belt_speed,
            self.robot.speed,
        )
    }

    /// Whole time of the pick, until the robot is free again [s].
    #[inline(always)]
    pub fn processing_time(&self, candidate: &Candidate) -> f64 {
        kinematics::processing_time(
            self.travel_time(candidate),
            self.robot.grasp_time,
            self.robot.release_time,
        )
    }

    /// Distance from the item, where it is now, to the robot's base [m].
    #[inline(always)]
    pub fn distance_to_base(&self, candidate: &Candidate) -> f64 {
        kinematics::distance(
            self.x(candidate) - self.robot.base.x,
            candidate.y - self.robot.base.y,
        )
    }
}
