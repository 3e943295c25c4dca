//! The frame of every line: a checksum at its end and a sequence number.

use super::super::rejection::{Rejected, Rejection};
use super::LONGEST_CSV_LINE;
use pickline::error::shown;

/// Number of sequence numbers; they are below this.
pub(super) const NUMBERS: u16 = 1000;

/// Fletcher's checksum of 16 bits (J. G. Fletcher, "An arithmetic checksum for serial
/// transmissions", IEEE Transactions on Communications 30(1), 1982,
/// <https://doi.org/10.1109/TCOM.1982.1095369>): it needs only additions and remainders, and
/// detects swapped characters, which a plain sum does not.
pub(super) fn checksum(text: &[u8]) -> u16 {
    let (mut low, mut high) = (0u16, 0u16);
    for byte in text {
        low = (low + u16::from(*byte)) % 255;
        high = (high + low) % 255;
    }
    high * 256 + low
}

/// `text` as a line, with its checksum and line ending.
pub(super) fn framed(text: &str) -> String {
    format!("{text}*{:05}\r\n", checksum(text.as_bytes()))
}

/// Checks a line, given without its line ending, and returns its fields.
///
/// # Errors
/// The line is too long, is not ASCII, or has a wrong checksum.
pub(super) fn opened(line: &[u8]) -> Result<Vec<&str>, Rejected> {
    let line = line.trim_ascii();
    if line.len() > LONGEST_CSV_LINE {
        let problem = format!(
            "the line is longer than {LONGEST_CSV_LINE} characters; expected a shorter one"
        );
        return Err(Rejected::new(Rejection::TooLong, problem));
    }
    let text = std::str::from_utf8(line)
        .ok()
        .filter(|text| text.is_ascii());
    let Some((text, said)) = text.and_then(|text| text.rsplit_once('*')) else {
        let start = shown(&String::from_utf8_lossy(line));
        let problem = format!("`{start}`; expected ASCII fields, an asterisk and the checksum");
        return Err(Rejected::new(Rejection::Syntax, problem));
    };
    let right = checksum(text.as_bytes());
    if said.trim().parse() != Ok(right) {
        let said = shown(said);
        let problem = format!("the checksum is `{said}`; expected {right:05}");
        return Err(Rejected::new(Rejection::Checksum, problem));
    }
    // Controllers pad numbers with spaces.
    Ok(text.split(',').map(str::trim).collect())
}

/// Checks the sequence numbers of one direction.
#[derive(Debug, Default)]
pub(super) struct Sequence {
    expected: Option<u16>,
}

impl Sequence {
    /// Checks the number of the next line, which may be empty.
    ///
    /// # Errors
    /// Lines are missing before this one, which itself is still accepted; or the number is invalid.
    pub(super) fn follow(&mut self, number: &str) -> Result<(), Rejected> {
        if number.is_empty() {
            return Ok(());
        }
        let found = number.parse::<u16>().ok();
        let Some(found) = found.filter(|found| *found < NUMBERS) else {
            let problem = format!(
                "the sequence number is `{}`; expected 0 to 999",
                shown(number)
            );
            return Err(Rejected::new(Rejection::Field, problem));
        };
        let expected = self.expected.replace((found + 1) % NUMBERS);
        match expected {
            Some(expected) if expected != found => {
                let missing = (found + NUMBERS - expected) % NUMBERS;
                let problem = format!(
                    "the sequence number is {found}, {missing} too high: lines are missing, or \
                     their sender has restarted its count; expected {expected}"
                );
                Err(Rejected::new(Rejection::Sequence, problem))
            }
            _ => Ok(()),
        }
    }
}
