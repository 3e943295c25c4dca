//! ROS 2 over DDS, without a ROS installation: messages as typed topics.
//!
//! The graph is a permanent peer, which is up while a node subscribes to the tasks. Received
//! messages are converted to those of the protocol; the values are held to the same ranges. DDS
//! only acknowledges that a reader has received a message, so robots still acknowledge tasks, which
//! are sent again until they do.

mod check;
mod incoming;
pub mod messages;
mod node;
mod outgoing;
mod other_nodes;
mod settings;
mod turns;
mod topics;

use super::TransportEvent;
use super::peer::Peer;
use pickline::error::Result;
use std::sync::mpsc::SyncSender;

pub use settings::Ros2Settings;

/// Joins a ROS 2 graph.
///
/// # Errors
/// A name or a network is invalid.
pub(super) fn start(
    number: u64,
    settings: &Ros2Settings,
    inbox: SyncSender<TransportEvent>,
) -> Result<Peer> {
    check::check(settings)?;
    node::start(number, settings, inbox)
}
