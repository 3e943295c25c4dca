//! What `pickline run` and `pickline emulate` are given.

use super::super::log::Log;
use super::{StationChoice, strategy_help};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// Where the time comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ClockArg {
    /// The machine's clock
    System,
    /// The stamps of the messages: the same messages give the same output, to the bit
    Messages,
}

/// How lines are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DialectArg {
    /// One JSON object a line
    Json,
    /// Fixed fields, at most 80 characters, with sequence number and checksum: for controllers
    /// without JSON
    Csv,
}

/// How remarks are written on stderr.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormatArg {
    /// As journald where stderr leads there, else as text
    Auto,
    /// The text alone
    Text,
    /// The level before each line, as journald reads it: <4>text
    Journald,
    /// Time [s] since 1970 and level before the text, for files
    Stamped,
}

/// How two programs talk to each other.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Transport")]
pub struct TransportArgs {
    /// Where the time comes from; run and emulate need the same
    #[arg(long, value_enum, default_value_t = ClockArg::System)]
    pub clock: ClockArg,
    /// Talk to whoever connects to this address instead of stdin and stdout; port 0 takes
    /// a free one and says which
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "connect")]
    pub listen: Option<String>,
    /// Talk to the program that listens at this address instead of stdin and stdout
    #[arg(long, value_name = "HOST:PORT")]
    pub connect: Option<String>,
    #[command(flatten)]
    pub access: super::AccessArgs,
    #[cfg(feature = "mqtt")]
    #[command(flatten)]
    pub mqtt: super::MqttArgs,
    #[cfg(feature = "ros2")]
    #[command(flatten)]
    pub ros2: super::Ros2Args,
    /// No remarks on stderr; refused messages are only counted
    #[arg(short, long)]
    pub quiet: bool,
    /// How remarks are written on stderr
    #[arg(long, value_enum, default_value_t = LogFormatArg::Auto)]
    pub log_format: LogFormatArg,
    /// Where they go; not an argument, opened with the first of them.
    #[arg(skip)]
    pub log: OnceLock<Arc<Log>>,
}

/// Run a line: take detections, send tasks to the robots
///
/// Takes what the camera, the belt and the robots tell, one JSON object a line, and sends
/// pick-and-place tasks; docs/protocol.md describes the messages. Ctrl-C or SIGTERM ends
/// it: no new task is given, the open ones are listed.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline run --clock messages < recorded.jsonl > tasks.jsonl
  pickline run --listen 127.0.0.1:7400 --strategy lookahead --budget-ms 20
  pickline run --listen 127.0.0.1:7400 --journal line.journal --record monday.mcap
  pickline run --replay monday.mcap --strategy lookahead > other-tasks.jsonl
  pickline run --listen 127.0.0.1:7400 --dashboard 127.0.0.1:8090
  pickline run --listen 0.0.0.0:7400 --token line.token
  pickline run --listen 127.0.0.1:7400 --dialect csv
  pickline run --schema > protocol.schema.json")]
pub struct RunArgs {
    /// How lines are written over TCP, stdin and stdout; docs/dialect-csv.md has the fields. A
    /// peer that begins in JSON is talked to in JSON
    #[arg(long, value_enum, default_value_t = DialectArg::Json, help_heading = "Transport")]
    #[cfg_attr(feature = "tls", arg(conflicts_with_all = ["tls_cert", "tls_key", "tls_ca"]))]
    #[cfg_attr(feature = "mqtt", arg(conflicts_with = "mqtt"))]
    #[cfg_attr(feature = "ros2", arg(conflicts_with = "ros2"))]
    pub dialect: DialectArg,
    #[command(flatten)]
    pub station: StationChoice,
    #[arg(long, value_name = "STRATEGY", help = strategy_help(
        "Strategy, as `pickline simulate --help` lists them",
        " [default: SPT for all but the last, FIFO for the last]",
    ))]
    pub strategy: Option<String>,
    /// Time for each decision of a strategy that looks ahead [ms] [default: 10 with the
    /// system's clock; with that of the messages a budget that gives the same output on
    /// every machine]
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub budget_ms: Option<f64>,
    /// Master seed of everything random
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    #[command(flatten)]
    pub transport: TransportArgs,
    /// Detections within this distance of an item are of that item, as far as nothing else is
    /// known [m]: five standard deviations of a position at least, and less than two items are
    /// apart
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.015,
        allow_negative_numbers = true
    )]
    pub tolerance: f64,
    /// A task that is not acknowledged for so long is sent again [s]
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    pub ack_timeout: f64,
    /// A result that is overdue for so long is not waited for [s]
    #[arg(
        long,
        value_name = "S",
        default_value_t = 5.0,
        allow_negative_numbers = true
    )]
    pub result_timeout: f64,
    /// Give no new task when the belt, once heard, has been silent for so long [s]; 0 is never
    /// [default: ten times its period, and a second at least, where it reports regularly]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub belt_timeout: Option<f64>,
    /// Give a robot no new task when it, once heard, has been silent for so long [s]; 0 is
    /// never [default: ten times its period, and a second at least, where it reports regularly]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub robot_timeout: Option<f64>,
    /// Pictures are stamped so long after they were taken [ms]
    #[arg(
        long,
        value_name = "MS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub camera_delay: f64,
    /// Decide each task so long before the robot has to set out that it reaches the arm in
    /// time [s]; NAME=S for one robot, also several times
    #[arg(long, value_name = "[NAME=]S", allow_negative_numbers = true)]
    pub lead: Vec<String>,
    /// Ask the belt's drive to stop while no robot takes tasks, and before an item would
    /// leave the last robot's reach (belt_request in docs/protocol.md)
    #[arg(long)]
    pub may_stop_belt: bool,
    /// With --may-stop-belt, so long before an item would be lost [s]: the belt takes a
    /// while to stop
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0.5,
        requires = "may_stop_belt",
        allow_negative_numbers = true
    )]
    pub stop_margin: f64,
    /// Send a status every so many seconds; 0 sends only the last one
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    pub status_every: f64,
    /// Show the line on a web page at this address; it only looks on. Port 0 takes a free
    /// one and says which
    #[arg(long, value_name = "HOST:PORT")]
    pub dashboard: Option<String>,
    /// Print the JSON Schema of the protocol and end
    #[arg(long)]
    pub schema: bool,
    #[command(flatten)]
    pub kept: KeptArgs,
}

