//! The lines of a journal: a checksum, a space, one JSON object.

use super::{LineState, StateChange};
use pickline::error::{Error, Result, shown};
use pickline::files::fingerprint;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Version of the format; its key marks the file as a journal.
pub(super) const FORMAT: u64 = 2;

/// The first line: the format, and the run that the journal belongs to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Header {
    /// Version of the format.
    pub journal: u64,
    /// Version of the protocol.
    pub protocol: u64,
    /// Hash of the station.
    pub station: String,
    /// The kind of clock.
    pub clock: String,
    /// The program that wrote it, and its version.
    pub program: String,
}

/// Any other line: a change of the state, with its number.
#[derive(Debug, Serialize, Deserialize)]
struct Numbered<C> {
    /// Number of the record, from 1, so that a missing line is noticed.
    n: u64,
    change: C,
}

/// The content of a journal.
#[derive(Debug)]
#[non_exhaustive]
pub struct JournalContents {
    /// The state after the last record.
    pub state: LineState,
    /// Number of records read.
    pub records: u64,
    /// Size of an incomplete last record [bytes]. Its messages were never sent.
    pub torn: usize,
}

/// The record with number `n`.
pub(super) fn numbered(n: u64, change: &StateChange) -> impl Serialize {
    Numbered { n, change }
}

/// A record as a line, with its line ending.
pub(super) fn line(record: &impl Serialize) -> String {
    // Plain structures with string keys always serialize.
    let json = serde_json::to_string(record).unwrap_or_default();
    format!("{} {json}\n", fingerprint(&json))
}

/// Reads a journal, whose header must match `expected`.
///
/// # Errors
/// The journal is of another station, clock or version, or a line is damaged.
pub(super) fn read(bytes: &[u8], expected: &Header) -> Result<JournalContents> {
    let mut lines = bytes.split_inclusive(|byte| *byte == b'\n');
    let first = lines.next().unwrap_or_default();
    let header: Header = whole(first).ok_or_else(|| {
        Error::input(
            "line 1",
            "is not the beginning of a journal",
            "give a journal that `pickline run` wrote with 'journal', or a file that does not exist yet",
        )
    })?;
    check(&header, expected)?;
    let mut reading = JournalContents {
        state: LineState::default(),
        records: 0,
        torn: 0,
    };
    let mut read = first.len();
    for (line, number) in lines.zip(2..) {
        let record = whole::<Numbered<StateChange>>(line).filter(|r| r.n == reading.records + 1);
        let Some(record) = record else {
            if reading.records > 0 && is_torn(line, &bytes[read + line.len()..]) {
                reading.torn = line.len();
                break;
            }
            return Err(Error::input(
                format!("line {number}"),
                "is damaged: it does not match its checksum",
                "restore a copy of the file; without one, clear the belt, make all robots idle, \
                 and move the file away to start over",
            ));
        };
        reading.state.apply(record.change);
        reading.records += 1;
        read += line.len();
    }
    if reading.records == 0 {
        return Err(Error::input(
            "line 2",
            "is missing: the file was truncated",
            "restore a copy of the file, or move it away to start over",
        ));
    }
    Ok(reading)
}

/// The record of a line, if the line is intact.
fn whole<R: DeserializeOwned>(line: &[u8]) -> Option<R> {
    let line = std::str::from_utf8(line.strip_suffix(b"\n")?).ok()?;
    let (sum, json) = line.split_once(' ')?;
    let record = (sum == fingerprint(json)).then(|| serde_json::from_str(json));
    record?.ok()
}

/// Whether an unreadable line was being written when the process or the machine stopped: it is the
/// last one, and has no line ending, or the system had only allocated the space for it.
fn is_torn(line: &[u8], rest: &[u8]) -> bool {
    rest.is_empty() && (!line.ends_with(b"\n") || line.contains(&0))
}

fn check(header: &Header, expected: &Header) -> Result<()> {
    let start_over = "give this run another journal, or move the file away to start over";
    let other = |what: &str, theirs: &str, ours: &str, cure: &str| {
        let theirs = shown(theirs);
        let problem = format!("the journal has {what} {theirs}, but this run has {ours}");
        Err(Error::input("line 1", problem, cure))
    };
    if header.journal != expected.journal {
        let (theirs, ours) = (header.journal.to_string(), expected.journal.to_string());
        return other("format", &theirs, &ours, start_over);
    }
    if header.protocol != expected.protocol {
        let (theirs, ours) = (header.protocol.to_string(), expected.protocol.to_string());
        return other("protocol version", &theirs, &ours, start_over);
    }
    if header.station != expected.station {
        let cure = format!("run with the station of the journal, or {start_over}");
        return other("station", &header.station, &expected.station, &cure);
    }
    if header.clock != expected.clock {
        let cure = format!("give 'clock' {}, or {start_over}", shown(&header.clock));
        return other("clock", &header.clock, &expected.clock, &cure);
    }
    Ok(())
}
