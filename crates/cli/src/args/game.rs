//! The arguments of `pickline game`.

use super::conditions::ConditionArgs;
use super::shared::{Common, PatternSetArgs, StationChoice};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Solve the line as a game: robots are the players, rules are their actions
///
/// For a line of up to four robots, finds all pure Nash equilibria, the social optimum, the
/// prices of anarchy and of stability, where iterated best response ends from every start,
/// and the dominated rules. `--nfg` writes the game for Gambit.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline game --robots 3 --payoff total
  pickline game --station my-line.toml --patterns recorded/ --out game/
  pickline game --grasp-success 0.9
  pickline game --format csv --nfg line.nfg")]
pub(crate) struct GameArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    #[command(flatten)]
    pub set: PatternSetArgs,
    /// The payoff of each robot
    #[arg(long, value_enum, default_value_t = PayoffArg::Own, help_heading = "Game")]
    pub payoff: PayoffArg,
    /// Write the game to this file in Gambit's strategic game format; `-` prints it instead
    /// of the result
    #[arg(long, value_name = "FILE", help_heading = "Game")]
    pub nfg: Option<PathBuf>,
    /// Number of equilibria and cycles to print in the table
    #[arg(
        long,
        value_name = "N",
        default_value_t = 10,
        allow_negative_numbers = true
    )]
    pub top: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PayoffArg {
    /// Its own picks per minute
    Own,
    /// The line's picks per minute
    Total,
}
