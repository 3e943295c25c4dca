//! The region that an arm can occupy under any strategy, and thus which arms can meet.

use super::polygon::Polygon;
use super::segment::Segment;
use crate::station::{Belt, Robot, Station};
use nalgebra::Point2;
use std::f64::consts::TAU;

/// Number of corners of the polygon that approximates a circle. Its edges are at most 0.0003 radii
/// inside the circle.
const CORNERS: u32 = 128;

/// The intersection of two regions.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Shared {
    /// The range along the travel [m].
    pub x: [f64; 2],
    /// Area of the intersection [m^2].
    pub area: f64,
}

/// Two robots whose arms can touch.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Overlap {
    /// Indices of the robots, upstream first.
    pub robots: [usize; 2],
    /// The intersection of their workspaces on the belt; `None` if only their paths to the bins
    /// overlap.
    pub workspaces: Option<Shared>,
    /// The intersection of the regions that their arms sweep.
    pub swept: Shared,
    /// Distance between the arms while both rest [m].
    pub at_rest: f64,
}

/// How far apart the arms of a station stay.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Apart {
    /// The pairs of robots whose arms can touch, upstream first.
    pub overlaps: Vec<Overlap>,
    /// Other pairs whose arms can come closer than [`MARGIN`], and how close [m].
    pub near: Vec<(f64, [usize; 2])>,
    /// The smallest possible distance between the arms of the remaining pairs [m], and the pair;
    /// `None` if there are no other pairs.
    pub others: Option<(f64, [usize; 2])>,
}

impl Apart {
    /// Whether any arms can touch or come closer than [`MARGIN`].
    pub fn is_doubtful(&self) -> bool {
        !self.overlaps.is_empty() || !self.near.is_empty()
    }
}

/// Arms closer than this may touch, since they have a thickness that the model ignores [m].
pub const MARGIN: f64 = 0.05;

/// Determines which arms of `station` can touch, from geometry alone.
///
/// A tool point is on a line from a bin, or from where it rests, to a position on the belt within
/// reach. An arm therefore stays inside the convex hull of its base, its bins, its rest and the part
/// of the belt within its reach, and can be anywhere in it. Arms whose hulls are disjoint never touch.
pub fn apart(station: &Station) -> Apart {
    let robots = station.robots();
    let belt = station.belt();
    let workspaces: Vec<Polygon> = robots.iter().map(|r| workspace(r, belt)).collect();
    let swept: Vec<Polygon> = robots
        .iter()
        .zip(&workspaces)
        .map(|(robot, workspace)| {
            let mut points = workspace.corners().to_vec();
            points.extend([robot.base, robot.rest]);
            points.extend(robot.bins.iter().map(|bin| bin.at));
            Polygon::hull(points)
        })
        .collect();
    let mut found = Apart {
        overlaps: Vec::new(),
        near: Vec::new(),
        others: None,
    };
    for first in 0..robots.len() {
        for second in first + 1..robots.len() {
            let (one, other) = (&swept[first], &swept[second]);
            let least = found.others.map_or(f64::INFINITY, |(distance, _)| distance);
            let boxes = between(one.bounds(), other.bounds());
            if boxes > least.max(MARGIN) {
                continue;
            }
            let both = one.intersection(other);
            let at_rest = arm_at_rest(&robots[first]).nearest(&arm_at_rest(&robots[second]));
            // A robot that cannot reach the belt sweeps a line without an area.
            let line = one.corners().len().min(other.corners().len()) < 3;
            let inside = line && !both.corners().is_empty();
            if shares(&both) || inside || at_rest.distance == 0.0 {
                let workspaces = workspaces[first].intersection(&workspaces[second]);
                found.overlaps.push(Overlap {
                    robots: [first, second],
                    workspaces: shares(&workspaces).then(|| shared(&workspaces)),
                    swept: shared(&both),
                    at_rest: at_rest.distance,
                });
                continue;
            }
            let distance = one.distance(other);
            // Not if the distance equals the margin except for rounding.
            if distance < MARGIN - 1e-9 {
                found.near.push((distance, [first, second]));
            }
            if distance < least {
                found.others = Some((distance, [first, second]));
            }
        }
    }
    found
}

/// The part of the belt within reach of `robot`.
fn workspace(robot: &Robot, belt: &Belt) -> Polygon {
    let corner = |i: u32| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(CORNERS)).sin_cos();
        Point2::new(
            robot.base.x + robot.reach * cos,
            robot.base.y + robot.reach * sin,
        )
    };
    let half = 0.5 * belt.width;
    let belt = Polygon::hull(vec![
        Point2::new(0.0, -half),
        Point2::new(belt.length, -half),
        Point2::new(belt.length, half),
        Point2::new(0.0, half),
    ]);
    Polygon::hull((0..CORNERS).map(corner).collect()).intersection(&belt)
}

fn arm_at_rest(robot: &Robot) -> Segment {
    Segment {
        from: robot.base,
        to: robot.rest,
    }
}

/// Whether a polygon is larger than rounding can produce along an edge that two regions share.
fn shares(polygon: &Polygon) -> bool {
    polygon.area() > 1e-9
}

fn shared(polygon: &Polygon) -> Shared {
    let [x, _] = polygon.bounds();
    Shared {
        x,
        area: polygon.area(),
    }
}

/// Distance between two boxes [m].
fn between([ax, ay]: [[f64; 2]; 2], [bx, by]: [[f64; 2]; 2]) -> f64 {
    let gap = |a: [f64; 2], b: [f64; 2]| (a[0] - b[1]).max(b[0] - a[1]).max(0.0);
    gap(ax, bx).hypot(gap(ay, by))
}
