//! Iterated best response: players take turns to change to their currently best action.
//!
//! The first player moves first, and each player moves once per round. A player that already
//! has a best action keeps it; otherwise it takes the first of the best actions. A round is
//! therefore a function of the profile alone, its fixed points are exactly the pure equilibria,
//! and play from any start ends in an equilibrium or cycles forever. If all players have the
//! same payoff (a potential game, Monderer and Shapley 1996, DOI 10.1006/game.1996.0044), there
//! are no cycles.

use super::normal_form::Game;

/// A player changed its action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Deviation {
    /// Number of the player that deviates, from 0.
    pub player: usize,
    /// The profile after the change.
    pub profile: usize,
}

/// Where play ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// In the equilibrium with this profile number.
    Equilibrium(usize),
    /// In the cycle at this index of [`Play::cycles`].
    Cycle(usize),
}

/// Profiles that play cycles through forever.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Cycle {
    /// The profile at the beginning of a round; of all such profiles, the one with the lowest
    /// number.
    pub first: usize,
    /// Rounds until that profile is reached again, at least 2.
    pub rounds: usize,
    /// All changes of action in the cycle.
    pub changes: Vec<Deviation>,
    /// Number of starts from which play ends here.
    pub basin: usize,
}

/// Best response play from every start.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Play {
    /// For each profile, where play from it ends.
    pub ends: Vec<End>,
    /// The cycles, ordered by their first profiles.
    pub cycles: Vec<Cycle>,
    /// The start with the most changes of action before its end, and those changes.
    pub longest: (usize, Vec<Deviation>),
    /// The most rounds with a change before any start reaches its end.
    pub most_rounds: usize,
}

impl Play {
    /// Number of starts from which play ends in the equilibrium `profile`.
    pub fn basin(&self, profile: usize) -> usize {
        let here = |end: &&End| **end == End::Equilibrium(profile);
        self.ends.iter().filter(here).count()
    }

    /// Number of starts from which play ends in an equilibrium.
    pub fn to_equilibrium(&self) -> usize {
        let any = |end: &&End| matches!(end, End::Equilibrium(_));
        self.ends.iter().filter(any).count()
    }
}

/// Plays one round from `profile`.
fn round(game: &Game, mut profile: usize, changes: &mut Vec<Deviation>) -> usize {
    for player in 0..game.players().len() {
        let best = game.best_payoff(profile, player);
        if game.payoff(profile, player) == best {
            continue;
        }
        let reply = (0..game.actions(player))
            .map(|action| game.with(profile, player, action))
            .find(|&reply| game.payoff(reply, player) == best);
        if let Some(reply) = reply {
            profile = reply;
            changes.push(Deviation { player, profile });
        }
    }
    profile
}

/// Plays best responses from every profile of `game`.
pub fn play(game: &Game) -> Play {
    let count = game.profiles();
    let next: Vec<usize> = (0..count)
        .map(|p| round(game, p, &mut Vec::new()))
        .collect();
    let mut ends: Vec<Option<End>> = vec![None; count];
    let mut cycles: Vec<Cycle> = Vec::new();
    // The walk that last visited each profile, so that a walk recognises its own steps.
    let mut met = vec![usize::MAX; count];
    for start in 0..count {
        let mut walk = Vec::new();
        let mut at = start;
        while ends[at].is_none() && met[at] != start {
            met[at] = start;
            walk.push(at);
            at = next[at];
        }
        let end = ends[at].unwrap_or_else(|| {
            if next[at] == at {
                return End::Equilibrium(at);
            }
            cycles.push(cycle(game, &next, at));
            End::Cycle(cycles.len() - 1)
        });
        for profile in walk {
            ends[profile] = Some(end);
        }
    }
    let ends = order_cycles(&mut cycles, ends);
    let (longest, most_rounds) = longest(game, &next, &ends, &cycles);
    Play {
        ends,
        cycles,
        longest,
        most_rounds,
    }
}

/// The cycle that contains `on`.
fn cycle(game: &Game, next: &[usize], on: usize) -> Cycle {
    let mut first = on;
    let mut at = next[on];
    while at != on {
        first = first.min(at);
        at = next[at];
    }
    let (mut changes, mut rounds) = (Vec::new(), 0);
    at = first;
    loop {
        at = round(game, at, &mut changes);
        rounds += 1;
        if at == first {
            break;
        }
    }
    Cycle {
        first,
        rounds,
        changes,
        basin: 0,
    }
}

/// Sorts the cycles by their first profiles, counts their basins, and returns the ends with the
/// cycles' new indices.
fn order_cycles(cycles: &mut [Cycle], ends: Vec<Option<End>>) -> Vec<End> {
    let mut order: Vec<usize> = (0..cycles.len()).collect();
    order.sort_by_key(|&place| cycles[place].first);
    let ends: Vec<End> = ends
        .into_iter()
        .flatten()
        .map(|end| match end {
            End::Cycle(old) => End::Cycle(order.iter().position(|&o| o == old).unwrap_or(old)),
            other => other,
        })
        .collect();
    cycles.sort_by_key(|cycle| cycle.first);
    for end in &ends {
        if let End::Cycle(place) = end {
            cycles[*place].basin += 1;
        }
    }
    ends
}

