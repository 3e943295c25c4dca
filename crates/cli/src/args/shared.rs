//! The arguments that several verbs share.

use clap::{Args, ValueEnum};
use pickline::station::BUILT_INS;
use std::path::PathBuf;

/// How results are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum OutputFormat {
    /// For people
    Table,
    /// Everything, as one object
    Json,
    /// The main table, for other programs to read
    Csv,
}

/// The station that a verb works on.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Station")]
pub(crate) struct StationChoice {
    #[arg(long, value_name = "FILE|NAME", default_value = "paper", help = station_help())]
    pub station: String,
    /// Number of robots; needs a built-in station or a station file with a [line] table
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub robots: Option<usize>,
    /// Belt speed [m/s], overriding the station's
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub belt_speed: Option<f64>,
    /// Treat warnings about implausible values, such as lengths in millimetres, as errors
    #[arg(long)]
    pub strict: bool,
}

/// Options shared by every verb that computes something.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Common")]
pub(crate) struct Common {
    /// Master seed for everything random
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// Decide only at multiples of 1/HZ seconds; 0 decides at the exact time
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub update_hz: f64,
    /// Number of threads; does not affect results [default: all cores]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Output format on stdout
    #[arg(long, value_enum, default_value_t = OutputFormat::Table)]
    pub format: OutputFormat,
    /// Also write the result files to this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Overwrite files even if they are not results of the same verb
    #[arg(long)]
    pub force: bool,
    /// Print no progress and no remarks on stderr
    #[arg(short, long)]
    pub quiet: bool,
}

/// Pictures of a result, and where to write them.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Pictures")]
pub(crate) struct Pictures {
    /// Write a page with charts and tables to this HTML file, which opens in any browser
    #[arg(long, value_name = "FILE")]
    pub html: Option<PathBuf>,
    /// Write one chart to this SVG file, suitable for a paper
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Which chart --svg draws, one of those listed below [default: the main one]
    #[arg(long, value_name = "NAME", requires = "svg")]
    pub chart: Option<String>,
}

/// Attributes of generated items besides their position.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Item attributes")]
pub(crate) struct AttributeArgs {
    /// Item areas [cm^2]: const:V, uniform:LOW,HIGH, lognormal:MEDIAN,SIGMA, beta:A,B
    #[arg(long, value_name = "DIST")]
    pub area: Option<String>,
    /// Detection probabilities, with a distribution as for --area
    #[arg(long, value_name = "DIST")]
    pub p_detection: Option<String>,
    /// Grasp probabilities, with a distribution as for --area
    #[arg(long, value_name = "DIST")]
    pub p_grasp: Option<String>,
    /// Classes with their shares, such as pet:0.4,hdpe:0.3,wood:0.3; the rest has none
    #[arg(long, value_name = "SHARES")]
    pub classes: Option<String>,
}

/// Flow and shape of generated feeds.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Feed")]
pub(crate) struct FeedArgs {
    /// Flow of the feed [items/min] at the station's belt speed; the pattern is fixed in
    /// space, so the flow changes with the belt speed
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    pub flow: Option<f64>,
    /// clustered: mean number of items per cluster [default: 5]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub cluster_size: Option<f64>,
    /// clustered: standard deviation of an item's offset from its cluster's centre, along
    /// and across the belt [m] [default: 0.1]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub cluster_spread: Option<f64>,
    /// gaps: mean length of an empty stretch of belt [m] [default: 1]
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub gap_length: Option<f64>,
    /// gaps: share of the belt that is empty stretches [default: 0.3]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    pub gap_share: Option<f64>,
}

/// The patterns on which assignments are scored.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Patterns")]
pub(crate) struct PatternSetArgs {
    /// Patterns: balanced[:N] (N grids and N Poisson disk patterns over 0.15 to 0.4 m),
    /// grid:SPACING, poisson:RADIUS[:N], a CSV file or a folder of them; with --flow: grid,
    /// poisson[:N], random[:N], clustered[:N], gaps[:N], profile:FILE[:N] (FILE is CSV:
    /// time_s,flow_per_min)
    #[arg(long, value_name = "SET", default_value = "balanced:120")]
    pub patterns: String,
    /// Items in each generated pattern [default: 150; for a profile, all its items]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub items: Option<usize>,
    #[command(flatten)]
    pub feed: FeedArgs,
    #[command(flatten)]
    pub attributes: AttributeArgs,
}

/// The help text of an argument that takes a station.
fn station_help() -> String {
    let names: Vec<&str> = BUILT_INS.iter().map(|station| station.name).collect();
    format!("Station file (TOML), or a built-in: {}", names.join(", "))
}

/// The help text of an argument that takes a strategy: `what`, all strategy forms, then
/// `more`.
pub(super) fn strategy_help(what: &str, more: &str) -> String {
    format!("{what}: {}{more}", pickline::strategies::forms())
}
