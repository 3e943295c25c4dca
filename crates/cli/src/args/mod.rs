//! The arguments as typed: the program and its verbs.

mod access;
mod benchmark;
mod bound;
mod conditions;
mod experiment;
mod game;
mod live;
#[cfg(feature = "mqtt")]
mod mqtt;
mod optimize;
mod pattern;
#[cfg(feature = "ros2")]
mod ros2;
mod service;
mod shards;
mod shared;
mod simulate;
mod station;
#[cfg(feature = "onnx")]
mod train;
mod verification;

pub(crate) use access::AccessArgs;
pub(crate) use benchmark::{BenchmarkArgs, TrackArg};
pub(crate) use bound::{BoundArgs, ObjectiveArg};
pub(crate) use conditions::{ConditionArgs, DetectionArgs, OutageArgs};
pub(crate) use experiment::{CompareArgs, SweepArgs, TrainingArgs};
pub(crate) use game::{GameArgs, PayoffArg};
pub(crate) use live::{
    ClockArg, DialectArg, EmulateArgs, LogFormatArg, RunArgs, TransportArgs, TroubleArgs,
};
#[cfg(feature = "mqtt")]
pub(crate) use mqtt::MqttArgs;
pub(crate) use optimize::{LimitArgs, OptimizeArgs, SearchArg};
pub(crate) use pattern::{
    AxisArg, BoxesArg, DescribeArgs, GenerateArgs, ImportCommand, PatternArgs, PatternCommand,
    PatternKind, TracksArgs,
};
#[cfg(feature = "ros2")]
pub(crate) use ros2::Ros2Args;
pub(crate) use service::{ManArgs, PlaceArgs, ServiceArgs, ServiceCommand};
pub(crate) use shards::{MergeArgs, ShardArgs};
pub(crate) use shared::{
    AttributeArgs, Common, FeedArgs, OutputFormat, PatternSetArgs, Pictures, StationChoice,
};
pub(crate) use simulate::SimulateArgs;
pub(crate) use station::{FitArgs, LawArg, StationArgs, StationCommand};
#[cfg(feature = "onnx")]
pub(crate) use train::TrainArgs;
pub(crate) use verification::CheckArgs;

use clap::{Parser, Subcommand};

/// Decides which robot picks what from a moving belt: finds a robust dispatching rule
/// for each robot of a line, and simulates any strategy exactly.
#[derive(Debug, Parser)]
#[command(
    name = "pickline",
    version,
    arg_required_else_help = true,
    after_long_help = "\
Every verb runs without arguments on built-in defaults: the station `paper` with two
robots and, where a single pattern is needed, a 0.15 m grid of 50 items.

Exit codes: 0 success, 1 failure, 2 invalid usage or input, 130 interrupted (searches,
games and bounds print the best result so far; comparisons and sweeps print the cases or
values that are finished, marked as partial)."
)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Optimize(Box<OptimizeArgs>),
    Compare(Box<CompareArgs>),
    Sweep(Box<SweepArgs>),
    Game(Box<GameArgs>),
    Bound(Box<BoundArgs>),
    Benchmark(Box<BenchmarkArgs>),
    Merge(MergeArgs),
    Simulate(Box<SimulateArgs>),
    Check(Box<CheckArgs>),
    #[cfg(feature = "onnx")]
    Train(Box<TrainArgs>),
    Run(Box<RunArgs>),
    Emulate(Box<EmulateArgs>),
    Pattern(PatternArgs),
    Station(StationArgs),
    Service(ServiceArgs),
    Man(ManArgs),
    /// Print a completion script for a shell
    #[command(after_help = "Example: pickline completions bash > /etc/bash_completion.d/pickline")]
    Completions {
        /// The shell [default: taken from the environment]
        shell: Option<clap_complete::Shell>,
    },
}

impl Command {
    /// The arguments of a verb that can be split into shards.
    pub(crate) fn shards(&mut self) -> Option<(&mut ShardArgs, &mut Common)> {
        match self {
            Self::Optimize(args) => Some((&mut args.shards, &mut args.common)),
            Self::Compare(args) => Some((&mut args.shards, &mut args.common)),
            Self::Sweep(args) => Some((&mut args.shards, &mut args.common)),
            Self::Benchmark(args) => Some((&mut args.shards, &mut args.common)),
            _ => None,
        }
    }
}
