//! Lines of limited length from any stream.

use crate::live::protocol::LONGEST_LINE;
use std::io::{BufRead, ErrorKind, Result};

/// One line, without its line end.
#[derive(Debug, PartialEq, Eq)]
pub enum Line {
    /// The line.
    Whole(Vec<u8>),
    /// It was longer than a line may be, and was skipped.
    TooLong,
}

/// The lines of a stream.
#[derive(Debug)]
pub struct Lines<R> {
    stream: R,
    /// Lines read so far, blank ones with them.
    number: u64,
}

impl<R: BufRead> Lines<R> {
    /// The lines of `stream`.
    pub fn new(stream: R) -> Self {
        Self { stream, number: 0 }
    }

    /// Reads the next line that is not blank, and says which it is, from 1; none at the
    /// end. A line that is too long takes no more memory than one that is not.
    ///
    /// # Errors
    /// A stream that cannot be read.
    pub fn next(&mut self) -> Result<Option<(u64, Line)>> {
        let mut line = Vec::new();
        let mut too_long = false;
        loop {
            let bytes = match self.stream.fill_buf() {
                Ok(bytes) => bytes,
                Err(error) if error.kind() == ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            let is_end = bytes.is_empty();
            let end = bytes.iter().position(|byte| *byte == b'\n');
            let part = &bytes[..end.unwrap_or(bytes.len())];
            if line.len() + part.len() > LONGEST_LINE {
                too_long = true;
                line.clear();
            } else if !too_long {
                line.extend_from_slice(part);
            }
            let used = end.map_or(bytes.len(), |end| end + 1);
            self.stream.consume(used);
            if !is_end && end.is_none() {
                continue;
            }
            self.number += 1;
            if too_long {
                return Ok(Some((self.number, Line::TooLong)));
            }
            if !line.trim_ascii().is_empty() {
                return Ok(Some((self.number, Line::Whole(line))));
            }
            if is_end {
                return Ok(None);
            }
            line.clear();
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
        let mut lines = Lines::new(std::io::BufReader::new(text.as_bytes()));
        let mut next = || lines.next().unwrap();
        assert_eq!(next(), Some((1, Line::Whole(b"a".to_vec()))));
        assert_eq!(next(), Some((3, Line::TooLong)));
        assert_eq!(next(), Some((4, Line::Whole(b"b\r".to_vec()))));
        assert!(matches!(next(), Some((5, Line::Whole(line))) if line.len() == LONGEST_LINE));
        assert_eq!(next(), Some((6, Line::Whole(b"last".to_vec()))));
        assert_eq!(next(), None);
    }
}
