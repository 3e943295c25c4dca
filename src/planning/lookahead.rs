//! The look-ahead strategy: plans for all robots at every decision and takes the first step of
//! the plan.

use super::horizon::{Horizon, Valuation};
use super::meter::Meter;
use super::options::LookaheadOptions;
use super::plan::PickPlan;
use super::rollout::{Bases, Beam, BestPlan, Rollout};
use super::search::Improver;
use crate::decision::{Action, Snapshot, Strategy};
use crate::error::Result;
use crate::pattern::random_stream;

/// Plans for all robots over the items in view, again at every decision.
///
/// The candidates are the still possible part of the previous plan, and the completion of the
/// situation by each base assignment. The best of them is improved by neighbourhood search as
/// far as the budget allows. Because the previous plan remains a candidate (a *fortified*
/// rollout, Bertsekas 2013, DOI 10.1007/978-1-4419-7997-1_8), the run picks at least as much as
/// the best base would have picked, if all items were in view from the start and nothing fails.
///
/// A robot may wait: for an item whose window opens later, or because the others take
/// everything that it could take.
#[derive(Debug)]
pub struct Lookahead {
    options: LookaheadOptions,
    horizon: Horizon,
    plan: PickPlan,
    /// For each robot, the items of the plan by their index in the pattern, because places are
    /// valid for one decision only.
    kept: Vec<Vec<u32>>,
    nothing: PickPlan,
    rollout: Rollout,
    improver: Improver,
    decisions: u64,
}

impl Lookahead {
    /// A planner at the start of a run.
    pub fn new(options: LookaheadOptions) -> Self {
        Self {
            options,
            horizon: Horizon::default(),
            plan: PickPlan::default(),
            kept: Vec::new(),
            nothing: PickPlan::default(),
            rollout: Rollout::default(),
            improver: Improver::default(),
            decisions: 0,
        }
    }

    /// Makes the plan for `snapshot`.
    fn make_plan(&mut self, snapshot: &Snapshot) {
        let mut meter = Meter::new(self.options.budget);
        let valuation = Valuation {
            goal: self.options.goal,
            foresee: self.options.foresee,
        };
        self.horizon.read(snapshot, self.options.horizon, valuation);
        self.take_up();
        let options = &self.options;
        let horizon = &self.horizon;
        let bases = Bases {
            station: snapshot.station,
            horizon,
            assignments: &options.bases,
        };
        let mut best = BestPlan {
            score: self.plan.score(horizon),
            plan: &mut self.plan,
        };
        self.nothing.clear(horizon);
        let nothing = &self.nothing;
        let completed = self.rollout.complete(bases, nothing, &mut best, &mut meter);
        if completed.is_some() && options.depth > 0 {
            let beam = Beam {
                depth: options.depth,
                width: options.width,
            };
            self.rollout.search(bases, beam, &mut best, &mut meter);
        }
        for robot in 0..horizon.robots() {
            // Rollouts do not compute the latest starts.
            self.plan.retime(horizon, robot);
        }
        if options.improve {
            // One random stream per decision, so that the draws of one do not shift those of
            // the next.
            let mut rng = random_stream(options.seed, self.decisions);
            self.improver
                .improve(horizon, &mut self.plan, &mut meter, &mut rng);
        }
        self.decisions += 1;
        self.keep();
    }

    /// Restores the still possible part of the previous plan.
    fn take_up(&mut self) {
        let (horizon, plan) = (&self.horizon, &mut self.plan);
        plan.clear(horizon);
        for (robot, items) in self.kept.iter().enumerate().take(horizon.robots()) {
            for &item in items {
                let Some(place) = plan.next_place(horizon, item) else {
                    continue;
                };
                // Whether a stop is still possible from where the one before it ends is found below.
                if horizon.reach(robot, place).close >= horizon.free[robot] {
                    plan.push(horizon, robot, place, horizon.free[robot]);
                }
            }
            plan.retime(horizon, robot);
        }
    }

    /// Stores the plan for the next decision.
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
            // The others take everything that this robot could take. The plan may change when
            // one of them decides next.
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
        // An item whose window is open is a candidate, so the position is always found.
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

    fn check_robots(&self, robots: usize) -> Result<()> {
        self.options.check_robots(robots)
    }
}
