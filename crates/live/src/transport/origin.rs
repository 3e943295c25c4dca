//! Where a message came from, as the user is told.

use pickline::error::shown;
use std::fmt;
use std::net::SocketAddr;
use std::sync::Arc;

/// Where a message came from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// A line of a stream.
    Line {
        /// Number of the connection.
        connection: u64,
        /// Who sent it; none is stdin.
        peer: Option<SocketAddr>,
        /// Which line of that connection, from 1.
        number: u64,
    },
    /// A topic.
    Topic(Arc<str>),
}

impl Origin {
    /// Who sent it, whichever line and connection it was: stdin, a host or a topic.
    pub fn sender(&self) -> String {
        match self {
            Self::Line { peer: None, .. } => "stdin".to_owned(),
            Self::Line {
                peer: Some(peer), ..
            } => peer.ip().to_string(),
            Self::Topic(_) => self.to_string(),
        }
    }
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line {
                peer: None, number, ..
            } => write!(f, "stdin line {number}"),
            Self::Line {
                peer: Some(peer),
                number,
                ..
            } => write!(f, "{peer} line {number}"),
            Self::Topic(topic) => write!(f, "topic {}", shown(topic)),
        }
    }
}
