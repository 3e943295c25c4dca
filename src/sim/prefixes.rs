//! What the line looks like after every beginning of an assignment that was simulated on one scene.
//!
//! In a cascade a robot's pass depends on the rules before it only through the items that they left.
//! Beginnings that leave the same items are therefore one node of a graph, and a pass is made once
//! for each node and rule. An assignment that differs from known ones is simulated from the first
//! changed robot on.

use super::cascade::{Level, PassBuffers};
use super::scene::Scene;
use crate::decision::Figures;
use crate::dispatch::{RULES, Rule};
use std::collections::HashMap;

/// No node, or no step yet.
const NONE: u32 = u32::MAX;
/// The node before the first robot.
const ROOT: u32 = 0;

/// The states of a line after beginnings of assignments, on one scene. Unlike an
/// [`AssignmentTree`](super::AssignmentTree), which must know all assignments in advance, it keeps
/// them for assignments to come, and it makes one state of beginnings that leave the same items.
pub struct PrefixGraph<'a> {
    scene: &'a Scene<'a>,
    buffers: PassBuffers,
    before: Level,
    after: Level,
    /// The node whose claims are in `before`.
    loaded: u32,
    /// Whether all items weigh the same, so that PP picks like FIFO.
    equal_weights: bool,
    nodes: Vec<Node>,
    /// Claimed items of each node, one slice of words after the other.
    claims: Vec<u64>,
    /// For each node and rule the index of the step, or `NONE`.
    next: Vec<u32>,
    steps: Vec<Step>,
    /// The latest node with a hash of robot and claims; the others are linked to it.
    by_hash: HashMap<u64, u32>,
    passes: u64,
    most_nodes: usize,
}

struct Node {
    /// Number of robots so far.
    robots: u32,
    picked: u32,
    /// The last item that is left; `NONE` if everything was picked.
    last_missing: u32,
    /// Another node with the same hash.
    alike: u32,
}

/// What one robot does under one rule.
#[derive(Clone, Copy)]
struct Step {
    to: u32,
    weight: f64,
    last_release: f64,
}

impl<'a> PrefixGraph<'a> {
    /// A graph of no beginning yet for `scene`, in about `memory` [bytes]: if it outgrows that, it
    /// begins anew. `None` if windows overlap, so that a downstream robot may change what an
    /// upstream one does.
    pub fn new(scene: &'a Scene<'a>, memory: usize) -> Option<Self> {
        if !scene.is_independent() {
            return None;
        }
        let before = Level::new(scene);
        let words = before.line.claims.words().len();
        let node = size_of::<Node>() + 8 * words + 4 * RULES.len() + 2 * size_of::<Step>() + 32;
        let (station, items) = (scene.station(), scene.pattern().items());
        let mut weights = items.iter().map(|item| item.weight_on(station));
        let first = weights.next();
        let mut graph = Self {
            scene,
            buffers: PassBuffers::default(),
            after: before.clone(),
            before,
            loaded: NONE,
            equal_weights: weights.all(|weight| Some(weight) == first),
            nodes: Vec::new(),
            claims: Vec::new(),
            next: Vec::new(),
            steps: Vec::new(),
            by_hash: HashMap::new(),
            passes: 0,
            most_nodes: memory / node,
        };
        graph.forget();
        Some(graph)
    }

    /// The figures if the first robots follow `rules` and the others stay idle; `rules` must not be
    /// more than the robots.
    pub fn figures(&mut self, rules: &[Rule]) -> Figures {
        // Only between assignments, as nodes are referred to by their index.
        if self.nodes.len() > self.most_nodes {
            self.forget();
        }
        let mut at = ROOT;
        let (mut weight, mut last_release) = (0.0, 0.0_f64);
        for &rule in rules {
            if self.nodes[at as usize].last_missing == NONE {
                break;
            }
            let step = self.step(at, rule);
            at = step.to;
            // In the order of the cascade, so that both agree to the last bit.
            weight += step.weight;
            last_release = last_release.max(step.last_release);
        }
        let node = &self.nodes[at as usize];
        let missing = (node.last_missing != NONE).then_some(node.last_missing as usize);
        self.scene
            .figures(node.picked as usize, weight, last_release, missing)
    }

    /// Passes of one robot that were simulated so far.
    pub fn passes(&self) -> u64 {
        self.passes
    }

    /// What the next robot after node `at` does under `rule`, simulated if it is not known.
    fn step(&mut self, at: u32, rule: Rule) -> Step {
        let rule = match self.equal_weights && rule == Rule::PP {
            true => Rule::FIFO,
            false => rule,
        };
        let place = at as usize * RULES.len() + rule.index();
        if self.next[place] != NONE {
            return self.steps[self.next[place] as usize];
        }
        let robot = self.nodes[at as usize].robots as usize;
        if self.loaded != at {
            let words = self.before.line.claims.words().len();
            let from = at as usize * words;
            self.before.restore(&self.claims[from..from + words]);
            self.loaded = at;
        }
        let spent = self.before.is_spent(self.scene.queue(robot));
        let every_rule = if spent {
            self.after.restore(self.before.line.claims.words());
            true
        } else {
            self.passes += 1;
            let levels = (&mut self.before, &mut self.after);
            self.buffers
                .pass(self.scene, robot, rule, levels, &mut |_| {})
        };
        let picked = self.nodes[at as usize].picked + self.after.line.picked as u32;
        let step = Step {
            to: self.node(robot as u32 + 1, picked),
            weight: self.after.line.weight,
            last_release: self.after.line.last_release,
        };
        let number = self.steps.len() as u32;
        self.steps.push(step);
        let alike = if every_rule {
            0..RULES.len()
        } else {
            rule.index()..rule.index() + 1
        };
        for rule in alike {
            self.next[at as usize * RULES.len() + rule] = number;
        }
        step
    }

