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
}

impl Queue {
    /// Back to time 0.
    pub fn reset(&mut self) {
        self.next = 0;
        self.active.clear();
        self.free = 0.0;
    }

    /// When the robot decides next [s], and leaves in `active` what it can choose
    /// from then; none when there is nothing left for it.
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
        loop {
            self.open_until(queue, self.free, &gone);
            // An earlier call may have opened items past `free`.
            let mut opened = f64::INFINITY;
            self.active.retain(|c| {
                let stays = c.close >= self.free && !lost(c.item);
                if stays {
                    opened = opened.min(c.open);
                }
                stays
            });
            if self.active.is_empty() {
                opened = self.next_opening(queue, &gone)?;
            }
            let exact = self.free.max(opened);
            let time = scene.tick(exact);
            self.open_until(queue, time, &gone);
            if time > exact {
                self.active.retain(|c| c.close >= time);
                if self.active.is_empty() {
                    self.free = time;
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
