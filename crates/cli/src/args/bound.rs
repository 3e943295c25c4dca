//! The arguments of `pickline bound`.

use super::conditions::ConditionArgs;
use super::shared::{Common, StationChoice};
use clap::{Args, ValueEnum};

/// Bound what any strategy can pick from a pattern, even one that knows the future
///
/// Divides time into slots, puts a price on each item and finds the best schedule of each
/// robot by itself. No strategy can exceed their sum, whatever the prices and however few
/// the iterations. Also bounds the rate and the end of a run, and looks for a schedule that
/// comes close.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline bound
  pickline bound --pattern items.csv --objective weight --slot 0.02
  pickline bound --camera-x 0.5 --grasp-success 0.9
  pickline pattern generate grid --count 150 | pickline bound --pattern - --format json")]
pub(crate) struct BoundArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    /// Pattern file (CSV), or `-` for stdin [default: a 0.15 m grid of 50 items]
    #[arg(long, value_name = "FILE")]
    pub pattern: Option<String>,
    /// What to bound
    #[arg(long, value_enum, default_value_t = ObjectiveArg::Picks, help_heading = "Bound")]
    pub objective: ObjectiveArg,
    /// Length of the time slots [s]; shorter is tighter but slower [default: about a
    /// fiftieth of a pick]
    #[arg(
        long,
        value_name = "SECONDS",
        allow_negative_numbers = true,
        help_heading = "Bound"
    )]
    pub slot: Option<f64>,
    /// Maximum number of price updates; the rate and the end take as many again
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
pub(crate) enum ObjectiveArg {
    /// The number of items picked
    Picks,
    /// The sum of the picked items' weights
    Weight,
}
