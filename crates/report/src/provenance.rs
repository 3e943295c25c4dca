//! How a result was made: enough to reproduce it, and nothing that changes from run to run, so
//! that equal inputs give equal bytes.

use pickline::error::counted;
use pickline::files::{csv_comment, fingerprint};
use pickline::sim::Conditions;
use pickline::station::{Station, station_hash};
use serde::Serialize;

/// Where a result comes from. No date, no machine, no thread count.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Provenance {
    /// Name and version of the program, for example `pickline 0.1.0`.
    pub program: String,
    /// The command line, without options that cannot change the result (threads, quietness,
    /// output path and format).
    pub command: String,
    /// Description of the station.
    pub station: String,
    /// First 16 hexadecimal digits of the SHA-256 of the resolved station file.
    pub station_hash: String,
    /// Description of what was simulated, with its seed.
    pub patterns: String,
    /// What the camera saw and what went wrong, if not the plain model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub conditions: Vec<String>,
    /// Master seed of everything random in the result; omitted if nothing is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// How far the run got if the user stopped it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub partial: Option<String>,
}

impl Provenance {
    /// Provenance of a result on `station`, which the user calls `name`.
    pub fn new(command: &str, name: &str, station: &Station, patterns: &str, seed: u64) -> Self {
        Self {
            program: format!("pickline {}", env!("CARGO_PKG_VERSION")),
            command: command.to_owned(),
            station: format!(
                "{name}, {}, belt at {} m/s",
                counted(station.robots().len(), "robot"),
                station.belt().speed
            ),
            station_hash: station_hash(station),
            patterns: patterns.to_owned(),
            conditions: Vec::new(),
            seed: Some(seed),
            partial: None,
        }
    }

    /// Provenance of a result on `set`, instances with a station each.
    pub fn of_stations<'s>(
        command: &str,
        set: &str,
        stations: impl Iterator<Item = &'s Station>,
        seed: u64,
    ) -> Self {
        let hashes: Vec<String> = stations.map(station_hash).collect();
        Self {
            program: format!("pickline {}", env!("CARGO_PKG_VERSION")),
            command: command.to_owned(),
            station: "one for each instance".into(),
            station_hash: fingerprint(hashes.join("\n")),
            patterns: set.to_owned(),
            conditions: Vec::new(),
            seed: Some(seed),
            partial: None,
        }
    }

    /// The same for a result without anything random.
    #[must_use]
    pub fn without_seed(self) -> Self {
        Self { seed: None, ..self }
    }

    /// The same for a result with only `done` of `planned` parts, named `what`. If all are
    /// done, nothing changes; only the first call has an effect.
    pub fn of_parts(mut self, done: usize, planned: usize, what: &str) -> Self {
        if done < planned && self.partial.is_none() {
            self.partial = Some(format!("interrupted, with {done} of {planned} {what} done"));
        }
        self
    }

    /// The same for a result without a part of its work, if `without` says which.
    #[must_use]
    pub fn without(mut self, without: Option<&str>) -> Self {
        self.partial = without.map(str::to_owned).or(self.partial);
        self
    }

    /// The same for a result under `conditions`.
    pub fn under(self, conditions: &Conditions) -> Self {
        self.under_facts(conditions.describe())
    }

    /// The same for a result under conditions in words, one text per fact.
    pub fn under_facts(mut self, conditions: Vec<String>) -> Self {
        self.conditions = conditions;
        self
    }

    /// The comment lines at the top of a CSV file, one fact each. The command comes first, to
    /// show which subcommand wrote the file.
    pub fn csv_comment(&self) -> String {
        let facts = format!(
            "{}\nprogram: {}\nstation: {} (hash {})\npatterns: {}\n",
            self.command, self.program, self.station, self.station_hash, self.patterns
        );
        let conditions = self.conditions.iter().map(|c| format!("under: {c}\n"));
        let partial = self.partial.iter().map(|p| format!("partial: {p}\n"));
        let seed = self.seed.iter().map(|seed| format!("seed: {seed}\n"));
        let more = conditions.chain(seed).chain(partial);
        csv_comment(&(facts + &more.collect::<String>()))
    }

    /// Everything on one line, for the description of a picture.
    pub fn one_line(&self) -> String {
        let partial = match &self.partial {
            Some(partial) => format!("; {partial}"),
            None => String::new(),
        };
        let seed = self
            .seed
            .map_or(String::new(), |seed| format!("; seed {seed}"));
        format!(
            "{}; {}; station {} ({}){seed}{partial}",
            self.program, self.command, self.station_hash, self.station
        )
    }

    /// One line per fact, for the end of a table.
    pub fn lines(&self) -> String {
        let conditions = match self.conditions.join("; ") {
            none if none.is_empty() => none,
            some => format!("under     {some}\n"),
        };
        let partial = match &self.partial {
            Some(partial) => format!("partial   {partial}\n"),
            None => String::new(),
        };
        format!(
            "{partial}station   {} (hash {})\npatterns  {}\n{conditions}made by   {}: {}\n",
            self.station, self.station_hash, self.patterns, self.program, self.command
        )
    }
}