/// What a run keeps.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Recording and recovery")]
pub struct KeptArgs {
    /// Keep items, claims and figures in this file: a run that is started again with it
    /// after a crash goes on where the last one was
    #[arg(long, value_name = "FILE")]
    pub journal: Option<PathBuf>,
    /// Have every record of the journal on the disk before a task leaves: it then outlives
    /// the machine's power, not only the program
    #[arg(long, requires = "journal")]
    pub fsync: bool,
    /// Record every message in and out into this new MCAP file, as Foxglove reads them
    #[cfg(feature = "mcap")]
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Run a recording again, as it was or with another --strategy, and tell what differs;
    /// --clock messages goes by its stamps where the system clock ruled
    #[cfg(feature = "mcap")]
    #[arg(long, value_name = "FILE", conflicts_with_all = [
        "listen", "connect", "station", "robots", "belt_speed", "seed", "tolerance",
        "ack_timeout", "result_timeout", "status_every", "belt_timeout", "robot_timeout",
        "camera_delay", "dashboard", "journal", "record", "dialect",
        "token", "insecure", "max_peers",
    ])]
    #[cfg_attr(feature = "mqtt", arg(conflicts_with = "mqtt"))]
    #[cfg_attr(feature = "ros2", arg(conflicts_with = "ros2"))]
    pub replay: Option<PathBuf>,
}

/// Play the station: a camera, a belt and robots that are not there
///
/// Puts a pattern on an emulated belt and talks to `pickline run` as the camera and the
/// robots would. With `--clock messages` both go as fast as they can, and where nothing
/// goes wrong the line picks exactly what `simulate` picks.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline run --listen 127.0.0.1:7400 --clock messages &
  pickline emulate --connect 127.0.0.1:7400 --clock messages --failing-grasps 0.1
  pickline emulate --clock messages < /dev/null > stream.jsonl")]
pub struct EmulateArgs {
    #[command(flatten)]
    pub station: StationChoice,
    /// Pattern file (CSV); the grid of 0.15 m with 50 items when not given
    #[arg(long, value_name = "FILE")]
    pub pattern: Option<PathBuf>,
    #[command(flatten)]
    pub transport: TransportArgs,
    #[command(flatten)]
    pub trouble: TroubleArgs,
}

/// What goes wrong at the emulated station.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Trouble")]
pub struct TroubleArgs {
    /// Share of grasps that fail
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub failing_grasps: f64,
    /// Share of acknowledgements that are lost
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub lost_acks: f64,
    /// Share of detections that are sent twice
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub duplicates: f64,
    /// Share of detections that come up to a second late, and so out of order
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub out_of_order: f64,
    /// Messages are up to this much late [ms]
    #[arg(
        long,
        value_name = "MS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub jitter_ms: f64,
    /// A robot is down: its number (from 1, upstream first), from when and how long [s]
    #[arg(long, value_name = "ROBOT,FROM,SECONDS")]
    pub robot_down: Option<String>,
    /// The belt stands: from when and how long [s]
    #[arg(long, value_name = "FROM,SECONDS")]
    pub belt_stop: Option<String>,
    /// Seed of the luck
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
}
