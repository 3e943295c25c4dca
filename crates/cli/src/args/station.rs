//! The arguments of `pickline station`.

use super::shared::StationChoice;
use clap::{Args, Subcommand};
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
