//! Writes a recording during a run.

use super::{Heading, RecordedEvent};
use crate::protocol::{self, Incoming, Outgoing, VERSION};
use crate::state::StateChange;
use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, McapResult, WriteOptions, Writer};
use pickline::error::{Error, Result};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};

/// Interval of flushes to the file [s]: this much is lost if the process is killed.
const FLUSH: f64 = 1.0;

/// A recording that is being written.
pub(crate) struct Recorder {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    channels: HashMap<String, Channel>,
    /// Time of the last flush [s since 1970].
    flushed: f64,
    /// Whether nothing was recorded since the last flush.
    is_flushed: bool,
}

#[derive(Debug, Clone, Copy)]
struct Channel {
    id: u16,
    messages: u32,
}

impl Recorder {
    /// Starts a recording, with the initial state of the run if a journal held one.
    ///
    /// # Errors
    /// The file already exists or cannot be created.
    pub(crate) fn create(
        path: &Path,
        heading: &Heading,
        state: Option<&StateChange>,
    ) -> Result<Self> {
        let file = File::options().write(true).create_new(true).open(path);
        let file = file.map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists if !path.is_file() => Error::path(
                format!("'record' {}", path.display()),
                "is not a regular file",
                "give the recording a separate file",
            ),
            ErrorKind::AlreadyExists => Error::path(
                format!("'record' {}", path.display()),
                "the file already exists, and a recording does not replace files",
                "give another name, or move the file away",
            ),
            _ => Error::write(path, error),
        })?;
        // Chunks reach the file as a whole, so that it can be read up to the last one however the
        // process ends. Without compression it can be read up to the last record.
        let options = WriteOptions::new()
            .compression(None)
            .profile("")
            .library(heading.program.clone())
            .disable_seeking(true);
        let begun = options.create(BufWriter::new(file)).and_then(|writer| {
            let mut recorder = Self {
                path: path.to_owned(),
                writer,
                channels: HashMap::new(),
                flushed: 0.0,
                is_flushed: true,
            };
            recorder.begin(heading, state)?;
            Ok(recorder)
        });
        begun.map_err(|error| cannot_write(path, error))
    }

    fn begin(&mut self, heading: &Heading, state: Option<&StateChange>) -> McapResult<()> {
        self.writer.write_metadata(&Metadata {
            name: "pickline".into(),
            metadata: texts(heading),
        })?;
        if let Some(state) = state {
            let text = serde_json::to_string(state).unwrap_or_default();
            self.writer.write_metadata(&Metadata {
                name: "state".into(),
                metadata: BTreeMap::from([("state".to_owned(), text)]),
            })?;
        }
        let version = BTreeMap::from([("version".to_owned(), VERSION.to_string())]);
        for (topics, schemas) in [
            ("/in/", protocol::schemas_of::<Incoming>()),
            ("/out/", protocol::schemas_of::<Outgoing>()),
            ("/node/", protocol::schemas_of::<RecordedEvent>()),
        ] {
            for (kind, schema) in schemas {
                let (name, schema) = (format!("pickline.{kind}"), schema.to_string());
                let schema = self
                    .writer
                    .add_schema(&name, "jsonschema", schema.as_bytes())?;
                let topic = format!("{topics}{kind}");
                let id = self.writer.add_channel(schema, &topic, "json", &version)?;
                self.channels.insert(topic, Channel { id, messages: 0 });
            }
        }
        self.writer.flush()
    }

    /// Records a message that arrived at `now` [s since 1970].
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn record_incoming(&mut self, message: &Incoming, now: f64) -> Result<()> {
        let line = protocol::encode(message);
        self.write("/in/", message.kind(), &line, message.stamp(), now)
    }

    /// Records a message that is sent at `now` [s since 1970].
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn record_outgoing(&mut self, message: &Outgoing, now: f64) -> Result<()> {
        let line = protocol::encode(message);
        self.write("/out/", message.kind(), &line, message.stamp(), now)
    }

    /// Records an event at `now` [s since 1970].
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn record_event(&mut self, event: &RecordedEvent, now: f64) -> Result<()> {
        let line = protocol::encode(event);
        self.write("/node/", event.kind(), &line, now, now)
    }

    fn write(&mut self, topics: &str, kind: &str, line: &str, stamp: f64, now: f64) -> Result<()> {
        let written = match self.channels.get_mut(&format!("{topics}{kind}")) {
            None => return Ok(()),
            Some(channel) => {
                let header = MessageHeader {
                    channel_id: channel.id,
                    sequence: channel.messages,
                    log_time: nanoseconds(now),
                    publish_time: nanoseconds(stamp),
                };
                channel.messages = channel.messages.wrapping_add(1);
                let data = line.trim_end().as_bytes();
                self.writer.write_to_known_channel(&header, data)
            }
        };
        self.is_flushed = false;
        written.map_err(|error| cannot_write(&self.path, error))?;
        self.flush(now)
    }

    /// Flushes to the file if it is time; `now` is the present time [s since 1970].
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn flush(&mut self, now: f64) -> Result<()> {
        // The machine's clock may have been set back.
        let is_time = now - self.flushed >= FLUSH || now < self.flushed;
        if self.is_flushed || !is_time {
            return Ok(());
        }
        (self.flushed, self.is_flushed) = (now, true);
        let flushed = self.writer.flush();
        flushed.map_err(|error| cannot_write(&self.path, error))
    }

    /// Ends the recording and writes its index.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn finish(mut self) -> Result<()> {
        let finished = self.writer.finish();
        finished.map_err(|error| cannot_write(&self.path, error))?;
        Ok(())
    }
}

fn cannot_write(path: &Path, error: McapError) -> Error {
    match error {
        McapError::Io(error) => Error::write(path, error),
        other => Error::write(path, std::io::Error::other(other.to_string())),
    }
}

/// Timestamps are at least 0; `protocol` checks that.
fn nanoseconds(seconds: f64) -> u64 {
    (seconds * 1e9).round() as u64
}

/// A structure's fields as strings, for metadata; fields without a value are omitted.
fn texts(heading: &Heading) -> BTreeMap<String, String> {
    let fields = match serde_json::to_value(heading) {
        Ok(Value::Object(fields)) => fields,
        // A plain structure always serializes to an object.
        _ => Map::new(),
    };
    let fields = fields.into_iter().filter(|(_, value)| !value.is_null());
    let text = |value: Value| match value {
        Value::String(text) => text,
        other => other.to_string(),
    };
    fields.map(|(name, value)| (name, text(value))).collect()
}
