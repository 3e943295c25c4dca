//! The dialect of a peer on a stream: JSON or csv.

use super::lines::InputLine;
use super::{Origin, TransportEvent};
use crate::protocol::{CsvLine, CsvReader, CsvWriter, Message, Rejected, encode};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Reads the time [s]; passed in by the caller, which knows the kind of clock.
pub(super) type ReadClock = fn() -> f64;

/// The format of lines.
#[derive(Debug, Clone, Copy, Default)]
pub enum Dialect {
    /// One JSON object per line.
    #[default]
    Json,
    /// The csv dialect, with the clock for omitted times, if there is one. With a peer that begins
    /// in JSON, JSON is used.
    Csv(Option<ReadClock>),
}

impl Dialect {
    /// The reader and the writer for one peer.
    pub fn reader_and_writer(self) -> (DialectReader, DialectWriter) {
        let is_json = Arc::new(AtomicBool::new(matches!(self, Self::Json)));
        let reader = DialectReader {
            dialect: self,
            is_json: Arc::clone(&is_json),
            is_new: true,
            csv: CsvReader::default(),
        };
        let csv = CsvWriter::default();
        (reader, DialectWriter { is_json, csv })
    }

    /// Whether a stream that begins with these bytes, ignoring blanks, may be from a peer, not from
    /// a browser, a scanner or TLS.
    pub fn may_begin(self, bytes: &[u8]) -> bool {
        let is_csv = matches!(self, Self::Csv(_));
        match bytes.trim_ascii_start() {
            [] | [b'{', ..] => true,
            [letter] | [letter, b',', ..] => is_csv && letter.is_ascii_uppercase(),
            _ => false,
        }
    }
}

/// Reads the lines of a peer.
#[derive(Debug)]
pub struct DialectReader {
    dialect: Dialect,
    is_json: Arc<AtomicBool>,
    is_new: bool,
    csv: CsvReader,
}

impl DialectReader {
    /// The JSON of a line, and whether lines are missing before it.
    fn read(&mut self, line: InputLine) -> CsvLine {
        let line = match line {
            InputLine::Whole(line) => Ok(line),
            InputLine::TooLong => Err(Rejected::too_long()),
        };
        let is_new = std::mem::replace(&mut self.is_new, false);
        match (self.dialect, line) {
            (Dialect::Csv(clock), Ok(line)) => {
                if is_new && line.trim_ascii_start().starts_with(b"{") {
                    self.is_json.store(true, Ordering::Relaxed);
                }
                if self.is_json.load(Ordering::Relaxed) {
                    return CsvLine::of(Ok(line));
                }
                self.csv.read(&line, clock.map(|clock| clock()))
            }
            (_, line) => CsvLine::of(line),
        }
    }

    /// The contents of a line from `origin`, for the inbox.
    pub fn events(
        &mut self,
        origin: &Origin,
        line: InputLine,
    ) -> impl Iterator<Item = TransportEvent> + use<> {
        let CsvLine { gap, message } = self.read(line);
        let gap = gap.map(|gap| TransportEvent::Refused(origin.clone(), gap));
        let message = match message {
            Ok(line) => TransportEvent::Line(origin.clone(), line),
            Err(rejected) => TransportEvent::Refused(origin.clone(), rejected),
        };
        gap.into_iter().chain([message])
    }
}

/// Writes messages to a peer.
#[derive(Debug)]
pub struct DialectWriter {
    is_json: Arc<AtomicBool>,
    csv: CsvWriter,
}

impl DialectWriter {
    /// A message as text, with its line endings.
    ///
    /// # Errors
    /// The message does not fit into the dialect; the error is a text for the user.
    pub fn write(&mut self, message: &Message) -> Result<String, String> {
        if self.is_json.load(Ordering::Relaxed) {
            return Ok(encode(message));
        }
        self.csv.write(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::{Due, Outgoing};

    #[test]
    fn a_peer_is_answered_as_it_begins() {
        let due = Message::from(Outgoing::Due(Due {
            stamp: 1.0,
            next: None,
        }));
        let (mut reader, mut writer) = Dialect::Csv(None).reader_and_writer();
        assert!(writer.write(&due).unwrap().starts_with("U,0,1000,*"));
        let json = br#"{"kind":"tick","stamp":1}"#.to_vec();
        assert_eq!(
            reader.read(InputLine::Whole(json.clone())),
            CsvLine::of(Ok(json.clone()))
        );
        assert!(writer.write(&due).unwrap().starts_with('{'));
        // A peer that began in the other dialect must stay with it.
        let (mut reader, mut writer) = Dialect::Csv(None).reader_and_writer();
        assert!(
            reader
                .read(InputLine::Whole(b"K,0,1000*1".to_vec()))
                .message
                .is_err()
        );
        assert!(reader.read(InputLine::Whole(json)).message.is_err());
        assert!(writer.write(&due).unwrap().starts_with("U,"));
    }

    #[test]
    fn unknown_peers_are_recognised_by_their_first_line() {
        let csv = Dialect::Csv(None);
        for bytes in [&b"K,0,1"[..], b"K", b"\r\n", b" {", b""] {
            assert!(csv.may_begin(bytes));
        }
        for bytes in [&b"GET / HTTP/1.1"[..], b"\x16\x03\x01", b"k,0"] {
            assert!(!csv.may_begin(bytes) && !Dialect::Json.may_begin(bytes));
        }
        assert!(!Dialect::Json.may_begin(b"K,0,1"));
    }
}
