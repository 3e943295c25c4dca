//! The transports: JSON Lines over stdin and stdout and over TCP, MQTT, and ROS 2.
//!
//! The messages of all peers come in through one inbox: as lines of the protocol, or over ROS 2 as
//! messages whose values are checked in the same way. Messages from the node go to the peers that should get them. Every
//! queue is bounded. A TCP peer that reads nothing is disconnected; its unacknowledged tasks are
//! sent again to the peer that speaks for the robot next. Other peers cannot be disconnected: while
//! their queue is more than half full no task is given, and what must not be lost is kept.

mod access;
mod connection;
mod descriptors;
mod dialect;
mod endpoint;
mod event;
#[cfg(test)]
#[allow(
    dead_code,
    unreachable_pub,
    reason = "the tests of crates/cli use all of it"
)]
#[path = "../../../../tests/common/gate.rs"]
mod gate;
mod hub;
mod identity;
mod lines;
#[cfg(feature = "mqtt")]
pub mod mqtt;
mod origin;
mod peer;
#[cfg(feature = "ros2")]
pub mod ros2;
mod stream;
mod tcp;
pub mod tls;

use pickline::error::{Error, Result, shown};
use std::net::TcpListener;
use std::time::Duration;

pub use access::{Access, Token};
pub use descriptors::is_short as is_short_of_descriptors;
pub use dialect::Dialect;
pub use endpoint::Endpoint;
pub use event::TransportEvent;
pub(crate) use hub::HelloOutcome;
pub use hub::{Hub, HubOptions};
pub use origin::Origin;

/// Size of the inbox, for all peers together; readers wait when it is full.
const INBOX_CAPACITY: usize = 1024;
/// Time between two attempts to connect.
const RETRY_INTERVAL: Duration = Duration::from_millis(200);

/// Which of the two programs this is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The node: it receives the station's messages and sends tasks.
    Node,
    /// A station: the opposite.
    Station,
}

/// Listens at `address`, which the setting `place` gives.
///
/// # Errors
/// The address is invalid, not of this machine, or in use.
pub fn listen_at(place: &str, address: &str) -> Result<TcpListener> {
    TcpListener::bind(address).map_err(|error| {
        let cure = "give HOST:PORT of this machine with a free port, or port 0 for any";
        Error::usage(place, format!("{}: {error}", shown(address)), cure).caused_by(error)
    })
}
