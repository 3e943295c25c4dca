//! One of the shards of a call.

use crate::error::{Error, Result, shown};
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Most shards of one call: more are treated as a typing mistake.
const MOST_SHARDS: usize = 1_000_000;

/// Shard `index` of `count`. Shard 0 does the shared work only, so that the others need not repeat it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Shard {
    index: usize,
    count: usize,
}

impl Shard {
    /// Shard `index`, from 0 to `count`.
    ///
    /// # Errors
    /// No shards, too many, or an index above their number.
    pub fn new(index: usize, count: usize) -> Result<Self> {
        let cure = "give I/N with I from 1 to N, such as 3/8, or 0/N for what all shards share";
        if !(1..=MOST_SHARDS).contains(&count) {
            let problem = format!("{count} is not a number of shards from 1 to {MOST_SHARDS}");
            return Err(Error::usage("'shard'", problem, cure));
        }
        if index > count {
            let problem = format!("there is no shard {index} of {count}");
            return Err(Error::usage("'shard'", problem, cure));
        }
        Ok(Self { index, count })
    }

    /// Its number, from 1; 0 for the shared work only.
    pub fn index(self) -> usize {
        self.index
    }

    /// The number of shards that own units.
    pub fn count(self) -> usize {
        self.count
    }

    /// Whether it owns unit `unit`: shards take turns, so that each gets about as much of everything.
    pub fn owns(self, unit: usize) -> bool {
        self.index > 0 && unit % self.count == self.index - 1
    }

    /// Those of `units` units that it owns if each shard gets neighbours: where units that follow each
    /// other need the same shared work.
    pub fn neighbours(self, units: usize) -> Range<usize> {
        match self.index {
            0 => 0..0,
            index => units * (index - 1) / self.count..units * index / self.count,
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for Shard {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let parts = text.split_once('/');
        let parts = parts.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
        let (index, count) = parts.ok_or_else(|| {
            Error::usage(
                "'shard'",
                format!("`{}` is not a shard", shown(text)),
                "give I/N with I from 1 to N, such as 3/8, or 0/N for what all shards share",
            )
        })?;
        Self::new(index, count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_has_one_owner() {
        for (count, units) in [(1, 5), (3, 10), (7, 3), (4, 4)] {
            let shards: Vec<Shard> = (0..=count).map(|i| Shard::new(i, count).unwrap()).collect();
            for unit in 0..units {
                let owners = shards.iter().filter(|shard| shard.owns(unit)).count();
                let near = shards
                    .iter()
                    .filter(|s| s.neighbours(units).contains(&unit));
                assert_eq!(
                    (owners, near.count()),
                    (1, 1),
                    "{unit} of {units} in {count}"
                );
            }
            let sizes = shards[1..].iter().map(|s| s.neighbours(units).len());
            let (least, most) = (sizes.clone().min().unwrap(), sizes.max().unwrap());
            assert!(most - least <= 1, "{least} {most}");
        }
    }

    #[test]
    fn shards_are_written_as_a_fraction() {
        for text in ["1/1", "0/4", "3/8", "8/8"] {
            assert_eq!(text.parse::<Shard>().unwrap().to_string(), text);
        }
        for (text, words) in [
            ("", "`` is not a shard"),
            ("3", "`3` is not a shard"),
            ("3/", "`3/` is not a shard"),
            ("-1/3", "`-1/3` is not a shard"),
            ("1.5/3", "`1.5/3` is not a shard"),
            ("9/8", "no shard 9 of 8"),
            ("1/0", "0 is not a number of shards"),
            ("1/1000001", "1000001 is not a number of shards"),
        ] {
            let message = text.parse::<Shard>().unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
            assert!(message.contains("such as 3/8"), "{message}");
        }
    }
}
