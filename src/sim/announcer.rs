//! Tells an observer what happens between decisions, in order of time.

use super::claims::Claims;
use super::scene::Scene;
use crate::decision::{Action, Event, Observer, Pick, Snapshot};

pub(super) struct Announcer<'o> {
    observer: &'o mut dyn Observer,
    /// Picks whose grasp or release is still to come; a few a robot at most.
    pending: Vec<Pick>,
    /// First item that may still leave the belt.
    leaving: usize,
}

impl<'o> Announcer<'o> {
    pub fn new(observer: &'o mut dyn Observer) -> Self {
        Self {
            observer,
            pending: Vec::new(),
            leaving: 0,
        }
    }

    /// Tells of a decision and remembers the pick that it led to.
    pub fn decided(&mut self, snapshot: &Snapshot, action: Action, pick: Option<Pick>) {
        self.observer.observe(&Event::Decision { snapshot, action });
        self.pending.extend(pick);
    }

    /// Everything that happens up to `now` [s]. At equal times grasps come before
    /// releases before the item that leaves, each in the order of their decisions.
    pub fn advance(&mut self, scene: &Scene, claims: &Claims, now: f64) {
        loop {
            while self.leaving < scene.pattern().len() && claims.contains(self.leaving as u32) {
                self.leaving += 1;
            }
            let leave = (self.leaving < scene.pattern().len()).then(|| Event::LeftBelt {
                time: scene.leaves_belt(self.leaving),
                item: self.leaving as u32,
            });
            let releases = self.pending.iter().map(|p| Event::Release {
                time: p.release,
                robot: p.robot,
                item: p.item,
            });
            let grasps = self.pending.iter().filter(|p| p.grasp.is_finite());
            let grasps = grasps.map(|p| Event::Grasp {
                time: p.grasp,
                robot: p.robot,
                item: p.item,
            });
            let mut next: Option<Event> = None;
            for event in grasps.chain(releases).chain(leave) {
                if next.as_ref().is_none_or(|n| event.time() < n.time()) {
                    next = Some(event);
                }
            }
            let Some(event) = next.filter(|event| event.time() <= now) else {
                return;
            };
            self.observer.observe(&event);
            match event {
                Event::Grasp { item, .. } => {
                    // Done with; the release of the same pick is still to come.
                    for pick in self.pending.iter_mut().filter(|p| p.item == item) {
                        pick.grasp = f64::INFINITY;
                    }
                }
                Event::Release { item, .. } => self.pending.retain(|p| p.item != item),
                Event::LeftBelt { .. } => self.leaving += 1,
                Event::Decision { .. } => {}
            }
        }
    }
}
