//! The result of solving a line's game.

use super::game_table;
use super::nfg::nfg_text;
use super::provenance::Provenance;
use super::table::column;
use pickline::optimize::game::{
    Deviation, End, Equilibrium, LineGame, Payoff, PayoffKind, Price, dominance, dominant,
    equilibria, equivalent, optimum, play, prices,
};
use pickline::stats::Interval;
use serde::Serialize;

/// A solved game as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
pub struct GameReport {
    /// `own` or `total`.
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
    pub rules_of_robots: Vec<RobotReport>,
    /// All assignments, in registry order.
    pub profiles: Vec<ProfileReport>,
    /// Remarks for the reader.
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    /// The game in Gambit's format, written as a separate file.
    #[serde(skip)]
    pub nfg: String,
}

/// One equilibrium.
#[derive(Debug, Clone, Serialize)]
pub struct EquilibriumReport {
    /// The rules, upstream first.
    pub assignment: Vec<String>,
    /// `strict`: every change of one rule is a loss to the robot that changes; `weak`: some
    /// change costs it nothing.
    pub kind: &'static str,
    /// Each robot's payoff.
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
pub struct DeviationReport {
    /// The robot's name.
    pub robot: String,
    /// Its new rule.
    pub rule: String,
    /// Whether the new rule gives this robot the same payoff as its own whatever the others do.
    pub equivalent: bool,
    /// The robot's gain; never above 0 in an equilibrium.
    pub gain: Payoff,
    /// Lower end of the 95 % interval of the gain, paired over patterns; `None` for a single
    /// pattern.
    pub gain_low: Option<f64>,
    /// Upper end of that interval.
    pub gain_high: Option<f64>,
}

/// The assignments with the highest welfare.
#[derive(Debug, Clone, Serialize)]
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
pub struct PlayReport {
    /// The order in which robots move.
    pub order: &'static str,
    /// Number of starts: all assignments.
    pub starts: usize,
    /// How many of them end in an equilibrium.
    pub to_equilibrium: usize,
    /// How many end in a cycle.
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
pub struct RobotReport {
    /// The robot's name.
    pub robot: String,
    /// Rules that are never worse than any other.
    pub dominant: Vec<String>,
    /// Rules that another rule dominates.
    pub dominated: Vec<DominatedReport>,
    /// Groups of rules that always give it the same payoff.
    pub equivalent: Vec<Vec<String>>,
}

/// A dominated rule.
#[derive(Debug, Clone, Serialize)]
pub struct DominatedReport {
    /// The dominated rule.
    pub rule: String,
    /// A rule that dominates it.
    pub by: String,
    /// `strictly`: always better; `weakly`: never worse and sometimes better.
    pub how: &'static str,
}

/// One assignment.
#[derive(Debug, Clone, Serialize)]
pub struct ProfileReport {
    /// The rules, upstream first.
    pub assignment: Vec<String>,
    /// Each robot's payoff.
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

impl GameReport {
    /// The report of `line`, whose robots receive `payoff`; `expected` patterns were requested.
    pub fn new(
        line: &LineGame,
        payoff: PayoffKind,
        expected: usize,
        notes: Vec<String>,
        made: Provenance,
    ) -> Self {
        let game = &line.game;
        let found = equilibria(game);
        let best = optimum(game);
        let (anarchy, stability) = prices(game, &best, &found);
        let played = play(game);
        let mut notes = notes;
        match anarchy {
            Price::Ratio(_) => {}
            Price::NoEquilibrium => notes.push(
                "no pure equilibrium, so there is no price of anarchy or stability; \
                 mixed equilibria are not searched for"
                    .to_owned(),
            ),
            Price::Unbounded => notes.push(
                "the price of anarchy is unbounded: some equilibrium picks nothing".to_owned(),
            ),
        }
        let all = Reporter { line };
        let title = format!("Dispatching rules of a line, payoff {}", payoff.name());
        let partial = made.partial.iter().map(|partial| format!("{partial}; "));
        let comment = format!(
            "{}payoffs in picks per minute; station {} (hash {}); patterns {}; made by {}: {}",
            partial.collect::<String>(),
            made.station,
            made.station_hash,
            made.patterns,
            made.program,
            made.command
        );
        let kind_of = |profile: usize| {
            let here = found.iter().find(|e| e.profile == profile);
            here.map_or("", kind)
        };
        let path = |first: usize, changes: &[Deviation]| {
            let after = changes.iter().map(|change| change.profile);
            std::iter::once(first)
                .chain(after)
                .map(|p| all.names(p))
                .collect::<Vec<_>>()
        };
        let profile = |p: usize| ProfileReport {
            assignment: all.names(p),
            payoffs: game.payoffs(p).to_vec(),
            rates: line.rates(p).to_vec(),
            welfare: game.welfare(p),
            equilibrium: kind_of(p),
            leads_to: match played.ends[p] {
                End::Equilibrium(end) => all.names(end),
                End::Cycle(_) => Vec::new(),
            },
        };
        Self {
            payoff: payoff.name(),
            unit: "1/min",
            resolution: Payoff::RESOLUTION,
            robots: game.players().iter().map(|p| p.name.clone()).collect(),
            rules: game
                .players()
                .first()
                .map_or(Vec::new(), |p| p.actions.clone()),
            patterns: line.patterns,
            runs: line.runs(),
            stop_reason: if line.patterns == expected {
                "enumerated"
            } else {
                "interrupted"
            },
            equilibria: found
                .iter()
                .map(|e| all.equilibrium(e, played.basin(e.profile)))
                .collect(),
            social_optimum: SocialOptimum {
                welfare: best.welfare,
                assignments: best.profiles.iter().map(|&p| all.names(p)).collect(),
                is_equilibrium: best.profiles.iter().any(|&p| !kind_of(p).is_empty()),
            },
            price_of_anarchy: anarchy.ratio(),
            price_of_stability: stability.ratio(),
            best_response: PlayReport {
                order: "robots in turn, upstream first; among equally good rules, the current \
                        one if possible, otherwise the first listed",
                starts: game.profiles(),
                to_equilibrium: played.to_equilibrium(),
                to_cycle: game.profiles() - played.to_equilibrium(),
                most_rounds: played.most_rounds,
                most_changes: played.longest.1.len(),
                longest: path(played.longest.0, &played.longest.1),
                cycles: played
                    .cycles
                    .iter()
                    .map(|cycle| CycleReport {
                        rounds: cycle.rounds,
                        assignments: path(cycle.first, &cycle.changes),
                        basin: cycle.basin,
                    })
                    .collect(),
            },
            rules_of_robots: all.robots(),
            profiles: (0..game.profiles()).map(profile).collect(),
            notes,
            nfg: nfg_text(game, &title, &comment),
            made,
        }
    }

