//! The contents of a recording besides messages.

use crate::protocol::VERSION;
use crate::{ClockKind, Config, Timeouts};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What happens to the controller besides messages. The order of both determines its output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum RecordedEvent {
    /// With the system clock: the time was read, and what was due was done.
    Step {
        /// Timestamp [s since 1970].
        stamp: f64,
        /// Whether all robots were held, because no peer was there or all lagged behind.
        held: bool,
        /// If not all robots were held: the held ones, counted from 0, upstream first.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        held_robots: Vec<usize>,
        /// By how much the machine's clock was ahead of the timestamp because it was set [s].
        #[serde(default, skip_serializing_if = "is_nothing")]
        ahead: f64,
    },
    /// The peer that speaks for all robots has connected; open tasks were sent again.
    Joined {},
    /// The node has connected to its peer, perhaps again; open tasks were sent again.
    Connected {},
    /// A peer has connected and was sent the open tasks as they stood.
    Welcomed {},
    /// A peer speaks for a robot from now on; the robot's open tasks were sent again, except for
    /// acknowledged ones.
    Spoken {
        /// Index of the robot in the station, from 0, upstream first.
        robot: usize,
    },
    /// A line was refused before it was decoded.
    Refused {
        /// The reason, as counted in a status.
        reason: String,
    },
    /// A status was requested.
    Report {
        /// Whether it was the last one.
        last: bool,
        /// Messages waiting to be sent.
        queued: u64,
    },
    /// With message time: no further message came.
    Finished {},
    /// From then on no task was given.
    Stopped {},
}

impl RecordedEvent {
    /// Its value of `kind`.
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

/// A time [s since 1970] rounded so that a recording returns it bit-exactly. Recordings store
/// nanoseconds, which are finer than the precision of a present timestamp.
pub(crate) fn whole_microseconds(time: f64) -> f64 {
    (time * 1e6).round() / 1e6
}

fn is_nothing(ahead: &f64) -> bool {
    *ahead == 0.0
}

/// The settings of a run: the first metadata of a recording, with everything needed to run it
/// again.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Heading {
    /// Version of the recording's topics and fields.
    pub recording: u64,
    /// Version of the protocol.
    pub protocol: u64,
    /// The program and its version.
    pub program: String,
    /// The command line that started the run.
    pub command: String,
    /// The station as TOML.
    pub station: String,
    /// Hash of the station.
    pub station_hash: String,
    /// The strategy, as it was given.
    pub strategy: String,
    /// Time budget for each decision of a look-ahead strategy [ms], if there was one.
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
    /// As [`Config::min_detection`].
    #[serde(default)]
    pub min_detection: f64,
    /// When a state was restored from a journal [s since 1970]; none with message time or without a
    /// journal.
    pub restored_at: Option<f64>,
}

impl Heading {
    /// The version that this module writes.
    pub(crate) const RECORDING: u64 = 1;

    /// The settings of a run with this configuration; other fields are empty.
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
            min_detection: config.min_detection,
            restored_at: None,
        }
    }

    /// The configuration of the run; none if its clock is unknown.
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
            min_detection: self.min_detection,
            ..Config::default()
        })
    }
}
