//! The counts. They only grow, with two exceptions: an item counted as missed that was picked after
//! all, and an item that turns out to be another one.

use super::fate::Fate;
use super::protocol::{MissedCounts, Rejection};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// Counts by kind of event.
type Counts = BTreeMap<Cow<'static, str>, u64>;

/// Whether nothing was counted. Lines on which every item is wanted keep their files.
fn is_none(count: &u64) -> bool {
    *count == 0
}

/// The counts so far.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(crate) struct Tally {
    /// Items seen.
    seen: u64,
    /// Fates of the forgotten items.
    picked: u64,
    #[serde(default, skip_serializing_if = "is_none")]
    unwanted: u64,
    missed: MissedCounts,
    rejected: Counts,
    noted: Counts,
}

impl Tally {
    /// Counts another item as seen.
    pub(crate) fn see(&mut self) {
        self.seen += 1;
    }

    /// Subtracts an item that turned out to be another one.
    pub(crate) fn unsee(&mut self) {
        self.seen = self.seen.saturating_sub(1);
    }

    /// Counts an event. Returns whether it is the first of its kind.
    pub(crate) fn note(&mut self, what: &'static str) -> bool {
        let count = self.noted.entry(what.into()).or_default();
        *count += 1;
        *count == 1
    }

    /// Counts a refused message.
    pub(crate) fn reject(&mut self, reason: Rejection) {
        *self.rejected.entry(reason.name().into()).or_default() += 1;
    }

    /// Counts an item with this fate that is forgotten.
    pub(crate) fn forget(&mut self, fate: Fate) {
        match fate {
            Fate::Picked => self.picked += 1,
            Fate::Unwanted => self.unwanted += 1,
            fate => {
                if let Some(count) = fate.count(&mut self.missed) {
                    *count += 1;
                }
            }
        }
    }

    /// Corrects the counts: a forgotten item that was missed or left as `fate` was picked after
    /// all.
    pub(crate) fn correct(&mut self, fate: Fate) {
        let count = match fate {
            Fate::Unwanted => Some(&mut self.unwanted),
            fate => fate.count(&mut self.missed),
        };
        if let Some(count) = count {
            *count = count.saturating_sub(1);
            self.picked += 1;
        }
    }

    /// Items seen so far.
    pub(crate) fn seen(&self) -> u64 {
        self.seen
    }

    /// The forgotten items: picked, and missed by reason.
    pub(crate) fn forgotten(&self) -> (u64, MissedCounts) {
        (self.picked, self.missed)
    }

    /// The forgotten items that were left on purpose.
    pub(crate) fn unwanted(&self) -> u64 {
        self.unwanted
    }

    /// Messages that were refused, by reason.
    pub(crate) fn rejected(&self) -> BTreeMap<String, u64> {
        by_name(&self.rejected)
    }

    /// Other counted events, by kind.
    pub(crate) fn noted(&self) -> BTreeMap<String, u64> {
        by_name(&self.noted)
    }
}

fn by_name(counts: &Counts) -> BTreeMap<String, u64> {
    let counts = counts.iter();
    counts
        .map(|(name, count)| (name.to_string(), *count))
        .collect()
}
