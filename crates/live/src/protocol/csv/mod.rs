//! The csv dialect, for controllers without JSON: short lines of fixed fields, with a sequence
//! number and a checksum. `docs/dialect-csv.md` describes it.
//!
//! A line stands for a message of the protocol. One table ([`table`]) converts it to that message's
//! JSON and back, so that one decoder checks both.

mod fields;
mod frame;
mod read;
mod table;
mod write;
#[cfg(test)]
mod tests;

use pickline::error::{Error, Result, shown, shown_number};
use pickline::station::Station;

pub(crate) use read::{CsvLine, CsvReader};
pub(crate) use write::CsvWriter;

/// Maximum length of a line [characters], including its line ending.
pub(super) const LONGEST_CSV_LINE: usize = 80;
/// Maximum length of a robot's name [characters].
const LONGEST_ROBOT: usize = 8;
/// Maximum length of a belt [m], because positions must fit into their fields.
const LONGEST_BELT: f64 = 99.0;

/// Checks that every message about `station` fits into a line.
///
/// # Errors
/// A name or a belt that is too long.
pub fn check_station(station: &Station) -> Result<()> {
    for robot in station.robots() {
        let name = &robot.name;
        if name.len() > LONGEST_ROBOT || *name != fields::plain(name, LONGEST_ROBOT) {
            return Err(Error::usage(
                "'dialect'",
                format!(
                    "`{}` is not a valid robot name in the csv dialect",
                    shown(name)
                ),
                format!(
                    "rename the robot in the station file: at most {LONGEST_ROBOT} ASCII \
                     characters, without comma, semicolon or asterisk"
                ),
            ));
        }
    }
    let length = station.belt().length;
    if length > LONGEST_BELT {
        return Err(Error::usage(
            "'dialect'",
            format!(
                "a belt of {} m is too long for the csv dialect",
                shown_number(length)
            ),
            format!("use JSON, or a belt of at most {LONGEST_BELT} m"),
        ));
    }
    Ok(())
}
