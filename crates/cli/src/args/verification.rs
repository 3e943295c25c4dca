//! The arguments of `pickline check`.

use super::shared::{OutputFormat, StationChoice};
use clap::Args;
use std::path::PathBuf;

/// Check the picks of any run, from files alone
///
/// Reads who picked what and when, as this or another program wrote it, and lists everything
/// that contradicts the model: times that an arm does not take, items out of reach or off the
/// belt, wrong bins, items that another robot has, robots in two places at once. Says for each
/// what would be right. Exit code 1 if there is anything.
#[derive(Debug, Args)]
#[command(after_long_help = "\
The file of picks is CSV with a header and one attempt per line, columns in any order:
  robot      name, or number from 1, upstream first
  item       id in the pattern
  decide_s   when the robot left for it [s], counted from when the pattern's x were taken
  grasp_s    start of the grasp [s]
  release_s  when the item was in the bin and the robot free [s]
  bin        name of the bin [default: the one that the item's class goes into]
  failure    grasp or out_of_reach for a failed attempt [default: a pick]
  meet_x_m, meet_y_m  where it was met [m] [default: where the item was at the grasp]
Commas, semicolons or tabs separate fields; decimal commas, comments with # and other units,
such as grasp_ms, are understood.

Examples:
  pickline check picks.csv --station my-line.toml --pattern items.csv
  pickline check picks.csv --pattern items.csv --tolerance 0.0005 --format json
  pickline simulate -q --format csv | pickline check -")]
pub(crate) struct CheckArgs {
    /// File of picks (CSV), or `-` for stdin
    pub picks: PathBuf,
    #[command(flatten)]
    pub station: StationChoice,
    /// Pattern file (CSV) that was picked from, or `-` for stdin [default: a 0.15 m grid of 50
    /// items]
    #[arg(long, value_name = "FILE")]
    pub pattern: Option<String>,
    /// How far each time may be off [s], for files with rounded or measured times; 0 allows for
    /// floating-point rounding only
    #[arg(
        long,
        value_name = "SECONDS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub tolerance: f64,
    /// Position of the camera [m]: no robot may leave for an item before that
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    pub camera_x: Option<f64>,
    /// Robots may leave only at multiples of 1/HZ seconds; 0 for any time
    #[arg(
        long,
        value_name = "HZ",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub update_hz: f64,
    /// Output format on stdout
    #[arg(long, value_enum, default_value_t = OutputFormat::Table)]
    pub format: OutputFormat,
    /// Print no remarks on stderr
    #[arg(short, long)]
    pub quiet: bool,
}
