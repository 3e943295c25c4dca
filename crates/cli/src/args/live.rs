//! The arguments of `pickline run` and `pickline emulate`.

use super::shared::{StationChoice, strategy_help};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Which clock is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ClockArg {
    /// The machine's clock
    System,
    /// The timestamps of the messages: the same messages give bit-identical output
    Messages,
}

/// The encoding of protocol lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum DialectArg {
    /// One JSON object per line
    Json,
    /// Fixed fields, at most 80 characters, with a sequence number and a checksum: for
    /// controllers without JSON
    Csv,
}

/// The format of remarks on stderr.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum LogFormatArg {
    /// `journald` if stderr is connected to the journal, otherwise `text`
    Auto,
    /// Only the text
    Text,
    /// Each line prefixed with its level, as journald expects it: <4>text
    Journald,
    /// Each remark prefixed with the Unix time [s] and its level, for files
    Stamped,
}

/// How the two programs communicate.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Transport")]
pub(crate) struct TransportArgs {
    /// Which clock to use; must be the same for run and emulate
    #[arg(long, value_enum, default_value_t = ClockArg::System)]
    pub clock: ClockArg,
    /// Listen for connections at this address instead of using stdin and stdout; port 0
    /// picks a free port and prints it
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "connect")]
    pub listen: Option<String>,
    /// Connect to the program listening at this address instead of using stdin and stdout
    #[arg(long, value_name = "HOST:PORT")]
    pub connect: Option<String>,
    #[command(flatten)]
    pub access: super::access::AccessArgs,
    #[cfg(feature = "mqtt")]
    #[command(flatten)]
    pub mqtt: super::mqtt::MqttArgs,
    #[cfg(feature = "ros2")]
    #[command(flatten)]
    pub ros2: super::ros2::Ros2Args,
    /// Print no remarks on stderr; refused messages are still counted
    #[arg(short, long)]
    pub quiet: bool,
    /// Format of remarks on stderr
    #[arg(long, value_enum, default_value_t = LogFormatArg::Auto)]
    pub log_format: LogFormatArg,
}

/// Run a line: receive detections, send tasks to the robots
///
/// Receives messages from the camera, the belt and the robots, one JSON object per line,
/// and sends pick-and-place tasks; docs/protocol.md describes the messages. On Ctrl-C or
/// SIGTERM it gives no new tasks, lists the open ones and exits.
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
pub(crate) struct RunArgs {
    /// Encoding of lines over TCP, stdin and stdout; docs/dialect-csv.md lists the fields. A
    /// peer whose first line is JSON is answered in JSON
    #[arg(long, value_enum, default_value_t = DialectArg::Json, help_heading = "Transport")]
    #[cfg_attr(feature = "tls", arg(conflicts_with_all = ["tls_cert", "tls_key", "tls_ca"]))]
    #[cfg_attr(feature = "mqtt", arg(conflicts_with = "mqtt"))]
    #[cfg_attr(feature = "ros2", arg(conflicts_with = "ros2"))]
    pub dialect: DialectArg,
    #[command(flatten)]
    pub station: StationChoice,
    #[arg(long, value_name = "STRATEGY", help = strategy_help(
        "Strategy (see `pickline simulate --help`)",
        " [default: FIFO for the last robot, SPT for all others]",
    ))]
    pub strategy: Option<String>,
    /// Time per decision for a strategy that looks ahead [ms] [default: 10 with --clock
    /// system; with --clock messages, a budget that gives the same output on every machine]
    #[arg(long, value_name = "MS", allow_negative_numbers = true)]
    pub budget_ms: Option<f64>,
    /// Master seed for everything random
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
    #[command(flatten)]
    pub transport: TransportArgs,
    /// Detections within this distance of an item are matched to it, unless other data says
    /// otherwise [m]; use at least five standard deviations of a position, but less than the
    /// distance between two items
    #[arg(
        long,
        value_name = "M",
        default_value_t = 0.015,
        allow_negative_numbers = true
    )]
    pub tolerance: f64,
    /// Resend a task that is not acknowledged within this time [s]
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    pub ack_timeout: f64,
    /// Stop waiting for a result that is overdue by this time [s]
    #[arg(
        long,
        value_name = "S",
        default_value_t = 5.0,
        allow_negative_numbers = true
    )]
    pub result_timeout: f64,
    /// Give no new tasks once the belt, after its first report, has been silent for this
    /// time [s]; 0 disables this [default: ten times its period but at least a second, if it
    /// reports regularly]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub belt_timeout: Option<f64>,
    /// Give a robot no new tasks once it, after its first report, has been silent for this
    /// time [s]; 0 disables this [default: ten times its period but at least a second, if it
    /// reports regularly]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub robot_timeout: Option<f64>,
    /// Delay between taking a picture and its timestamp [ms]
    #[arg(
        long,
        value_name = "MS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub camera_delay: f64,
    /// Decide each task this long before the robot must start moving, so that the task
    /// reaches the arm in time [s]; NAME=S for one robot. May be given several times
    #[arg(long, value_name = "[NAME=]S", allow_negative_numbers = true)]
    pub lead: Vec<String>,
    /// Ask the belt's drive to stop while no robot accepts tasks, and before an item would
    /// leave the last robot's reach (belt_request in docs/protocol.md)
    #[arg(long)]
    pub may_stop_belt: bool,
    /// With --may-stop-belt, how long before an item would be lost to ask for the stop [s];
    /// the belt takes a while to stop
    #[arg(
        long,
        value_name = "S",
        default_value_t = 0.5,
        requires = "may_stop_belt",
        allow_negative_numbers = true
    )]
    pub stop_margin: f64,
    /// Leave items with a p_detection below P on the belt; those without one count as certain
    /// [default: 0, all are picked]
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        hide_default_value = true,
        allow_negative_numbers = true
    )]
    pub min_detection: f64,
    /// Send a status at this interval [s]; 0 sends only the last one
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    pub status_every: f64,
    /// Serve a read-only web page that shows the line at this address; port 0 picks a free
    /// port and prints it
    #[arg(long, value_name = "HOST:PORT")]
    pub dashboard: Option<String>,
    /// Print the JSON Schema of the protocol and exit
    #[arg(long)]
    pub schema: bool,
    #[command(flatten)]
    pub kept: KeptArgs,
}