    /// The whole report for the terminal, with the first `top` equilibria and cycles.
    pub fn to_table(&self, top: usize) -> String {
        game_table::text(self, top)
    }

    /// All assignments with their payoffs as CSV.
    pub fn to_csv(&self) -> String {
        let robots = robot_columns(&self.robots);
        let each = |what: &str| {
            let name = |robot: &String| column(&format!("{what}_{robot}"), self.unit);
            robots.iter().map(name).collect::<Vec<_>>()
        };
        let header = [
            vec!["assignment".to_owned()],
            each("payoff"),
            each("rate"),
            vec![
                column("welfare", self.unit),
                "equilibrium".to_owned(),
                "leads_to".to_owned(),
            ],
        ]
        .concat();
        let rows = self.profiles.iter().map(|profile| {
            let texts = |values: &[Payoff]| values.iter().map(Payoff::to_string).collect();
            [
                vec![profile.assignment.join(" ")],
                texts(&profile.payoffs),
                texts(&profile.rates),
                vec![
                    profile.welfare.to_string(),
                    profile.equilibrium.to_owned(),
                    profile.leads_to.join(" "),
                ],
            ]
            .concat()
        });
        self.made.csv(std::iter::once(header).chain(rows))
    }
}

/// The robots' names as parts of column names; their numbers, upstream first, if the names are
/// not unique.
fn robot_columns(names: &[String]) -> Vec<String> {
    let snake = |name: &String| {
        let part = |c: char| {
            if c.is_alphanumeric() {
                c.to_ascii_lowercase()
            } else {
                '_'
            }
        };
        name.chars().map(part).collect::<String>()
    };
    let parts: Vec<String> = names.iter().map(snake).collect();
    let distinct: std::collections::BTreeSet<&String> = parts.iter().collect();
    if distinct.len() == parts.len() {
        return parts;
    }
    (1..=names.len())
        .map(|number| format!("robot_{number}"))
        .collect()
}

fn kind(equilibrium: &Equilibrium) -> &'static str {
    if equilibrium.is_strict() {
        "strict"
    } else {
        "weak"
    }
}

struct Reporter<'a> {
    line: &'a LineGame,
}

impl Reporter<'_> {
    fn names(&self, profile: usize) -> Vec<String> {
        let names = self.line.game.names(profile);
        names.into_iter().map(str::to_owned).collect()
    }

