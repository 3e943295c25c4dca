//! How a result was made: enough to make it again, nothing that changes from run to
//! run, so that equal inputs give equal bytes.

use crate::files::fingerprint;
use crate::sim::Conditions;
use crate::station::{Station, to_toml};
use serde::Serialize;

/// Where a result comes from. No date, no machine, no thread count.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Provenance {
    /// Program and version.
    pub program: String,
    /// The command line, without what cannot change the result (threads, quietness,
    /// where and in which form it is written).
    pub command: String,
    /// The station in words.
    pub station: String,
    /// First 16 hexadecimal digits of the SHA-256 of the resolved station file.
    pub station_hash: String,
    /// What was simulated, in words, with its seed.
    pub patterns: String,
    /// What the camera saw and what went wrong, where it is not the plain model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conditions: Vec<String>,
    /// Master seed.
    pub seed: u64,
}

impl Provenance {
    /// Provenance of a result on `station`, which the user knows as `name`.
    pub fn new(command: &str, name: &str, station: &Station, patterns: &str, seed: u64) -> Self {
        Self {
            program: format!("pickline {}", env!("CARGO_PKG_VERSION")),
            command: command.to_owned(),
            station: format!(
                "{name}, {} robot(s), belt at {} m/s",
                station.robots().len(),
                station.belt().speed
            ),
            station_hash: station_hash(station),
            patterns: patterns.to_owned(),
            conditions: Vec::new(),
            seed,
        }
    }

    /// The same of a result under `conditions`.
    pub fn under(mut self, conditions: &Conditions) -> Self {
        self.conditions = conditions.describe();
        self
    }

    /// Everything on one line, for the last column of a CSV file.
    pub fn one_line(&self) -> String {
        format!(
            "{}; {}; station {} ({}); seed {}",
            self.program, self.command, self.station_hash, self.station, self.seed
        )
    }

    /// One line a fact, for the foot of a table.
    pub fn lines(&self) -> String {
        let conditions = match self.conditions.join("; ") {
            none if none.is_empty() => none,
            some => format!("under     {some}\n"),
        };
        format!(
            "station   {} (hash {})\npatterns  {}\n{conditions}made by   {}: {}\n",
            self.station, self.station_hash, self.patterns, self.program, self.command
        )
    }
}

/// Identifies a station by its resolved values, however they were given.
pub fn station_hash(station: &Station) -> String {
    fingerprint(&to_toml(station))
}