/// What a run keeps on disk.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Recording and recovery")]
pub(crate) struct KeptArgs {
    /// Keep items, claims and counters in this file, so that a run restarted with it after
    /// a crash resumes where the last one stopped
    #[arg(long, value_name = "FILE")]
    pub journal: Option<PathBuf>,
    /// Sync the journal to disk before a task is sent, so that it survives a power failure
    /// and not only a crash of the program
    #[arg(long, requires = "journal")]
    pub fsync: bool,
    /// Record every incoming and outgoing message in this new MCAP file, which Foxglove reads
    #[cfg(feature = "mcap")]
    #[arg(long, value_name = "FILE")]
    pub record: Option<PathBuf>,
    /// Replay a recording, unchanged or with another --strategy, and report what differs;
    /// with --clock messages, use the recorded timestamps even if it used the system clock
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

/// Emulate a station: its camera, belt and robots
///
/// Puts a pattern on an emulated belt and talks to `pickline run` as the camera and the
/// robots would. With `--clock messages` both run as fast as they can, and if nothing goes
/// wrong the line picks exactly what `simulate` picks.
#[derive(Debug, Args)]
#[command(after_long_help = "\
Examples:
  pickline run --listen 127.0.0.1:7400 --clock messages &
  pickline emulate --connect 127.0.0.1:7400 --clock messages --failing-grasps 0.1
  pickline emulate --connect 127.0.0.1:7400 --true-station as-built.toml --time-noise 0.003
  pickline emulate --clock messages < /dev/null > stream.jsonl")]
pub(crate) struct EmulateArgs {
    #[command(flatten)]
    pub station: StationChoice,
    /// Pattern file (CSV) [default: a 0.15 m grid of 50 items]
    #[arg(long, value_name = "FILE")]
    pub pattern: Option<PathBuf>,
    /// Let the arms move as this station says (file or built-in), while protocol and plan go by
    /// --station: how an arm does that is not what its station file says
    #[arg(long, value_name = "FILE|NAME")]
    pub true_station: Option<String>,
    #[command(flatten)]
    pub transport: TransportArgs,
    #[command(flatten)]
    pub trouble: TroubleArgs,
}

/// Faults of the emulated station.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Faults")]
pub(crate) struct TroubleArgs {
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
    /// Share of detections that arrive up to a second late, and so out of order
    #[arg(
        long,
        value_name = "P",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub out_of_order: f64,
    /// Maximum random delay of each message [ms]
    #[arg(
        long,
        value_name = "MS",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub jitter_ms: f64,
    /// Take a robot down: its number (from 1, upstream first), when and for how long [s]
    #[arg(long, value_name = "ROBOT,FROM,SECONDS")]
    pub robot_down: Option<String>,
    /// Stop the belt: when and for how long [s]
    #[arg(long, value_name = "FROM,SECONDS")]
    pub belt_stop: Option<String>,
    /// Standard deviation of when an arm's movement ends [s]
    #[arg(
        long,
        value_name = "SD",
        default_value_t = 0.0,
        allow_negative_numbers = true
    )]
    pub time_noise: f64,
    /// Seed for these random faults
    #[arg(
        long,
        value_name = "S",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    pub seed: u64,
}
