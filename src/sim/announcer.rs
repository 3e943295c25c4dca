//! Reports the events between decisions to an observer, in order of time.

use super::run::Run;
use super::scene::Scene;
use crate::decision::{Action, Downtime, Event, Failure, Observer, Pick, Snapshot};

pub(super) struct Announcer<'o> {
    observer: &'o mut dyn Observer,
    /// Future events of the attempts so far; at most a few per robot.
    pending: Vec<Event<'static>>,
    /// First item that may still leave the belt.
    leaving: usize,
    /// When robots go down and are ready again, in order.
    changes: Vec<Event<'static>>,
    /// Number of these that have been reported.
    changed: usize,
}

impl<'o> Announcer<'o> {
    /// An announcer of a run of `scene`.
    pub(super) fn new(observer: &'o mut dyn Observer, scene: &Scene) -> Self {
        Self {
            observer,
            pending: Vec::new(),
            leaving: 0,
            changes: changes(&scene.downtimes().known(), f64::INFINITY),
            changed: 0,
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

    /// Reports what is left of `run`, which is over.
    pub(super) fn finish(&mut self, run: &Run) {
        // Robots may go down after the last decision, too.
        let end = run.figures().end;
        self.changes = changes(&run.scene().downtimes().before(end), end);
        self.advance(run, f64::INFINITY);
    }

    /// Reports every event of `run` up to `now` [s]. At equal times, robots that go down or are ready
    /// again come first, then grasps, then
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
            let change = self.changes.get(self.changed).copied();
            let changes =
                change.filter(|change| next.is_none_or(|next| order(change) < order(&next)));
            next = changes.or(next);
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
                None if changes.is_some() => self.changed += 1,
                None => self.leaving += 1,
            }
        }
    }
}

/// When robots go down and are ready again before `end` [s], in order, upstream robots first.
fn changes(downtimes: &[Downtime], end: f64) -> Vec<Event<'static>> {
    let both = |down: &Downtime| {
        let Downtime { robot, from, to } = *down;
        let up = (to < end).then_some((robot, Event::RobotUp { time: to, robot }));
        [Some((robot, Event::RobotDown { time: from, robot })), up]
    };
    let mut all: Vec<(usize, Event)> = downtimes.iter().flat_map(both).flatten().collect();
    all.sort_by(|(a, first), (b, second)| first.time().total_cmp(&second.time()).then(a.cmp(b)));
    all.into_iter().map(|(_, change)| change).collect()
}

/// Time [s], then the order at equal times.
fn order(event: &Event) -> (f64, u8) {
    let rank = match event {
        Event::RobotDown { .. } | Event::RobotUp { .. } => 0,
        Event::Grasp { .. } => 1,
        Event::GraspFailed { .. } => 2,
        Event::Release { .. } => 3,
        Event::LeftBelt { .. } => 4,
        Event::Decision { .. } => 5,
    };
    (event.time(), rank)
}
