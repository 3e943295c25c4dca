//! The arguments of `pickline station`.

use super::shared::{OutputFormat, StationChoice};
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Show, check or create a station file
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline station show --robots 3
  pickline station init my-line.toml && pickline station check my-line.toml")]
pub(crate) struct StationArgs {
    #[command(subcommand)]
    pub command: Option<StationCommand>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum StationCommand {
    /// Print the resolved station as TOML
    #[command(
        after_long_help = "Example:\n  pickline station show --robots 3 --svg station.svg --camera-x 0.2"
    )]
    Show {
        #[command(flatten)]
        station: StationChoice,
        /// Also write a drawing of the station to this SVG file
        #[arg(long, value_name = "FILE")]
        svg: Option<PathBuf>,
        /// Draw the items of this pattern file (CSV) on the belt instead of random ones
        #[arg(long, value_name = "FILE", requires = "svg")]
        pattern: Option<String>,
        /// Draw a camera over the belt at this x [m]
        #[arg(
            long,
            value_name = "X",
            requires = "svg",
            allow_negative_numbers = true
        )]
        camera_x: Option<f64>,
        /// Overwrite the SVG file even if `station show` did not write it
        #[arg(long)]
        force: bool,
    },
    /// Check a station file, and print what each robot reaches and which arms can collide
    #[command(after_long_help = "Example:\n  pickline station check my-line.toml")]
    Check {
        /// The station file, or a built-in station
        #[arg(default_value = "paper")]
        file: String,
        /// Treat warnings about implausible values as errors
        #[arg(long)]
        strict: bool,
    },
    Fit(Box<FitArgs>),
    /// Write a commented station file to start from
    #[command(after_long_help = "Example:\n  pickline station init my-line.toml")]
    Init {
        /// Output file [default: stdout]
        file: Option<PathBuf>,
        /// Overwrite the file if it exists
        #[arg(long)]
        force: bool,
    },
}

/// Fit each robot's travel-time law to recorded moves
///
/// Estimates speed and acceleration, or a table of travel times, lift, and grasp and release
/// times of every robot from a recording (`pickline run --record`) or a CSV file of moves. Failed
/// grasps and waits do not bend it. Says what the moves do not determine, gives 95 % intervals,
/// and how well times are predicted that the fit did not use.
#[derive(Debug, Args)]
#[command(after_long_help = "\
A CSV file of moves has a header and one move per line, columns in any order:
  robot            name, or number from 1, upstream first
  from_x, from_y   where the arm was before [m]
  meet_x, meet_y   where it grasped the item [m]
  depart_s         when it left [s]
  grasp_s          start of the grasp [s]
  bin_x, bin_y     where it released the item [m]
  release_s        when the item was in the bin and the robot free [s]
All columns after meet_y may be missing, and so may their fields. Other units are understood
in names, such as from_x_mm or grasp_ms.

Examples:
  pickline station fit line.mcap --out as-built.toml
  pickline station fit moves.csv --station my-line.toml --svg residuals.svg
  pickline station fit moves.csv --station my-line.toml --law table --lift 0.03")]
pub(crate) struct FitArgs {
    /// Recording of `pickline run --record` (MCAP), or file of moves (CSV)
    pub moves: PathBuf,
    /// Station that the moves are of, whose other values are kept: a file (TOML) or a built-in
    /// [default: that of the recording; for a CSV file paper]
    #[arg(long, value_name = "FILE|NAME")]
    pub station: Option<String>,
    /// Law to fit
    #[arg(long, value_enum, default_value_t = LawArg::Auto)]
    pub law: LawArg,
    /// Lift [m], if it is known, so that it is not estimated
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    pub lift: Option<f64>,
    /// Number of bootstrap resamples for the intervals; 0 for none
    #[arg(
        long,
        value_name = "N",
        default_value_t = 500,
        allow_negative_numbers = true
    )]
    pub resamples: usize,
    /// Seed of the resamples
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// Number of threads; does not affect results [default: all cores]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Output format on stdout
    #[arg(long, value_enum, default_value_t = OutputFormat::Table)]
    pub format: OutputFormat,
    /// Also write the station with the fitted laws to this TOML file
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Also draw a chart to this SVG file
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Which chart --svg draws: residuals or times [default: residuals]
    #[arg(long, value_name = "NAME", requires = "svg")]
    pub chart: Option<String>,
    /// Overwrite files even if `station fit` did not write them
    #[arg(long)]
    pub force: bool,
    /// Treat warnings about implausible values of the station as errors
    #[arg(long)]
    pub strict: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LawArg {
    /// The simplest that fits
    Auto,
    /// Constant speed
    Speed,
    /// Speed and acceleration
    Trapezoid,
    /// A monotone table of travel times
    Table,
}

impl Default for StationCommand {
    /// The default of `pickline station` without a subcommand.
    fn default() -> Self {
        Self::Show {
            station: StationChoice {
                station: "paper".into(),
                robots: None,
                belt_speed: None,
                strict: false,
            },
            svg: None,
            pattern: None,
            camera_x: None,
            force: false,
        }
    }
}
