//! Evaluates many assignments on one scene and shares their common work.

use super::cascade::Cascade;
use super::run::Run;
use super::scene::Scene;
use crate::decision::Figures;
use crate::dispatch::{Rule, RuleAssignment, RuleStrategy};
use crate::error::Result;

/// Assignments as a prefix tree: assignments with a common prefix share the passes of its robots.
/// The tree of all assignments of N robots takes 6 + 6^2 + ... + 6^N passes of one robot.
#[derive(Debug, Clone)]
pub struct AssignmentTree {
    assignments: Vec<RuleAssignment>,
    /// In preorder: the parent of a node is the last node before it that is one level higher.
    nodes: Vec<Node>,
}

#[derive(Debug, Clone)]
struct Node {
    robot: usize,
    rule: Rule,
    /// Index in `assignments` of the assignment that ends here.
    assignment: Option<usize>,
}

impl AssignmentTree {
    /// The tree of these assignments, which may differ in length: robots without a rule stay idle.
    /// Empty and duplicate assignments are removed.
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

    /// Number of robot passes in one walk if the robots are independent.
    pub fn passes(&self) -> usize {
        self.nodes.len()
    }

    /// Calls `visit` with the figures of every assignment on `scene`, in the order of
    /// [`AssignmentTree::assignments`] and with its index there. Uses the cascade if the robots are
    /// independent on this scene, otherwise the event loop.
    ///
    /// # Errors
    /// If an assignment has more rules than there are robots.
    pub fn evaluate(&self, scene: &Scene, visit: impl FnMut(usize, Figures)) -> Result<()> {
        self.evaluate_while(scene, || true, visit).map(drop)
    }

    /// Like [`AssignmentTree::evaluate`], but stops when `go_on`, which is called before every
    /// assignment, returns false. Returns whether all assignments were visited.
    ///
    /// # Errors
    /// See [`AssignmentTree::evaluate`].
    pub fn evaluate_while(
        &self,
        scene: &Scene,
        go_on: impl Fn() -> bool,
        mut visit: impl FnMut(usize, Figures),
    ) -> Result<bool> {
        let passes = self.evaluate_passes(scene, go_on, |place, figures, _| visit(place, figures));
        Ok(passes?.is_some())
    }

    /// Like [`AssignmentTree::evaluate_while`], but also passes to `visit` how many items each
    /// robot of the station picked, upstream first. This needs no further simulation: in a cascade
    /// the picks of a robot are those of its own pass.
    ///
    /// # Errors
    /// See [`AssignmentTree::evaluate`].
    pub fn evaluate_robots(
        &self,
        scene: &Scene,
        go_on: impl Fn() -> bool,
        visit: impl FnMut(usize, Figures, &[usize]),
    ) -> Result<bool> {
        Ok(self.evaluate_passes(scene, go_on, visit)?.is_some())
    }

    /// Like [`AssignmentTree::evaluate_robots`], but returns how many passes of one robot it took;
    /// `None` if stopped. In the event loop every assignment takes one pass for each of its rules.
    ///
    /// # Errors
    /// See [`AssignmentTree::evaluate`].
    pub fn evaluate_passes(
        &self,
        scene: &Scene,
        go_on: impl Fn() -> bool,
        mut visit: impl FnMut(usize, Figures, &[usize]),
    ) -> Result<Option<u64>> {
        let robots = scene.station().robots().len();
        if let Some(long) = self.assignments.iter().find(|a| a.rules().len() > robots) {
            return long.clone().for_robots(robots).map(|_| None);
        }
        let mut picks = vec![0; robots];
        let mut passes = 0;
        if let Some(mut cascade) = Cascade::new(scene) {
            // The robot after which no item is left, and the figures at that point. The robots
            // below it change nothing, which on a long line is most of the tree.
            let mut last: Option<(usize, Figures)> = None;
            for node in &self.nodes {
                let (robot, figures) = match last.filter(|(robot, _)| node.robot > *robot) {
                    Some(last) => last,
                    None => {
                        passes += 1;
                        let figures = cascade.extend(node.robot, node.rule);
                        last = figures.complete().then_some((node.robot, figures));
                        (node.robot, figures)
                    }
                };
                if let Some(place) = node.assignment {
                    if !go_on() {
                        return Ok(None);
                    }
                    // Robots beyond the end of the assignment stay idle.
                    let each = cascade.picks(robot + 1).chain(std::iter::repeat(0));
                    picks.iter_mut().zip(each).for_each(|(to, n)| *to = n);
                    visit(place, figures, &picks);
                }
            }
        } else {
            let mut run = Run::new(scene);
            for (place, assignment) in self.assignments.iter().enumerate() {
                if !go_on() {
                    return Ok(None);
                }
                passes += assignment.rules().len() as u64;
                run.reset();
                // Robots beyond the end of the assignment stay idle.
                run.play_on(&mut RuleStrategy(assignment.clone()), || true)?;
                let each = run.robots().iter().map(|robot| robot.picked);
                picks.iter_mut().zip(each).for_each(|(to, n)| *to = n);
                visit(place, run.figures(), &picks);
            }
        }
        Ok(Some(passes))
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

    /// Skipping the robots after the last item does not change any result.
    #[test]
    fn skipping_robots_without_candidates_changes_nothing() {
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
        // All three kinds occurred.
        assert!(
            early > 0 && late > 0 && missed > 0,
            "{early}, {late}, {missed}"
        );
    }
}
