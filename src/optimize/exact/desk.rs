//! One pattern during branch and bound: the line up to each robot, and what can still be picked.

use super::ceiling::Ceilings;
use crate::decision::Figures;
use crate::dispatch::Rule;
use crate::optimize::Objective;
use crate::sim::{Cascade, LineState, Scene};

/// The work on one pattern. Robots pass one after the other; what each rule of a robot left is kept until
/// another prefix of the same length is followed.
pub(super) struct Desk<'a> {
    scene: &'a Scene<'a>,
    objective: Objective,
    cascade: Cascade<'a>,
    ceilings: Ceilings,
    /// For each robot, the line after it under each rule.
    after: Vec<Vec<LineState>>,
}

/// What one robot's pass gave.
#[derive(Clone, Copy)]
pub(super) struct Step {
    /// The objective if it is settled; otherwise a figure that no completion exceeds.
    pub value: f64,
    /// Share of the items picked so far.
    pub share: f64,
    /// Whether there are no robots after it or they change nothing.
    pub settled: bool,
}

impl<'a> Desk<'a> {
    /// The work on `scene`; `None` if its robots are not independent.
    pub(super) fn new(scene: &'a Scene<'a>, objective: Objective) -> Option<Self> {
        let robots = scene.station().robots().len();
        Some(Self {
            scene,
            objective,
            cascade: Cascade::new(scene)?,
            ceilings: Ceilings::new(scene, objective == Objective::WeightedRate),
            after: vec![vec![LineState::default(); Rule::all().len()]; robots],
        })
    }

    /// Whether all items that a robot can pick have the same reward.
    pub(super) fn has_equal_rewards(&self) -> bool {
        let robots = 0..self.scene.station().robots().len();
        let queues = robots.map(|robot| self.scene.queue(robot));
        let mut rewards = queues.flatten().map(|candidate| candidate.weight);
        let first = rewards.next();
        rewards.all(|reward| Some(reward) == first)
    }

    /// A figure that no assignment exceeds.
    pub(super) fn most(&mut self) -> f64 {
        let idle = self.cascade.run(&[]);
        let most = self.ceilings.figures(0, self.cascade.state(0), idle.items);
        self.value(&most.unwrap_or(idle))
    }

    /// Simulates `robot` under `rule` after the prefix that is followed.
    pub(super) fn pass(&mut self, robot: usize, rule: Rule) -> Step {
        let figures = self.cascade.extend(robot, rule);
        let state = self.cascade.state(robot + 1);
        let most = self.ceilings.figures(robot + 1, state, figures.items);
        let step = Step {
            value: self.value(&most.unwrap_or(figures)),
            share: figures.picked_share(),
            settled: most.is_none(),
        };
        self.cascade
            .exchange(robot + 1, &mut self.after[robot][rule.index()]);
        step
    }

    /// Follows the prefix that ends with `rule` at `robot`, whose pass was the last one of this rule there.
    pub(super) fn follow(&mut self, robot: usize, rule: Rule) {
        self.cascade
            .exchange(robot + 1, &mut self.after[robot][rule.index()]);
    }

    /// Whether the rest of the line gives the same objective after either rule of `robot`.
    pub(super) fn coincide(&self, robot: usize, (one, other): (Rule, Rule)) -> bool {
        let of = |rule: Rule| &self.after[robot][rule.index()];
        let (one, other) = (of(one), of(other));
        let end = |line: &LineState| self.ceilings.least_end(robot + 1, line);
        let weighs = self.objective == Objective::WeightedRate;
        one.leaves_as(other)
            && (!weighs || one.weight == other.weight)
            && (self.objective == Objective::PickedShare || end(one) == end(other))
    }

    fn value(&self, figures: &Figures) -> f64 {
        self.objective.of_run(figures).unwrap_or(f64::INFINITY)
    }
}
