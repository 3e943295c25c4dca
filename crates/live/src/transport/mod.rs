//! The transports: JSON Lines over stdin and stdout and over TCP, MQTT, and ROS 2.
//!
//! The messages of all peers come in through one inbox, as lines of the protocol, so that one
//! decoder checks them all. Messages from the node go to the peers that should get them. Every
//! queue is bounded. A TCP peer that reads nothing is disconnected; its unacknowledged tasks are
//! sent again to the peer that speaks for the robot next. Other peers cannot be disconnected: while
//! their queue is more than half full no task is given, and what must not be lost is kept.

mod access;
mod descriptors;
mod dialect;
#[cfg(test)]
#[allow(dead_code, reason = "the tests of crates/cli use all of it")]
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

use crate::protocol::Rejected;
use pickline::error::{Error, Result, shown};
use std::net::TcpListener;
use std::time::Duration;
use tcp::Connection;

pub use access::{Access, Token};
pub use descriptors::is_short as is_short_of_descriptors;
pub use dialect::Dialect;
pub use hub::{Greeted, Hub, Terms};
pub use origin::Origin;

/// Size of the inbox, for all peers together; readers wait when it is full.
const INBOX: usize = 1024;
/// Time between two attempts to connect.
const RETRY: Duration = Duration::from_millis(200);

/// An event from the peers.
#[derive(Debug)]
pub enum Heard {
    /// A line.
    Line(Origin, Vec<u8>),
    /// Input that was refused before it became a line.
    Refused(Origin, Rejected),
    /// A peer has connected.
    Joined(Connection),
    /// A peer has ended its stream.
    Left(u64),
    /// A peer no longer reads.
    Stalled(u64),
    /// A peer began with something other than a message; the text is its beginning.
    Foreign(u64, String),
    /// A permanent peer is reachable, perhaps again, and may have missed messages.
    Up(u64),
    /// A permanent peer is unreachable at the moment.
    Down(u64),
    /// The other side of a permanent peer has ended; others may come.
    Ended(u64),
    /// A remark for the user.
    Remark(String),
    /// A fatal error.
    Failed(Error),
}

/// Which of the two programs this is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The node: it receives the station's messages and sends tasks.
    Node,
    /// A station: the opposite.
    Station,
}

/// Where the peers are.
#[derive(Debug, Clone)]
pub enum Place {
    /// One peer, on stdin and stdout.
    Stdio,
    /// All peers that connect to this address.
    Listen(String),
    /// The peer that listens at this address.
    Connect(String),
    /// All clients of this broker.
    #[cfg(feature = "mqtt")]
    Mqtt(Box<mqtt::Settings>),
    /// All nodes of this ROS 2 graph.
    #[cfg(feature = "ros2")]
    Ros2(Box<ros2::Settings>),
}

/// Listens at `address`, which was given with `flag`.
///
/// # Errors
/// The address is invalid, not of this machine, or in use.
pub fn listen_at(flag: &str, address: &str) -> Result<TcpListener> {
    TcpListener::bind(address).map_err(|error| {
        let cure = "give HOST:PORT of this machine with a free port, or port 0 for any";
        Error::input(flag, format!("{}: {error}", shown(address)), cure)
    })
}
