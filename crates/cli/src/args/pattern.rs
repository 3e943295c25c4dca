//! The arguments of `pickline pattern`.

use super::shared::{AttributeArgs, FeedArgs, OutputFormat, StationChoice};
use clap::{Args, Subcommand, ValueEnum};
use std::path::PathBuf;

/// Generate, describe or import patterns
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline pattern generate poisson --radius 0.2 --count 29 --output p.csv
  pickline pattern describe p.csv
  pickline pattern import tracks film.txt --fps 30 --scale 0.0015 --axis x --belt-speed 0.1")]
pub(crate) struct PatternArgs {
    #[command(subcommand)]
    pub command: Option<PatternCommand>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum PatternCommand {
    /// Write a generated pattern as CSV
    #[command(after_long_help = "\
Example:
  pickline pattern generate poisson --radius 0.2 --count 29 --area lognormal:80,0.5
  pickline pattern generate random --flow 60 --count 300 --output p.csv
  pickline pattern generate clustered --flow 60 --count 300 | pickline simulate --pattern -
  pickline pattern generate profile --profile shift.csv --output p.csv
  pickline pattern generate random --station sorting --flow 120 --classes pet:0.6,wood:0.4")]
    Generate(Box<GenerateArgs>),
    /// Print the statistics of a pattern
    #[command(after_long_help = "\
Examples:
  pickline pattern describe items.csv --format json
  pickline pattern describe items.csv --station my-line.toml")]
    Describe(DescribeArgs),
    /// Turn a recording from another program into a pattern
    #[command(subcommand)]
    Import(ImportCommand),
}

impl Default for PatternCommand {
    /// The default of `pickline pattern` without a subcommand.
    fn default() -> Self {
        Self::Describe(DescribeArgs {
            file: None,
            station: None,
            belt_speed: None,
            format: OutputFormat::Table,
            strict: false,
        })
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PatternKind {
    /// A square lattice
    Grid,
    /// A maximal Poisson disk sample
    Poisson,
    /// A Poisson process: items arrive at random and may overlap
    Random,
    /// Clusters at random places
    Clustered,
    /// Random items with empty stretches of belt
    Gaps,
    /// Random items whose flow follows --profile
    Profile,
}

#[derive(Debug, Args)]
pub(crate) struct GenerateArgs {
    /// Kind of pattern
    #[arg(value_enum, default_value_t = PatternKind::Grid)]
    pub kind: PatternKind,
    /// Number of items [default: 50; 29 for a Poisson disk pattern; all for a profile]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub count: Option<usize>,
    /// Grid: spacing [m] [default: 0.15]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub spacing: Option<f64>,
    /// Poisson disk: minimum distance between two items [m] [default: 0.2]
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    pub radius: Option<f64>,
    /// Profile: CSV with the flow over time, columns time_s,flow_per_min; interpolated
    /// linearly between rows
    #[arg(long, value_name = "FILE")]
    pub profile: Option<PathBuf>,
    #[command(flatten)]
    pub feed: FeedArgs,
    /// Belt width [m] [default: the station's]
    #[arg(long, value_name = "W", allow_negative_numbers = true)]
    pub width: Option<f64>,
    #[command(flatten)]
    pub station: StationChoice,
    #[command(flatten)]
    pub attributes: AttributeArgs,
    /// Seed for everything random
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    /// Write to this file instead of stdout
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Overwrite the file even if `pattern generate` did not write it
    #[arg(long)]
    pub force: bool,
    /// Do not report on stderr the defaults used for what was not given
    #[arg(short, long)]
    pub quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct DescribeArgs {
    /// Pattern file (CSV), or `-` for stdin [default: a 0.15 m grid of 50 items]
    pub file: Option<String>,
    /// Also print the flow on the belt of this station: a file (TOML) or a built-in
    #[arg(long, value_name = "FILE|NAME")]
    pub station: Option<String>,
    /// Also print the flow at this belt speed [m/s]
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub belt_speed: Option<f64>,
    /// Output format
    #[arg(long, value_enum, default_value_t = OutputFormat::Table)]
    pub format: OutputFormat,
    /// Treat warnings about implausible values as errors
    #[arg(long)]
    pub strict: bool,
}

#[derive(Debug, Subcommand)]
pub(crate) enum ImportCommand {
    /// Import the output of a tracker or a detector
    ///
    /// Makes one item per track: its belt position from all frames, its area from the box,
    /// its detection probability from the confidence, and its class. Boxes without track ids
    /// are linked by the belt's motion. The tracks also show the belt's direction and speed.
    /// These are compared with the values given here; if the pattern would be wrong by
    /// centimetres, the import fails and prints the values that would fit. What was read,
    /// dropped and measured is printed on stderr.
    #[command(
        visible_alias = "mot",
        after_long_help = "\
Examples:
  pickline pattern import tracks film.txt --fps 30 --scale 0.0015 --axis x \\
      --belt-speed 0.1 --output p.csv
  pickline pattern import tracks runs/track/labels --image-size 1280x720 --fps 25 \\
      --scale 0.002 --axis x --belt-speed 0.25 --angle 1.8
  pickline pattern import tracks waste.txt --fps 30 --scale 0.0015 --axis x \\
      --belt-speed 0.3 --class-names 1:pet,2:hdpe,3:wood

File formats, detected from the content:
  mot          frame,id,left,top,width,height,conf[,class,visibility] or [,x,y,z]
  supervision  CSV with a header, x_min,y_min,x_max,y_max,class_id,confidence,tracker_id,
               class_name,frame; also MOT columns under their names
  ultralytics  a folder of labels, class xc yc w h [conf] [id], one file per frame
  yolo         frame class x1 y1 x2 y2 xc yc
  coco         JSON detections, image_id (the frame), category_id, bbox, score"
    )]
    Tracks(Box<TracksArgs>),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum BoxesArg {
    /// Left, top, width, height
    Sizes,
    /// Left, top, right, bottom
    Corners,
    /// Centre along x, along y, width, height
    Centres,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum AxisArg {
    /// The belt travels along the image's x axis
    X,
    /// The belt travels along the image's y axis
    Y,
}

#[derive(Debug, Args)]
pub(crate) struct TracksArgs {
    /// The recording: a file, or a folder of label files
    pub file: PathBuf,
    /// File format: mot, supervision, ultralytics, yolo, coco [default: detected]
    #[arg(long = "as", value_name = "FORM")]
    pub form: Option<String>,
    /// Meaning of the four numbers of a box in MOT and COCO files; the other formats define
    /// it themselves [default: sizes]
    #[arg(long, value_enum)]
    pub boxes: Option<BoxesArg>,
    /// Image width and height [px], for boxes given as fractions of the image
    #[arg(long, value_name = "WxH")]
    pub image_size: Option<String>,
    /// Frames per second of the recording
    #[arg(long, value_name = "HZ", allow_negative_numbers = true)]
    pub fps: f64,
    /// Metres per pixel on the belt
    #[arg(long, value_name = "M_PER_PX", allow_negative_numbers = true)]
    pub scale: f64,
    /// The image axis along which the belt travels
    #[arg(long, value_enum)]
    pub axis: AxisArg,
    /// The belt travels towards smaller pixel values
    #[arg(long)]
    pub reverse: bool,
    /// Angle between the belt's travel and that axis, positive towards larger pixel values
    /// of the other axis [degrees]; the import measures it
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub angle: f64,
    /// Belt speed during the recording [m/s]
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    pub belt_speed: f64,
    /// Pixel coordinate of the belt's centre line, across the travel [default: midway
    /// between the outermost items]
    #[arg(long, value_name = "PX", allow_negative_numbers = true)]
    pub centre_px: Option<f64>,
    /// Drop tracks seen in fewer frames
    #[arg(
        long,
        value_name = "N",
        default_value_t = 2,
        allow_negative_numbers = true
    )]
    pub min_frames: usize,
    /// Split a track where it jumps by more than this along the belt [m]
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.1,
        allow_negative_numbers = true
    )]
    pub split_distance: f64,
    /// Merge consecutive tracks whose positions agree within this distance [m]
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.02,
        allow_negative_numbers = true
    )]
    pub merge_distance: f64,
    /// Names of the class ids: such as 1:pet,2:hdpe, or a file with one such pair on each line
    #[arg(long, value_name = "NAMES|FILE")]
    pub class_names: Option<String>,
    /// Write to this file instead of stdout
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Make the pattern even if the tracks contradict the given values
    #[arg(long)]
    pub accept_mismatch: bool,
    /// Also write what was dropped, split, merged and measured, and why, to this JSON file
    #[arg(long, value_name = "FILE")]
    pub report: Option<PathBuf>,
    /// Treat warnings as errors: about implausible values, and about tracks that do not
    /// agree with the given values
    #[arg(long)]
    pub strict: bool,
    /// Overwrite files even if `pattern import` did not write them
    #[arg(long)]
    pub force: bool,
    /// Print warnings only, not what was read and dropped
    #[arg(short, long)]
    pub quiet: bool,
}
