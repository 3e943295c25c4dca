//! The decisions: who is next, what it sees, what becomes of the answer.

use super::Controller;
use crate::decision::{Action, BeltItem, Moment, Snapshot};
use crate::error::{counted, shown};
use crate::live::claims::Claim;
use crate::live::items::State;
use crate::live::robots::{Service, Wait};

impl Controller {
    /// The next decision: when [s], and whose; ties to the robot listed first.
    pub(super) fn next_decision(&mut self) -> Option<(f64, usize)> {
        if self.held || self.stopping || self.awaits_belt || self.planning.is_none() {
            return None;
        }
        let now = self.clock.now;
        let mut first: Option<(f64, usize)> = None;
        let robots = self.robots.iter().zip(&mut self.windows).enumerate();
        for (index, (robot, windows)) in robots {
            if robot.is_ready()
                && robot.free_at.is_finite()
                && let Some(time) = windows.next_decision(now, robot.free_at.max(now))
                && first.is_none_or(|(earliest, _)| time < earliest)
            {
                first = Some((time, index));
            }
        }
        first
    }

    /// Lets `robot` decide now.
    pub(super) fn decide(&mut self, robot: usize) {
        let time = self.clock.now;
        self.windows[robot].candidates(time, &mut self.candidates);
        for candidate in &self.candidates {
            // Asked for to be changed it would count as changed.
            let is_new = self.items.get(candidate.item).is_some_and(|t| !t.offered);
            if is_new && let Some(tracked) = self.items.get_mut(candidate.item) {
                tracked.offered = true;
            }
        }
        self.look_around();
        let Some(station) = &self.planning else {
            return;
        };
        if self.candidates.is_empty() {
            // Nothing is open after all; a decision on nothing has no answer.
            self.robots[robot].free_at = time.next_up();
            return;
        }
        let snapshot = Snapshot {
            station,
            time,
            robot,
            candidates: &self.candidates,
            free_at: &self.free_at,
            in_view: &self.view,
        };
        let began = self.stopwatch.as_mut().map(|read| read());
        let action = self.strategy.decide(&snapshot);
        if let (Some(began), Some(read)) = (began, &mut self.stopwatch) {
            self.latency.note(read() - began);
        }
        self.act(robot, action);
    }

    fn act(&mut self, robot: usize, action: Action) {
        let time = self.clock.now;
        let (until, wait) = match action {
            Action::Pick(place) if place < self.candidates.len() => {
                self.claim(robot, place);
                return;
            }
            Action::WaitUntil(until) if until > time => (until, Wait::Until),
            Action::WaitForNextWindow => {
                let next = self.windows[robot].next_opening_after(time);
                (next.unwrap_or(f64::INFINITY), Wait::Window)
            }
            Action::Pick(_) | Action::WaitUntil(_) | Action::NoAnswer => {
                // A strategy that breaks the rules must neither stop the line nor give a
                // task: the robot waits, the others go on.
                self.note("illegal_action");
                self.complain(robot, action);
                let next = self.windows[robot].next_opening_after(time);
                (next.unwrap_or(f64::INFINITY), Wait::Window)
            }
        };
        let info = &mut self.robots[robot];
        (info.free_at, info.wait) = (until, wait);
    }

    /// Keeps what is wrong with an answer, if it is the first that is.
    fn complain(&mut self, robot: usize, action: Action) {
        if std::mem::replace(&mut self.has_complained, true) {
            return;
        }
        let problem = match action {
            Action::NoAnswer => self.strategy.trouble().unwrap_or_default(),
            other => {
                let count = counted(self.candidates.len(), "candidate");
                format!("{other:?} among {count}")
            }
        };
        self.complaint = Some(format!(
            "the strategy {} has no usable answer for robot `{}` at t = {} s: {problem}\n  the \
             robot gets no task and waits; further ones are only counted, as illegal_action in \
             the status",
            self.strategy.name(),
            shown(&self.station().robots()[robot].name),
            self.clock.now,
        ));
    }

    /// What is wrong with the first answer of the strategy that cannot be used, once.
    pub fn take_complaint(&mut self) -> Option<String> {
        self.complaint.take()
    }

    /// `robot` takes candidate `place`.
    fn claim(&mut self, robot: usize, place: usize) {
        let candidate = self.candidates[place];
        let Some(station) = &self.planning else {
            return;
        };
        let moment = Moment::new(station, robot, self.clock.now);
        let task = self.next_task;
        self.next_task += 1;
        let mut claim = Claim::new(task, robot, &moment, &candidate);
        claim.deadline = self.clock.now + self.config.ack_timeout;
        if let Some(tracked) = self.items.get_mut(candidate.item) {
            tracked.state = State::Claimed(task);
            tracked.tasks.push(task);
        }
        for windows in &mut self.windows {
            windows.remove(candidate.item);
        }
        let info = &mut self.robots[robot];
        info.task = Some(task);
        info.free_at = claim.free_at;
        info.wait = Wait::No;
        self.send(&claim);
        self.claims.insert(task, claim);
    }

    /// Fills what a snapshot shows besides the candidates.
    fn look_around(&mut self) {
        self.free_at.clear();
        let free = self.robots.iter().map(|robot| match robot.service {
            Service::Ready => robot.free_at,
            _ => f64::INFINITY,
        });
        self.free_at.extend(free);
        self.view.clear();
        let Some(station) = self
            .planning
            .as_ref()
            .filter(|_| self.strategy.needs_view())
        else {
            return;
        };
        let belt = station.belt();
        let offset = self.motion.planned_offset();
        let travelled = offset + belt.speed * self.clock.now;
        let (low, high) = (self.config.view_from - travelled, belt.length - travelled);
        // A little more on both sides: it is x that counts, as in simulation.
        for (item, tracked) in self.items.within(low - 1e-6, high + 1e-6) {
            let x0 = tracked.place + offset;
            let x = x0 + belt.speed * self.clock.now;
            if tracked.state == State::Free && (self.config.view_from..=belt.length).contains(&x) {
                self.view.push(BeltItem {
                    item,
                    x0,
                    x,
                    y: tracked.y,
                    weight: tracked.weight,
                });
            }
        }
    }
}
