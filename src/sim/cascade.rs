//! The cascade engine: rules only, robot by robot.
//!
//! Where extended workspaces do not overlap, downstream decisions never change
//! upstream ones (`docs/model.md`, independence). The robots can then be simulated
//! one after the other, each on what those before it left, and all assignments that
//! begin alike share that work (see `AssignmentTree`).

use super::attempt::make_pick;
use super::claims::Claims;
use super::queue::Queue;
use super::scene::Scene;
use crate::decision::{Candidate, Figures, Moment, Pick};
use crate::dispatch::{DispatchingRule, Rule};

/// Reusable buffers for one scene; nothing is allocated per decision or per pass.
pub struct Cascade<'a> {
    scene: &'a Scene<'a>,
    queue: Queue,
    /// What the robots up to each depth of the tree left, and made of it.
    levels: Vec<Level>,
}

#[derive(Clone)]
struct Level {
    claims: Claims,
    /// The next robot's queue without what is claimed, once that robot was asked for.
    left: Vec<Candidate>,
    left_is_current: bool,
    picked: usize,
    weight: f64,
    last_release: f64,
}

impl<'a> Cascade<'a> {
    /// An engine for `scene`; none when its windows overlap, so that robots cannot be
    /// simulated one after the other.
    pub fn new(scene: &'a Scene<'a>) -> Option<Self> {
        scene.is_independent().then(|| Self {
            scene,
            queue: Queue::default(),
            levels: vec![
                Level {
                    claims: Claims::none(scene.pattern().len()),
                    left: Vec::new(),
                    left_is_current: false,
                    picked: 0,
                    weight: 0.0,
                    last_release: 0.0,
                };
                scene.station().robots().len() + 1
            ],
        })
    }

    /// The figures when the first robots follow `rules` and any others stand idle.
    pub fn run(&mut self, rules: &[Rule]) -> Figures {
        self.run_observed(rules, |_| {})
    }

    /// As [`Cascade::run`], telling `on_pick` every pick, robot by robot.
    pub fn run_observed(&mut self, rules: &[Rule], mut on_pick: impl FnMut(Pick)) -> Figures {
        for (robot, rule) in rules.iter().enumerate() {
            self.pass(robot, *rule, &mut on_pick);
        }
        self.figures(rules.len())
    }

    /// Simulates `robot` under `rule` on what the robots before it left in the last
    /// calls, and returns the figures of the line up to it.
    pub fn extend(&mut self, robot: usize, rule: Rule) -> Figures {
        self.pass(robot, rule, &mut |_| {});
        self.figures(robot + 1)
    }

    /// Picks of each of the first `robots` robots in the passes that led to the last
    /// figures: what each level adds to the one before it.
    pub fn picks(&self, robots: usize) -> impl Iterator<Item = usize> + '_ {
        let levels = self.levels.windows(2).take(robots);
        levels.map(|level| level[1].picked - level[0].picked)
    }

    fn figures(&self, robots: usize) -> Figures {
        let level = &self.levels[robots];
        let items = self.scene.pattern().len();
        self.scene.figures(
            level.picked,
            level.weight,
            level.last_release,
            level.claims.last_missing(items),
        )
    }

    /// Simulates `robot` under `rule` on what level `robot` left, into the next level.
    fn pass(&mut self, robot: usize, rule: Rule, on_pick: &mut impl FnMut(Pick)) {
        let (upstream, rest) = self.levels.split_at_mut(robot + 1);
        let (before, after) = (&mut upstream[robot], &mut rest[0]);
        before.find_left(self.scene.queue(robot));
        let rule: &dyn DispatchingRule = &*rule;
        after.claims.copy_from(&before.claims);
        let mut picked = before.picked;
        let mut weight = 0.0;
        let mut last_release = before.last_release;
        self.queue.reset();
        let mut at = Moment::new(self.scene.station(), robot, 0.0);
        // Only this robot claims now, and what it claims leaves `active` at once.
        let none = |_| false;
        while let Some(time) = self
            .queue
            .next_decision(self.scene, &before.left, none, none)
        {
            at.time = time;
            let place = rule.choose(&at, &self.queue.active);
            let candidate = self.queue.active.swap_remove(place);
            let pick = make_pick(&at, robot, &candidate);
            after.claims.insert(candidate.item);
            picked += 1;
            weight += candidate.weight;
            last_release = last_release.max(pick.release);
            self.queue.free = pick.release;
            on_pick(pick);
        }
        after.left_is_current = false;
        after.picked = picked;
        // Robot by robot, as the event loop adds it, so that both agree to the bit.
        after.weight = before.weight + weight;
        after.last_release = last_release;
    }
}

impl Level {
    /// Fills `left` from the next robot's whole queue, once for all its rules.
    fn find_left(&mut self, queue: &[Candidate]) {
        if self.left_is_current {
            return;
        }
        self.left.clear();
        let unclaimed = queue.iter().filter(|c| !self.claims.contains(c.item));
        self.left.extend(unclaimed);
        self.left_is_current = true;
    }
}
