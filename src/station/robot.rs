//! One robot: its arm, its workspace, its bins, and the departure windows of items.

use super::belt::Belt;
use crate::kinematics::{self, Arm, TravelLaw};
use nalgebra::{Point2, Vector2};

/// Where a robot releases items.
#[derive(Debug, Clone, PartialEq)]
pub struct Bin {
    /// Name, unique in its robot.
    pub name: String,
    /// Position [m].
    pub at: Point2<f64>,
    /// The classes that go into this bin; `None` for every class that no other bin of the robot
    /// names, and for items without a class.
    pub classes: Option<Vec<String>>,
    /// Dwell time at the release [s].
    pub release_time: f64,
}

impl Bin {
    /// The bin `b1` of a robot with only one, which takes every class.
    pub fn only(at: Point2<f64>, release_time: f64) -> Self {
        Self {
            name: default_bin_name(0),
            at,
            classes: None,
            release_time,
        }
    }
}

/// The name of a robot's bin with this index if the station does not give one.
pub(super) fn default_bin_name(index: usize) -> String {
    format!("b{}", index + 1)
}

/// One arm beside the belt.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Name, unique in the station.
    pub name: String,
    /// Base, the centre of the workspace [m].
    pub base: Point2<f64>,
    /// Radius of the workspace around the base [m].
    pub reach: f64,
    /// How the arm travels; faster than the belt at every distance.
    pub arm: Arm,
    /// Dwell time at the grasp [s].
    pub grasp_time: f64,
    /// Where the arm is until its first item [m].
    pub rest: Point2<f64>,
    /// The bins, at least one.
    pub bins: Vec<Bin>,
}

impl Robot {
    /// A robot that rests at its only bin and needs no time at the item and at the bin; see
    /// [`Robot::with_dwell`]. `base` and `bin` are positions, `reach` the radius of the workspace
    /// [m].
    pub fn new(
        name: impl Into<String>,
        base: Point2<f64>,
        bin: Point2<f64>,
        reach: f64,
        arm: Arm,
    ) -> Self {
        Self {
            name: name.into(),
            base,
            reach,
            arm,
            grasp_time: 0.0,
            rest: bin,
            bins: vec![Bin::only(bin, 0.0)],
        }
    }

    /// The same robot with these dwell times at the grasp and at the release into any bin [s].
    #[must_use]
    pub fn with_dwell(mut self, grasp_time: f64, release_time: f64) -> Self {
        self.grasp_time = grasp_time;
        for bin in &mut self.bins {
            bin.release_time = release_time;
        }
        self
    }

    /// The same robot resting at `bin` [m], its only bin, which takes everything.
    #[must_use]
    pub fn with_only_bin(mut self, bin: Point2<f64>) -> Self {
        self.bins = vec![Bin::only(bin, self.bins[0].release_time)];
        self.rest = bin;
        self
    }

    /// Whether this is the paper's robot: an arm of constant speed without lift, from and to one
    /// bin that takes everything.
    pub fn is_plain(&self) -> bool {
        self.arm.constant_speed().is_some() && self.places() == 1 && self.has_only_bin()
    }

    /// Whether it has one bin that takes everything and has no name of its own.
    pub fn has_only_bin(&self) -> bool {
        match self.bins.as_slice() {
            [bin] => bin.name == default_bin_name(0) && bin.classes.is_none(),
            _ => false,
        }
    }

    /// Number of places from which the arm may leave: its bins, and its rest if no bin is there.
    #[inline]
    pub fn places(&self) -> usize {
        self.start().max(self.bins.len() - 1) + 1
    }

    /// The place where the arm is at the beginning: the first bin at its rest, or one more than the
    /// last bin.
    #[inline]
    pub fn start(&self) -> usize {
        let at_rest = |bin: &Bin| bin.at == self.rest;
        self.bins
            .iter()
            .position(at_rest)
            .unwrap_or(self.bins.len())
    }

    /// Position [m] of the place with this index: a bin, or the rest after the last bin.
    #[inline(always)]
    pub fn place(&self, index: usize) -> Point2<f64> {
        self.bins.get(index).map_or(self.rest, |bin| bin.at)
    }

    /// Time [s] for a move as long as the reach, a scale of the robot's times.
    pub fn crossing_time(&self) -> f64 {
        match self.arm.law {
            // A table may say that a move takes no time.
            TravelLaw::Table(_) => self.arm.law.time(self.reach).max(1e-9),
            _ => self.arm.law.time(self.reach),
        }
    }

    /// Mean speed [m/s] of a move as long as the reach: the speed of an arm that moves at only one.
    pub fn cruising_speed(&self) -> f64 {
        match self.arm.law {
            TravelLaw::Constant { speed } => speed,
            _ => self.reach / self.crossing_time(),
        }
    }

