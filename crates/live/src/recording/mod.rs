//! Recordings: every message in and out of a run, in an MCAP file, so that the run can be viewed
//! with common tools and replayed.
//!
//! Each kind of message has its own topic, such as `/in/detection` or `/out/task`, as JSON with its
//! JSON Schema. Everything else that determines the controller's output, mainly the readings of the
//! clock, is recorded as [`RecordedEvent`]s on `/node/...`. The settings of the run and its initial state
//! are metadata. Log times are by the machine's clock, publish times are the messages' timestamps.

mod event;
#[cfg(feature = "mcap")]
mod inflate;
#[cfg(feature = "mcap")]
mod moves;
#[cfg(feature = "mcap")]
mod read;
#[cfg(feature = "mcap")]
mod write;

pub(crate) use event::whole_microseconds;
pub use event::{Heading, RecordedEvent};
#[cfg(feature = "mcap")]
pub use moves::{RecordedMoves, read_recorded_moves};
#[cfg(feature = "mcap")]
pub use read::{RecordingEnd, RecordingEntry, RecordingReader};
#[cfg(feature = "mcap")]
pub(crate) use write::Recorder;