/// The start with the most changes before its end, those changes, and the most rounds with a
/// change.
fn longest(
    game: &Game,
    next: &[usize],
    ends: &[End],
    cycles: &[Cycle],
) -> ((usize, Vec<Deviation>), usize) {
    let mut is_end = vec![false; ends.len()];
    for (profile, end) in ends.iter().enumerate() {
        is_end[profile] = *end == End::Equilibrium(profile);
    }
    for cycle in cycles {
        let mut at = cycle.first;
        for _ in 0..cycle.rounds {
            is_end[at] = true;
            at = next[at];
        }
    }
    let mut best = (0, Vec::new());
    let mut most_rounds = 0;
    for start in 0..ends.len() {
        let (mut at, mut rounds, mut changes) = (start, 0, Vec::new());
        while !is_end[at] {
            at = round(game, at, &mut changes);
            rounds += 1;
        }
        most_rounds = most_rounds.max(rounds);
        if changes.len() > best.1.len() {
            best = (start, changes);
        }
    }
    (best, most_rounds)
}

#[cfg(test)]
mod tests {
    use super::super::equilibrium::equilibria;
    use super::super::normal_form::tests::*;
    use super::super::normal_form::{Game, Player};
    use super::super::payoff::Payoff;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_prisoners_confess_from_every_start() {
        let play = play(&prisoners_dilemma());
        assert_eq!(play.ends, [End::Equilibrium(3); 4]);
        assert_eq!((play.basin(3), play.to_equilibrium()), (4, 4));
        assert!(play.cycles.is_empty());
        let change = |player, profile| Deviation { player, profile };
        assert_eq!(play.longest, (0, vec![change(0, 2), change(1, 3)]));
        assert_eq!(play.most_rounds, 1);
    }

    #[test]
    fn best_responses_cycle_in_matching_pennies() {
        let play = play(&matching_pennies());
        assert_eq!(play.ends, [End::Cycle(0); 4]);
        assert_eq!(play.to_equilibrium(), 0);
        let [cycle] = &play.cycles[..] else {
            panic!("{play:?}")
        };
        // Heads-heads: column turns, then row, and so on: four changes in two rounds and back;
        // these rounds begin at (1, 2) and (2, 1) only.
        assert_eq!(cycle.basin, 4);
        assert_eq!(cycle.changes.len(), 4);
        let last = cycle.changes.last().unwrap();
        assert_eq!(last.profile, cycle.first);
    }

    #[test]
    fn coordination_ends_where_the_second_player_began() {
        let play = play(&coordination());
        let ends: Vec<End> = [0, 3, 0, 3].map(End::Equilibrium).to_vec();
        assert_eq!(play.ends, ends);
        assert_eq!((play.basin(0), play.basin(3)), (2, 2));
    }

    fn games(common: bool) -> impl Strategy<Value = Game> {
        prop::collection::vec(1usize..=4, 1..=4).prop_flat_map(move |sizes| {
            let players: Vec<Player> = sizes
                .iter()
                .map(|&size| Player {
                    name: "p".into(),
                    actions: (0..size).map(|i| i.to_string()).collect(),
                })
                .collect();
            let (n, profiles) = (sizes.len(), sizes.iter().product::<usize>());
            let values = prop::collection::vec(0..6i32, profiles * n);
            values.prop_map(move |values| {
                let value = |i: usize| Payoff::whole(values[if common { i / n } else { i }]);
                let payoffs = (0..values.len()).map(value).collect();
                Game::of_payoffs(players.clone(), payoffs).unwrap()
            })
        })
    }

    proptest! {
        /// A profile is an equilibrium exactly if no change by one player improves it; play
        /// that ends without a cycle ends there.
        #[test]
        fn play_ends_in_equilibria_or_cycles(game in games(false)) {
            let found = equilibria(&game);
            let play = play(&game);
            prop_assert_eq!(play.ends.len(), game.profiles());
            for profile in 0..game.profiles() {
                let stable = (0..game.players().len())
                    .all(|i| game.payoff(profile, i) == game.best_payoff(profile, i));
                prop_assert_eq!(found.iter().any(|e| e.profile == profile), stable);
                prop_assert_eq!(play.basin(profile) > 0, stable);
            }
            let cycled: usize = play.cycles.iter().map(|c| c.basin).sum();
            prop_assert_eq!(cycled + play.to_equilibrium(), game.profiles());
            for cycle in &play.cycles {
                prop_assert!(cycle.rounds >= 2 && cycle.changes.len() >= cycle.rounds);
                prop_assert_eq!(cycle.changes.last().unwrap().profile, cycle.first);
                // Each round leads on, and the first return is to the start, with no lower
                // profile on the way.
                let (mut at, mut changes) = (cycle.first, Vec::new());
                for passed in 1..=cycle.rounds {
                    at = round(&game, at, &mut changes);
                    prop_assert_eq!(at == cycle.first, passed == cycle.rounds);
                    prop_assert!(at >= cycle.first);
                }
                prop_assert_eq!(&changes, &cycle.changes);
            }
        }

        /// A game of common interest is a potential game, so play never cycles.
        #[test]
        fn common_interest_never_cycles(game in games(true)) {
            let play = play(&game);
            prop_assert!(play.cycles.is_empty());
            prop_assert!(!equilibria(&game).is_empty());
        }
    }
}