    /// Dwell time at the grasp, and at the release as a mean over the bins [s].
    pub fn mean_dwell(&self) -> f64 {
        let releases = self.bins.iter().map(|bin| bin.release_time);
        self.grasp_time + releases.sum::<f64>() / self.bins.len() as f64
    }

    /// The longest time [s] for a move to an item, from any of its places: no item is met farther from
    /// the base than the reach.
    pub fn longest_way_out(&self) -> f64 {
        let places = (0..self.places()).map(|index| self.place(index));
        places.map(|at| self.longest_move(at)).fold(0.0, f64::max)
    }

    /// A time [s] that no pick exceeds.
    pub fn longest_pick(&self) -> f64 {
        let bins = self.bins.iter();
        let back = bins.map(|bin| self.longest_move(bin.at) + bin.release_time);
        self.longest_way_out() + self.grasp_time + back.fold(0.0, f64::max)
    }

    /// Time [s] for a move between `at` and the far side of the workspace.
    fn longest_move(&self, at: Point2<f64>) -> f64 {
        let way = kinematics::distance(at.x - self.base.x, at.y - self.base.y);
        self.arm.time(way + self.reach)
    }

    /// The bin for items of this class; `None` if this robot cannot take them.
    pub fn bin_for(&self, class: Option<&str>) -> Option<usize> {
        let names = |bin: &Bin| {
            let classes = bin.classes.iter().flatten();
            class.is_some_and(|class| classes.into_iter().any(|own| own == class))
        };
        let named = self.bins.iter().position(names);
        named.or_else(|| self.bins.iter().position(|bin| bin.classes.is_none()))
    }

    /// Departure window `[open, close]` [s], from the place with index `place`, of an item that was
    /// at (`x0`, `y`) [m] at time 0: the departure times at which this robot still meets it inside
    /// its workspace, ends included. The item is in the robot's *extended workspace* (Jermann et al.,
    /// section on the custom environment) exactly while the departure time lies in the window.
    /// `None` if the robot can never reach the item from there.
    #[inline(always)]
    pub fn departure_window(
        &self,
        belt: &Belt,
        place: usize,
        x0: f64,
        y: f64,
    ) -> Option<(f64, f64)> {
        let (x_in, x_out) =
            kinematics::meeting_range(self.base.x, self.base.y, self.reach, y, belt.length)?;
        let from = self.place(place);
        let from = (from.x, from.y);
        let leave = |x: f64| self.arm.departure_time(x, (x0, y), from, belt.speed);
        let close = leave(x_out);
        if close < 0.0 {
            return None;
        }
        let open = leave(x_in).max(0.0);
        // Rounding can swap the ends of a window that is barely more than a point. The model has no
        // such window, so it becomes a point.
        Some((open.min(close), close))
    }

    /// The earliest opening and the latest closing [s] of the item's windows over all places;
    /// `None` if there is none.
    pub fn widest_window(&self, belt: &Belt, x0: f64, y: f64) -> Option<(f64, f64)> {
        (0..self.places())
            .filter_map(|place| self.departure_window(belt, place, x0, y))
            .reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// The same robot, with its rest and its bins, moved along the belt [m].
    pub(super) fn moved(&self, along: f64) -> Self {
        let by = Vector2::new(along, 0.0);
        let moved = |bin: &Bin| Bin {
            at: bin.at + by,
            ..bin.clone()
        };
        Self {
            base: self.base + by,
            rest: self.rest + by,
            bins: self.bins.iter().map(moved).collect(),
            ..self.clone()
        }
    }

    /// The belt speed [m/s] that this robot's arm must exceed by one millionth: the inverse of the
    /// steepest slope of its travel-time law. 0 if the slope is infinite, infinite if travelling
    /// farther takes no longer.
    pub(super) fn belt_limit(&self, belt: &Belt) -> f64 {
        match self.arm.law {
            TravelLaw::Constant { speed } => speed,
            _ => 1.0 / self.arm.law.steepest(self.shortest_path(belt)),
        }
    }

    /// The shortest path [m] that the arm may have to travel to the belt: its lift up and down, and
    /// from the nearest of its places to the rectangle that the belt covers.
    pub(super) fn shortest_path(&self, belt: &Belt) -> f64 {
        let places = (0..self.places()).map(|index| belt.distance_to(self.place(index)));
        places.fold(f64::INFINITY, f64::min) + 2.0 * self.arm.lift
    }

    /// Index of the place that is nearest to the belt.
    pub(super) fn nearest_place(&self, belt: &Belt) -> usize {
        let way = |index: &usize| belt.distance_to(self.place(*index));
        let nearest = (0..self.places()).min_by(|a, b| way(a).total_cmp(&way(b)));
        nearest.unwrap_or_default()
    }
}
