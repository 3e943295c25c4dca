//! Proves which assignment is best without scoring all of them: branch and bound over the tree of
//! assignments.
//!
//! Land, Doig 1960, *An Automatic Method of Solving Discrete Programming Problems*, Econometrica 28
//! (DOI 10.2307/1910129). A node is a prefix: rules for the first robots of the line. Because these pick
//! the same whatever the others do, a node is scored by what is left after them. Three things cut the tree:
//! what the remaining robots can still do ([`ceiling`]), prefixes beside each other that leave the same
//! items on every pattern, and prefixes after which nothing is left to pick. A node's patterns are simulated
//! in blocks, and it is dropped as soon as the patterns simulated so far and the ceilings of the others show
//! that it cannot win.

mod ceiling;
mod desk;
mod scored;

use super::environment::Environment;
use super::evaluator::{Evaluation, Evaluator, Score};
use super::objective::{Objective, Risk};
use crate::dispatch::{Rule, RuleAssignment};
use crate::error::{Error, Result};
use crate::sim::Scene;
use crate::stats;
use desk::{Desk, Step};
use rayon::prelude::*;
use scored::Scored;

/// Patterns that are simulated before it is looked at again which prefixes can still win.
const BLOCK: usize = 24;
/// Length of the prefixes that are reported as progress.
const REPORTED: usize = 2;

/// How far it is proven that an assignment is best.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct Proof {
    /// No assignment scores higher than this, in the unit of the objective.
    pub most: f64,
    /// That minus the highest score found, in the same unit; 0 if it is proven that nothing is better.
    pub gap: f64,
    /// Passes of one robot over a pattern that the search took.
    pub passes: u64,
    /// Passes that walking the whole tree takes: `6 + 6^2 + ... + 6^N` on every pattern.
    pub tree_passes: f64,
    /// Number of prefixes whose next robot was simulated.
    pub nodes: u64,
    /// Number of prefixes that were not followed because a prefix beside them leaves the same items on
    /// every pattern, or because nothing is left after them.
    pub merged: u64,
}

/// What branch and bound found.
pub(super) struct ExactOutcome {
    /// The assignments that were scored on all patterns, in registry order.
    pub evaluation: Evaluation,
    pub proof: Proof,
    /// Whether it ended before nothing better was possible.
    pub cut: bool,
}

/// Searches on the patterns of `evaluator` in at most `most` runs. What `known` scored is ranked beside
/// what is found, and its best is what has to be beaten.
///
/// # Errors
/// Robots that are not independent, or an objective that takes more than one run of an assignment.
pub(super) fn prove(
    evaluator: &Evaluator,
    risk: Risk,
    known: Evaluation,
    most: u64,
    environment: &Environment,
) -> Result<ExactOutcome> {
    check(evaluator)?;
    let (objective, scenes) = (evaluator.objective(), evaluator.scenes());
    let scenes: Vec<&Scene> = scenes.collect();
    // All of them are independent.
    let desks = scenes
        .par_iter()
        .filter_map(|scene| Desk::new(scene, objective));
    let mut desks: Vec<Desk> = desks.collect();
    let robots = evaluator.station().robots().len();
    let equal = desks.iter().all(Desk::has_equal_rewards);
    let rules: Vec<Rule> = Rule::all()
        .filter(|rule| !(equal && rule.ranks_by_reward()))
        .collect();
    let bounds: Vec<f64> = desks.iter_mut().map(Desk::most).collect();
    let progress = environment.progress;
    let branches = (rules.len() as u64).pow(robots.min(REPORTED) as u32);
    progress.begin("branch and bound", branches, "branches");
    let mut tree = Tree {
        robots,
        risk,
        rules,
        desks,
        prefix: Vec::with_capacity(robots),
        scored: Scored::new(known, risk),
        open: f64::NEG_INFINITY,
        passes: 0,
        most_passes: most.saturating_mul(robots as u64),
        nodes: 0,
        merged: 0,
        environment,
    };
    tree.expand(&bounds);
    progress.end();
    evaluator.count_runs(tree.passes.div_ceil(robots as u64));
    let count = Rule::all().len() as f64;
    let levels = (1..=robots as i32).map(|depth| count.powi(depth));
    let best = tree.scored.best;
    let most = tree.open.max(best);
    Ok(ExactOutcome {
        proof: Proof {
            most,
            gap: most - best,
            passes: tree.passes,
            tree_passes: levels.sum::<f64>() * bounds.len() as f64,
            nodes: tree.nodes,
            merged: tree.merged,
        },
        evaluation: tree.scored.into_evaluation(evaluator),
        cut: most > best,
    })
}

/// Memory per robot and item, and per robot and rule, on each pattern [bytes]: somewhat more than the sizes of
/// what is kept of them.
const PER_ITEM: f64 = 64.0;
const PER_RULE: f64 = 128.0;

/// Memory that the search takes for the patterns of `evaluator` [bytes].
pub(super) fn memory(evaluator: &Evaluator) -> f64 {
    let robots = evaluator.station().robots().len() as f64;
    let pattern = PER_ITEM * evaluator.mean_items() + PER_RULE * Rule::all().len() as f64;
    robots * pattern * evaluator.pattern_count() as f64
}

/// Checks that branch and bound applies.
///
/// # Errors
/// Robots that are not independent, or an objective that takes more than one run of an assignment.
pub(super) fn check(evaluator: &Evaluator) -> Result<()> {
    let (problem, cure) = if matches!(evaluator.objective(), Objective::MaxSpeed(_)) {
        (
            "branch and bound does not take the objective max-speed",
            "use another 'objective', or 'kind' exhaustive or grasp",
        )
    } else if evaluator.independent_patterns() < evaluator.pattern_count() {
        (
            "branch and bound needs robots that pick independently, but here workspaces overlap or \
             attempts may fail",
            "use 'kind' exhaustive or grasp",
        )
    } else {
        return Ok(());
    };
    Err(Error::usage("'kind'", problem, cure))
}

