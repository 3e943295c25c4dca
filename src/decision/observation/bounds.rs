//! Between which values each feature lies on a station, whatever the patterns are.
//!
//! Every range contains 0, because empty slots and the observation after the end of an episode are
//! zero. The bounds follow from the geometry: an item is met within reach of the robot's base, so no
//! move is longer than the way from a bin to the far side of the workspace. Two features depend on the
//! items themselves: the number of items, which is at most that of a pattern, and the reward.

use super::full::{self, NEVER, Scale, count};
use super::paper;
use super::real::relative;
use crate::pattern::MOST_ITEMS;
use crate::station::{Robot, Station};
use nalgebra::Point2;

/// The least and the greatest value of a feature.
type Bounds = (f32, f32);

/// A flag, or a share that is not computed.
const SHARE: Bounds = (0.0, 1.0);

/// Share by which bounds of computed features are wider than without rounding. A mean over the robots of
/// a long line, in f32, is as inexact as that.
const ROUNDING: f64 = 1e-5;

/// From `low` to `high`, and wide enough for rounding.
fn about(low: f64, high: f64) -> Bounds {
    let margin = ROUNDING * low.abs().max(high.abs()).max(1.0);
    ((low - margin) as f32, (high + margin) as f32)
}

/// From the least to the greatest of `values` and 0.
fn around(values: impl Iterator<Item = f64>) -> Bounds {
    let (low, high) = values.fold((0.0f64, 0.0f64), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    about(low, high)
}

/// What the features depend on.
pub(super) struct Line<'a> {
    pub station: &'a Station,
    /// Position of the camera [m], if there is one.
    pub camera_x: Option<f64>,
    /// No item has a higher reward.
    pub most_weight: f64,
}

/// The bounds of the globals and of the features of a slot.
type ViewBounds = (Vec<Bounds>, Vec<Bounds>);

impl Line<'_> {
    /// Those of the paper's observation.
    pub(super) fn paper(&self) -> ViewBounds {
        (self.paper_globals(), self.paper_slot())
    }

    /// Those of the full observation.
    pub(super) fn full(&self) -> ViewBounds {
        (self.full_globals(), self.full_slot())
    }

    /// Those of the observation for real lines.
    pub(super) fn real(&self) -> ViewBounds {
        (self.real_globals(), self.real_slot())
    }

    /// The greatest value of a figure of the robots.
    fn most(&self, figure: impl Fn(&Robot) -> f64) -> f64 {
        let robots = self.station.robots().iter();
        robots.map(figure).fold(0.0, f64::max)
    }

    /// The points of every robot that `of` lists, relative to its base, along and across.
    fn places(&self, of: impl Fn(&Robot) -> Vec<Point2<f64>>) -> [Bounds; 2] {
        let robots = self.station.robots().iter();
        let places: Vec<(f32, f32)> = robots
            .flat_map(|robot| of(robot).into_iter().map(|at| relative(robot, at)))
            .collect();
        [
            around(places.iter().map(|place| f64::from(place.0))),
            around(places.iter().map(|place| f64::from(place.1))),
        ]
    }

    /// How far upstream of its base an item is at most when `robot` leaves for it [m].
    fn upstream(&self, robot: &Robot) -> f64 {
        robot.reach + self.station.belt().speed * robot.longest_way_out()
    }

    /// Any time on the logarithmic scale.
    fn log(&self) -> Bounds {
        about(
            0.0,
            self.most(|robot| f64::from(Scale::of(robot).log(f64::INFINITY))),
        )
    }

    fn paper_globals(&self) -> Vec<Bounds> {
        let robot = [SHARE, about(0.0, paper::LONGEST)];
        robot.repeat(paper::ROBOTS)
    }

    fn paper_slot(&self) -> Vec<Bounds> {
        let reach = self.most(|robot| robot.reach);
        vec![
            about(-self.most(|robot| self.upstream(robot)), reach),
            about(-reach, reach),
            about(0.0, self.most(Robot::longest_pick)),
            about(0.0, self.most_weight),
        ]
    }

    fn full_globals(&self) -> Vec<Bounds> {
        let belt = self.station.belt();
        let log = self.log();
        let items = about(0.0, f64::from(count(MOST_ITEMS as f32)));
        let mut globals = vec![items; full::GLOBALS];
        globals[0..3].fill(SHARE);
        globals[3] = about(0.0, self.station.robots().len() as f64 / 6.0);
        (globals[4], globals[5]) = (SHARE, log);
        (globals[6], globals[7]) = (SHARE, log);
        globals[8] = log;
        globals[16] = about(0.0, self.most(|robot| belt.speed / robot.cruising_speed()));
        globals[17] = log;
        globals[18] = about(
            0.0,
            self.most(|robot| robot.mean_dwell() / robot.crossing_time()),
        );
        globals[19] = about(self.camera_x.unwrap_or(0.0).min(0.0) / belt.length, 1.0);
        globals
    }

    fn full_slot(&self) -> Vec<Bounds> {
        let never = f64::from(NEVER);
        let log = self.log();
        let half = |time: f64, robot: &Robot| time / (2.0 * robot.crossing_time());
        let pick = about(0.0, self.most(|robot| half(robot.longest_pick(), robot)));
        let longest = self.most(Robot::longest_pick);
        let of_others = self.most(|robot| half(longest, robot));
        let upstream = self.most(|robot| self.upstream(robot) / robot.reach);
        vec![
            SHARE,
            about(-upstream, 1.0),
            about(-1.0, 1.0),
            pick,
            // The item is then between its ends upstream and downstream.
            about(0.0, 0.5 * (upstream + 1.0)),
            log,
            about(0.0, self.most_weight),
            pick,
            log,
            pick,
            about(0.0, 1.0),
            SHARE,
            (log.0, log.1.max(NEVER)),
            about(0.0, of_others.max(never)),
            log,
            pick,
            log,
        ]
    }

    fn real_globals(&self) -> Vec<Bounds> {
        let belt = self.station.belt();
        let mut globals = self.full_globals();
        let arm = |robot: &Robot| {
            (0..robot.places())
                .map(|place| robot.place(place))
                .collect()
        };
        globals.extend(self.places(arm));
        globals.extend([
            about(0.0, 1.0),
            about(0.0, self.most(|robot| 2.0 * robot.arm.lift / robot.reach)),
            about(0.0, self.most(|robot| robot.bins.len() as f64 / 4.0)),
            self.places(|_| vec![Point2::origin()])[1],
            about(0.0, self.most(|robot| belt.width / robot.reach)),
            about(0.0, 1.0),
            about(0.0, 1.0),
        ]);
        globals
    }

    fn real_slot(&self) -> Vec<Bounds> {
        let mut slot = self.full_slot();
        slot.extend([SHARE, SHARE]);
        slot.extend(self.places(|robot| robot.bins.iter().map(|bin| bin.at).collect()));
        slot
    }
}
