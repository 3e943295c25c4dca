//! What `pickline simulate` is given.

use super::{Common, ConditionArgs, StationChoice, strategy_help};
use clap::Args;
use std::path::PathBuf;

/// Run one strategy on one pattern, exactly
///
/// Jumps from decision to decision; there is no time step. Prints the throughput, what is
/// picked per minute in the steady state, where the pattern is long enough for one. Says for every item that
/// was not picked why: unreachable, grasp_failed, passed_over, unseen or busy.
#[derive(Debug, Args)]
#[command(after_long_help = simulate_help())]
pub struct SimulateArgs {
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub conditions: ConditionArgs,
    /// Pattern file (CSV), `-` for stdin; the grid of 0.15 m with 50 items when not given
    #[arg(long, value_name = "FILE")]
    pub pattern: Option<String>,
    #[arg(long, value_name = "STRATEGY", help = strategy_help(
        "Strategy, as listed below",
        " [default: SPT for all but the last, FIFO for the last]",
    ))]
    pub strategy: Option<String>,
    /// Time for each decision of a strategy that looks ahead [ms], instead of a number
    /// of simulated decisions; the result then depends on the machine
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub budget_ms: Option<f64>,
    /// Have the independent checker verify the run, with exit code 1 if it refutes it, and
    /// report the smallest distance between two arms (collisions are not avoided)
    #[arg(long)]
    pub check: bool,
    /// Leave out how far the run is at most from the best that any strategy can do
    #[arg(long)]
    pub no_bound: bool,
    /// Write every event of the run into this CSV file
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Write a replay of the run into this HTML file, to be opened in any browser
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
}

/// What can be simulated, from the registries, and examples.
fn simulate_help() -> String {
    let mut help = "Strategies:\n".to_owned();
    help += &pickline::strategies::help();
    help += "\nRules, each picking the candidate with the smallest key:\n";
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
