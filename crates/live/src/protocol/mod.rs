//! What crosses the wire: one JSON object a line, typed, versioned and limited.
//!
//! `docs/protocol.md` describes every message; its JSON Schema is made from these types.
//! Lengths are in metres and times in seconds, positions in the belt frame.

mod check;
mod csv;
mod decode;
mod fields;
mod incoming;
mod message;
mod outgoing;
mod schema;
mod session;

pub use check::LARGEST_STAMP;
pub use csv::{CsvLine, CsvReader, CsvWriter, LONGEST_CSV_LINE, check_station};
pub use decode::{
    LONGEST_LINE, Rejected, Rejection, Said, decode, decode_answer, decode_outgoing, decode_said,
};
pub use incoming::{
    Ack, BeltState, Detection, Incoming, Order, Place, Report, RobotState, RobotStatus, Verdict,
};
pub use message::Message;
pub use outgoing::{
    BeltRequest, Cancel, Due, Latency, MissedCounts, Outgoing, Point, RobotReport, SourceKind,
    SourceReport, Status, Task, encode,
};
pub use schema::{schema, schemas_of};
pub use session::{Answer, Hello, Role};

/// Version of the protocol, `v` of every message. It grows when a message changes so that
/// an old reader would misread it; fields may be added without.
pub const VERSION: u64 = 1;
