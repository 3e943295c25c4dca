//! The decisions: who is next, what it sees, what becomes of the answer.

use super::Controller;
use pickline::decision::{Action, Moment};
use crate::claims::Claim;
use crate::robots::Wait;

impl Controller {
    /// The next decision: when [s], and whose; ties to the robot listed first.
    pub(super) fn next_decision(&mut self) -> Option<(f64, usize)> {
        let waits = self.world.awaits_belt() || self.world.planning().is_none();
        if self.stopping || waits {
            return None;
        }
        let now = self.stamps.now();
        let mut first: Option<(f64, usize)> = None;
        let belt_until = self.sources.belt_until();
        for (index, robot) in self.fleet.iter() {
            let lead = self.config.lead_of(index);
            if robot.is_ready()
                && !self.is_held(index)
                && self.operation.allows(index)
                && robot.free_at.is_finite()
                && let Some(start) =
                    self.world
                        .next_decision(index, now, robot.available_from(now + lead))
                && let time = start - lead
                && first.is_none_or(|(earliest, _)| time < earliest)
                // Nobody is sent on the word of a belt or to a robot that has fallen silent.
                && time <= belt_until
                && time <= self.sources.robot_until(&self.robot_keys[index])
            {
                first = Some((time, index));
            }
        }
        first
    }

    /// Lets `robot` decide now.
    pub(super) fn decide(&mut self, robot: usize) {
        // The strategy decides for the moment at which the robot can set out.
        let time = self.stamps.now() + self.config.lead_of(robot);
        let decider = &mut self.decider;
        self.world.offer(robot, time, &mut decider.candidates);
        self.fleet.free_at(&mut decider.free_at);
        for robot in &self.held {
            decider.free_at[*robot] = f64::INFINITY;
        }
        if decider.needs_view() {
            let from = self.config.view_from;
            self.world.in_view(from, time, &mut decider.view);
        }
        let Some(station) = self.world.planning() else {
            return;
        };
        if decider.candidates.is_empty() {
            // Nothing is open after all; a decision on nothing has no answer.
            self.fleet.get_mut(robot).free_at = time.next_up();
            return;
        }
        let action = decider.decide(station, time, robot);
        self.act(robot, time, action);
    }

    /// `robot`, which can set out at `time` [s], does as its strategy says.
    fn act(&mut self, robot: usize, time: f64, action: Action) {
        let (until, wait) = match action {
            Action::Pick(place) if place < self.decider.candidates.len() => {
                self.claim(robot, time, place);
                return;
            }
            Action::WaitUntil(until) if until > time => (until, Wait::Until),
            Action::WaitForNextWindow => {
                let next = self.world.next_opening_after(robot, time);
                (next.unwrap_or(f64::INFINITY), Wait::Window)
            }
            Action::Pick(_) | Action::WaitUntil(_) | Action::NoAnswer => {
                // A strategy that breaks the rules must neither stop the line nor give a
                // task: the robot waits, the others go on.
                self.note("illegal_action");
                let name = &self.world.station().robots()[robot].name;
                self.decider.complain(action, name, time);
                let next = self.world.next_opening_after(robot, time);
                (next.unwrap_or(f64::INFINITY), Wait::Window)
            }
        };
        let info = self.fleet.get_mut(robot);
        (info.free_at, info.wait) = (until, wait);
    }

    /// `robot` takes candidate `place` and sets out at `start` [s].
    fn claim(&mut self, robot: usize, start: f64, place: usize) {
        let candidate = self.decider.candidates[place];
        let Some(station) = self.world.planning() else {
            return;
        };
        let now = self.stamps.now();
        let moment = Moment::new(station, robot, start);
        let task = self.tasks.next_number();
        let mut claim = Claim::new(task, robot, &moment, &candidate);
        claim.decided = now;
        claim.deadline = now + self.config.ack_timeout;
        self.world.claim(candidate.item, task);
        let info = self.fleet.get_mut(robot);
        info.task = Some(task);
        info.idle_said = false;
        info.free_at = claim.free_at;
        info.wait = Wait::No;
        self.send(&claim);
        self.tasks.put(claim);
    }
}
