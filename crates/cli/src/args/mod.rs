//! The arguments as they are typed. Nothing below the command line ever sees clap.

mod access;
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
mod simulate;
mod station;
#[cfg(feature = "onnx")]
mod train;

pub use access::AccessArgs;
pub use bound::{BoundArgs, ObjectiveArg};
pub use conditions::ConditionArgs;
pub use experiment::{CompareArgs, SweepArgs, TrainingArgs};
pub use game::{GameArgs, PayoffArg};
pub use live::{
    ClockArg, DialectArg, EmulateArgs, LogFormatArg, RunArgs, TransportArgs, TroubleArgs,
};
#[cfg(feature = "mqtt")]
pub use mqtt::MqttArgs;
pub use optimize::{LimitArgs, OptimizeArgs, SearchArg};
pub use pattern::{
    AxisArg, BoxesArg, DescribeArgs, GenerateArgs, ImportCommand, PatternArgs, PatternCommand,
    PatternKind, TracksArgs,
};
#[cfg(feature = "ros2")]
pub use ros2::Ros2Args;
pub use service::{ManArgs, PlaceArgs, ServiceArgs, ServiceCommand};
pub use simulate::SimulateArgs;
pub use station::{StationArgs, StationCommand};
#[cfg(feature = "onnx")]
pub use train::TrainArgs;

use clap::{Args, Parser, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Decides which robot picks what from a moving belt: finds the robust dispatching
/// rule for each robot of a line, and simulates any strategy exactly.
#[derive(Debug, Parser)]
#[command(
    version,
    arg_required_else_help = true,
    after_long_help = "\
Every verb runs without arguments on built-in defaults: the station `paper` with two
robots and, where one pattern is needed, the grid of 0.15 m with 50 items.

Exit codes: 0 done, 1 failed, 2 wrong usage or input, 130 interrupted (searches, games
and bounds print the best found so far; comparisons and sweeps the cases and values that
are done, marked as partial)."
)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Optimize(Box<OptimizeArgs>),
    Compare(Box<CompareArgs>),
    Sweep(Box<SweepArgs>),
    Game(Box<GameArgs>),
    Bound(Box<BoundArgs>),
    Simulate(Box<SimulateArgs>),
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
        /// The shell; found out from the environment when not given
        shell: Option<clap_complete::Shell>,
    },
}

/// How results are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For people
    Table,
    /// Everything, one object
    Json,
    /// The main table, for other programs
    Csv,
}

/// The line that a verb works on.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Station")]
pub struct StationChoice {
    /// Station file (TOML), or a built-in: paper, paper-narrow
    #[arg(long, value_name = "FILE|NAME", default_value = "paper")]
    pub station: String,
    /// Number of robots; needs a built-in station or a file with a [line]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub robots: Option<usize>,
    /// Belt speed [m/s] instead of the station's
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub belt_speed: Option<f64>,
    /// Take warnings of values that are not plausible, such as those in millimetres, for
    /// errors
    #[arg(long)]
    pub strict: bool,
}

/// What every verb that computes has in common.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Common")]
pub struct Common {
    /// Master seed of everything random
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// Decisions at multiples of 1/HZ seconds only; 0 is exact
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub update_hz: f64,
    /// Threads; all cores when not given. Results do not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// How the result is printed on stdout
    #[arg(long, value_enum, default_value_t = Format::Table)]
    pub format: Format,
    /// Also write the result files into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite files that are not results of the same verb
    #[arg(long)]
    pub force: bool,
    /// No progress and no remarks on stderr
    #[arg(short, long)]
    pub quiet: bool,
}

/// Where pictures of a result go.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Pictures")]
pub struct Pictures {
    /// Write charts and tables as a page into this HTML file, to be opened in any browser
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Draw one chart into this SVG file, fit for a paper
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Which chart --svg draws; the main one when not given, all are named below
    #[arg(long, value_name = "NAME", requires = "svg")]
    pub chart: Option<String>,
}

/// What generated items carry besides their position.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Item attributes")]
pub struct AttributeArgs {
    /// Item areas [cm^2]: const:V, uniform:LOW,HIGH, lognormal:MEDIAN,SIGMA, beta:A,B
    #[arg(long, value_name = "DIST")]
    pub area: Option<String>,
    /// Detection probabilities, a distribution as for --area
    #[arg(long, value_name = "DIST")]
    pub p_detection: Option<String>,
    /// Grasp probabilities, a distribution as for --area
    #[arg(long, value_name = "DIST")]
    pub p_grasp: Option<String>,
}

/// Flow and shape of generated feeds.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Feed")]
pub struct FeedArgs {
    /// Flow of the feed [items/min] at the station's belt speed; the pattern is fixed in
    /// space, so at another belt speed it is another
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    pub flow: Option<f64>,
    /// clustered: mean number of items in a cluster [default: 5]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub cluster_size: Option<f64>,
    /// clustered: standard deviation of an item's distance from its cluster's centre, along
    /// and across [m] [default: 0.1]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub cluster_spread: Option<f64>,
    /// gaps: mean length of an empty stretch of belt [m] [default: 1]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub gap_length: Option<f64>,
    /// gaps: share of the belt that lies in empty stretches [default: 0.3]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub gap_share: Option<f64>,
}

/// The patterns that assignments are judged on.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Patterns")]
pub struct PatternSetArgs {
    /// Patterns: balanced[:N] (N grids and N Poisson disk patterns over 0.15 to 0.4 m),
    /// grid:SPACING, poisson:RADIUS[:N], a CSV file or a folder of them; with --flow: grid,
    /// poisson[:N], random[:N], clustered[:N], gaps[:N], profile:FILE[:N] (FILE is CSV:
    /// time_s,flow_per_min)
    #[arg(long, value_name = "SET", default_value = "balanced:120")]
    pub patterns: String,
    /// Items in each generated pattern [default: 150; of a profile all]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub items: Option<usize>,
    #[command(flatten)]
    pub feed: FeedArgs,
    #[command(flatten)]
    pub attributes: AttributeArgs,
}

/// What an argument that takes a strategy is said to be: `what`, every way of writing one,
/// `more`.
fn strategy_help(what: &str, more: &str) -> String {
    format!("{what}: {}{more}", pickline::strategies::forms())
}
