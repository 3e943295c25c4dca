//! Many assignments on one scene, with the work that they have in common done once.

use super::cascade::Cascade;
use super::run::Run;
use super::scene::Scene;
use crate::decision::Figures;
use crate::dispatch::{Rule, RuleAssignment, RuleStrategy};
use crate::error::Result;

/// Assignments as a prefix tree: two that begin alike share the passes of the robots
/// that they have in common. The tree of all assignments of N robots takes
/// 6 + 6^2 + ... + 6^N passes of one robot.
#[derive(Debug, Clone)]
pub struct AssignmentTree {
    assignments: Vec<RuleAssignment>,
    /// In preorder: a node's parent is the last one before it that is one shallower.
    nodes: Vec<Node>,
}

#[derive(Debug, Clone)]
struct Node {
    robot: usize,
    rule: Rule,
    /// Position in `assignments` of the one that ends here.
    assignment: Option<usize>,
}

impl AssignmentTree {
    /// The tree of these assignments, which may be of different lengths: robots
    /// without a rule stand idle. Empty assignments are left out, doubles kept once.
    pub fn new(mut assignments: Vec<RuleAssignment>) -> Self {
        assignments.retain(|assignment| !assignment.rules().is_empty());
        assignments.sort_unstable();
        assignments.dedup();
        let mut nodes = Vec::new();
        let mut before: &[Rule] = &[];
        for (place, assignment) in assignments.iter().enumerate() {
            let rules = assignment.rules();
            let common = before.iter().zip(rules).take_while(|(a, b)| a == b).count();
            for (robot, &rule) in rules.iter().enumerate().skip(common) {
                nodes.push(Node {
                    robot,
                    rule,
                    assignment: (robot + 1 == rules.len()).then_some(place),
                });
            }
            before = rules;
        }
        Self { assignments, nodes }
    }

    /// The tree of all `6^robots` assignments.
    pub fn all(robots: usize) -> Self {
        Self::new(RuleAssignment::all(robots).collect())
    }

    /// The assignments, in registry order.
    pub fn assignments(&self) -> &[RuleAssignment] {
        &self.assignments
    }

    /// Robot passes that one walk takes where robots are independent.
    pub fn passes(&self) -> usize {
        self.nodes.len()
    }

    /// The figures of every assignment on `scene`, told to `visit` with its position
    /// in [`AssignmentTree::assignments`], in that order. Uses the cascade where the
    /// robots are independent on this scene, else the event loop.
    ///
    /// # Errors
    /// More rules than robots.
    pub fn evaluate(&self, scene: &Scene, visit: impl FnMut(usize, Figures)) -> Result<()> {
        self.evaluate_while(scene, || true, visit).map(drop)
    }

    /// As [`AssignmentTree::evaluate`], as long as `go_on` says so; it is asked before
    /// every assignment. Returns whether all were visited.
    ///
    /// # Errors
    /// As for [`AssignmentTree::evaluate`].
    pub fn evaluate_while(
        &self,
        scene: &Scene,
        go_on: impl Fn() -> bool,
        mut visit: impl FnMut(usize, Figures),
    ) -> Result<bool> {
        self.evaluate_robots(scene, go_on, |place, figures, _| visit(place, figures))
    }

    /// As [`AssignmentTree::evaluate_while`], telling `visit` also how many items each
    /// robot of the station picked, upstream first. That takes no more simulation: in a
    /// cascade a robot's picks are those of its own pass.
    ///
    /// # Errors
    /// As for [`AssignmentTree::evaluate`].
    pub fn evaluate_robots(
        &self,
        scene: &Scene,
        go_on: impl Fn() -> bool,
        mut visit: impl FnMut(usize, Figures, &[usize]),
    ) -> Result<bool> {
        let robots = scene.station().robots().len();
        if let Some(long) = self.assignments.iter().find(|a| a.rules().len() > robots) {
            return long.clone().for_robots(robots).map(|_| true);
        }
        let mut picks = vec![0; robots];
        if let Some(mut cascade) = Cascade::new(scene) {
            // The robot behind which nothing is left, and the figures then: those below it
            // change nothing, which on a long line is most of the tree.
            let mut last: Option<(usize, Figures)> = None;
            for node in &self.nodes {
                let (robot, figures) = match last.filter(|(robot, _)| node.robot > *robot) {
                    Some(last) => last,
                    None => {
                        let figures = cascade.extend(node.robot, node.rule);
                        last = figures.complete().then_some((node.robot, figures));
                        (node.robot, figures)
                    }
                };
                if let Some(place) = node.assignment {
                    if !go_on() {
                        return Ok(false);
                    }
                    // Robots past the assignment's end stand idle.
                    let each = cascade.picks(robot + 1).chain(std::iter::repeat(0));
                    picks.iter_mut().zip(each).for_each(|(to, n)| *to = n);
                    visit(place, figures, &picks);
                }
            }
        } else {
            let mut run = Run::new(scene);
            for (place, assignment) in self.assignments.iter().enumerate() {
                if !go_on() {
                    return Ok(false);
                }
                run.reset();
                run.play(&mut RuleStrategy(assignment.clone()))?;
                let each = run.robots().iter().map(|robot| robot.picked);
                picks.iter_mut().zip(each).for_each(|(to, n)| *to = n);
                visit(place, run.figures(), &picks);
            }
        }
        Ok(true)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shared_prefixes_are_passed_once() {
        let read = |text: &str| text.parse::<RuleAssignment>().unwrap();
        let tree = AssignmentTree::new(vec![
            read("SPT,FIFO,LD"),
            read("SPT,FIFO,LD"),
            read("SPT,FIFO"),
            read("SPT,SPT"),
        ]);
        assert_eq!(tree.assignments().len(), 3);
        assert_eq!(tree.passes(), 4);
        let rules = crate::dispatch::RULES.len();
        let passes = rules + rules.pow(2) + rules.pow(3);
        assert_eq!(AssignmentTree::all(3).passes(), passes);
    }

    /// What the robots behind the last item are spared is what they would not have done.
    #[test]
    fn robots_with_nothing_left_are_spared_without_a_difference() {
        let station = crate::station::built_in("paper").unwrap();
        let station = station.station(Some(5)).unwrap();
        let pattern = crate::pattern::grid(1.05, 0.3, 20).unwrap();
        let tree = AssignmentTree::all(5);
        let (mut early, mut late, mut missed) = (0, 0, 0);
        for speed in [0.01, 0.1, 0.3] {
            let station = station.with_belt_speed(speed).unwrap();
            let scene = Scene::new(&station, &pattern).unwrap();
            assert!(scene.is_independent());
            let mut run = Run::new(&scene);
            let visit = |place: usize, figures: Figures, picks: &[usize]| {
                run.reset();
                let rules = tree.assignments()[place].clone();
                run.play(&mut RuleStrategy(rules)).unwrap();
                assert_eq!(run.figures(), figures);
                let plain: Vec<usize> = run.robots().iter().map(|robot| robot.picked).collect();
                assert_eq!(plain, picks);
                match picks {
                    _ if !figures.complete() => missed += 1,
                    [.., 0] => early += 1,
                    _ => late += 1,
                }
            };
            assert!(tree.evaluate_robots(&scene, || true, visit).unwrap());
        }
        // All three kinds were among them.
        assert!(
            early > 0 && late > 0 && missed > 0,
            "{early}, {late}, {missed}"
        );
    }
}
