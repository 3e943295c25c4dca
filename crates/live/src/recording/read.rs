//! Reads a recording, as far as it is intact.

use super::inflate::Inflate;
use super::{Heading, RecordedEvent, whole_microseconds};
use crate::protocol::{Incoming, VERSION, decode};
use crate::state::{LineState, StateChange};
use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use pickline::error::{Error, Result, shown};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{BufRead as _, BufReader, ErrorKind, Read as _};
use std::path::Path;

/// Maximum length of a record [bytes]; the state of a full belt is the longest.
const LONGEST: usize = 1 << 28;

/// An entry of a recording.
// Entries are passed on one at a time.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, PartialEq)]
pub enum RecordingEntry {
    /// A message arrived, at this time [s since 1970].
    In(Incoming, f64),
    /// A message was sent: its line, without the line ending.
    Out(String),
    /// An event that is not a message.
    Event(RecordedEvent),
}

/// How a recording ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordingEnd {
    /// Complete.
    Whole,
    /// It stops after a message: the run was killed or is still running.
    Open,
    /// It stops within a record.
    Torn,
}

/// A recording that is being read.
pub struct RecordingReader {
    name: String,
    file: Inflate<BufReader<File>>,
    reader: LinearReader,
    topics: HashMap<u16, String>,
    /// The MCAP profile of the file.
    profile: String,
    /// Time of the last message [ns], and whether any message was earlier than its predecessor.
    last: u64,
    is_unordered: bool,
    ending: RecordingEnd,
    entries: u64,
    /// The settings of the run.
    pub heading: Heading,
    /// The initial state of the run, if a journal held one.
    pub state: Option<LineState>,
    first: Option<RecordingEntry>,
}

