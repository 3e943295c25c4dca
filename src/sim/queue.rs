//! The items of one robot over time: which windows have opened, and when it decides next.

use super::scene::Scene;
use crate::decision::Candidate;

/// The items of one robot over time. Each item is considered from the opening of its window until
/// it closes or the item is gone, so the cost of a run is proportional to the items in the
/// workspace, not on the belt.
#[derive(Debug, Clone, Default)]
pub(super) struct Queue {
    /// First item of the robot's queue whose window has not opened yet.
    next: usize,
    /// Items whose windows have opened and that may still be picked.
    pub active: Vec<Candidate>,
    /// When the robot is free [s].
    pub free: f64,
    /// Whether the robot is waiting for the next window to open.
    pub waits: bool,
}

impl Queue {
    /// Returns to time 0.
    pub(super) fn reset(&mut self) {
        let mut active = std::mem::take(&mut self.active);
        active.clear();
        *self = Self {
            active,
            ..Self::default()
        };
    }

    /// Returns when the robot decides next [s]; `None` if nothing is left for it. `active` then
    /// contains the items that it can choose from at that time and, if items can be given back,
    /// possibly some that open later.
    ///
    /// `queue` contains the items that the robot has windows for, by opening time; it must be the
    /// same in every call. `gone` returns whether an item that has not opened yet is claimed;
    /// `lost` does so for an opened item.
    pub(super) fn next_decision(
        &mut self,
        scene: &Scene,
        queue: &[Candidate],
        gone: impl Fn(u32) -> bool,
        lost: impl Fn(u32) -> bool,
    ) -> Option<f64> {
        // Keep `free`: an item may be given back before the time found here.
        let from = self.free;
        loop {
            self.open_until(queue, from, &gone);
            // An earlier call may have opened items after `from`.
            let mut opened = f64::INFINITY;
            self.active.retain(|c| {
                let stays = c.close >= from && !lost(c.item);
                if stays {
                    opened = opened.min(c.open);
                }
                stays
            });
            // Items in `active` open before those that have not been opened.
            if self.active.is_empty() {
                opened = self.next_opening(queue, &gone)?;
            }
            let exact = from.max(opened);
            let time = scene.tick(exact);
            self.open_until(queue, time, &gone);
            if time > exact {
                self.active.retain(|c| c.close >= time);
                if !self.active.iter().any(|c| c.open <= time) {
                    continue;
                }
            }
            return Some(time);
        }
    }

    /// When the next window after those in `active` opens [s].
    pub(super) fn next_opening(
        &mut self,
        queue: &[Candidate],
        gone: &impl Fn(u32) -> bool,
    ) -> Option<f64> {
        while gone(queue.get(self.next)?.item) {
            self.next += 1;
        }
        Some(queue[self.next].open)
    }

    /// Like [`Queue::next_opening`], but includes the items in `active`, because items that were
    /// given back may open after `time` [s].
    pub(super) fn next_opening_after(
        &mut self,
        time: f64,
        queue: &[Candidate],
        gone: &impl Fn(u32) -> bool,
    ) -> Option<f64> {
        let later = self.active.iter().filter(|c| c.open > time);
        let given_back = later.filter(|c| !gone(c.item)).map(|c| c.open);
        given_back
            .reduce(f64::min)
            .or_else(|| self.next_opening(queue, gone))
    }

    /// Adds `queue[place]` again, which is unclaimed from `time` [s] on; `time` must not be before
    /// any decision so far. Returns a lower bound of the robot's next decision time [s], or `None`
    /// if it is too late for this item.
    pub(super) fn give_back(
        &mut self,
        queue: &[Candidate],
        place: usize,
        time: f64,
    ) -> Option<f64> {
        let candidate = queue[place];
        if candidate.close < time {
            return None;
        }
        let opens = candidate.open.max(time);
        if self.waits {
            self.free = self.free.min(opens);
        }
        // An idle robot could have left for the item earlier, had it been available.
        self.free = self.free.max(time);
        // It may still be there if the robot has not decided in the meantime.
        if place < self.next && self.active.iter().all(|c| c.item != candidate.item) {
            self.active.push(candidate);
        }
        Some(opens)
    }

    fn open_until(&mut self, queue: &[Candidate], time: f64, gone: &impl Fn(u32) -> bool) {
        while let Some(candidate) = queue.get(self.next)
            && candidate.open <= time
        {
            if !gone(candidate.item) && candidate.close >= time {
                self.active.push(*candidate);
            }
            self.next += 1;
        }
    }
}
