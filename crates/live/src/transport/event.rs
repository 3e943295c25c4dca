//! What comes into the inbox.

use super::connection::Connection;
use super::origin::Origin;
use crate::protocol::{Message, Rejected};
use pickline::error::Error;

/// An event from the peers.
#[derive(Debug)]
pub enum TransportEvent {
    /// A line of text, not yet decoded.
    Line(Origin, Vec<u8>),
    /// A message that did not come as a line. Its values are checked.
    Message(Origin, Box<Message>),
    /// Input that was refused before it became a line or a message.
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
    /// An error after which the transport cannot go on.
    Failed(Error),
}