impl RecordingReader {
    /// Opens a recording.
    ///
    /// # Errors
    /// The file cannot be read, is not an MCAP file, or is not a recording of this version.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|error| Error::read(path, error))?;
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(LONGEST);
        let mut file = BufReader::new(file);
        let head = file.fill_buf().map_err(|error| Error::read(path, error))?;
        check_not_compressed(head, path)?;
        let mut reader = Self {
            name: path.display().to_string(),
            file: Inflate::new(file),
            reader: LinearReader::new_with_options(options),
            topics: HashMap::new(),
            profile: String::new(),
            last: 0,
            is_unordered: false,
            ending: RecordingEnd::Open,
            entries: 0,
            heading: Heading::of(&crate::Config::default()),
            state: None,
            first: None,
        };
        reader.heading = reader.read_heading()?;
        reader.first = match reader.part()? {
            Some(McapPart::Metadata(name, fields)) if name == "state" => {
                let text = fields.get("state").map_or("", String::as_str);
                let change: StateChange = serde_json::from_str(text).map_err(|error| {
                    let problem = format!("has an invalid state: {error}");
                    not_a_recording(&reader.name, problem).caused_by(error)
                })?;
                let mut state = LineState::default();
                state.apply(change);
                reader.state = Some(state);
                None
            }
            Some(McapPart::Entry(entry)) => Some(entry),
            _ => None,
        };
        Ok(reader)
    }

    /// Reads the heading, which comes first.
    fn read_heading(&mut self) -> Result<Heading> {
        let place = self.name.clone();
        let wrong = |problem: String| not_a_recording(&place, problem);
        let (name, fields) = match self.part() {
            Ok(Some(McapPart::Metadata(name, fields))) => (name, fields),
            Err(_) if self.profile.starts_with("ros") => return Err(ros_bag(&place)),
            Err(error) if self.entries == 0 => return Err(error),
            // Messages come first, whether they are of the protocol or not.
            _ if self.profile.starts_with("ros") => return Err(ros_bag(&place)),
            Ok(Some(McapPart::Entry(_))) | Err(_) => return Err(without_heading(&place)),
            Ok(None) => return Err(wrong("is not a recording of pickline".into())),
        };
        if name == "rosbag2" || self.profile.starts_with("ros") {
            return Err(ros_bag(&place));
        }
        let heading = (name == "pickline").then(|| heading(&fields)).flatten();
        let heading = heading.ok_or_else(|| wrong("is not a recording of pickline".into()))?;
        let versions = (heading.recording, heading.protocol);
        if versions != (Heading::RECORDING, VERSION) {
            return Err(wrong(format!(
                "is a recording of version {} with protocol {}; this program reads version {} with \
                 protocol {VERSION}",
                versions.0,
                versions.1,
                Heading::RECORDING,
            )));
        }
        Ok(heading)
    }

    /// How the recording ends; known once there is no further entry.
    pub fn ending(&self) -> RecordingEnd {
        self.ending
    }

    /// Warnings about the file, complete once there is no further entry.
    pub fn doubts(&self) -> Vec<&'static str> {
        let damaged = self.file.is_damaged().then_some(
            "the checksum of the file is wrong: it was damaged or changed; restore a copy",
        );
        let unordered = self.is_unordered.then_some(
            "its messages are not in the order of their log times and are replayed in file order; \
             `mcap sort` sorts them",
        );
        damaged.into_iter().chain(unordered).collect()
    }

    /// The next entry; none at the end.
    ///
    /// # Errors
    /// The file cannot be read or is damaged, or a message is invalid.
    pub fn next_entry(&mut self) -> Result<Option<RecordingEntry>> {
        if let Some(entry) = self.first.take() {
            return Ok(Some(entry));
        }
        loop {
            match self.part()? {
                None => return Ok(None),
                Some(McapPart::Entry(entry)) => return Ok(Some(entry)),
                Some(McapPart::Metadata(..)) => {}
            }
        }
    }

    /// Where the reader is, for an error.
    fn place(&self) -> String {
        format!("{}, after message {}", self.name, self.entries)
    }

    fn damaged(&self, problem: &str) -> Error {
        Error::input(self.place(), problem, "restore a copy of the file")
    }

    /// The error for a file that the parser cannot read on.
    fn unreadable(&self, error: &McapError) -> Error {
        if let McapError::UnsupportedCompression(name) = error {
            let problem = format!(
                "is an MCAP file whose chunks are compressed as `{}`; this program reads lz4 and \
                 zstd",
                shown(name)
            );
            let cure = "compress it with one of these, for example with `mcap compress`";
            return Error::input(self.place(), problem, cure);
        }
        if matches!(error, McapError::BadMagic) || self.entries == 0 {
            let problem = format!("is not an MCAP file: {error}");
            let cure = "give a file that `pickline run` wrote with 'record'";
            return Error::input(self.place(), problem, cure);
        }
        self.damaged(&format!("is damaged: {error}"))
    }

    /// The next entry or metadata.
    fn part(&mut self) -> Result<Option<McapPart>> {
        loop {
            let event = match self.reader.next_event() {
                None => {
                    if self.ending == RecordingEnd::Open && self.file.is_torn() {
                        self.ending = RecordingEnd::Torn;
                    }
                    return Ok(None);
                }
                Some(Err(McapError::UnexpectedEof)) if self.entries > 0 => {
                    self.ending = RecordingEnd::Torn;
                    return Ok(None);
                }
                Some(Err(error)) => return Err(self.unreadable(&error).caused_by(error)),
                Some(Ok(event)) => event,
            };
            let record = match event {
                LinearReadEvent::ReadRequest(need) => {
                    let read = self.file.read(self.reader.insert(need));
                    let read = read.map_err(|error| match error.kind() {
                        ErrorKind::InvalidData => {
                            let damaged = self.damaged(&format!("is damaged: {error}"));
                            damaged.caused_by(error)
                        }
                        _ => Error::read(Path::new(&self.name), error),
                    })?;
                    self.reader.notify_read(read);
                    continue;
                }
                LinearReadEvent::Record { opcode, data } => mcap::parse_record(opcode, data),
            };
            let record = match record {
                Ok(record) => record,
                Err(error) => return Err(self.damaged(&error.to_string())),
            };
            match record {
                Record::Header(header) => self.profile = header.profile,
                Record::Channel(channel) => {
                    self.topics.insert(channel.id, channel.topic);
                }
                Record::Metadata(metadata) => {
                    return Ok(Some(McapPart::Metadata(metadata.name, metadata.metadata)));
                }
                Record::Message { header, data } => {
                    self.entries += 1;
                    self.is_unordered |= header.log_time < self.last;
                    self.last = self.last.max(header.log_time);
                    let topic = self.topics.get(&header.channel_id);
                    let topic = topic.map_or("", String::as_str);
                    let found = entry(topic, &data, header.log_time).map_err(|error| {
                        error.inside(&format!("{}, message {}", self.name, self.entries))
                    })?;
                    if let Some(entry) = found {
                        return Ok(Some(McapPart::Entry(entry)));
                    }
                }
                Record::Footer(_) => self.ending = RecordingEnd::Whole,
                _ => {}
            }
        }
    }
}

