//! JSON Lines over stdin and stdout, and over TCP.
//!
//! What all peers say comes in one after another, as lines of the protocol, so that one
//! decoder judges them all; what is said goes to those whom it concerns. Every queue is
//! bounded. A TCP peer that takes nothing is disconnected: the tasks that it has not
//! acknowledged are sent again to whoever speaks for the robot next. Others cannot be
//! disconnected: while a queue is more than half full no task is given, and what must not
//! be lost is kept.

mod access;
mod descriptors;
mod dialect;
#[cfg(test)]
pub mod gate;
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
use crate::protocol::Rejected;
use std::net::TcpListener;
use std::time::Duration;
use tcp::Connection;

pub use access::{Access, Token};
pub use descriptors::is_short as is_short_of_descriptors;
pub use dialect::Dialect;
pub use hub::{Greeted, Hub, Terms};
pub use origin::Origin;

/// Lines read and not yet handled, of all peers together; readers wait beyond.
const INBOX: usize = 1024;
/// Time between two tries to connect.
const RETRY: Duration = Duration::from_millis(200);

/// What is heard of the peers.
#[derive(Debug)]
pub enum Heard {
    /// A line.
    Line(Origin, Vec<u8>),
    /// Something that was refused before it became a line.
    Refused(Origin, Rejected),
    /// A peer has connected.
    Joined(Connection),
    /// A peer says no more.
    Left(u64),
    /// A peer takes nothing any more.
    Stalled(u64),
    /// A peer has begun with something that is no message, which begins like this.
    Foreign(u64, String),
    /// A peer that is kept is there, perhaps again, and has perhaps not heard what was said.
    Up(u64),
    /// A peer that is kept is not there for the moment.
    Down(u64),
    /// Who was at a peer that is kept says no more; others may come.
    Ended(u64),
    /// Something that the user should know.
    Remark(String),
    /// It cannot go on.
    Failed(Error),
}

/// Which of the two programs this is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The node: it hears the station and sends tasks.
    Node,
    /// A station: the other way round.
    Station,
}

/// Where the peers are.
#[derive(Debug, Clone)]
pub enum Place {
    /// One peer, on stdin and stdout.
    Stdio,
    /// Whoever connects to this address.
    Listen(String),
    /// The one that listens at this address.
    Connect(String),
    /// Whoever talks to this broker.
    #[cfg(feature = "mqtt")]
    Mqtt(Box<mqtt::Settings>),
    /// Whoever is in this ROS 2 graph.
    #[cfg(feature = "ros2")]
    Ros2(Box<ros2::Settings>),
}

/// Listens at `address`, which was given by `flag`.
///
/// # Errors
/// An address that is none, is not of this machine or is taken.
pub fn listen_at(flag: &str, address: &str) -> Result<TcpListener> {
    TcpListener::bind(address).map_err(|error| {
        let cure = "give HOST:PORT of this machine with a free port, or port 0 for any";
        Error::input(flag, format!("{}: {error}", shown(address)), cure)
    })
}
