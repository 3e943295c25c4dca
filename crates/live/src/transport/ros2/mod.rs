//! ROS 2, over DDS without a ROS installation: the messages as typed topics.
//!
//! The line is a peer that is kept: it is up while somebody listens to the tasks. What is
//! heard is turned into lines of the protocol, so that one decoder judges all transports.
//! DDS acknowledges only that a reader has got a message, so tasks are still acknowledged
//! by their robots and sent again until they are.

mod check;
mod incoming;
pub mod messages;
mod node;
mod outgoing;
mod rivals;
mod turns;
mod wires;

use super::peer::Peer;
use super::{Heard, Side};
use pickline::error::Result;
use std::net::IpAddr;
use std::sync::mpsc::SyncSender;

/// How to talk in a ROS 2 graph.
#[derive(Debug, Clone)]
pub struct Settings {
    /// DDS domain.
    pub domain: u16,
    /// What all topics begin with, `/` and a name.
    pub namespace: String,
    /// The frame of all places: the belt's.
    pub frame: String,
    /// Addresses of this machine whose networks are used.
    pub networks: Vec<IpAddr>,
    /// Whether publishers of detections need not be reliable.
    pub best_effort: bool,
    /// Which of the two programs this is.
    pub side: Side,
    /// Whether the two take turns, as with message time.
    pub turns: bool,
}

/// Starts talking in a ROS 2 graph.
///
/// # Errors
/// Names that are none, a network that is not there.
pub(super) fn start(number: u64, settings: &Settings, inbox: SyncSender<Heard>) -> Result<Peer> {
    check::check(settings)?;
    node::start(number, settings, inbox)
}