/// The search. What it does depends on nothing but the patterns: blocks are simulated in parallel, but
/// everything is decided between them.
struct Tree<'a, 'e> {
    robots: usize,
    risk: Risk,
    /// The rules that are tried: all but those that always coincide with an earlier one.
    rules: Vec<Rule>,
    desks: Vec<Desk<'a>>,
    /// The rules of the robots before the one that is looked at.
    prefix: Vec<Rule>,
    scored: Scored,
    /// The highest ceiling of the prefixes that were not followed to their end.
    open: f64,
    passes: u64,
    most_passes: u64,
    nodes: u64,
    merged: u64,
    environment: &'e Environment<'e>,
}

/// A rule of the next robot.
struct Child {
    rule: Rule,
    /// The objective on each pattern, or what it does not exceed.
    values: Vec<f64>,
    /// Share of the items picked so far on each pattern.
    shares: Vec<f64>,
    /// The values combined.
    most: f64,
    /// Whether the robots after it change nothing on any pattern.
    settled: bool,
}

impl Tree<'_, '_> {
    /// Looks at every completion of the prefix, which does not exceed `bounds`. Returns whether that was
    /// done to the end.
    fn expand(&mut self, bounds: &[f64]) -> bool {
        let robot = self.prefix.len();
        let cost = (self.rules.len() * self.desks.len()) as u64;
        if self.environment.stopped() || self.passes + cost > self.most_passes {
            self.open = self.open.max(self.risk.aggregate(bounds));
            return false;
        }
        self.nodes += 1;
        let mut children = self.simulate(robot, bounds);
        if robot + 1 == self.robots {
            self.report(self.rules.len());
            for child in children {
                self.record(child);
            }
            return true;
        }
        self.report(self.rules.len() - children.len());
        // The most promising first, so that the others have more to beat.
        children.sort_by(|a, b| b.most.total_cmp(&a.most));
        let mut followed: Vec<Rule> = Vec::new();
        let mut whole = true;
        for child in children {
            if !whole {
                self.open = self.open.max(child.most);
            } else if self.scored.cannot_gain_by(child.most) {
                self.report(1);
            } else if followed
                .iter()
                .any(|&rule| self.coincide(robot, (rule, child.rule)))
            {
                self.merged += 1;
                self.report(1);
            } else if child.settled {
                self.merged += 1;
                self.report(1);
                self.record(child);
            } else {
                followed.push(child.rule);
                self.desks
                    .iter_mut()
                    .for_each(|desk| desk.follow(robot, child.rule));
                self.prefix.push(child.rule);
                whole = self.expand(&child.values);
                self.prefix.pop();
                self.desks
                    .iter_mut()
                    .for_each(|desk| desk.follow(robot, child.rule));
            }
        }
        whole
    }

    /// The rules of `robot` that can still win, simulated on all patterns.
    fn simulate(&mut self, robot: usize, bounds: &[f64]) -> Vec<Child> {
        let child = |&rule: &Rule| Child {
            rule,
            values: bounds.to_vec(),
            shares: Vec::with_capacity(bounds.len()),
            most: f64::INFINITY,
            settled: true,
        };
        let mut children: Vec<Child> = self.rules.iter().map(child).collect();
        for (block, desks) in self.desks.chunks_mut(BLOCK).enumerate() {
            let rules: Vec<Rule> = children.iter().map(|child| child.rule).collect();
            self.passes += (rules.len() * desks.len()) as u64;
            let steps = desks.par_iter_mut().map(|desk| {
                let steps = rules.iter().map(|&rule| desk.pass(robot, rule));
                steps.collect::<Vec<Step>>()
            });
            let steps: Vec<Vec<Step>> = steps.collect();
            for (place, steps) in steps.iter().enumerate() {
                for (child, step) in children.iter_mut().zip(steps) {
                    let value = &mut child.values[block * BLOCK + place];
                    // A figure of whole runs stands as it is; of the others, what no completion of the shorter
                    // prefix exceeds, none of this one does.
                    *value = match step.settled {
                        true => step.value,
                        false => value.min(step.value),
                    };
                    child.shares.push(step.share);
                    child.settled &= step.settled;
                }
            }
            children.retain_mut(|child| {
                child.most = self.risk.aggregate(&child.values);
                !self.scored.cannot_gain_by(child.most)
            });
        }
        children
    }

    /// Whether both rules of `robot` give the same on all patterns, whatever the others do.
    fn coincide(&self, robot: usize, rules: (Rule, Rule)) -> bool {
        self.desks.iter().all(|desk| desk.coincide(robot, rules))
    }

    /// Keeps the score of the prefix with `child`; robots after it, which change nothing, get the first
    /// rule.
    fn record(&mut self, child: Child) {
        let mut rules = self.prefix.clone();
        rules.push(child.rule);
        rules.resize(self.robots, self.rules[0]);
        let assignment = RuleAssignment::new(rules);
        if child.most > self.scored.best {
            let text = format!("{assignment} {:.4}", child.most);
            self.environment.progress.incumbent(&text);
        }
        let score = Score {
            picked_share: stats::mean(&child.shares),
            values: child.values,
        };
        self.scored.add(assignment, score, child.most);
    }

    /// Reports that `count` branches below the prefix are done.
    fn report(&self, count: usize) {
        let depth = self.prefix.len() + 1;
        if depth <= REPORTED {
            let each = self
                .rules
                .len()
                .pow((REPORTED.min(self.robots) - depth) as u32);
            self.environment.progress.advance((count * each) as u64);
        }
    }
}
