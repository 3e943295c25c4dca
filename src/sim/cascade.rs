//! The cascade engine: rules only, one robot after the other.
//!
//! If extended workspaces do not overlap, downstream decisions never affect upstream ones
//! (`docs/model.md`, independence). The robots can then be simulated one after the other, each with
//! the items that the previous ones left, and all assignments with a common prefix share that work
//! (see `AssignmentTree`).

use super::attempt::make_pick;
use super::claims::Claims;
use super::queue::{Queue, QueuedItems};
use super::scene::Scene;
use crate::decision::{Candidate, Figures, Moment, Pick};
use crate::dispatch::{DispatchingRule, Rule};

/// Reusable buffers for one scene. Neither a decision nor a pass allocates.
pub struct Cascade<'a> {
    scene: &'a Scene<'a>,
    buffers: PassBuffers,
    /// For each depth of the tree, the items that the robots so far left, and their figures.
    levels: Vec<Level>,
}

/// What one robot's pass needs while it lasts.
#[derive(Clone, Default)]
pub(super) struct PassBuffers {
    queue: Queue,
    /// The items that a robot with several places can leave for now.
    candidates: Vec<Candidate>,
}

/// What the robots so far picked and left.
#[derive(Clone)]
pub(super) struct Level {
    pub line: LineState,
    /// The next robot's queue without claimed items, once it has been requested.
    left: Vec<Candidate>,
    left_is_current: bool,
}

/// What the first robots of a line did with a pattern: all that the robots after them, and the figures
/// of the run, depend on.
#[derive(Debug, Clone, Default)]
pub(crate) struct LineState {
    pub(super) claims: Claims,
    /// Number of items picked.
    pub picked: usize,
    /// Sum of their rewards.
    pub weight: f64,
    /// When the last of them was released [s]; 0 if there is none.
    pub last_release: f64,
}

impl LineState {
    /// Whether `item` is to be picked and has not been.
    #[inline(always)]
    pub(crate) fn leaves(&self, item: u32) -> bool {
        !self.claims.contains(item)
    }

    /// Whether the same items are left as in `other`.
    pub(crate) fn leaves_as(&self, other: &Self) -> bool {
        self.claims == other.claims
    }
}

impl<'a> Cascade<'a> {
    /// An engine for `scene`; `None` if its windows overlap, so that robots cannot be simulated one
    /// after the other.
    pub fn new(scene: &'a Scene<'a>) -> Option<Self> {
        scene.is_independent().then(|| Self {
            scene,
            buffers: PassBuffers::default(),
            levels: vec![Level::new(scene); scene.station().robots().len() + 1],
        })
    }

    /// The figures if the first robots follow `rules` and the others stay idle.
    pub fn run(&mut self, rules: &[Rule]) -> Figures {
        self.run_observed(rules, |_| {})
    }

    /// Like [`Cascade::run`], but calls `on_pick` for every pick, robot by robot.
    pub fn run_observed(&mut self, rules: &[Rule], mut on_pick: impl FnMut(Pick)) -> Figures {
        for (robot, rule) in rules.iter().enumerate() {
            self.pass(robot, *rule, &mut on_pick);
        }
        self.figures(rules.len())
    }

    /// Simulates `robot` under `rule` with the items that the robots before it left in the latest
    /// calls, and returns the figures of the line up to this robot.
    pub fn extend(&mut self, robot: usize, rule: Rule) -> Figures {
        self.pass(robot, rule, &mut |_| {});
        self.figures(robot + 1)
    }

    /// The state after the first `robots` robots in the passes that led to the latest figures.
    pub(crate) fn state(&self, robots: usize) -> &LineState {
        &self.levels[robots].line
    }

    /// Puts `state` in the place of the state after the first `robots` robots, which goes into `state`.
    pub(crate) fn exchange(&mut self, robots: usize, state: &mut LineState) {
        let level = &mut self.levels[robots];
        std::mem::swap(&mut level.line, state);
        level.left_is_current = false;
    }

