//! The report of a solved game.

use super::nfg::nfg_text;
use super::report::{
    CycleReport, DeviationReport, DominatedReport, EquilibriumReport, GameReport, PlayReport,
    ProfileReport, RobotRulesReport, SocialOptimum,
};
use crate::provenance::Provenance;
use pickline::optimize::game::{
    Deviation, End, Equilibrium, LineGame, Payoff, PayoffKind, Play, Price, dominance, dominant,
    equilibria, equivalent, optimum, play, prices,
};

impl GameReport {
    /// The report of `line`, whose robots receive `payoff`; `expected` patterns were requested.
    pub fn new(
        line: &LineGame,
        payoff: PayoffKind,
        expected: usize,
        mut notes: Vec<String>,
        made: Provenance,
    ) -> Self {
        let game = &line.game;
        let equilibria = equilibria(game);
        let highest = optimum(game);
        let (anarchy, stability) = prices(game, &highest, &equilibria);
        notes.extend(price_note(&anarchy));
        let solved = SolvedGame {
            line,
            equilibria,
            highest: (highest.welfare, highest.profiles),
            played: play(game),
        };
        let players = game.players();
        Self {
            payoff: payoff.name(),
            unit: "1/min",
            resolution: Payoff::RESOLUTION,
            robots: players.iter().map(|p| p.name.clone()).collect(),
            rules: players.first().map_or(Vec::new(), |p| p.actions.clone()),
            patterns: line.patterns,
            runs: line.runs(),
            stop_reason: if line.patterns == expected {
                "enumerated"
            } else {
                "interrupted"
            },
            equilibria: solved.equilibria(),
            social_optimum: solved.social_optimum(),
            price_of_anarchy: anarchy.ratio(),
            price_of_stability: stability.ratio(),
            best_response: solved.best_response(),
            rules_of_robots: solved.robots(),
            profiles: (0..game.profiles()).map(|p| solved.profile(p)).collect(),
            notes,
            nfg: solved.nfg(payoff, &made),
            made,
        }
    }
}

/// Why there is no price of anarchy.
fn price_note(anarchy: &Price) -> Option<String> {
    match anarchy {
        Price::Ratio(_) => None,
        Price::NoEquilibrium => Some(
            "no pure equilibrium, so there is no price of anarchy or stability; \
             mixed equilibria are not searched for"
                .to_owned(),
        ),
        Price::Unbounded => {
            Some("the price of anarchy is unbounded: some equilibrium picks nothing".to_owned())
        }
    }
}

fn kind(equilibrium: &Equilibrium) -> &'static str {
    if equilibrium.is_strict() {
        "strict"
    } else {
        "weak"
    }
}

/// A line's game and what was found in it.
struct SolvedGame<'a> {
    line: &'a LineGame,
    equilibria: Vec<Equilibrium>,
    /// The highest welfare, and the assignments that reach it.
    highest: (Payoff, Vec<usize>),
    played: Play,
}

impl SolvedGame<'_> {
    fn names(&self, profile: usize) -> Vec<String> {
        let names = self.line.game.names(profile);
        names.into_iter().map(str::to_owned).collect()
    }

    /// The assignments after each of `changes`, `first` included.
    fn path(&self, first: usize, changes: &[Deviation]) -> Vec<Vec<String>> {
        let after = changes.iter().map(|change| change.profile);
        let profiles = std::iter::once(first).chain(after);
        profiles.map(|profile| self.names(profile)).collect()
    }

    /// How stable `profile` is, if it is an equilibrium; empty if not.
    fn kind_of(&self, profile: usize) -> &'static str {
        let mut equilibria = self.equilibria.iter();
        let here = equilibria.find(|equilibrium| equilibrium.profile == profile);
        here.map_or("", kind)
    }

    fn profile(&self, profile: usize) -> ProfileReport {
        let game = &self.line.game;
        ProfileReport {
            assignment: self.names(profile),
            payoffs: game.payoffs(profile).to_vec(),
            rates: self.line.rates(profile).to_vec(),
            welfare: game.welfare(profile),
            equilibrium: self.kind_of(profile),
            leads_to: match self.played.ends[profile] {
                End::Equilibrium(end) => self.names(end),
                End::Cycle(_) => Vec::new(),
            },
        }
    }

    fn social_optimum(&self) -> SocialOptimum {
        let (welfare, profiles) = &self.highest;
        SocialOptimum {
            welfare: *welfare,
            assignments: profiles.iter().map(|&p| self.names(p)).collect(),
            is_equilibrium: profiles.iter().any(|&p| !self.kind_of(p).is_empty()),
        }
    }

    fn best_response(&self) -> PlayReport {
        let (played, starts) = (&self.played, self.line.game.profiles());
        let (first, changes) = &played.longest;
        let cycles = played.cycles.iter();
        PlayReport {
            order: "robots in turn, upstream first; among equally good rules, the current \
                    one if possible, otherwise the first listed",
            starts,
            to_equilibrium: played.to_equilibrium(),
            to_cycle: starts - played.to_equilibrium(),
            most_rounds: played.most_rounds,
            most_changes: changes.len(),
            longest: self.path(*first, changes),
            cycles: cycles
                .map(|cycle| CycleReport {
                    rounds: cycle.rounds,
                    assignments: self.path(cycle.first, &cycle.changes),
                    basin: cycle.basin,
                })
                .collect(),
        }
    }

    /// The game in Gambit's format.
    fn nfg(&self, payoff: PayoffKind, made: &Provenance) -> String {
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
        nfg_text(&self.line.game, &title, &comment)
    }

    fn equilibria(&self) -> Vec<EquilibriumReport> {
        let found = self.equilibria.iter();
        found.map(|found| self.equilibrium(found)).collect()
    }

    fn equilibrium(&self, equilibrium: &Equilibrium) -> EquilibriumReport {
        let (game, profile) = (&self.line.game, equilibrium.profile);
        let mut deviations = Vec::new();
        for (i, player) in game.players().iter().enumerate() {
            let current = game.action(profile, i);
            let groups = equivalent(game, i);
            let others = (0..game.actions(i)).filter(|&a| a != current);
            deviations.extend(others.map(|action| {
                let interval = self.line.gain_interval(profile, i, action);
                DeviationReport {
                    robot: player.name.clone(),
                    rule: player.actions[action].clone(),
                    equivalent: groups
                        .iter()
                        .any(|g| g.contains(&action) && g.contains(&current)),
                    gain: game.payoff(game.with(profile, i, action), i) - game.payoff(profile, i),
                    gain_interval: interval,
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
                let loses =
                    |d: &&DeviationReport| d.gain_interval.is_some_and(|gain| gain.high < 0.0);
                deviations.iter().filter(loses).count()
            }),
            basin: self.played.basin(profile),
            deviations,
        }
    }

    fn robots(&self) -> Vec<RobotRulesReport> {
        let game = &self.line.game;
        let dominated = dominance(game);
        let of = |i: usize| {
            let player = &game.players()[i];
            let names = |actions: Vec<usize>| -> Vec<String> {
                let name = |a: usize| player.actions[a].clone();
                actions.into_iter().map(name).collect()
            };
            RobotRulesReport {
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