    fn equilibrium(&self, equilibrium: &Equilibrium, basin: usize) -> EquilibriumReport {
        let (game, profile) = (&self.line.game, equilibrium.profile);
        let mut deviations = Vec::new();
        for (i, player) in game.players().iter().enumerate() {
            let current = game.action(profile, i);
            let groups = equivalent(game, i);
            let others = (0..game.actions(i)).filter(|&a| a != current);
            deviations.extend(others.map(|action| {
                let interval = self.line.gain_interval(profile, i, action);
                let (gain_low, gain_high) = Interval::ends(interval);
                DeviationReport {
                    robot: player.name.clone(),
                    rule: player.actions[action].clone(),
                    equivalent: groups
                        .iter()
                        .any(|g| g.contains(&action) && g.contains(&current)),
                    gain: game.payoff(game.with(profile, i, action), i) - game.payoff(profile, i),
                    gain_low,
                    gain_high,
                }
            }));
        }
        EquilibriumReport {
            assignment: self.names(profile),
            kind: kind(equilibrium),
            payoffs: game.payoffs(profile).to_vec(),
            rates: self.line.rates(profile).to_vec(),
            welfare: game.welfare(profile),
            margin: equilibrium.margin,
            margin_to_others: equilibrium.margin_to_others,
            proven: (self.line.patterns > 1).then(|| {
                let loses = |d: &&DeviationReport| d.gain_high.is_some_and(|high| high < 0.0);
                deviations.iter().filter(loses).count()
            }),
            basin,
            deviations,
        }
    }

    fn robots(&self) -> Vec<RobotReport> {
        let game = &self.line.game;
        let dominated = dominance(game);
        let of = |i: usize| {
            let player = &game.players()[i];
            let names = |actions: Vec<usize>| -> Vec<String> {
                let name = |a: usize| player.actions[a].clone();
                actions.into_iter().map(name).collect()
            };
            RobotReport {
                robot: player.name.clone(),
                dominant: names(dominant(game, i)),
                dominated: dominated
                    .iter()
                    .filter(|d| d.player == i)
                    .map(|d| DominatedReport {
                        rule: player.actions[d.action].clone(),
                        by: player.actions[d.by].clone(),
                        how: if d.strict { "strictly" } else { "weakly" },
                    })
                    .collect(),
                equivalent: equivalent(game, i).into_iter().map(names).collect(),
            }
        };
        (0..game.players().len()).map(of).collect()
    }
}
