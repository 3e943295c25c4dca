//! The departure windows of a robot: which items it can leave for, and when.

use pickline::decision::Candidate;
use std::cmp::Ordering;
use std::collections::{BTreeMap, HashMap};

/// A number as a sort key; equal numbers are ordered by the second part, their order of insertion.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TimeKey(pub f64, pub u32);

impl Ord for TimeKey {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for TimeKey {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for TimeKey {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for TimeKey {}

/// The windows of a robot. Each is considered from its opening until it closes or the item is
/// taken, as in a simulation.
#[derive(Debug, Clone, Default)]
pub(crate) struct Windows {
    /// Windows that have not opened yet, by opening time.
    later: BTreeMap<TimeKey, Candidate>,
    /// Windows that have opened.
    open: Vec<Candidate>,
    /// Opening time of the window of each item [s].
    opens: HashMap<u32, f64>,
}

impl Windows {
    /// Removes all windows.
    pub(crate) fn clear(&mut self) {
        self.later.clear();
        self.open.clear();
        self.opens.clear();
    }

    /// Adds the window of a free item, once.
    pub(crate) fn add(&mut self, candidate: Candidate) {
        self.remove(candidate.item);
        self.opens.insert(candidate.item, candidate.open);
        self.later
            .insert(TimeKey(candidate.open, candidate.item), candidate);
    }

    /// Removes the window of `item`, if there is one.
    pub(crate) fn remove(&mut self, item: u32) {
        if let Some(open) = self.opens.remove(&item)
            && self.later.remove(&TimeKey(open, item)).is_none()
        {
            self.open.retain(|c| c.item != item);
        }
    }

    /// When a robot that is free from `from` [s] on decides next, at the time `now` [s]; none if it
    /// has no window.
    pub(crate) fn next_decision(&mut self, now: f64, from: f64) -> Option<f64> {
        self.open_until(from);
        let opens = &mut self.opens;
        // Remove only closed windows, because the robot may be free sooner than expected.
        self.open.retain(|c| {
            let stays = c.close >= now;
            if !stays {
                opens.remove(&c.item);
            }
            stays
        });
        let usable = self.open.iter().filter(|c| c.close >= from);
        // All windows that open by `from`, or were opened by an earlier call with a later time.
        let opened = usable.map(|c| c.open).fold(f64::INFINITY, f64::min);
        if opened < f64::INFINITY {
            let next = self.later.keys().next().map_or(f64::INFINITY, |key| key.0);
            return Some(from.max(opened.min(next)));
        }
        self.later.keys().next().map(|key| key.0)
    }

    /// When the first window opens after `time` [s].
    pub(crate) fn next_opening_after(&self, time: f64) -> Option<f64> {
        let after = TimeKey(time, u32::MAX);
        let range = (std::ops::Bound::Excluded(after), std::ops::Bound::Unbounded);
        let later = self.later.range(range).next().map(|(key, _)| key.0);
        let open = self.open.iter().map(|c| c.open).filter(|open| *open > time);
        open.chain(later).reduce(f64::min)
    }

    /// The windows open at `time` [s], downstream first.
    pub(crate) fn candidates(&mut self, time: f64, into: &mut Vec<Candidate>) {
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
            bin: 0,
            class: pickline::station::ClassId::OTHER,
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
