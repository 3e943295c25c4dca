//! A line of robots as a normal-form game: players are robots, actions are rules.
//!
//! The non-cooperative view of Bozma and Kalalioglu, "Multirobot coordination in
//! pick-and-place tasks on a moving conveyor", Robotics and Computer-Integrated
//! Manufacturing 28, 2012, DOI 10.1016/j.rcim.2011.12.001. `docs/game.md` has the
//! formulas.

mod dominance;
mod equilibrium;
mod line;
mod normal_form;
mod payoff;
mod response;

pub use dominance::{Dominance, dominance, dominant, equivalent};
pub use equilibrium::{Equilibrium, Price, WelfareOptimum, equilibria, optimum, prices};
pub use line::{LineGame, MOST_ROBOTS, PayoffKind, check_size};
pub use normal_form::{Game, Player};
pub use payoff::Payoff;
pub use response::{Cycle, Deviation, End, Play, play};
