//! Live control: the node between the camera and the robots.
//!
//! The [`Controller`] is sans-IO: it takes messages and the time and returns messages. It has no
//! clock, thread, file or socket, so that every behaviour can be tested exactly.
//!
//! # Where to look
//!
//! - [`node::run`] runs a line with one call: the controller, its peers, its journal and its
//!   recording. [`node::NodeOptions`] and [`node::Connections`] say how; a [`node::NodeMonitor`] is
//!   told what happens.
//! - [`Controller`] with [`Config`], for programs that bring their own messages and time.
//! - [`protocol`] has the messages, [`transport`] carries them, [`emulator`] answers them in place of
//!   a real station.
//! - [`journal`] and `recording` keep a run: the one to resume it, the other to replay it.
//! - [`LineView`] and [`Trend`] are what a dashboard shows.
//!
//! # Features
//!
//! - `mcap` (default): recordings, and what reads them.
//! - `tls` (default): TLS with certificates of both sides, over TCP.
//! - `mqtt`: the live protocol over MQTT 5.
//! - `ros2`: the live protocol over ROS 2, without a ROS installation.

mod aim;
mod association;
mod belt;
mod claims;
mod clock;
mod controller;
mod decider;
mod doubts;
mod drive;
pub mod emulator;
mod fate;
mod features;
mod items;
pub mod journal;
mod latency;
pub mod layout;
mod lifecycle;
pub mod node;
mod operation;
pub mod protocol;
pub mod recording;
mod robots;
mod setting;
mod sight;
mod sources;
mod stamps;
mod state;
mod steady;
mod tally;
mod tasks;
pub mod transport;
mod trend;
mod view;
mod windows;
mod world;

pub use clock::ClockKind;
pub use controller::{Config, Controller, HandledAs, lead_times};
pub use decider::Stopwatch;
pub use latency::DecisionTimes;
pub use setting::RemarkSetting;
pub use sources::Timeouts;
pub use state::{LineState, StateChange};
pub use steady::{ClockReading, SteadyClock};
pub use trend::{Trend, TrendView};
pub use view::{ClaimView, ItemView, LineView};
