//! The origin of a message, for reports to the user.

use pickline::error::shown;
use std::fmt;
use std::net::SocketAddr;
use std::sync::Arc;

/// The origin of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Origin {
    /// A line of a stream.
    Line {
        /// Number of the connection.
        connection: u64,
        /// Address of the sender; none is stdin.
        peer: Option<SocketAddr>,
        /// Line number in that connection, from 1.
        number: u64,
    },
    /// A topic of MQTT or ROS 2; the peers that publish on it are not told apart.
    Topic(Arc<str>),
}

impl Origin {
    /// The sender, independent of line and connection: stdin, a host or a topic.
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
