//! Reports the events between decisions to an observer, in order of time.

use super::run::Run;
use crate::decision::{Action, Event, Failure, Observer, Pick, Snapshot};

pub(super) struct Announcer<'o> {
    observer: &'o mut dyn Observer,
    /// Future events of the attempts so far; at most a few per robot.
    pending: Vec<Event<'static>>,
    /// First item that may still leave the belt.
    leaving: usize,
}

impl<'o> Announcer<'o> {
    pub(super) fn new(observer: &'o mut dyn Observer) -> Self {
        Self {
            observer,
            pending: Vec::new(),
            leaving: 0,
        }
    }

    /// Reports a decision.
    pub(super) fn decided(&mut self, snapshot: &Snapshot, action: Action) {
        self.observer.observe(&Event::Decision { snapshot, action });
    }

    /// Records the future events of a pick.
    pub(super) fn picks(&mut self, pick: &Pick) {
        let (robot, item) = (pick.robot, pick.item);
        let time = pick.grasp;
        self.pending.push(Event::Grasp { time, robot, item });
        let time = pick.release;
        self.pending.push(Event::Release { time, robot, item });
    }

    /// Records the future events of a failed attempt.
    pub(super) fn fails(&mut self, failure: &Failure, grasp_time: f64) {
        self.pending.push(Event::GraspFailed {
            time: failure.claim_ends(grasp_time),
            robot: failure.attempt.robot,
            item: failure.attempt.item,
            free: failure.attempt.release,
        });
    }

    /// Reports every event of `run` up to `now` [s]. At equal times, grasps come first, then
    /// failures, then releases, then items that leave the belt, each in the order of their
    /// decisions.
    pub(super) fn advance(&mut self, run: &Run, now: f64) {
        let items = run.scene().pattern().len();
        loop {
            while self.leaving < items && run.is_picked(self.leaving as u32) {
                self.leaving += 1;
            }
            let mut next = (self.leaving < items).then(|| Event::LeftBelt {
                time: run.scene().leaves_belt(self.leaving),
                item: self.leaving as u32,
            });
            let mut place = None;
            for (i, event) in self.pending.iter().enumerate() {
                if next.is_none_or(|next| order(event) < order(&next)) {
                    next = Some(*event);
                    place = Some(i);
                }
            }
            let Some(event) = next.filter(|event| event.time() <= now) else {
                return;
            };
            self.observer.observe(&event);
            match place {
                Some(place) => drop(self.pending.remove(place)),
                None => self.leaving += 1,
            }
        }
    }
}

/// Time [s], then the order at equal times.
fn order(event: &Event) -> (f64, u8) {
    let rank = match event {
        Event::Grasp { .. } => 0,
        Event::GraspFailed { .. } => 1,
        Event::Release { .. } => 2,
        Event::LeftBelt { .. } => 3,
        Event::Decision { .. } => 4,
    };
    (event.time(), rank)
}
