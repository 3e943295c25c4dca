//! A message of either direction, as a transport carries it.

use super::{Incoming, Outgoing};
use serde::Serialize;

/// A message of either direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Message {
    /// To the node.
    ToNode(Incoming),
    /// From the node.
    FromNode(Outgoing),
}

impl From<Incoming> for Message {
    fn from(message: Incoming) -> Self {
        Self::ToNode(message)
    }
}

impl From<Outgoing> for Message {
    fn from(message: Outgoing) -> Self {
        Self::FromNode(message)
    }
}