/// Checks that a file that begins with `head` is not compressed as a whole.
fn check_not_compressed(head: &[u8], path: &Path) -> Result<()> {
    let kinds: [(&[u8], &str, &str); 4] = [
        (b"\x1f\x8b", "gzip", "gunzip"),
        (b"\x28\xb5\x2f\xfd", "zstd", "unzstd"),
        (b"\x04\x22\x4d\x18", "lz4", "unlz4"),
        (b"PK\x03\x04", "zip", "unzip"),
    ];
    match kinds.iter().find(|(magic, ..)| head.starts_with(magic)) {
        Some((_, kind, tool)) => Err(Error::input(
            path.display().to_string(),
            format!("the whole file is compressed with {kind}"),
            format!("decompress it first, for example with `{tool}`"),
        )),
        None => Ok(()),
    }
}

fn not_a_recording(place: &str, problem: String) -> Error {
    let cure = "give a file that `pickline run` wrote with 'record'";
    Error::input(place, problem, cure)
}

fn ros_bag(place: &str) -> Error {
    Error::input(
        place,
        "is a ROS bag, not a recording of pickline",
        "give a file that `pickline run` wrote with 'record'; to play a bag to a line, use `ros2 bag \
         play` and `pickline run` with 'ros2'",
    )
}

/// The error for an MCAP file of another program, with the topics of a recording but no metadata.
fn without_heading(place: &str) -> Error {
    Error::input(
        place,
        "is an MCAP file with messages only: the station, strategy and settings at the start of a \
         recording are missing",
        "give a file that `pickline run` wrote with 'record'; to play the messages to a line, print \
         those under /in/ as JSON, one per line, and pipe them to `pickline run` with 'clock' messages",
    )
}

// Entries are passed on one at a time.
#[allow(clippy::large_enum_variant)]
enum McapPart {
    Metadata(String, BTreeMap<String, String>),
    Entry(RecordingEntry),
}

/// A log time [ns] in seconds, rounded as by [`whole_microseconds`].
fn received(log_time: u64) -> f64 {
    whole_microseconds(log_time as f64 / 1e9)
}

/// A message as an entry; none for a topic that another program has added.
fn entry(topic: &str, data: &[u8], log_time: u64) -> Result<Option<RecordingEntry>> {
    let wrong = |problem: String| {
        let cure = "restore the file as `pickline run` wrote it";
        Error::input(topic, problem, cure)
    };
    if topic.starts_with("/in/") {
        let message = decode(data).map_err(|rejected| wrong(rejected.message))?;
        return Ok(Some(RecordingEntry::In(message, received(log_time))));
    }
    if topic.starts_with("/out/") {
        let line = String::from_utf8(data.to_vec());
        let line = line.map_err(|_| wrong("is not UTF-8 text".into()))?;
        return Ok(Some(RecordingEntry::Out(line)));
    }
    if topic.starts_with("/node/") {
        let event = serde_json::from_slice(data);
        let event = event.map_err(|error: serde_json::Error| {
            wrong(shown(&error.to_string())).caused_by(error)
        })?;
        return Ok(Some(RecordingEntry::Event(event)));
    }
    Ok(None)
}

/// The heading in the metadata, if it is valid.
fn heading(fields: &BTreeMap<String, String>) -> Option<Heading> {
    const TEXTS: [&str; 6] = [
        "program",
        "command",
        "station",
        "station_hash",
        "strategy",
        "clock",
    ];
    let mut object = Map::new();
    for (name, text) in fields {
        let value = if TEXTS.contains(&name.as_str()) {
            Value::String(text.clone())
        } else {
            serde_json::from_str(text).ok()?
        };
        object.insert(name.clone(), value);
    }
    serde_json::from_value(Value::Object(object)).ok()
}
