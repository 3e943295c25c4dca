//! ROS 2 over DDS, without a ROS installation: messages as typed topics.
//!
//! The graph is a permanent peer, which is up while a node subscribes to the tasks. Received
//! messages are converted to lines of the protocol, so that one decoder checks all transports. DDS
//! only acknowledges that a reader has received a message, so robots still acknowledge tasks, which
//! are sent again until they do.

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

/// Settings for a ROS 2 graph.
#[derive(Debug, Clone)]
pub struct Settings {
    /// DDS domain.
    pub domain: u16,
    /// Namespace of all topics: `/` and a name.
    pub namespace: String,
    /// The frame of all positions: the belt's.
    pub frame: String,
    /// Addresses of this machine in the networks to use.
    pub networks: Vec<IpAddr>,
    /// Whether detections are also accepted from best-effort publishers.
    pub best_effort: bool,
    /// Which of the two programs this is.
    pub side: Side,
    /// Whether node and station take turns, as with message time.
    pub turns: bool,
}

/// Joins a ROS 2 graph.
///
/// # Errors
/// A name or a network is invalid.
pub(super) fn start(number: u64, settings: &Settings, inbox: SyncSender<Heard>) -> Result<Peer> {
    check::check(settings)?;
    node::start(number, settings, inbox)
}
