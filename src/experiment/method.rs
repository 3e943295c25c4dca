//! The methods that a comparison compares.

use crate::decision::{Figures, Outcome};
use crate::dispatch::{RULES, RuleAssignment};
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::purity::{BinContents, bin_contents};
use crate::sim::{AssignmentTree, ClassRun, Scene, class_runs, simulate_rules, simulate_while};
use crate::strategies::{Blueprint, POLICY};
use crate::throughput::{SteadyState, Unsteady, steady_state};

/// One column of a comparison.
#[derive(Debug, Clone)]
pub enum Method {
    /// The assignment that is best over a training set (robust GT, game theory, of Jermann et
    /// al.).
    Robust(RuleAssignment),
    /// For every pattern, the assignment that is best on it (greedy GT).
    Greedy(AssignmentTree),
    /// Any other strategy.
    Strategy(Blueprint),
}

/// The result of a method on one pattern.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub struct MethodRun {
    /// What the run picked, and when it ended.
    pub figures: Figures,
    /// The steady state of the run, or why there is none.
    pub steady: std::result::Result<SteadyState, Unsteady>,
    /// What truly went into the bins; `None` unless detections may be wrong.
    pub contents: Option<BinContents>,
    /// What it picked of each class, on a station where classes matter.
    pub classes: Vec<ClassRun>,
    /// The assignment that greedy GT chose.
    pub chosen: Option<RuleAssignment>,
}

impl MethodRun {
    fn of(scene: &Scene, outcome: &Outcome, chosen: Option<RuleAssignment>) -> Self {
        Self {
            figures: outcome.figures,
            steady: steady_state(scene, outcome),
            contents: scene
                .conditions()
                .disturbances
                .misdetections
                .then(|| bin_contents(scene, &outcome.picks)),
            classes: class_runs(scene, outcome),
            chosen,
        }
    }
}

/// Largest number of robots for which greedy GT enumerates all assignments on every pattern.
const MOST_ROBOTS: usize = 7;

/// Robot passes times items that greedy GT can simulate in about a minute.
const GREEDY_PASSES: f64 = 300e6;

impl Method {
    /// Greedy GT for a line of `robots` robots.
    ///
    /// # Errors
    /// There are too many robots to try all assignments on every pattern.
    pub fn greedy(robots: usize) -> Result<Self> {
        if robots > MOST_ROBOTS {
            return Err(Error::usage(
                "greedy GT (game theory)",
                format!(
                    "{}^{robots} assignments to try on every pattern",
                    RULES.len()
                ),
                format!("compare at most {MOST_ROBOTS} robots, or skip it ('no_greedy')"),
            ));
        }
        Ok(Self::Greedy(AssignmentTree::all(robots)))
    }

    /// On how many of `patterns` patterns, with `items` items in total, greedy GT for a line of
    /// `robots` robots can be computed in about a minute; `None` if on all of them.
    pub(crate) fn greedy_limit(robots: usize, patterns: usize, items: f64) -> Option<usize> {
        let passes: f64 = (1..=robots as i32)
            .map(|depth| (RULES.len() as f64).powi(depth))
            .sum();
        let afforded = GREEDY_PASSES / (passes * items);
        (afforded < 1.0).then_some((afforded * patterns as f64) as usize)
    }

    /// The name in files: `robust_gt`, `greedy_gt`, or the strategy as it is written.
    pub fn id(&self) -> &str {
        match self {
            Self::Robust(_) => "robust_gt",
            Self::Greedy(_) => "greedy_gt",
            Self::Strategy(blueprint) => blueprint.name(),
        }
    }

    /// The name in tables, for people.
    pub fn title(&self) -> String {
        match self {
            Self::Robust(rules) => format!("robust GT {rules}"),
            Self::Greedy(_) => "greedy GT".into(),
            Self::Strategy(blueprint) if blueprint.name() == POLICY => policy_title(),
            Self::Strategy(blueprint) => blueprint.name().to_owned(),
        }
    }

