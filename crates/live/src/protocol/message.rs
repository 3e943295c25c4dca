//! A message in either direction, as a transport carries it.

use super::session::{Hello, HelloAnswer};
use super::{Incoming, Outgoing};
use serde::Serialize;

/// A message in either direction.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Message {
    /// To the node.
    ToNode(Incoming),
    /// From the node.
    FromNode(Outgoing),
    /// A hello to the node. Only streams carry it.
    Hello(Tagged<Hello>),
    /// The answer to a hello. Only streams carry it.
    Answer(Tagged<HelloAnswer>),
}

/// A message that is not a variant of a tagged enumeration, with its kind.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tagged<M> {
    kind: &'static str,
    #[serde(flatten)]
    message: M,
}

impl From<Hello> for Message {
    fn from(message: Hello) -> Self {
        let kind = Hello::KIND;
        Self::Hello(Tagged { kind, message })
    }
}

impl From<HelloAnswer> for Message {
    fn from(message: HelloAnswer) -> Self {
        let kind = Hello::KIND;
        Self::Answer(Tagged { kind, message })
    }
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
