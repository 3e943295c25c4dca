//! Pure Nash equilibria, the social optimum, and the price of selfishness.
//!
//! Equilibrium: Nash 1950, DOI 10.1073/pnas.36.1.48. Price of anarchy: Koutsoupias and
//! Papadimitriou 1999, DOI 10.1007/3-540-49116-3_38. Price of stability: Anshelevich
//! et al. 2008, DOI 10.1137/070680096.

use super::dominance::classes;
use super::normal_form::Game;
use super::payoff::Payoff;

/// A profile from which no player gains by changing its action alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Equilibrium {
    /// Number of the profile, as [`Game::action`](super::Game::action) takes it.
    pub profile: usize,
    /// The smallest loss of any player by any change of its own action [1/min]; `None` if no
    /// player has a second action.
    pub margin: Option<Payoff>,
    /// The same over changes to actions that are not [equivalent](super::equivalent) to the
    /// player's own. Equivalent actions make any equilibrium weak and say nothing about it.
    pub margin_to_others: Option<Payoff>,
}

impl Equilibrium {
    /// Whether every change of one action is a loss. In a weak equilibrium, some player could
    /// change and get the same.
    pub fn is_strict(&self) -> bool {
        self.margin.is_none_or(|margin| margin > Payoff::default())
    }
}

/// The profiles with the highest welfare.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct WelfareOptimum {
    /// The highest welfare of any profile [1/min].
    pub welfare: Payoff,
    /// Numbers of the profiles that have it, in ascending order.
    pub profiles: Vec<usize>,
}

/// Welfare of the social optimum divided by that of an equilibrium.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Price {
    /// How many times the welfare of the equilibrium the optimum has, at least 1.
    Ratio(f64),
    /// The equilibrium's welfare is 0 but the optimum's is not.
    Unbounded,
    /// There is no pure equilibrium.
    NoEquilibrium,
}

impl Price {
    fn of(optimum: Payoff, equilibrium: Option<Payoff>) -> Self {
        let Some(equilibrium) = equilibrium else {
            return Self::NoEquilibrium;
        };
        if equilibrium == optimum {
            // Also if both are 0: nothing is lost then.
            Self::Ratio(1.0)
        } else if equilibrium > Payoff::default() {
            Self::Ratio(optimum.value() / equilibrium.value())
        } else {
            Self::Unbounded
        }
    }

    /// The ratio, if there is one.
    pub fn ratio(self) -> Option<f64> {
        match self {
            Self::Ratio(ratio) => Some(ratio),
            Self::Unbounded | Self::NoEquilibrium => None,
        }
    }
}

/// All pure Nash equilibria, highest welfare first, then in order of profiles.
pub fn equilibria(game: &Game) -> Vec<Equilibrium> {
    let classes: Vec<Vec<usize>> = (0..game.players().len())
        .map(|player| classes(game, player))
        .collect();
    let mut found: Vec<Equilibrium> = (0..game.profiles())
        .filter_map(|profile| at(game, profile, &classes))
        .collect();
    // The sort is stable, so ties stay in order of profiles.
    found.sort_by_key(|equilibrium| -game.welfare(equilibrium.profile));
    found
}

/// `profile` as an equilibrium, if it is one; `classes` groups equivalent actions.
fn at(game: &Game, profile: usize, classes: &[Vec<usize>]) -> Option<Equilibrium> {
    let least = |margin: &mut Option<Payoff>, loss: Payoff| {
        *margin = Some(margin.map_or(loss, |least| least.min(loss)));
    };
    let (mut margin, mut margin_to_others) = (None, None);
    for (player, class) in classes.iter().enumerate() {
        let own = game.payoff(profile, player);
        let current = game.action(profile, player);
        for action in 0..game.actions(player) {
            if action == current {
                continue;
            }
            let loss = own - game.payoff(game.with(profile, player, action), player);
            if loss < Payoff::default() {
                return None;
            }
            least(&mut margin, loss);
            if class[action] != class[current] {
                least(&mut margin_to_others, loss);
            }
        }
    }
    Some(Equilibrium {
        profile,
        margin,
        margin_to_others,
    })
}

/// The profiles with the highest welfare.
pub fn optimum(game: &Game) -> WelfareOptimum {
    let all = 0..game.profiles();
    // Every game has at least one profile.
    let welfare = all
        .clone()
        .map(|p| game.welfare(p))
        .max()
        .unwrap_or_default();
    WelfareOptimum {
        welfare,
        profiles: all.filter(|&p| game.welfare(p) == welfare).collect(),
    }
}

