//! Reads lines of limited length from any stream.

use crate::protocol::LONGEST_LINE;
use std::io::{BufRead, ErrorKind, Result};

/// A line, without its line ending.
#[derive(Debug, PartialEq, Eq)]
pub enum InputLine {
    /// All bytes of the line.
    Whole(Vec<u8>),
    /// It was too long and was skipped.
    TooLong,
}

/// Assembles lines from bytes that come in parts.
#[derive(Debug, Default)]
pub(super) struct LineSplitter {
    line: Vec<u8>,
    too_long: bool,
    /// Number of lines so far, including blank ones.
    number: u64,
}

impl LineSplitter {
    /// Consumes bytes up to the end of the next non-blank line, and returns its number, from 1, and
    /// the line; none if the bytes end before. A line that is too long takes no extra memory.
    pub(super) fn next(&mut self, bytes: &mut &[u8]) -> Option<(u64, InputLine)> {
        while !bytes.is_empty() {
            let end = bytes.iter().position(|byte| *byte == b'\n');
            let part = &bytes[..end.unwrap_or(bytes.len())];
            if self.line.len() + part.len() > LONGEST_LINE {
                self.too_long = true;
                self.line.clear();
            } else if !self.too_long {
                self.line.extend_from_slice(part);
            }
            *bytes = &bytes[end.map_or(bytes.len(), |end| end + 1)..];
            if end.is_some()
                && let Some(line) = self.end()
            {
                return Some(line);
            }
        }
        None
    }

    /// Ends the line at the end of the stream; none if it is blank.
    pub(super) fn end(&mut self) -> Option<(u64, InputLine)> {
        self.number += 1;
        let line = std::mem::take(&mut self.line);
        if std::mem::take(&mut self.too_long) {
            return Some((self.number, InputLine::TooLong));
        }
        (!line.trim_ascii().is_empty()).then_some((self.number, InputLine::Whole(line)))
    }
}

/// The lines of a stream.
#[derive(Debug)]
pub(super) struct LineReader<R> {
    stream: R,
    splitter: LineSplitter,
}

impl<R: BufRead> LineReader<R> {
    /// The lines of `stream`.
    pub(super) fn new(stream: R) -> Self {
        let splitter = LineSplitter::default();
        Self { stream, splitter }
    }

    /// Reads the next non-blank line; none at the end.
    ///
    /// # Errors
    /// The stream cannot be read.
    pub(super) fn next(&mut self) -> Result<Option<(u64, InputLine)>> {
        loop {
            let bytes = match self.stream.fill_buf() {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            if bytes.is_empty() {
                return Ok(self.splitter.end());
            }
            let mut rest = bytes;
            let line = self.splitter.next(&mut rest);
            let used = bytes.len() - rest.len();
            self.stream.consume(used);
            if line.is_some() {
                return Ok(line);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_skipped_and_the_stream_goes_on() {
        let long = "x".repeat(10_000_000);
        let text = format!("a\n\n{long}\r\nb\r\n{}\nlast", "y".repeat(LONGEST_LINE));
        let mut lines = LineReader::new(std::io::BufReader::new(text.as_bytes()));
        let mut next = || lines.next().unwrap();
        assert_eq!(next(), Some((1, InputLine::Whole(b"a".to_vec()))));
        assert_eq!(next(), Some((3, InputLine::TooLong)));
        assert_eq!(next(), Some((4, InputLine::Whole(b"b\r".to_vec()))));
        assert!(matches!(next(), Some((5, InputLine::Whole(line))) if line.len() == LONGEST_LINE));
        assert_eq!(next(), Some((6, InputLine::Whole(b"last".to_vec()))));
        assert_eq!(next(), None);
    }
}
