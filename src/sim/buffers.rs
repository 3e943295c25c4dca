//! What a run keeps between decisions.

use super::claims::Claims;
use super::queue::Queue;
use super::scene::Scene;
use super::view::View;
use crate::decision::{Candidate, Failure, Pick, RobotFigures};

/// What a run keeps between decisions, detached from any scene.
#[derive(Debug, Clone, Default)]
pub struct RunBuffers {
    pub(super) queues: Vec<Queue>,
    /// For each robot a lower bound of its next decision [s]; it can only be late, as
    /// claims by others only take items away, and what is given back lowers it.
    pub(super) decisions: Vec<Option<f64>>,
    pub(super) claims: Claims,
    /// Items that were a candidate of some robot at some decision.
    pub(super) offered: Claims,
    pub(super) free_at: Vec<f64>,
    pub(super) candidates: Vec<Candidate>,
    pub(super) view: View,
    /// Whether the view is filled before every decision.
    pub(super) looks: bool,
    /// Robot and time [s] of the last decision come to.
    pub(super) at: (usize, f64),
    /// Whether that decision is still to be taken.
    pub(super) undecided: bool,
    pub(super) robots: Vec<RobotFigures>,
    pub(super) picks: Vec<Pick>,
    pub(super) failures: Vec<Failure>,
    /// Attempts at each item so far; filled only where they can fail.
    pub(super) attempts: Vec<u32>,
    /// Claims that end, as the grasp fails: when [s], of which item; one a robot at most.
    pub(super) ending: Vec<(f64, u32)>,
    pub(super) last_release: f64,
}

impl RunBuffers {
    pub(super) fn reset(&mut self, scene: &Scene) {
        let robots = scene.station().robots().len();
        let items = scene.pattern().len();
        // Queues past the last robot stay, with what they have grown to.
        self.queues
            .resize_with(robots.max(self.queues.len()), Queue::default);
        self.queues.iter_mut().for_each(Queue::reset);
        refill(&mut self.decisions, robots, Some(0.0));
        self.claims.reset(items);
        self.offered.reset(items);
        refill(&mut self.free_at, robots, 0.0);
        self.view.reset();
        self.looks = true;
        self.at = (0, 0.0);
        self.undecided = false;
        refill(&mut self.robots, robots, RobotFigures::default());
        self.picks.clear();
        self.failures.clear();
        let attempted = scene.conditions().disturbances.any();
        refill(&mut self.attempts, if attempted { items } else { 0 }, 0);
        self.ending.clear();
        self.last_release = 0.0;
    }

    /// Which of the claims that end comes first, if it ends by `time` [s], at any time
    /// where there is none. Equal times: the claim made first.
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

    /// Gives `item` back to every robot at `time` [s].
    pub(super) fn give_back(&mut self, scene: &Scene, item: u32, time: f64) {
        self.claims.remove(item);
        for (robot, decision) in self.decisions.iter_mut().enumerate() {
            if let Some(place) = scene.place(robot, item)
                && let Some(bound) = self.queues[robot].give_back(scene.queue(robot), place, time)
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
