//! The refusal of a message: why, and what was expected instead.

use super::session::Hello;

/// Longer lines are refused unparsed [bytes].
pub(crate) const LONGEST_LINE: usize = 64 * 1024;

/// Why a message was refused.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, strum::EnumString, strum::IntoStaticStr,
)]
#[strum(serialize_all = "snake_case")]
#[non_exhaustive]
pub enum Rejection {
    /// The line is too long.
    TooLong,
    /// It is not UTF-8, or not a JSON object.
    Syntax,
    /// In the csv dialect: the checksum is wrong.
    Checksum,
    /// In the csv dialect: lines before it are missing.
    Sequence,
    /// It has another version of the protocol.
    Version,
    /// Its kind of message is unknown.
    Kind,
    /// A field is missing, unknown, repeated, or of the wrong type.
    Field,
    /// A value is out of its range.
    Value,
    /// The timestamp is too far from the present.
    Stamp,
    /// It names a robot that the station does not have.
    UnknownRobot,
    /// It names a task that was never given, or long ago.
    UnknownTask,
    /// The detection is past the belt's end or beside the belt.
    OffBelt,
    /// The node already keeps its maximum number of items.
    TooManyItems,
    /// The peer may not send this.
    NotAllowed,
}

impl Rejection {
    /// The reason with this name, if there is one.
    pub fn named(name: &str) -> Option<Self> {
        name.parse().ok()
    }

    /// The key in a status.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Whether such a line is not a message of this protocol at all, so that a peer that begins
    /// with it speaks something else.
    pub(crate) fn is_foreign(self) -> bool {
        matches!(
            self,
            Self::TooLong | Self::Syntax | Self::Version | Self::Kind
        )
    }
}

/// A message that was refused.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Rejected {
    /// The reason, for the counters.
    pub reason: Rejection,
    /// The explanation in one line: what was found and what was expected.
    pub message: String,
    /// Whether it was a hello, which is answered and ends the connection.
    pub is_hello: bool,
}

impl Rejected {
    /// A refusal with this reason and explanation.
    pub fn new(reason: Rejection, message: impl Into<String>) -> Self {
        Self {
            reason,
            message: message.into(),
            is_hello: false,
        }
    }

    /// The same refusal for a line of this kind of message.
    pub(super) fn of_kind(self, kind: &str) -> Self {
        let is_hello = kind == Hello::KIND;
        Self { is_hello, ..self }
    }

    /// The refusal of a line that is too long.
    pub fn too_long() -> Self {
        Self::new(
            Rejection::TooLong,
            format!(
                "the line is longer than {LONGEST_LINE} bytes; expected one JSON object per line"
            ),
        )
    }
}
