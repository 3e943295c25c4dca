//! What a recording holds besides messages.

use crate::protocol::VERSION;
use crate::{ClockKind, Config, Timeouts};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What happens to the controller besides messages; in their order the two decide what it
/// says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Event {
    /// With the system clock: the time was read, and what was due was done.
    Step {
        /// The time [s since 1970].
        stamp: f64,
        /// Whether all tasks had to wait, for nobody was there or kept up.
        held: bool,
        /// Where not all had to wait, the robots whose tasks had to, upstream first from 0.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        held_robots: Vec<usize>,
        /// By how much the machine's clock was ahead of the stamp, for it was set [s].
        #[serde(default, skip_serializing_if = "is_nothing")]
        ahead: f64,
    },
    /// Whoever speaks for all robots has come; open tasks were told of again.
    Joined {},
    /// The one that the node connects to is there, perhaps again; open tasks were told of
    /// again.
    Connected {},
    /// Some peer has come; it was told of open tasks as they stood.
    Welcomed {},
    /// A peer speaks for a robot from now on; its open tasks were told of again, but for those
    /// that were acknowledged.
    Spoken {
        /// The robot's place in the station, upstream first from 0.
        robot: usize,
    },
    /// A line was refused before it became a message.
    Refused {
        /// Why, as a status counts it.
        reason: String,
    },
    /// A status was asked for.
    Report {
        /// Whether it was the last.
        last: bool,
        /// Messages that waited to be sent.
        queued: u64,
    },
    /// With message time: no further message came.
    Finished {},
    /// From here on no task was given.
    Stopped {},
}

impl Event {
    /// All kinds, as they are written.
    pub const KINDS: [&str; 9] = [
        "step",
        "joined",
        "connected",
        "welcomed",
        "spoken",
        "refused",
        "report",
        "finished",
        "stopped",
    ];

    /// Its kind, as it is written.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Step { .. } => "step",
            Self::Joined {} => "joined",
            Self::Connected {} => "connected",
            Self::Welcomed {} => "welcomed",
            Self::Spoken { .. } => "spoken",
            Self::Refused { .. } => "refused",
            Self::Report { .. } => "report",
            Self::Finished {} => "finished",
            Self::Stopped {} => "stopped",
        }
    }
}

/// A time [s since 1970] rounded so that a recording gives it back to the bit: it is kept in
/// nanoseconds, more than a number of these days has digits for.
pub fn whole_microseconds(time: f64) -> f64 {
    (time * 1e6).round() / 1e6
}

fn is_nothing(ahead: &f64) -> bool {
    *ahead == 0.0
}

/// What was run: the first metadata of a recording, and all that it takes to run it again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Heading {
    /// Version of the recording's own topics and fields.
    pub recording: u64,
    /// Version of the protocol.
    pub protocol: u64,
    /// The program and its version.
    pub program: String,
    /// The command line.
    pub command: String,
    /// The station as TOML.
    pub station: String,
    /// Hash of the station.
    pub station_hash: String,
    /// The strategy as it is written after `--strategy`.
    pub strategy: String,
    /// Time for each decision of a strategy that looks ahead [ms], if it was limited.
    pub budget_ms: Option<f64>,
    /// Seed of everything random.
    pub seed: u64,
    /// `system` or `messages`.
    pub clock: String,
    /// As [`Config::tolerance`] [m].
    pub tolerance: f64,
    /// As [`Config::ack_timeout`] [s].
    pub ack_timeout: f64,
    /// As [`Config::result_timeout`] [s].
    pub result_timeout: f64,
    /// As [`Config::status_every`] [s].
    #[serde(default)]
    pub status_every: f64,
    /// As [`Timeouts::belt`] [s].
    #[serde(default)]
    pub belt_timeout: Option<f64>,
    /// As [`Timeouts::robot`] [s].
    #[serde(default)]
    pub robot_timeout: Option<f64>,
    /// As [`Config::camera_delay`] [s].
    #[serde(default)]
    pub camera_delay: f64,
    /// As [`Config::lead`] [s].
    #[serde(default)]
    pub lead: Vec<f64>,
    /// As [`Config::may_stop_belt`].
    #[serde(default)]
    pub may_stop_belt: bool,
    /// As [`Config::stop_margin`] [s].
    #[serde(default)]
    pub stop_margin: f64,
    /// When a state was taken up that a journal held [s since 1970]; with message time, or
    /// without a journal, none.
    pub restored_at: Option<f64>,
}

impl Heading {
    /// Version of what this module writes.
    pub const RECORDING: u64 = 1;

    /// The settings of a run.
    pub fn of(config: &Config) -> Self {
        Self {
            recording: Self::RECORDING,
            protocol: VERSION,
            program: String::new(),
            command: String::new(),
            station: String::new(),
            station_hash: String::new(),
            strategy: String::new(),
            budget_ms: None,
            seed: 0,
            clock: config.clock.name().to_owned(),
            tolerance: config.tolerance,
            ack_timeout: config.ack_timeout,
            result_timeout: config.result_timeout,
            status_every: config.status_every,
            belt_timeout: config.timeouts.belt,
            robot_timeout: config.timeouts.robot,
            camera_delay: config.camera_delay,
            lead: config.lead.clone(),
            may_stop_belt: config.may_stop_belt,
            stop_margin: config.stop_margin,
            restored_at: None,
        }
    }

    /// The configuration of the run; none where its clock is unknown.
    pub fn config(&self) -> Option<Config> {
        Some(Config {
            clock: ClockKind::named(&self.clock)?,
            tolerance: self.tolerance,
            ack_timeout: self.ack_timeout,
            result_timeout: self.result_timeout,
            status_every: self.status_every,
            timeouts: Timeouts {
                belt: self.belt_timeout,
                robot: self.robot_timeout,
            },
            camera_delay: self.camera_delay,
            lead: self.lead.clone(),
            may_stop_belt: self.may_stop_belt,
            stop_margin: self.stop_margin,
            ..Config::default()
        })
    }
}
