//! The items of one robot over time: which windows have opened, and when it decides next.

use super::scene::Scene;
use super::windows::Windows;
use crate::decision::Candidate;

/// The items that a robot has windows for, the same in every call for one run.
#[derive(Debug, Clone, Copy)]
pub(super) struct QueuedItems<'a> {
    /// Index of the robot.
    pub robot: usize,
    /// By opening time, the earliest over all places of the robot.
    pub list: &'a [Candidate],
    /// The windows from each place of the robot; `None` if it has only one.
    pub windows: Option<&'a Windows>,
}

impl<'a> QueuedItems<'a> {
    /// All items of robot `robot`.
    pub(super) fn of(scene: &'a Scene, robot: usize) -> Self {
        Self {
            robot,
            list: scene.queue(robot),
            windows: scene.windows(robot),
        }
    }
}

/// The items of one robot over time. Each item is considered from the opening of its window until
/// it closes or the item is gone, so the cost of a run is proportional to the items in the
/// workspace, not on the belt.
///
/// A robot with several places considers an item from the first opening to the last closing over all
/// of them; `active` has the windows from where its arm is.
#[derive(Debug, Clone, Default)]
pub(super) struct Queue {
    /// First item of the robot's queue whose window has not opened yet.
    next: usize,
    /// Items whose windows have opened and that may still be picked.
    pub active: Vec<Candidate>,
    /// When the robot is free [s].
    pub free: f64,
    /// Where its arm is then.
    pub place: usize,
    /// Whether the robot is waiting for the next window to open.
    pub waits: bool,
}

impl Queue {
    /// Returns to time 0, with the arm at `place`.
    pub(super) fn reset(&mut self, place: usize) {
        let mut active = std::mem::take(&mut self.active);
        active.clear();
        *self = Self {
            active,
            place,
            ..Self::default()
        };
    }

    /// Returns when the robot decides next [s]; `None` if nothing is left for it. `active` then
    /// contains the items that it can choose from at that time. If items can be given back, or the
    /// robot has several places, it may also contain some that cannot be met from here at that time.
    ///
    /// `gone` returns whether an item that has not opened yet is claimed; `lost` does so for an opened
    /// item.
    #[inline]
    pub(super) fn next_decision(
        &mut self,
        scene: &Scene,
        items: &QueuedItems,
        gone: impl Fn(u32) -> bool,
        lost: impl Fn(u32) -> bool,
    ) -> Option<f64> {
        match items.windows {
            None => self.next_from_one_place(scene, items, gone, lost),
            Some(windows) => self.next_from_this_place(scene, items, windows, gone, lost),
        }
    }

    #[inline]
    fn next_from_one_place(
        &mut self,
        scene: &Scene,
        items: &QueuedItems,
        gone: impl Fn(u32) -> bool,
        lost: impl Fn(u32) -> bool,
    ) -> Option<f64> {
        let queue = items.list;
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
            let time = scene.postponed(items.robot, exact);
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

    fn next_from_this_place(
        &mut self,
        scene: &Scene,
        items: &QueuedItems,
        windows: &Windows,
        gone: impl Fn(u32) -> bool,
        lost: impl Fn(u32) -> bool,
    ) -> Option<f64> {
        let list = items.list;
        let mut from = self.free;
        let place = self.place;
        self.active
            .retain(|c| windows.last_close(c.item) >= from && !lost(c.item));
        for candidate in &mut self.active {
            (candidate.open, candidate.close) = windows.of(candidate.item, place);
        }
        loop {
            let leaves = |c: &Candidate| match c.open <= c.close && c.close >= from {
                true => c.open.max(from),
                false => f64::INFINITY,
            };
            let mut exact = self.active.iter().map(leaves).fold(f64::INFINITY, f64::min);
            // From here, an item opens no earlier than its first opening from anywhere.
            while let Some(candidate) = list.get(self.next)
                && candidate.open <= exact
            {
                if let Some(opened) = self.open_next(list, windows, from, &gone) {
                    exact = exact.min(leaves(&opened));
                }
            }
            if exact == f64::INFINITY {
                return None;
            }
            let time = scene.postponed(items.robot, exact);
            while let Some(candidate) = list.get(self.next)
                && candidate.open <= time
            {
                self.open_next(list, windows, from, &gone);
            }
            let can_leave = |c: &Candidate| (c.open..=c.close).contains(&time);
            if time > exact && !self.active.iter().any(can_leave) {
                from = time;
                continue;
            }
            return Some(time);
        }
    }

    /// Adds the next item to `active`, with its window from here, unless it is claimed or can no
    /// longer be met from anywhere at `from` [s] or later.
    fn open_next(
        &mut self,
        list: &[Candidate],
        windows: &Windows,
        from: f64,
        gone: &impl Fn(u32) -> bool,
    ) -> Option<Candidate> {
        let mut candidate = list[self.next];
        self.next += 1;
        if gone(candidate.item) || candidate.close < from {
            return None;
        }
        (candidate.open, candidate.close) = windows.of(candidate.item, self.place);
        self.active.push(candidate);
        Some(candidate)
    }

    /// When the next window after those in `active` opens [s].
    fn next_opening(&mut self, queue: &[Candidate], gone: &impl Fn(u32) -> bool) -> Option<f64> {
        while gone(queue.get(self.next)?.item) {
            self.next += 1;
        }
        Some(queue[self.next].open)
    }

    /// When the next window from here after `time` [s] opens [s].
    pub(super) fn next_opening_after(
        &mut self,
        time: f64,
        items: &QueuedItems,
        gone: &impl Fn(u32) -> bool,
    ) -> Option<f64> {
        // Items in `active` may open later if they were given back, or from this place.
        let later = self
            .active
            .iter()
            .filter(|c| c.open > time && c.open <= c.close);
        let opens = later
            .filter(|c| !gone(c.item))
            .map(|c| c.open)
            .reduce(f64::min);
        let Some(windows) = items.windows else {
            return opens.or_else(|| self.next_opening(items.list, gone));
        };
        let mut first = opens.unwrap_or(f64::INFINITY);
        for candidate in &items.list[self.next..] {
            if candidate.open > first {
                break;
            }
            let (open, close) = windows.of(candidate.item, self.place);
            if open <= close && !gone(candidate.item) {
                first = first.min(open);
            }
        }
        (first < f64::INFINITY).then_some(first)
    }

    /// Adds item number `position` of `items` again, which is unclaimed from `time` [s] on; `time`
    /// must not be before any decision so far. Returns a lower bound of the robot's next decision
    /// time [s], or `None` if it is too late for this item.
    pub(super) fn give_back(
        &mut self,
        items: &QueuedItems,
        position: usize,
        time: f64,
    ) -> Option<f64> {
        let mut candidate = items.list[position];
        if candidate.close < time {
            return None;
        }
        if let Some(windows) = items.windows {
            (candidate.open, candidate.close) = windows.of(candidate.item, self.place);
        }
        // From another place there may still be time, but that takes another pick first.
        let opens = (candidate.close >= time && candidate.open <= candidate.close)
            .then(|| candidate.open.max(time));
        if let Some(opens) = opens
            && self.waits
        {
            self.free = self.free.min(opens);
        }
        // An idle robot could have left for the item earlier, had it been available: also from here, for
        // an item that it can now only meet from another place.
        self.free = self.free.max(time);
        // It may still be there if the robot has not decided in the meantime.
        if position < self.next && self.active.iter().all(|c| c.item != candidate.item) {
            self.active.push(candidate);
        }
        opens
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
