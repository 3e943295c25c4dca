//! The identity of a peer on a stream: its hello, and the node's answer.
//!
//! These messages are not about the line, so the controller never sees them. Recordings omit them,
//! because a hello may contain the token.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The role of a peer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// It sees items. It is sent statuses.
    Camera,
    /// It knows how the belt moves. It is sent statuses.
    Encoder,
    /// It speaks for robots. It is sent their tasks and cancels, and statuses.
    Robot,
    /// It pauses, resumes, drains and stops the line. It is sent statuses.
    Operator,
    /// It is sent everything and may send nothing.
    Observer,
}

impl Role {
    /// The value of `role`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Encoder => "encoder",
            Self::Robot => "robot",
            Self::Operator => "operator",
            Self::Observer => "observer",
        }
    }
}

/// The identity of a peer: the first line that it sends.
#[derive(Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Hello {
    /// Timestamp [s]; ignored.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stamp: Option<f64>,
    /// Its name, for remarks and as a source.
    pub name: String,
    /// Its role.
    pub role: Role,
    /// The robots that it speaks for, by their names in the station file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<String>,
    /// The shared token, if the node requires one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub token: Option<String>,
}

impl Hello {
    /// Its value of `kind`.
    pub(crate) const KIND: &str = "hello";
}

/// Without the token, which must not get into a log.
impl std::fmt::Debug for Hello {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Hello")
            .field("name", &self.name)
            .field("role", &self.role)
            .field("robots", &self.robots)
            .finish_non_exhaustive()
    }
}

/// The node's answer to a hello, and its last message to a peer that it disconnects.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "Answer")]
pub struct HelloAnswer {
    /// Whether the peer may stay.
    pub accepted: bool,
    /// The reason if it may not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// The robots of the node's station, upstream first, if the peer may stay.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<String>,
}

/// What a peer sends besides the line's messages; only for the schema.
#[derive(JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[expect(dead_code, reason = "only its schema is made")]
pub(super) enum ToNode {
    /// The identity of a peer: the first line that it sends.
    Hello(Hello),
}

/// What the node sends besides the line's messages; only for the schema.
#[derive(JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[expect(dead_code, reason = "only its schema is made")]
pub(super) enum FromNode {
    /// The answer to a hello, and the last message to a peer that is disconnected.
    Hello(HelloAnswer),
}
