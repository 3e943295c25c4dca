//! The model's definitions, written down apart from the engines: bins, travel times, and what can be
//! met.

use super::violation::Terms;
use crate::decision::LeftReason;
use crate::kinematics::TravelLaw;
use crate::pattern::{Item, Pattern};
use crate::station::{Robot, Station};
use nalgebra::Point2;

/// What attempts are checked against.
pub(super) struct CheckedLine<'a> {
    pub station: &'a Station,
    pub pattern: &'a Pattern,
    /// What the run is judged by, besides the model.
    pub terms: Terms,
}

/// Largest deviation from the model [m or s] that is attributed to rounding, per unit of the times
/// and lengths involved.
const TOLERANCE: f64 = 1e-9;

/// Allowance for rounding of a time or length of this size [m or s].
pub(super) fn slack(size: f64) -> f64 {
    TOLERANCE * (1.0 + size.abs())
}

/// The bin that the model gives items of this class, by its definition.
pub(super) fn bin_of(robot: &Robot, class: Option<&str>) -> Option<usize> {
    let names =
        |classes: &Vec<String>| class.is_some_and(|class| classes.iter().any(|c| c == class));
    let mut bins = robot.bins.iter();
    let named = bins.position(|bin| bin.classes.as_ref().is_some_and(names));
    named.or_else(|| robot.bins.iter().position(|bin| bin.classes.is_none()))
}

/// Why the model leaves an item on the belt on purpose.
pub(super) fn left_reason(station: &Station, item: &Item) -> Option<LeftReason> {
    let class = item.class.as_deref();
    let mut stated = station.classes().iter();
    if stated.any(|stated| Some(stated.name.as_str()) == class && !stated.wanted) {
        return Some(LeftReason::Unwanted);
    }
    let mut robots = station.robots().iter();
    let taken = robots.any(|robot| bin_of(robot, class).is_some());
    (!taken).then_some(LeftReason::NoBin)
}

/// The weight of an item: its own, or its reward times the value of its class.
pub(super) fn weight_of(station: &Station, item: &Item) -> f64 {
    let mut stated = station.classes().iter();
    let stated = stated.find(|stated| Some(&stated.name) == item.class.as_ref());
    match (item.weight, stated) {
        (None, Some(class)) => class.value * item.reward(),
        _ => item.reward(),
    }
}

/// Time [s] for a move over this distance in the plane [m]: the lift, and then the profile of the
/// speed, whose peak is at most the top speed.
pub(super) fn move_time(robot: &Robot, distance: f64) -> f64 {
    let length = distance + 2.0 * robot.arm.lift;
    match &robot.arm.law {
        TravelLaw::Constant { speed } => length / speed,
        TravelLaw::Trapezoid {
            speed,
            acceleration: a,
            deceleration: b,
        } => {
            let peak = speed.min((2.0 * length * a * b / (a + b)).sqrt());
            if peak == 0.0 {
                return 0.0;
            }
            let ramps = peak * peak * (0.5 / a + 0.5 / b);
            peak / a + peak / b + (length - ramps) / peak
        }
        TravelLaw::Table(points) => {
            let last = points.len() - 2;
            let piece = (0..last)
                .find(|&i| length < points[i + 1].0)
                .unwrap_or(last);
            let ((l0, t0), (l1, t1)) = (points[piece], points[piece + 1]);
            let share = (length - l0) / (l1 - l0);
            t0 * (1.0 - share) + t1 * share
        }
    }
}

/// Whether the robot can meet the item within reach and on the belt if it leaves at some time >= 0.
/// Considers the meeting point furthest downstream.
pub(super) fn can_be_met(station: &Station, robot: &Robot, x0: f64, y: f64) -> bool {
    let belt = station.belt();
    let dy = (y - robot.base.y).abs();
    if dy > robot.reach {
        return false;
    }
    let half = ((robot.reach - dy) * (robot.reach + dy)).sqrt();
    let low = (robot.base.x - half).max(0.0);
    let high = (robot.base.x + half).min(belt.length);
    let bins = robot.bins.iter().map(|bin| bin.at);
    let mut places = bins.chain([robot.rest]);
    let in_time = |from: Point2<f64>| {
        let way = (high - from.x).hypot(y - from.y);
        (high - x0) / belt.speed >= move_time(robot, way)
    };
    low <= high && places.any(in_time)
}
