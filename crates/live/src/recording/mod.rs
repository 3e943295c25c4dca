//! Recordings: every message in and out of a run, in an MCAP file, so that the run can be
//! looked at in the usual tools and run again.
//!
//! Each kind of message has a topic of its own, `/in/detection` or `/out/task`, as JSON
//! with its JSON Schema. What else decides what the controller says, the looks at the
//! clock above all, is recorded as [`Event`]s on `/node/...`; what the run was, and the
//! state it began with, as metadata. Log times are those of the machine, publish times the
//! stamps of the messages.

mod event;
#[cfg(feature = "mcap")]
mod inflate;
#[cfg(feature = "mcap")]
mod read;
#[cfg(feature = "mcap")]
mod write;

pub use event::{Event, Heading, whole_microseconds};
#[cfg(feature = "mcap")]
pub use read::{Ending, Entry, Reader};
#[cfg(feature = "mcap")]
pub use write::Recorder;
