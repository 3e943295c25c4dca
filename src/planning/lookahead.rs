//! The look-ahead strategy: at every decision a plan for all robots, of which the first
//! step is taken.

use super::horizon::Horizon;
use super::meter::Meter;
use super::options::Options;
use super::plan::Plan;
use super::rollout::{Bases, Best, Rollout};
use super::search::Improver;
use crate::decision::{Action, Snapshot, Strategy};
use crate::pattern::random_stream;

/// Plans for all robots over the items in view, at every decision anew.
///
/// The plan of the decision before, as far as it is still possible, and what each base
/// assignment would make of the situation compete; the best is improved by
/// neighbourhood search as far as the budget goes. As the old plan stays in the race
/// (a *fortified* rollout, Bertsekas 2013, DOI 10.1007/978-1-4419-7997-1_8), what is
/// picked in the end is at least what the best base would have picked, if all items
/// were in view from the start and nothing fails.
///
/// A robot may wait: for an item whose window opens later, or because the others take
/// all that it could.
#[derive(Debug)]
pub struct Lookahead {
    options: Options,
    horizon: Horizon,
    plan: Plan,
    /// The items of each robot in the plan, by their index in the pattern, as places
    /// hold for one decision only.
    kept: Vec<Vec<u32>>,
    nothing: Plan,
    rollout: Rollout,
    improver: Improver,
    decisions: u64,
}

impl Lookahead {
    /// A planner at the start of a run.
    pub fn new(options: Options) -> Self {
        Self {
            options,
            horizon: Horizon::default(),
            plan: Plan::default(),
            kept: Vec::new(),
            nothing: Plan::default(),
            rollout: Rollout::default(),
            improver: Improver::default(),
            decisions: 0,
        }
    }

    /// Makes the plan for `snapshot`.
    fn make_plan(&mut self, snapshot: &Snapshot) {
        let mut meter = Meter::new(self.options.budget);
        self.horizon
            .read(snapshot, self.options.horizon, self.options.goal);
        self.take_up();
        let options = &self.options;
        let horizon = &self.horizon;
        let bases = Bases {
            station: snapshot.station,
            horizon,
            assignments: &options.bases,
        };
        let mut best = Best {
            score: self.plan.score(horizon),
            plan: &mut self.plan,
        };
        self.nothing.clear(horizon);
        let nothing = &self.nothing;
        let completed = self.rollout.complete(bases, nothing, &mut best, &mut meter);
        if completed.is_some() && options.depth > 0 {
            let size = (options.depth, options.width);
            self.rollout.search(bases, size, &mut best, &mut meter);
        }
        for robot in 0..horizon.robots() {
            // Rollouts leave the latest starts open.
            self.plan.retime(horizon, robot);
        }
        if options.improve {
            // One stream a decision, so that what one draws does not shift the next.
            let mut rng = random_stream(options.seed, self.decisions);
            self.improver
                .improve(horizon, &mut self.plan, &mut meter, &mut rng);
        }
        self.decisions += 1;
        self.keep();
    }

    /// The last plan, as far as it is still possible.
    fn take_up(&mut self) {
        let (horizon, plan) = (&self.horizon, &mut self.plan);
        plan.clear(horizon);
        for (robot, items) in self.kept.iter().enumerate().take(horizon.robots()) {
            for place in items.iter().filter_map(|&item| horizon.place(item)) {
                if horizon.reach(robot, place).close >= horizon.free[robot] {
                    plan.push(horizon, robot, place, horizon.free[robot]);
                }
            }
            plan.retime(horizon, robot);
        }
    }

    /// Notes the plan for the next decision.
    fn keep(&mut self) {
        self.kept.resize_with(self.plan.routes.len(), Vec::new);
        for (kept, route) in self.kept.iter_mut().zip(&self.plan.routes) {
            let items = route.iter();
            kept.clear();
            kept.extend(items.map(|stop| self.horizon.items[stop.place as usize]));
        }
    }

    /// The first step of the plan.
    fn first_step(&self, snapshot: &Snapshot) -> Action {
        let Some(stop) = self.plan.routes[snapshot.robot].first() else {
            // The others take all that this robot could. Plans change when one of them
            // decides next.
            let busy = self.horizon.free.iter().filter(|&&f| f > snapshot.time);
            let next = busy.copied().fold(f64::INFINITY, f64::min);
            return if next.is_finite() {
                Action::WaitUntil(next)
            } else {
                Action::WaitForNextWindow
            };
        };
        if stop.start > snapshot.time {
            return Action::WaitUntil(stop.start);
        }
        let item = self.horizon.items[stop.place as usize];
        // What is open now is a candidate, so the position is always found.
        let mut candidates = snapshot.candidates.iter();
        let place = candidates.position(|candidate| candidate.item == item);
        Action::Pick(place.unwrap_or(0))
    }
}

impl Strategy for Lookahead {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        self.make_plan(snapshot);
        self.first_step(snapshot)
    }

    fn name(&self) -> String {
        self.options.written()
    }
}
