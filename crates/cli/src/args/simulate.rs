//! The arguments of `pickline simulate`.

use super::conditions::{ConditionArgs, DetectionArgs};
use super::shared::{Common, StationChoice, strategy_help};
use clap::Args;
use std::path::PathBuf;

/// Run one strategy on one pattern, exactly
///
/// Jumps from decision to decision; there is no time step. Prints the throughput (picks per
/// minute in the steady state) if the pattern is long enough to reach one. Gives the reason
/// for every item that was not picked: unreachable, grasp_failed, passed_over, unseen or busy.
#[derive(Debug, Args)]
#[command(after_long_help = simulate_help())]
pub(crate) struct SimulateArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    #[command(flatten)]
    pub detections: DetectionArgs,
    /// Pattern file (CSV), or `-` for stdin [default: a 0.15 m grid of 50 items]
    #[arg(long, value_name = "FILE")]
    pub pattern: Option<String>,
    #[arg(long, value_name = "STRATEGY", help = strategy_help(
        "Strategy, as listed below",
        " [default: FIFO for the last robot, SPT for all others]",
    ))]
    pub strategy: Option<String>,
    /// Time per decision for a strategy that looks ahead [ms], instead of a number of
    /// simulated decisions; the result then depends on the machine
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub budget_ms: Option<f64>,
    /// Verify the run with the independent checker, with exit code 1 if the check fails, and
    /// report the smallest distance between two arms (collisions are not avoided)
    #[arg(long)]
    pub check: bool,
    /// Do not bound how far the run is from the best that any strategy can do
    #[arg(long)]
    pub no_bound: bool,
    /// Write every event of the run to this CSV file
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Write a replay of the run to this HTML file, which opens in any browser
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// Help text listing the registered strategies, rules and stations, and examples.
fn simulate_help() -> String {
    let mut help = "Strategies:\n".to_owned();
    help += &pickline::strategies::help();
    help += "\nRules, each of which picks the candidate with the smallest key:\n";
    for rule in pickline::dispatch::RULES {
        help += &format!(
            "  {:<6}{:<26}{}\n",
            rule.name(),
            rule.title(),
            rule.key_text()
        );
    }
    help += "\nBuilt-in stations:\n";
    for built_in in pickline::station::BUILT_INS {
        help += &format!("  {:<14}{}\n", built_in.name, built_in.summary);
    }
    help + "\n\
Examples:
  pickline simulate --strategy rules:SPT,FIFO --format json
  pickline pattern generate poisson | pickline simulate --pattern - --check
  pickline simulate --station my-line.toml --pattern items.csv --trace events.csv
  pickline simulate --strategy lookahead --check
  pickline simulate --robots 3 --html replay.html
  pickline simulate --camera-x 0.5 --grasp-success 0.8 --position-noise 0.01"
}
