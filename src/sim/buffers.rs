//! The state of a run between decisions.

use super::claims::Claims;
use super::queue::{Queue, QueuedItems};
use super::scene::Scene;
use super::view::ItemsInView;
use crate::decision::{Candidate, Failure, Odds, Pick, RobotFigures};

/// The state of a run between decisions, independent of any scene.
#[derive(Debug, Clone, Default)]
pub struct RunBuffers {
    pub(super) queues: Vec<Queue>,
    /// For each robot, a lower bound of its next decision time [s]. Claims by other robots can only
    /// delay the decision, and an item that is given back lowers the bound.
    pub(super) decisions: Vec<Option<f64>>,
    pub(super) claims: Claims,
    /// Items that were a candidate of some robot at some decision.
    pub(super) offered: Claims,
    pub(super) free_at: Vec<f64>,
    pub(super) places: Vec<u16>,
    pub(super) candidates: Vec<Candidate>,
    /// What can go wrong with each of them; empty if nothing can.
    pub(super) candidate_odds: Vec<Odds>,
    pub(super) view: ItemsInView,
    /// Whether the view is filled before every decision.
    pub(super) looks: bool,
    /// Robot and time [s] of the latest decision.
    pub(super) at: (usize, f64),
    /// Whether this decision has not been made yet.
    pub(super) undecided: bool,
    pub(super) robots: Vec<RobotFigures>,
    pub(super) picks: Vec<Pick>,
    pub(super) failures: Vec<Failure>,
    /// Number of attempts at each item so far; filled only if they can fail.
    pub(super) attempts: Vec<u32>,
    /// Claims that end because the grasp fails: end [s] and item; at most one per robot.
    pub(super) ending: Vec<(f64, u32)>,
    pub(super) last_release: f64,
}

impl RunBuffers {
    pub(super) fn reset(&mut self, scene: &Scene) {
        let robots = scene.station().robots().len();
        let items = scene.pattern().len();
        // Queues beyond the last robot are kept, with their capacity.
        self.queues
            .resize_with(robots.max(self.queues.len()), Queue::default);
        for (queue, robot) in self.queues.iter_mut().zip(scene.station().robots()) {
            queue.reset(robot.start());
        }
        refill(&mut self.decisions, robots, Some(0.0));
        self.claims.reset_to(scene.not_offered());
        self.offered.reset(items);
        refill(&mut self.free_at, robots, 0.0);
        refill(&mut self.places, robots, 0);
        self.candidate_odds.clear();
        self.view.reset();
        self.looks = true;
        self.at = (0, 0.0);
        self.undecided = false;
        refill(&mut self.robots, robots, RobotFigures::default());
        self.picks.clear();
        self.failures.clear();
        let attempted = scene.conditions().disturbances.may_fail();
        refill(&mut self.attempts, if attempted { items } else { 0 }, 0);
        self.ending.clear();
        self.last_release = 0.0;
    }

    /// The claim that ends first, if it ends by `time` [s], or at any time if `time` is `None`. On
    /// a tie, the claim that was made first.
    pub(super) fn first_ending(&self, time: Option<f64>) -> Option<usize> {
        let mut first: Option<(usize, f64)> = None;
        for (place, (ends, _)) in self.ending.iter().enumerate() {
            if first.is_none_or(|(_, earliest)| *ends < earliest) {
                first = Some((place, *ends));
            }
        }
        let (place, ends) = first?;
        time.is_none_or(|time| ends <= time).then_some(place)
    }

    /// Makes `item` available to every robot again at `time` [s].
    pub(super) fn give_back(&mut self, scene: &Scene, item: u32, time: f64) {
        self.claims.remove(item);
        for (robot, decision) in self.decisions.iter_mut().enumerate() {
            let queue = QueuedItems::of(scene, robot);
            if let Some(position) = scene.position(robot, item)
                && let Some(bound) = self.queues[robot].give_back(&queue, position, time)
            {
                *decision = Some(decision.map_or(bound, |earlier| earlier.min(bound)));
            }
        }
    }
}

fn refill<T: Clone>(list: &mut Vec<T>, count: usize, value: T) {
    list.clear();
    list.resize(count, value);
}
