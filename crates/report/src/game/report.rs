//! The result of solving a line's game.

use crate::provenance::Provenance;
use pickline::optimize::game::Payoff;
use pickline::stats::Interval;
use serde::Serialize;

/// A solved game as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct GameReport {
    /// What a robot gains: `own` for its own picks, `total` for those of the line.
    pub payoff: &'static str,
    /// Unit of payoffs, rates, welfare and gains.
    pub unit: &'static str,
    /// Payoffs are rounded to whole multiples of this [1/min]. All later steps are exact:
    /// payoffs are equal if they round to the same multiple.
    pub resolution: f64,
    /// The players: the robots' names, upstream first.
    pub robots: Vec<String>,
    /// Each player's actions: the rules' names.
    pub rules: Vec<String>,
    /// Number of patterns over which payoffs are averaged.
    pub patterns: usize,
    /// Simulated runs: one assignment on one pattern each.
    pub runs: u64,
    /// `enumerated`, or `interrupted` if some patterns are missing.
    pub stop_reason: &'static str,
    /// All pure Nash equilibria, highest welfare first.
    pub equilibria: Vec<EquilibriumReport>,
    /// The assignments with the highest welfare.
    pub social_optimum: SocialOptimum,
    /// Welfare of the social optimum divided by that of the worst equilibrium; `None` without
    /// an equilibrium or if its welfare is 0 (a note says which).
    pub price_of_anarchy: Option<f64>,
    /// The same for the best equilibrium.
    pub price_of_stability: Option<f64>,
    /// Iterated best response from every start.
    pub best_response: PlayReport,
    /// For each robot: dominant, dominated and equivalent rules.
    pub rules_of_robots: Vec<RobotRulesReport>,
    /// All assignments, in registry order.
    pub profiles: Vec<ProfileReport>,
    /// Remarks on how the figures are to be read.
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    /// The game in Gambit's format, written as a separate file.
    #[serde(skip)]
    pub nfg: String,
}

/// An assignment from which no robot gains by deviating alone.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct EquilibriumReport {
    /// The rules, upstream first.
    pub assignment: Vec<String>,
    /// `strict`: every change of one rule is a loss to the robot that changes; `weak`: some
    /// change costs it nothing.
    pub kind: &'static str,
    /// Payoff of each robot [1/min], upstream first.
    pub payoffs: Vec<Payoff>,
    /// Each robot's own picks per minute.
    pub rates: Vec<Payoff>,
    /// The line's picks per minute.
    pub welfare: Payoff,
    /// The smallest loss of a robot that changes its rule.
    pub margin: Option<Payoff>,
    /// The same over changes to rules that are not equivalent to its own.
    pub margin_to_others: Option<Payoff>,
    /// Changes of one rule whose 95 % interval of the gain lies below 0: losses that the random
    /// choice of patterns does not explain; `None` for a single pattern.
    pub proven: Option<usize>,
    /// Number of starts from which iterated best response ends here.
    pub basin: usize,
    /// All changes of one rule.
    pub deviations: Vec<DeviationReport>,
}

/// One robot changes its rule; the others keep theirs.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct DeviationReport {
    /// Name of the robot.
    pub robot: String,
    /// Rule that it changes to.
    pub rule: String,
    /// Whether the new rule gives this robot the same payoff as its own whatever the others do.
    pub equivalent: bool,
    /// The robot's gain; never above 0 in an equilibrium.
    pub gain: Payoff,
    /// 95 % interval of the gain, paired over patterns [1/min]; `None` for a single pattern.
    #[serde(flatten, serialize_with = "crate::ends::gain")]
    pub gain_interval: Option<Interval>,
}

/// The assignments with the highest welfare.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct SocialOptimum {
    /// The line's picks per minute.
    pub welfare: Payoff,
    /// The assignments that reach this welfare.
    pub assignments: Vec<Vec<String>>,
    /// Whether one of them is an equilibrium.
    pub is_equilibrium: bool,
}

/// Iterated best response from every start.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct PlayReport {
    /// The order in which robots move.
    pub order: &'static str,
    /// Number of starts: all assignments.
    pub starts: usize,
    /// How many of them end in an equilibrium.
    pub to_equilibrium: usize,
    /// Number of starts from which play ends in a cycle.
    pub to_cycle: usize,
    /// The most rounds with a change before a start reaches its end.
    pub most_rounds: usize,
    /// The most rule changes before a start reaches its end.
    pub most_changes: usize,
    /// The longest path: the start, then the assignment after each change.
    pub longest: Vec<Vec<String>>,
    /// All cycles that were found.
    pub cycles: Vec<CycleReport>,
}

/// Assignments that best responses cycle through forever.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct CycleReport {
    /// Rounds until the cycle repeats.
    pub rounds: usize,
    /// The assignments, change by change; the last is the first.
    pub assignments: Vec<Vec<String>>,
    /// Number of starts from which play ends here.
    pub basin: usize,
}

/// What each rule is worth to one robot, whatever the others do.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RobotRulesReport {
    /// Name of the robot.
    pub robot: String,
    /// Rules that are never worse than any other.
    pub dominant: Vec<String>,
    /// Rules that another rule dominates.
    pub dominated: Vec<DominatedReport>,
    /// Groups of rules that always give it the same payoff.
    pub equivalent: Vec<Vec<String>>,
}

/// A rule that another one dominates for a robot.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct DominatedReport {
    /// The dominated rule.
    pub rule: String,
    /// A rule that dominates it.
    pub by: String,
    /// `strictly`: always better; `weakly`: never worse and sometimes better.
    pub how: &'static str,
}

/// An assignment with its payoffs.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct ProfileReport {
    /// The rules, upstream first.
    pub assignment: Vec<String>,
    /// Payoff of each robot [1/min], upstream first.
    pub payoffs: Vec<Payoff>,
    /// Each robot's own picks per minute.
    pub rates: Vec<Payoff>,
    /// The line's picks per minute.
    pub welfare: Payoff,
    /// `strict`, `weak` or empty.
    pub equilibrium: &'static str,
    /// The equilibrium in which iterated best response from here ends; empty for a cycle.
    pub leads_to: Vec<String>,
}
