//! Finite games in normal form, with any number of players and actions.

use super::payoff::Payoff;
use crate::error::{Error, Result};

/// One player and its actions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Player {
    /// The player's name: a robot's name.
    pub name: String,
    /// The names of its actions: names of rules.
    pub actions: Vec<String>,
}

/// A game in normal form. Profiles (one action per player) are numbered with the first player's
/// action varying slowest, in the order of
/// [`RuleAssignment::all`](crate::dispatch::RuleAssignment::all).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Game {
    players: Vec<Player>,
    /// Distance between two profiles that differ by one in a player's action.
    strides: Vec<usize>,
    /// Payoffs profile by profile, one per player.
    payoffs: Vec<Payoff>,
    /// The welfare of each profile.
    welfare: Vec<Payoff>,
}

impl Game {
    /// A game with `payoffs` profile by profile, one per player, and the welfare of each
    /// profile.
    ///
    /// # Errors
    /// A player without actions, or a wrong number of payoffs or welfares.
    pub fn new(players: Vec<Player>, payoffs: Vec<Payoff>, welfare: Vec<Payoff>) -> Result<Self> {
        let mut strides = vec![1usize; players.len()];
        for i in (1..players.len()).rev() {
            strides[i - 1] = strides[i].saturating_mul(players[i].actions.len());
        }
        let profiles = players
            .iter()
            .fold(1usize, |n, player| n.saturating_mul(player.actions.len()));
        let right = profiles > 0
            && welfare.len() == profiles
            && payoffs.len() == profiles.saturating_mul(players.len());
        if !right {
            return Err(Error::input(
                "game",
                format!(
                    "{} payoffs and {} welfares for {} players and {profiles} profiles",
                    payoffs.len(),
                    welfare.len(),
                    players.len()
                ),
                "give every player an action, every profile one welfare and one payoff per player",
            ));
        }
        Ok(Self {
            players,
            strides,
            payoffs,
            welfare,
        })
    }

    /// A game whose welfare is the sum of the players' payoffs.
    ///
    /// # Errors
    /// As for [`Game::new`].
    pub fn of_payoffs(players: Vec<Player>, payoffs: Vec<Payoff>) -> Result<Self> {
        let welfare = payoffs
            .chunks(players.len().max(1))
            .map(|profile| profile.iter().copied().sum())
            .collect();
        Self::new(players, payoffs, welfare)
    }

    /// The players, in the order of their numbers.
    pub fn players(&self) -> &[Player] {
        &self.players
    }

    /// Number of profiles: one action of each player.
    pub fn profiles(&self) -> usize {
        self.welfare.len()
    }

    /// Every player's payoff in `profile`.
    pub fn payoffs(&self, profile: usize) -> &[Payoff] {
        let n = self.players.len();
        &self.payoffs[profile * n..(profile + 1) * n]
    }

    /// The payoff of `player` in `profile`.
    pub fn payoff(&self, profile: usize, player: usize) -> Payoff {
        self.payoffs[profile * self.players.len() + player]
    }

    /// What `profile` is worth to all players together: the sum of their payoffs, unless the game
    /// was made with another welfare.
    pub fn welfare(&self, profile: usize) -> Payoff {
        self.welfare[profile]
    }

    /// Number of actions of `player`.
    pub fn actions(&self, player: usize) -> usize {
        self.players[player].actions.len()
    }

    /// The action of `player` in `profile`.
    pub fn action(&self, profile: usize, player: usize) -> usize {
        profile / self.strides[player] % self.actions(player)
    }

    /// `profile` with `player` doing `action` instead.
    pub fn with(&self, profile: usize, player: usize, action: usize) -> usize {
        let stride = self.strides[player];
        profile - self.action(profile, player) * stride + action * stride
    }

    /// The names of the actions of `profile`, one per player.
    pub fn names(&self, profile: usize) -> Vec<&str> {
        (0..self.players.len())
            .map(|player| self.players[player].actions[self.action(profile, player)].as_str())
            .collect()
    }

    /// The highest payoff that `player` can get against the others' actions in `profile`.
    pub(crate) fn best_payoff(&self, profile: usize, player: usize) -> Payoff {
        let own = self.payoff(profile, player);
        (0..self.actions(player))
            .map(|action| self.payoff(self.with(profile, player, action), player))
            .fold(own, Ord::max)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A game of two players from a table of (row's payoff, column's payoff).
    pub(crate) fn two_players(table: &[&[(i32, i32)]]) -> Game {
        let player = |name: &str, count: usize| Player {
            name: name.into(),
            actions: (1..=count).map(|i| format!("{name}{i}")).collect(),
        };
        let players = vec![player("row", table.len()), player("column", table[0].len())];
        let cells = table.iter().flat_map(|row| row.iter());
        let payoffs = cells.flat_map(|&(a, b)| [Payoff::whole(a), Payoff::whole(b)]);
        Game::of_payoffs(players, payoffs.collect()).unwrap()
    }

    /// Both confess: 5 years each; both stay silent: 1 year each. Payoffs are years of freedom
    /// out of ten.
    pub(crate) fn prisoners_dilemma() -> Game {
        two_players(&[&[(9, 9), (0, 10)], &[(10, 0), (5, 5)]])
    }

    pub(crate) fn matching_pennies() -> Game {
        two_players(&[&[(1, -1), (-1, 1)], &[(-1, 1), (1, -1)]])
    }

    /// Two equilibria, one twice as good; miscoordination is worth nothing.
    pub(crate) fn coordination() -> Game {
        two_players(&[&[(2, 2), (0, 0)], &[(0, 0), (1, 1)]])
    }

    #[test]
    fn profiles_are_numbered_as_assignments_are() {
        let game = two_players(&[&[(1, 2), (3, 4), (5, 6)], &[(7, 8), (9, 10), (11, 12)]]);
        assert_eq!(game.profiles(), 6);
        assert_eq!(game.names(2), ["row1", "column3"]);
        assert_eq!(game.with(2, 0, 1), 5);
        assert_eq!(game.with(5, 1, 0), 3);
        assert_eq!(game.payoffs(4), [Payoff::whole(9), Payoff::whole(10)]);
        assert_eq!(game.welfare(4), Payoff::whole(19));
        assert_eq!(game.best_payoff(0, 1), Payoff::whole(6));
    }

    #[test]
    fn tables_of_the_wrong_size_are_refused() {
        let player = |count| Player {
            name: "a".into(),
            actions: vec!["x".into(); count],
        };
        let zeros = |count| vec![Payoff::default(); count];
        assert!(Game::new(vec![player(2)], zeros(2), zeros(2)).is_ok());
        for (actions, payoffs, welfares) in [(2, 3, 2), (2, 2, 1), (0, 0, 0)] {
            let made = Game::new(vec![player(actions)], zeros(payoffs), zeros(welfares));
            let message = made.unwrap_err().to_string();
            let problem = format!("{payoffs} payoffs and {welfares} welfares for 1 players");
            assert!(message.contains(&problem), "{message}");
        }
        assert!(Game::of_payoffs(vec![player(2), player(3)], zeros(12)).is_ok());
    }
}
