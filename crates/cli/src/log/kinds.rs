//! Summing up repeated remarks of the same kind.

use super::LogLevel;
use pickline::error::grouped;
use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

/// Maximum number of distinct kinds; all further kinds are treated as one.
const MOST_KINDS: usize = 256;
/// Maximum time between two summaries of a kind that keeps repeating.
const LONGEST: Duration = Duration::from_secs(60);

/// The kinds of recent remarks.
#[derive(Debug)]
pub(super) struct Kinds {
    table: BTreeMap<String, Kind>,
    first_sum: Duration,
}

#[derive(Debug)]
struct Kind {
    /// Number of remarks that were not printed.
    more: u64,
    /// The last of those.
    last: (LogLevel, String),
    /// When the next summary is due.
    due: Instant,
    /// Time from that summary to the one after it.
    pause: Duration,
}

impl Kinds {
    /// No kinds yet. The first summary of a kind is due `first_sum` after its first remark.
    pub(super) fn new(first_sum: Duration) -> Self {
        Self {
            table: BTreeMap::new(),
            first_sum,
        }
    }

    /// Counts a remark, and returns it if it should be printed, as the first of its kind in a
    /// while.
    pub(super) fn note(
        &mut self,
        now: Instant,
        level: LogLevel,
        kind: &str,
        text: &str,
    ) -> Option<String> {
        let is_known = self.table.contains_key(kind) || self.table.len() < MOST_KINDS;
        // Beyond the limit, all new kinds share one entry.
        let kind = if is_known { kind } else { "" };
        if let Some(known) = self.table.get_mut(kind) {
            known.more += 1;
            known.last = (level, text.to_owned());
            return None;
        }
        let new = Kind {
            more: 0,
            last: (level, String::new()),
            due: now + self.first_sum,
            pause: self.first_sum,
        };
        self.table.insert(kind.to_owned(), new);
        Some(text.to_owned())
    }

    /// When the next summary is due.
    pub(super) fn next_due(&self) -> Option<Instant> {
        self.table.values().map(|kind| kind.due).min()
    }

    /// The summaries that are due. A kind without further remarks is forgotten.
    pub(super) fn take_due(&mut self, now: Instant) -> Vec<(LogLevel, String)> {
        let mut sums = Vec::new();
        self.table.retain(|_, kind| {
            if kind.due > now {
                return true;
            }
            let sum = kind.take();
            let goes_on = sum.is_some();
            sums.extend(sum);
            kind.pause = LONGEST.min(2 * kind.pause);
            kind.due = now + kind.pause;
            goes_on
        });
        sums
    }

    /// All summaries, due or not.
    pub(super) fn take_all(&mut self) -> Vec<(LogLevel, String)> {
        self.table.values_mut().filter_map(Kind::take).collect()
    }
}

impl Kind {
    /// Summarises the remarks that were not printed; a single one is returned unchanged.
    fn take(&mut self) -> Option<(LogLevel, String)> {
        let (level, last) = &mut self.last;
        let last = std::mem::take(last);
        match std::mem::take(&mut self.more) {
            0 => None,
            1 => Some((*level, last)),
            more => Some((
                *level,
                format!("and {} more, the last: {last}", grouped(more)),
            )),
        }
    }
}

/// The default kind of a remark: its text. Addresses lose their port, which differs each time
/// that a peer reconnects.
pub(crate) fn kind_of(text: &str) -> String {
    let word = |word: &str| {
        let bare = word.trim_end_matches([':', ',', ';', '.']);
        match bare.parse::<SocketAddr>() {
            Ok(address) => address.ip().to_string(),
            Err(_) => word.to_owned(),
        }
    };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quiet_while_ends_a_kind_and_sums_of_a_busy_one_grow_rare() {
        let start = Instant::now();
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        let mut kinds = Kinds::new(Duration::from_secs(5));
        let note = |kinds: &mut Kinds, second: u64| {
            kinds.note(at(second), LogLevel::Info, "a", &format!("a at {second}"))
        };
        assert_eq!(note(&mut kinds, 0).as_deref(), Some("a at 0"));
        assert_eq!(kinds.take_due(at(5)), []);
        assert_eq!(kinds.next_due(), None);
        assert!(note(&mut kinds, 6).is_some());
        let mut sums = 0;
        for second in 7..=600 {
            assert_eq!(note(&mut kinds, second), None);
            sums += kinds.take_due(at(second)).len();
        }
        assert!((8..=13).contains(&sums), "{sums}");
    }

    #[test]
    fn kinds_are_limited_and_nothing_is_uncounted() {
        let now = Instant::now();
        let mut kinds = Kinds::new(Duration::from_secs(5));
        let said = (0..10_000).filter(|i| {
            let kind = i.to_string();
            kinds.note(now, LogLevel::Info, &kind, &kind).is_some()
        });
        let said = said.count();
        assert!(said <= MOST_KINDS + 1);
        let rest = grouped(10_000 - said as u64);
        let sums = kinds.take_all();
        assert_eq!(sums.len(), 1);
        assert_eq!(sums[0].1, format!("and {rest} more, the last: 9999"));
    }

    #[test]
    fn a_peer_is_one_kind_whatever_its_port() {
        let gone = |port: u32| kind_of(&format!("10.0.0.5:{port}: has gone"));
        assert_eq!(gone(50_312), gone(50_313));
        assert_ne!(gone(50_312), kind_of("10.0.0.6:50312: has gone"));
    }
}
