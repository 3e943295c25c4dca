//! The arguments of `pickline benchmark`.

use super::shards::ShardArgs;
use super::shared::{Common, strategy_help};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Judge strategies and programs on the public benchmark
///
/// Runs every entrant on every instance, checks each run with the independent checker, and prints
/// picks, rate and the gaps to the best known solution and to the certified bounds, then a
/// ranking. Without an entrant, the best known solutions are checked. Times per decision are
/// measured and printed in the ranking only: they are in no file.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline benchmark
  pickline benchmark --strategy lookahead --strategy rules:SPT --only 'paper-*-150-*'
  pickline benchmark --track clairvoyant --strategy lookahead:budget=40000
  pickline benchmark --program 'python3 my.py' --timeout 60 --only '*-20-*'
  pickline benchmark --picks my-picks/ --update --by 'A. Name, my method'

A program is called with three more arguments: the files of the station (TOML) and of the pattern
(CSV), and the file into which it writes its picks (CSV, as `pickline check --help` describes).
Words of the call are separated by spaces.

Tracks: online, where an item becomes known as it passes the beginning of the belt; and
clairvoyant, where everything is known from the beginning, as it is for programs, for files of
picks and for the schedules of the bound.")]
pub(crate) struct BenchmarkArgs {
    #[command(flatten)]
    pub common: Common,
    /// Folder of the benchmark
    #[arg(
        long,
        value_name = "DIR",
        default_value = "patterns/benchmark",
        help_heading = "Instances"
    )]
    pub dir: PathBuf,
    /// Only instances with this name, in which * stands for any characters. May be given several
    /// times
    #[arg(long, value_name = "NAME", help_heading = "Instances")]
    pub only: Vec<String>,
    #[arg(long, value_name = "STRATEGY", help = entrant_help(), help_heading = "Entrants")]
    pub strategy: Vec<String>,
    /// What strategies know
    #[arg(long, value_enum, default_value_t = TrackArg::Online, help_heading = "Entrants")]
    pub track: TrackArg,
    /// A program that reads a station and a pattern and writes picks
    #[arg(long, value_name = "CALL", help_heading = "Entrants")]
    pub program: Option<String>,
    /// Longest time of the program for one instance [s]
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 60.0,
        allow_negative_numbers = true,
        help_heading = "Entrants"
    )]
    pub timeout: f64,
    /// A folder of files of picks, named after the instances: NAME.csv
    #[arg(long, value_name = "DIR", help_heading = "Entrants")]
    pub picks: Option<PathBuf>,
    /// Compute the bounds again; the schedules that come with them take part
    #[arg(long, help_heading = "Entrants")]
    pub bounds: bool,
    /// Write better solutions and tighter bounds into the folder of the benchmark
    #[arg(long, help_heading = "Contributing")]
    pub update: bool,
    /// Who found the picks of --program or --picks, for --update [default: the call or the folder]
    #[arg(
        long,
        value_name = "WORDS",
        requires = "update",
        help_heading = "Contributing"
    )]
    pub by: Option<String>,
    #[command(flatten)]
    pub shards: ShardArgs,
}

/// What strategies know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TrackArg {
    /// An item from when it passes the beginning of the belt
    Online,
    /// Everything from the beginning
    Clairvoyant,
}

fn entrant_help() -> String {
    strategy_help(
        "A strategy (see `pickline simulate --help`)",
        ". A single rule, share or number is that of every robot. May be given several times",
    )
}