/// Price of anarchy (worst of `equilibria`) and price of stability (best of `equilibria`).
pub fn prices(game: &Game, optimum: &WelfareOptimum, equilibria: &[Equilibrium]) -> (Price, Price) {
    let welfares = || equilibria.iter().map(|e| game.welfare(e.profile));
    (
        Price::of(optimum.welfare, welfares().min()),
        Price::of(optimum.welfare, welfares().max()),
    )
}

#[cfg(test)]
mod tests {
    use super::super::normal_form::tests::*;
    use super::*;

    fn solved(game: &Game) -> (Vec<Equilibrium>, WelfareOptimum, Price, Price) {
        let (found, best) = (equilibria(game), optimum(game));
        let (anarchy, stability) = prices(game, &best, &found);
        (found, best, anarchy, stability)
    }

    #[test]
    fn in_the_prisoners_dilemma_both_confess() {
        let (found, best, anarchy, stability) = solved(&prisoners_dilemma());
        assert_eq!(found.len(), 1);
        assert_eq!((found[0].profile, found[0].is_strict()), (3, true));
        assert_eq!(found[0].margin, Some(Payoff::whole(5)));
        assert_eq!((best.profiles, best.welfare), (vec![0], Payoff::whole(18)));
        assert_eq!(anarchy, Price::Ratio(1.8));
        assert_eq!(stability, Price::Ratio(1.8));
    }

    #[test]
    fn matching_pennies_has_no_pure_equilibrium() {
        let (found, best, anarchy, stability) = solved(&matching_pennies());
        assert!(found.is_empty());
        assert_eq!(best.profiles.len(), 4);
        assert_eq!(
            (anarchy, stability),
            (Price::NoEquilibrium, Price::NoEquilibrium)
        );
        assert_eq!(anarchy.ratio(), None);
    }

    #[test]
    fn coordination_has_a_good_and_a_bad_equilibrium() {
        let (found, best, anarchy, stability) = solved(&coordination());
        let profiles: Vec<usize> = found.iter().map(|e| e.profile).collect();
        assert_eq!(profiles, [0, 3]);
        assert!(found.iter().all(Equilibrium::is_strict));
        assert_eq!(best.profiles, [0]);
        assert_eq!((anarchy, stability), (Price::Ratio(2.0), Price::Ratio(1.0)));
    }

    #[test]
    fn the_better_equilibrium_comes_first() {
        let (found, best, anarchy, stability) =
            solved(&two_players(&[&[(1, 1), (0, 0)], &[(0, 0), (2, 2)]]));
        let profiles: Vec<usize> = found.iter().map(|e| e.profile).collect();
        assert_eq!((profiles, best.profiles), (vec![3, 0], vec![3]));
        assert_eq!((anarchy.ratio(), stability.ratio()), (Some(2.0), Some(1.0)));
    }

    #[test]
    fn ties_make_equilibria_weak() {
        let game = two_players(&[&[(1, 1), (1, 1)], &[(0, 0), (1, 0)]]);
        let (found, ..) = solved(&game);
        let strict: Vec<(usize, bool)> = found.iter().map(|e| (e.profile, e.is_strict())).collect();
        assert_eq!(strict, [(0, false), (1, false), (3, false)]);
    }

    #[test]
    fn duplicates_of_an_action_are_distinguished_from_ties() {
        // Rows 1 and 2 are equal; row 3 is worse by 2.
        let game = two_players(&[&[(5, 0)], &[(5, 0)], &[(3, 0)]]);
        let (found, ..) = solved(&game);
        assert_eq!(found.len(), 2);
        assert!(!found[0].is_strict());
        assert_eq!(found[0].margin, Some(Payoff::whole(0)));
        assert_eq!(found[0].margin_to_others, Some(Payoff::whole(2)));
    }

    #[test]
    fn an_equilibrium_worth_nothing_has_no_finite_price() {
        let (_, _, anarchy, stability) =
            solved(&two_players(&[&[(2, 2), (0, 0)], &[(0, 0), (0, 0)]]));
        assert_eq!((anarchy, stability), (Price::Unbounded, Price::Ratio(1.0)));
        let (found, _, anarchy, _) = solved(&two_players(&[&[(0, 0)]]));
        assert!(found[0].is_strict() && found[0].margin.is_none());
        assert_eq!(anarchy, Price::Ratio(1.0));
    }
}
