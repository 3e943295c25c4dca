//! The report of a solved game.

use super::nfg::nfg_text;
use super::report::{
    CycleReport, DeviationReport, DominatedReport, EquilibriumReport, GameReport, PlayReport,
    ProfileReport, RobotRulesReport, SocialOptimum,
};
use crate::provenance::Provenance;
use pickline::optimize::game::{
    Deviation, End, Equilibrium, LineGame, Payoff, PayoffKind, Price, dominance, dominant,
    equilibria, equivalent, optimum, play, prices,
};

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
            basin,
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
