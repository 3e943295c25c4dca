//! What `pickline bound` is given.

use super::{Common, ConditionArgs, StationChoice};
use clap::{Args, ValueEnum};

/// Bound what any strategy can pick from a pattern, waiting and clairvoyance included
///
/// Cuts time into slots, prices items and finds every robot's best day for itself; what
/// that adds up to no strategy can exceed, whatever the prices and however few steps.
/// Also bounds the rate and the end of a run, and looks for a schedule that comes near.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline bound
  pickline bound --pattern items.csv --objective weight --slot 0.02
  pickline bound --camera-x 0.5 --grasp-success 0.9
  pickline pattern generate grid --count 150 | pickline bound --pattern - --format json")]
pub struct BoundArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    /// Pattern file (CSV), `-` for stdin; the grid of 0.15 m with 50 items when not given
    #[arg(long, value_name = "FILE")]
    pub pattern: Option<String>,
    /// What is bounded
    #[arg(long, value_enum, default_value_t = ObjectiveArg::Picks, help_heading = "Bound")]
    pub objective: ObjectiveArg,
    /// Length of the slots [s]; shorter is tighter and slower [default: about a fiftieth
    /// of a pick]
    #[arg(
        long,
        value_name = "SECONDS",
        allow_negative_numbers = true,
        help_heading = "Bound"
    )]
    pub slot: Option<f64>,
    /// Most steps of the prices; rate and end take as many again
    #[arg(
        long,
        value_name = "N",
        default_value_t = 200,
        allow_negative_numbers = true,
        help_heading = "Bound"
    )]
    pub iterations: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ObjectiveArg {
    /// Items picked
    Picks,
    /// The sum of their weights
    Weight,
}