    /// Picks of each of the first `robots` robots in the passes that led to the latest figures: the
    /// difference between consecutive levels.
    pub fn picks(&self, robots: usize) -> impl Iterator<Item = usize> + '_ {
        let levels = self.levels.windows(2).take(robots);
        levels.map(|level| level[1].line.picked - level[0].line.picked)
    }

    fn figures(&self, robots: usize) -> Figures {
        let line = &self.levels[robots].line;
        let items = self.scene.pattern().len();
        self.scene.figures(
            line.picked,
            line.weight,
            line.last_release,
            line.claims.last_missing(items),
        )
    }

    /// Simulates `robot` under `rule` with the items that level `robot` left, and fills the next
    /// level.
    fn pass(&mut self, robot: usize, rule: Rule, on_pick: &mut impl FnMut(Pick)) {
        let (upstream, rest) = self.levels.split_at_mut(robot + 1);
        let levels = (&mut upstream[robot], &mut rest[0]);
        self.buffers.pass(self.scene, robot, rule, levels, on_pick);
    }
}

impl PassBuffers {
    /// Simulates `robot` under `rule` with the items that the first level left, and fills the
    /// second. Returns whether the robot never had two candidates, so that every rule does the same.
    pub(super) fn pass(
        &mut self,
        scene: &Scene,
        robot: usize,
        rule: Rule,
        (before, after): (&mut Level, &mut Level),
        on_pick: &mut impl FnMut(Pick),
    ) -> bool {
        before.find_left(scene.queue(robot));
        let rule: &dyn DispatchingRule = &*rule;
        after.line.claims.reset_to(&before.line.claims);
        let mut picked = before.line.picked;
        let mut weight = 0.0;
        let mut last_release = before.line.last_release;
        let mut forced = true;
        let station = scene.station();
        let items = QueuedItems {
            robot,
            list: &before.left,
            windows: scene.windows(robot),
        };
        let start = station.robots()[robot].start();
        self.queue.reset(start);
        let mut at = Moment::new(station, robot, start, 0.0);
        // Only this robot claims items now, and an item that it claims leaves `active` immediately.
        let none = |_| false;
        while let Some(time) = self.queue.next_decision(scene, &items, none, none) {
            at.time = time;
            let active = &mut self.queue.active;
            // Those that cannot be left for from this place count as well; one is enough.
            forced &= active.len() == 1;
            let place = if items.windows.is_none() {
                rule.choose(&at, active)
            } else {
                let can_leave = |c: &&Candidate| (c.open..=c.close).contains(&time);
                self.candidates.clear();
                self.candidates.extend(active.iter().filter(can_leave));
                let chosen = self.candidates[rule.choose(&at, &self.candidates)].item;
                // The candidates are some of these.
                active.iter().position(|c| c.item == chosen).unwrap_or(0)
            };
            let candidate = active.swap_remove(place);
            let pick = make_pick(&at, robot, &candidate);
            after.line.claims.insert(candidate.item);
            picked += 1;
            weight += candidate.weight;
            last_release = last_release.max(pick.release);
            self.queue.free = pick.release;
            if items.windows.is_some() {
                self.queue.place = usize::from(candidate.bin);
                at = at.with_place(self.queue.place);
            }
            on_pick(pick);
        }
        after.left_is_current = false;
        after.line.picked = picked;
        // Summed per robot, as in the event loop, so that both agree to the last bit.
        after.line.weight = before.line.weight + weight;
        after.line.last_release = last_release;
        forced
    }
}

impl Level {
    /// Before the first robot.
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            line: LineState {
                claims: scene.not_offered().clone(),
                ..LineState::default()
            },
            left: Vec::new(),
            left_is_current: false,
        }
    }

    /// Becomes a level from which everything but `claims` is left and nothing is counted yet.
    pub(super) fn restore(&mut self, claims: &[u64]) {
        self.line.claims.copy_from_words(claims);
        self.left_is_current = false;
        self.line.picked = 0;
        self.line.weight = 0.0;
        self.line.last_release = 0.0;
    }

    /// Whether nothing is left for the robot with this `queue`.
    pub(super) fn is_spent(&mut self, queue: &[Candidate]) -> bool {
        self.find_left(queue);
        self.left.is_empty()
    }

    /// Fills `left` from the next robot's whole queue, once for all its rules.
    fn find_left(&mut self, queue: &[Candidate]) {
        if self.left_is_current {
            return;
        }
        self.left.clear();
        let unclaimed = queue.iter().filter(|c| self.line.leaves(c.item));
        self.left.extend(unclaimed);
        self.left_is_current = true;
    }
}
