//! One robot's view of time: which items have opened, when it decides next.

use super::scene::Scene;
use crate::decision::Candidate;

/// The items of one robot as time passes. Each is looked at from when its window
/// opens until it closes or is gone, so a run costs time in proportion to the items
/// in the workspace, not on the belt.
#[derive(Debug, Clone, Default)]
pub(super) struct Queue {
    /// First item of the robot's queue that has not opened yet.
    next: usize,
    /// Opened items that may still be picked.
    pub active: Vec<Candidate>,
    /// When the robot is free [s].
    pub free: f64,
    /// Whether it is until the next window opens that it is not.
    pub waits: bool,
}

impl Queue {
    /// Back to time 0.
    pub fn reset(&mut self) {
        let mut active = std::mem::take(&mut self.active);
        active.clear();
        *self = Self {
            active,
            ..Self::default()
        };
    }

    /// When the robot decides next [s], and leaves in `active` what it can choose
    /// from then, and, where items are given back, some that open later; none when there is nothing left for it.
    ///
    /// `queue` is what the robot has windows for, by opening time, the same in every
    /// call. `gone` says whether an item that has not opened yet is claimed, `lost` the
    /// same of one that has.
    pub fn next_decision(
        &mut self,
        scene: &Scene,
        queue: &[Candidate],
        gone: impl Fn(u32) -> bool,
        lost: impl Fn(u32) -> bool,
    ) -> Option<f64> {
        // `free` stays as it is: an item may be given back before the time found here.
        let from = self.free;
        loop {
            self.open_until(queue, from, &gone);
            // An earlier call may have opened items past `from`.
            let mut opened = f64::INFINITY;
            self.active.retain(|c| {
                let stays = c.close >= from && !lost(c.item);
                if stays {
                    opened = opened.min(c.open);
                }
                stays
            });
            // What is in `active` opens before what has not been opened.
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
    pub fn next_opening(
        &mut self,
        queue: &[Candidate],
        gone: &impl Fn(u32) -> bool,
    ) -> Option<f64> {
        while gone(queue.get(self.next)?.item) {
            self.next += 1;
        }
        Some(queue[self.next].open)
    }

    /// As [`Queue::next_opening`], looking also among what is in `active`, where items
    /// that were given back may open after `time` [s].
    pub fn next_opening_after(
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

    /// Takes `queue[place]` back, which is unclaimed again from `time` [s] on, no earlier
    /// than any decision so far. Returns a lower bound of the robot's next decision [s],
    /// none when it is too late for this item.
    pub fn give_back(&mut self, queue: &[Candidate], place: usize, time: f64) -> Option<f64> {
        let candidate = queue[place];
        if candidate.close < time {
            return None;
        }
        let opens = candidate.open.max(time);
        if self.waits {
            self.free = self.free.min(opens);
        }
        // An idle robot could have left for it earlier had it been there.
        self.free = self.free.max(time);
        // It may still be there, if the robot did not come to decide in the meantime.
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
