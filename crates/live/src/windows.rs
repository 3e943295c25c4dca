//! One robot's view of time: which items it can leave for, and from when on.

use pickline::decision::Candidate;
use std::cmp::Ordering;
use std::collections::{BTreeMap, HashMap};

/// A number as a key; equal keys are in the order in which they came, by the second part.
#[derive(Debug, Clone, Copy)]
pub struct Key(pub f64, pub u32);

impl Ord for Key {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Key {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Key {}

/// The windows of one robot. Each is looked at from when it opens until it closes or the
/// item is taken, as in simulation.
#[derive(Debug, Clone, Default)]
pub struct Windows {
    /// Those that have not opened yet, by opening time.
    later: BTreeMap<Key, Candidate>,
    /// Those that have.
    open: Vec<Candidate>,
    /// When the window of each item in one of these opens [s].
    opens: HashMap<u32, f64>,
}

impl Windows {
    /// Forgets all.
    pub fn clear(&mut self) {
        self.later.clear();
        self.open.clear();
        self.opens.clear();
    }

    /// Adds the window of an item that is free, once.
    pub fn add(&mut self, candidate: Candidate) {
        self.remove(candidate.item);
        self.opens.insert(candidate.item, candidate.open);
        self.later
            .insert(Key(candidate.open, candidate.item), candidate);
    }

    /// Removes the window of `item`, if there is one.
    pub fn remove(&mut self, item: u32) {
        if let Some(open) = self.opens.remove(&item)
            && self.later.remove(&Key(open, item)).is_none()
        {
            self.open.retain(|c| c.item != item);
        }
    }

    /// When a robot that is free from `from` [s] on decides, at the time `now` [s]; none when
    /// there is nothing for it.
    pub fn next_decision(&mut self, now: f64, from: f64) -> Option<f64> {
        self.open_until(from);
        let opens = &mut self.opens;
        // Only what is over: the robot may be free sooner than it is thought to be.
        self.open.retain(|c| {
            let stays = c.close >= now;
            if !stays {
                opens.remove(&c.item);
            }
            stays
        });
        let usable = self.open.iter().filter(|c| c.close >= from);
        // All of them opened by `from`, or by an earlier call that looked further.
        let opened = usable.map(|c| c.open).fold(f64::INFINITY, f64::min);
        if opened < f64::INFINITY {
            let next = self.later.keys().next().map_or(f64::INFINITY, |key| key.0);
            return Some(from.max(opened.min(next)));
        }
        self.later.keys().next().map(|key| key.0)
    }

    /// When the first window after `time` [s] opens.
    pub fn next_opening_after(&self, time: f64) -> Option<f64> {
        let after = Key(time, u32::MAX);
        let range = (std::ops::Bound::Excluded(after), std::ops::Bound::Unbounded);
        let later = self.later.range(range).next().map(|(key, _)| key.0);
        let open = self.open.iter().map(|c| c.open).filter(|open| *open > time);
        open.chain(later).reduce(f64::min)
    }

    /// What is open at `time` [s], downstream first.
    pub fn candidates(&mut self, time: f64, into: &mut Vec<Candidate>) {
        self.open_until(time);
        into.clear();
        let open = self.open.iter();
        into.extend(open.filter(|c| (c.open..=c.close).contains(&time)));
        into.sort_unstable_by(|a, b| b.x0.total_cmp(&a.x0).then(a.item.cmp(&b.item)));
    }

    fn open_until(&mut self, time: f64) {
        while let Some(first) = self.later.first_entry()
            && first.key().0 <= time
        {
            self.open.push(first.remove());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn candidate(item: u32, open: f64, close: f64) -> Candidate {
        Candidate {
            item,
            x0: -f64::from(item),
            y: 0.0,
            weight: 1.0,
            open,
            close,
        }
    }

    #[test]
    fn decisions_fall_when_something_is_open() {
        let mut windows = Windows::default();
        assert_eq!(windows.next_decision(0.0, 0.0), None);
        windows.add(candidate(2, 3.0, 5.0));
        windows.add(candidate(1, 2.0, 4.0));
        assert_eq!(windows.next_decision(0.0, 0.0), Some(2.0));
        assert_eq!(windows.next_decision(2.5, 2.5), Some(2.5));
        let mut seen = Vec::new();
        windows.candidates(3.0, &mut seen);
        assert_eq!(seen.iter().map(|c| c.item).collect::<Vec<_>>(), [1, 2]);
        assert_eq!(windows.next_opening_after(2.5), Some(3.0));
        windows.remove(1);
        assert_eq!(windows.next_decision(2.5, 2.5), Some(3.0));
        assert_eq!(windows.next_decision(5.1, 5.1), None);
        windows.add(candidate(1, 2.0, 4.0));
        assert_eq!(windows.next_decision(3.5, 3.5), Some(3.5));
    }
}
