//! The arguments of `pickline train`.

use super::shared::strategy_help;
use clap::Args;
use pickline::rl::PRESETS;
use std::path::PathBuf;

/// Train a policy (a learned strategy) and export it as ONNX
///
/// Plays random patterns on the given stations and learns by masked PPO. At intervals the
/// policy is scored on the built-in cases, with separate seeds, next to [SPT; FIFO] and
/// greedy GT (game theory). The best policy so far is kept, also on Ctrl-C. Next to FILE.onnx
/// it writes FILE.json (the training record), FILE.csv and FILE.svg (the learning curve), and
/// FILE.checkpoint.json, from which --resume continues.
#[derive(Debug, Args)]
#[command(after_long_help = train_help())]
pub(crate) struct TrainArgs {
    /// Output file for the policy, NAME.onnx
    #[arg(long, value_name = "FILE", default_value = "policy.onnx")]
    pub out: PathBuf,
    /// Initial settings: default, paper [default: the plan's, otherwise default]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["resume", "plan"])]
    pub preset: Option<String>,
    /// Changes to the preset, as JSON with the keys of `plan` in a training record, such as
    /// {"preset": "paper", "reward": {"pick": 2}}. From a whole training record, only the plan
    /// is used, not the stations or the seed
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    pub plan: Option<PathBuf>,
    /// Station file (TOML) or built-in, optionally with a number of robots as NAME:N. May be
    /// given several times; repeat a station to train on it more often
    #[arg(
        long,
        value_name = "FILE|NAME[:N]",
        default_value = "paper",
        conflicts_with = "resume"
    )]
    pub station: Vec<String>,
    /// Number of decisions to learn from [default: the preset's]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub steps: Option<u64>,
    /// Learning rate [default: the preset's]
    #[arg(
        long,
        value_name = "X",
        allow_negative_numbers = true,
        conflicts_with = "resume"
    )]
    pub learning_rate: Option<f32>,
    /// Weight of the entropy bonus [default: the preset's]
    #[arg(
        long,
        value_name = "X",
        allow_negative_numbers = true,
        conflicts_with = "resume"
    )]
    pub entropy: Option<f32>,
    #[arg(
        long,
        value_name = "STRATEGY",
        conflicts_with = "resume",
        help = strategy_help(
            "First learn to imitate this strategy (see `pickline simulate --help`)",
            "",
        )
    )]
    pub imitate: Option<String>,
    /// Rounds of imitation: the strategy plays in the first, the network in the others
    /// [default: 10]
    #[arg(
        long,
        value_name = "N",
        requires = "imitate",
        allow_negative_numbers = true
    )]
    pub imitate_rounds: Option<usize>,
    /// Patterns per round of imitation [default: 500]
    #[arg(
        long,
        value_name = "N",
        requires = "imitate",
        allow_negative_numbers = true
    )]
    pub imitate_patterns: Option<usize>,
    /// Resume from a checkpoint, with its stations, plan and seed; --steps sets another
    /// number of decisions
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
    /// Master seed for everything random
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        conflicts_with = "resume",
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// Treat warnings about implausible values as errors
    #[arg(long)]
    pub strict: bool,
    /// Overwrite files even if `train` did not write them
    #[arg(long)]
    pub force: bool,
    /// Number of threads; does not affect results [default: all cores]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Print no progress and no remarks on stderr
    #[arg(short, long)]
    pub quiet: bool,
}

fn train_help() -> String {
    let mut help = String::from("Presets:\n");
    for (name, summary) in PRESETS {
        help += &format!("  {name:<9}{summary}\n");
    }
    help + "
Examples:
  pickline train --out mine.onnx --steps 1000000
  pickline train --preset paper --out as-in-the-paper.onnx
  pickline train --station my-line.toml --imitate lookahead --out my-line.onnx
  pickline compare --cases dense --strategy onnx:mine.onnx"
}
