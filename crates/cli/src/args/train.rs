//! What `pickline train` is given.

use super::strategy_help;
use pickline::rl::PRESETS;
use clap::Args;
use std::path::PathBuf;

/// Train a policy, the learned strategy, and export it as ONNX
///
/// Plays patterns drawn at random on the given stations and learns by masked PPO. Every
/// so often the policy is judged on the built-in cases, under seeds kept apart, beside
/// [SPT; FIFO] and greedy GT. The best so far is kept, on Ctrl-C too. Beside FILE.onnx
/// stand FILE.json, the training record, FILE.csv and FILE.svg, the learning curve, and
/// FILE.checkpoint.json to go on from with --resume.
#[derive(Debug, Args)]
#[command(after_long_help = train_help())]
pub struct TrainArgs {
    /// The policy's file, NAME.onnx
    #[arg(long, value_name = "FILE", default_value = "policy.onnx")]
    pub out: PathBuf,
    /// Where to begin: default, paper [default: the plan's, or default]
    #[arg(long, value_name = "NAME", conflicts_with_all = ["resume", "plan"])]
    pub preset: Option<String>,
    /// What is to differ from the preset, as JSON with the keys of `plan` in a training
    /// record, such as {"preset": "paper", "reward": {"pick": 2}}. Of a whole record the plan
    /// alone is taken, not its stations and seed
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    pub plan: Option<PathBuf>,
    /// Station file (TOML) or built-in; with a number of robots as NAME:N. May be given
    /// several times, and one several times to be trained on more often
    #[arg(
        long,
        value_name = "FILE|NAME[:N]",
        default_value = "paper",
        conflicts_with = "resume"
    )]
    pub station: Vec<String>,
    /// Decisions to learn from [default: the preset's]
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
            "First learn from this strategy's decisions, as `pickline simulate --help` lists them",
            "",
        )
    )]
    pub imitate: Option<String>,
    /// Rounds of that: the strategy plays in the first, the network in the others
    /// [default: 10]
    #[arg(
        long,
        value_name = "N",
        requires = "imitate",
        allow_negative_numbers = true
    )]
    pub imitate_rounds: Option<usize>,
    /// Patterns of each round [default: 500]
    #[arg(
        long,
        value_name = "N",
        requires = "imitate",
        allow_negative_numbers = true
    )]
    pub imitate_patterns: Option<usize>,
    /// Go on from a checkpoint, on its stations and with its plan and seed; with --steps to
    /// another end
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
    /// Master seed of everything random
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        conflicts_with = "resume",
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// Take warnings of values that are not plausible for errors
    #[arg(long)]
    pub strict: bool,
    /// Overwrite files that `train` did not write
    #[arg(long)]
    pub force: bool,
    /// Threads; all cores when not given. Results do not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// No progress and no remarks on stderr
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
