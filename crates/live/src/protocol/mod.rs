//! The messages on the wire: one JSON object per line, typed, versioned and limited.
//!
//! `docs/protocol.md` describes every message; the JSON Schema is generated from these types.
//! Lengths are in metres and times in seconds, positions in the belt frame.

mod check;
mod csv;
mod decode;
mod fields;
mod incoming;
mod message;
mod outgoing;
#[cfg(feature = "mcap")]
mod plain_schema;
mod rejection;
mod schema;
mod session;

#[cfg(feature = "ros2")]
pub(crate) use check::check_values;
pub use csv::check_station;
pub(crate) use csv::{CsvLine, CsvReader, CsvWriter};
pub(crate) use decode::{PeerMessage, decode_said};
pub use decode::{decode, decode_answer, decode_outgoing};
pub use incoming::{
    Ack, BeltState, Detection, FoundPlace, Incoming, Order, ResultMessage, RobotState, RobotStatus,
    Verdict,
};
pub use message::Message;
pub use outgoing::{
    BeltPoint, BeltRequest, Cancel, Due, Latency, MissedCounts, Outgoing, RobotCounts, SourceKind,
    SourceReport, Status, Task, encode,
};
#[cfg(feature = "mcap")]
pub(crate) use plain_schema::schemas_of;
pub(crate) use rejection::LONGEST_LINE;
pub use rejection::{Rejected, Rejection};
pub use schema::schema;
pub use session::{Hello, HelloAnswer, Role};

/// Version of the protocol, the `v` of every message. It increases when a message changes in a way
/// that an old reader would misread; fields may be added without a new version.
pub const VERSION: u64 = 1;
