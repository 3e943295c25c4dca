//! A plan: which items each robot takes, in which order, and when.

use super::horizon::{Horizon, RobotHorizon};
use std::cmp::Ordering;

/// No robot takes the item.
pub(super) const NOBODY: u16 = u16::MAX;

/// One pick of a plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlannedPick {
    /// Place of the item in the horizon.
    pub place: u32,
    /// When the robot leaves for it [s]: as soon as it is free and the window is open. Waiting
    /// longer never helps, because the end of a pick increases with its start.
    pub start: f64,
    /// When the robot is free again [s].
    pub finish: f64,
    /// Last start [s] that still allows this stop and all later stops of the robot.
    pub latest: f64,
}

/// For each robot a sequence of stops; no item twice.
#[derive(Debug, Clone, Default)]
pub(super) struct PickPlan {
    /// The stops of each robot in order of time.
    pub routes: Vec<Vec<PlannedPick>>,
    /// For each item of the horizon, the robot that takes it, or [`NOBODY`].
    pub owner: Vec<u16>,
    /// Total value of the planned items.
    pub value: f64,
}

/// How plans are compared: by value, then by the end, then by how soon robots are free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlanScore {
    /// Total value of the planned items.
    pub value: f64,
    /// When the last planned item is in its bin and the last other item has left the belt [s].
    pub end: f64,
    /// Sum of the times at which the robots are done [s].
    pub free: f64,
}

/// The last start [s] of the item at `place` from `from` after which the robot is free by `deadline`
/// [s], which may be infinite.
pub(super) fn latest(of_robot: &RobotHorizon, from: u16, place: u32, deadline: f64) -> f64 {
    let reach = of_robot.reach(place);
    let window = of_robot.window(from, place, reach);
    let (_, close) = window;
    if deadline.is_finite() {
        close.min(of_robot.latest_start(from, reach, window, deadline))
    } else {
        close
    }
}

impl PlanScore {
    /// Compares two scores; the better one is greater. Values are sums in any order, so they
    /// count as equal within rounding.
    pub(super) fn compare(&self, other: &Self) -> Ordering {
        let slack = 1e-9 * (1.0 + self.value.abs());
        if (self.value - other.value).abs() > slack {
            return self.value.total_cmp(&other.value);
        }
        let end = other.end.total_cmp(&self.end);
        end.then(other.free.total_cmp(&self.free))
    }

    /// Whether this score is better.
    pub(super) fn beats(&self, other: &Self) -> bool {
        self.compare(other) == Ordering::Greater
    }
}

impl PickPlan {
    /// Removes everything from the plan.
    pub(super) fn clear(&mut self, horizon: &Horizon) {
        self.routes.resize_with(horizon.robots(), Vec::new);
        self.routes.iter_mut().for_each(Vec::clear);
        self.owner.clear();
        self.owner.resize(horizon.items.len(), NOBODY);
        self.value = 0.0;
    }

    /// Copies `other`, reusing allocated memory.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.routes.clone_from(&other.routes);
        self.owner.clone_from(&other.owner);
        self.value = other.value;
    }

    /// Appends the item at `place` to the stops of `robot`, which leaves at `start` [s];
    /// returns when it is free again [s].
    pub(super) fn push(&mut self, horizon: &Horizon, robot: usize, place: u32, start: f64) -> f64 {
        let from = self.place(horizon, robot);
        let finish = horizon.finish(robot, from, horizon.reach(robot, place), start);
        // A station has at most 100 robots.
        self.owner[place as usize] = robot as u16;
        self.value += horizon.values[place as usize];
        self.routes[robot].push(PlannedPick {
            place,
            start,
            finish,
            latest: f64::NAN,
        });
        finish
    }

    /// Recomputes all times of `robot` and removes stops that have become impossible. Returns
    /// the number of stops examined.
    pub(super) fn retime(&mut self, horizon: &Horizon, robot: usize) -> usize {
        let route = &mut self.routes[robot];
        let looked_at = route.len();
        let mut free = horizon.free[robot];
        let mut from = horizon.place_of(robot);
        let of_robot = horizon.of_robot(robot);
        let (owner, value) = (&mut self.owner, &mut self.value);
        route.retain_mut(|stop| {
            let reach = of_robot.reach(stop.place);
            let (open, close) = of_robot.window(from, stop.place, reach);
            let start = free.max(open);
            let possible = start <= close;
            if possible {
                stop.start = start;
                stop.finish = of_robot.finish(from, reach, start);
                free = stop.finish;
                from = reach.bin;
            } else {
                owner[stop.place as usize] = NOBODY;
                *value -= horizon.values[stop.place as usize];
            }
            possible
        });
        let mut deadline = f64::INFINITY;
        for number in (0..route.len()).rev() {
            let from = match number.checked_sub(1) {
                Some(before) => of_robot.reach(route[before].place).bin,
                None => horizon.place_of(robot),
            };
            let stop = &mut route[number];
            stop.latest = latest(&of_robot, from, stop.place, deadline);
            deadline = stop.latest;
        }
        looked_at
    }

    /// The place of the next attempt at `item` of the pattern that nobody owns.
    pub(super) fn next_place(&self, horizon: &Horizon, item: u32) -> Option<u32> {
        let mut places = horizon.places_of(item);
        places.find(|&place| self.owner[place as usize] == NOBODY)
    }

    /// Where the arm of `robot` is after its last stop.
    #[inline(always)]
    pub(super) fn place(&self, horizon: &Horizon, robot: usize) -> u16 {
        match self.routes[robot].last() {
            Some(stop) => horizon.reach(robot, stop.place).bin,
            None => horizon.place_of(robot),
        }
    }

    /// When `robot` is done [s].
    pub(super) fn done(&self, horizon: &Horizon, robot: usize) -> f64 {
        let last = self.routes[robot].last();
        last.map_or(horizon.free[robot], |stop| stop.finish)
    }

    /// The score of the plan.
    pub(super) fn score(&self, horizon: &Horizon) -> PlanScore {
        // Items are in pattern order, downstream first, so the last one without an owner is the
        // last to leave.
        let unplanned =
            |place: &usize| self.owner[*place] == NOBODY && horizon.attempts[*place] == 0;
        let left = (0..self.owner.len()).rev().find(unplanned);
        let mut end = left.map_or(f64::NEG_INFINITY, |place| horizon.leaves[place]);
        let mut free = 0.0;
        for robot in (0..horizon.robots()).filter(|&r| horizon.free[r].is_finite()) {
            let done = self.done(horizon, robot);
            free += done;
            if !self.routes[robot].is_empty() {
                end = end.max(done);
            }
        }
        PlanScore {
            value: self.value,
            end,
            free,
        }
    }
}