    /// The node after `robots` robots that left what `after` has left.
    fn node(&mut self, robots: u32, picked: u32) -> u32 {
        let claims = self.after.line.claims.words();
        let hash = hash(robots, claims);
        let first = self.by_hash.get(&hash).copied().unwrap_or(NONE);
        let mut place = first;
        while place != NONE {
            let node = &self.nodes[place as usize];
            let from = place as usize * claims.len();
            if node.robots == robots && self.claims[from..from + claims.len()] == *claims {
                return place;
            }
            place = node.alike;
        }
        let number = self.nodes.len() as u32;
        let missing = self
            .after
            .line
            .claims
            .last_missing(self.scene.pattern().len());
        self.nodes.push(Node {
            robots,
            picked,
            last_missing: missing.map_or(NONE, |item| item as u32),
            alike: first,
        });
        self.claims.extend_from_slice(claims);
        self.next.extend(std::iter::repeat_n(NONE, RULES.len()));
        self.by_hash.insert(hash, number);
        number
    }

    /// Goes back to the line before its first robot.
    fn forget(&mut self) {
        self.nodes.clear();
        self.claims.clear();
        self.next.clear();
        self.steps.clear();
        self.by_hash.clear();
        self.loaded = NONE;
        self.after.restore(self.scene.not_offered().words());
        self.node(0, 0);
    }
}

/// A hash of a node, the same in every run.
fn hash(robots: u32, claims: &[u64]) -> u64 {
    // Fibonacci hashing: the golden ratio's bits spread each word over the product's upper half.
    const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;
    let mix = |hash: u64, word: &u64| (hash.rotate_left(5) ^ word).wrapping_mul(SPREAD);
    claims.iter().fold(u64::from(robots), mix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dispatch::RuleAssignment;
    use crate::pattern::{Pattern, random_stream};
    use crate::sim::AssignmentTree;
    use crate::station::built_in;
    use rand::seq::SliceRandom;

    const MEMORY: usize = 1 << 26;

    fn weighted(count: usize, weights: bool) -> Pattern {
        let pattern = crate::pattern::grid(1.05, 0.15, count).unwrap();
        let mut items = pattern.items().to_vec();
        for (place, item) in items.iter_mut().enumerate().filter(|_| weights) {
            item.weight = Some(0.1 + (place * 7 % 13) as f64 / 13.0);
        }
        Pattern::new(items).unwrap()
    }

    /// Whatever the order in which they come and however little memory there is, assignments have
    /// the figures of the tree, to the bit.
    #[test]
    fn assignments_have_the_figures_of_the_tree_in_any_order() {
        let station = built_in("paper").unwrap().station(Some(4)).unwrap();
        for (speed, weights) in [(0.02, true), (0.1, false), (0.1, true), (0.3, true)] {
            let station = station.with_belt_speed(speed).unwrap();
            let pattern = weighted(60, weights);
            let scene = Scene::new(&station, &pattern).unwrap();
            let tree = AssignmentTree::all(4);
            let mut expected = Vec::new();
            tree.evaluate(&scene, |_, figures| expected.push(figures))
                .unwrap();
            let mut order: Vec<usize> = (0..expected.len()).collect();
            order.shuffle(&mut random_stream(1, 0));
            let mut passes = Vec::new();
            for memory in [MEMORY, 0] {
                let mut graph = PrefixGraph::new(&scene, memory).unwrap();
                for &place in &order {
                    let found = graph.figures(tree.assignments()[place].rules());
                    assert_eq!(
                        found,
                        expected[place],
                        "{speed} {}",
                        tree.assignments()[place]
                    );
                }
                passes.push(graph.passes());
            }
            // Fewer than the tree, more where beginnings were forgotten.
            assert!(
                passes[0] < tree.passes() as u64 && passes[0] < passes[1],
                "{passes:?}"
            );
        }
    }

    /// A beginning has the figures of a line whose other robots stay idle; with equal weights PP costs
    /// nothing behind FIFO, and known beginnings cost nothing at all.
    #[test]
    fn known_beginnings_cost_nothing() {
        let station = built_in("paper").unwrap().station(Some(3)).unwrap();
        let station = station.with_belt_speed(0.2).unwrap();
        for weights in [false, true] {
            let pattern = weighted(60, weights);
            let scene = Scene::new(&station, &pattern).unwrap();
            let mut graph = PrefixGraph::new(&scene, MEMORY).unwrap();
            let mut cost = |rules: &str| {
                let rules: RuleAssignment = rules.parse().unwrap();
                let before = graph.passes();
                graph.figures(rules.rules());
                graph.passes() - before
            };
            assert_eq!(cost("SPT,FIFO,LD"), 3);
            assert_eq!(cost("SPT,FIFO"), 0);
            assert_eq!(cost("SPT,FIFO,SPT"), 1);
            assert_eq!(cost("SPT,PP,SPT"), if weights { 2 } else { 0 });
        }
        let failing = crate::sim::Disturbances {
            grasp_failures: true,
            ..crate::sim::Disturbances::default()
        };
        let mut pattern = weighted(10, false).items().to_vec();
        pattern[0].p_grasp = Some(0.5);
        let pattern = Pattern::new(pattern).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let scene = scene.with_disturbances(failing).unwrap();
        assert!(PrefixGraph::new(&scene, MEMORY).is_none());
    }
}
