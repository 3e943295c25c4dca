//! Actions that a player never needs to choose, whatever the others do.

use super::normal_form::Game;
use std::cmp::Ordering;

/// An action is dominated by another pure action of the same player.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Dominance {
    /// Number of the player, from 0.
    pub player: usize,
    /// Number of its dominated action, from 0.
    pub action: usize,
    /// The first action that dominates it; strictly dominating actions come first.
    pub by: usize,
    /// Whether it is always better; otherwise it is never worse and sometimes better.
    pub strict: bool,
}

/// How one action compares with another over everything that the others may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Relation {
    /// Better against every choice of the others.
    Above,
    /// Never worse, sometimes better.
    AtLeast,
    /// Equally good against every choice of the others.
    Equal,
    /// Worse against some choice of the others.
    Other,
}

fn relation(game: &Game, player: usize, a: usize, b: usize) -> Relation {
    let (mut better, mut equal) = (false, false);
    // Each choice of the others occurs once, with the player doing `a`.
    for profile in (0..game.profiles()).filter(|&p| game.action(p, player) == a) {
        let other = game.with(profile, player, b);
        match game
            .payoff(profile, player)
            .cmp(&game.payoff(other, player))
        {
            Ordering::Greater => better = true,
            Ordering::Equal => equal = true,
            Ordering::Less => return Relation::Other,
        }
    }
    match (better, equal) {
        (true, false) => Relation::Above,
        (true, true) => Relation::AtLeast,
        (false, _) => Relation::Equal,
    }
}

/// All dominated actions, player by player. Domination by mixed strategies is not considered.
pub fn dominance(game: &Game) -> Vec<Dominance> {
    let mut found = Vec::new();
    for player in 0..game.players().len() {
        for action in 0..game.actions(player) {
            let by = |wanted: Relation| {
                (0..game.actions(player)).find(|&b| relation(game, player, b, action) == wanted)
            };
            let strictly = by(Relation::Above);
            if let Some(by) = strictly.or_else(|| by(Relation::AtLeast)) {
                found.push(Dominance {
                    player,
                    action,
                    by,
                    strict: strictly.is_some(),
                });
            }
        }
    }
    found
}

/// For every action of `player`, the first action that is equivalent to it.
pub(super) fn classes(game: &Game, player: usize) -> Vec<usize> {
    let same = |a: usize, b: usize| relation(game, player, a, b) == Relation::Equal;
    (0..game.actions(player))
        .map(|action| (0..action).find(|&a| same(a, action)).unwrap_or(action))
        .collect()
}

/// Groups of two or more actions of `player` that always give it the same payoff, whatever the
/// others do.
pub fn equivalent(game: &Game, player: usize) -> Vec<Vec<usize>> {
    let classes = classes(game, player);
    let group = |first: usize| -> Vec<usize> {
        let members = (0..classes.len()).filter(|&a| classes[a] == first);
        members.collect()
    };
    let groups = (0..classes.len()).map(group);
    groups.filter(|group| group.len() > 1).collect()
}

/// The dominant actions of `player`: never worse than any other, whatever the others do.
pub fn dominant(game: &Game, player: usize) -> Vec<usize> {
    let actions = 0..game.actions(player);
    actions
        .clone()
        .filter(|&a| {
            actions
                .clone()
                .all(|b| relation(game, player, a, b) != Relation::Other)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::normal_form::tests::*;
    use super::*;

    #[test]
    fn silence_is_strictly_dominated() {
        let game = prisoners_dilemma();
        let strictly = |player| Dominance {
            player,
            action: 0,
            by: 1,
            strict: true,
        };
        assert_eq!(dominance(&game), [strictly(0), strictly(1)]);
        assert_eq!(dominant(&game, 0), [1]);
        assert!(equivalent(&game, 0).is_empty());
        assert!(dominance(&matching_pennies()).is_empty());
        assert!(dominant(&coordination(), 1).is_empty());
    }

    #[test]
    fn weak_dominance_and_duplicates_are_distinguished() {
        // Row 2 equals row 1; row 3 is never better and once worse.
        let game = two_players(&[&[(1, 0), (2, 0)], &[(1, 0), (2, 0)], &[(1, 0), (1, 0)]]);
        assert_eq!(equivalent(&game, 0), [vec![0, 1]]);
        assert_eq!(equivalent(&game, 1), [vec![0, 1]]);
        let weakly = Dominance {
            player: 0,
            action: 2,
            by: 0,
            strict: false,
        };
        assert_eq!(dominance(&game), [weakly]);
        assert_eq!(dominant(&game, 0), [0, 1]);
    }
}