    /// Runs the method on `scene`.
    ///
    /// # Errors
    /// The strategy acts illegally, or [`Interrupted`](crate::error::ErrorKind::Interrupted).
    pub fn run(&self, scene: &Scene, environment: &Environment) -> Result<MethodRun> {
        match self {
            Self::Robust(rules) => Ok(MethodRun::of(scene, &simulate_rules(scene, rules)?, None)),
            Self::Greedy(tree) => {
                let mut best: Option<(usize, Figures)> = None;
                // Of equally good assignments, the first in registry order is chosen.
                tree.evaluate(scene, |place, figures| {
                    let better = |(_, other): &(usize, Figures)| {
                        figures.picking_rate() > other.picking_rate()
                    };
                    if best.as_ref().is_none_or(better) {
                        best = Some((place, figures));
                    }
                })?;
                // A line has at least one robot, so its tree has an assignment.
                let (place, figures) = best.ok_or(Error::interrupted())?;
                let chosen = tree.assignments()[place].clone();
                // The tree does not store picks.
                let outcome = simulate_rules(scene, &chosen)?;
                Ok(MethodRun {
                    figures,
                    ..MethodRun::of(scene, &outcome, Some(chosen))
                })
            }
            Self::Strategy(blueprint) => {
                let go_on = || !environment.stopped();
                let outcome = simulate_while(scene, blueprint.make().as_mut(), go_on)?;
                Ok(MethodRun::of(scene, &outcome, None))
            }
        }
    }
}

/// The built-in policy's name in tables.
pub fn policy_title() -> String {
    format!("RL policy ({POLICY})")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::strategies::read_alone;

    #[test]
    fn greedy_gt_is_for_as_many_robots_as_can_be_enumerated() {
        for robots in [1, 2, 3] {
            let Method::Greedy(tree) = Method::greedy(robots).unwrap() else {
                panic!("greedy GT");
            };
            assert_eq!(tree.assignments().len(), 6usize.pow(robots as u32));
        }
        assert!(Method::greedy(7).is_ok());
        let message = Method::greedy(8).unwrap_err().to_string();
        for words in [
            "greedy GT",
            "6^8 assignments",
            "at most 7 robots",
            "'no_greedy'",
        ] {
            assert!(message.contains(words), "{words} not in {message}");
        }
    }

    /// Two robots need 6 + 36 passes of an item; 300 million passes take about a minute.
    #[test]
    fn greedy_gt_is_left_out_where_it_would_take_more_than_a_minute() {
        let minute = 300e6 / 42.0;
        assert_eq!(Method::greedy_limit(2, 100, 0.99 * minute), None);
        assert_eq!(Method::greedy_limit(2, 100, 1.01 * minute), Some(99));
        assert_eq!(Method::greedy_limit(2, 100, 2.0 * minute), Some(50));
        // Exactly one minute, with six passes of an item.
        assert_eq!(Method::greedy_limit(1, 100, 50e6), None);
        // 6 + 36 + 216.
        assert_eq!(Method::greedy_limit(3, 10, 0.99 * 300e6 / 258.0), None);
        assert_eq!(Method::greedy_limit(3, 10, 5.0 * 300e6 / 258.0), Some(2));
    }

    #[test]
    fn methods_have_names_for_files_and_tables() {
        let robust = Method::Robust("SPT,FIFO".parse().unwrap());
        let greedy = Method::greedy(2).unwrap();
        let rules = Method::Strategy(read_alone("SPT,PP", 2).unwrap());
        for (method, id, title) in [
            (robust, "robust_gt", "robust GT [SPT; FIFO]"),
            (greedy, "greedy_gt", "greedy GT"),
            (rules, "rules:SPT,PP", "rules:SPT,PP"),
        ] {
            assert_eq!((method.id(), method.title().as_str()), (id, title));
        }
        assert_eq!(policy_title(), "RL policy (onnx)");
        #[cfg(feature = "onnx")]
        {
            let policy = Method::Strategy(read_alone(POLICY, 2).unwrap());
            assert_eq!((policy.id(), policy.title()), ("onnx", policy_title()));
        }
    }
}
