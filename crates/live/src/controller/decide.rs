//! The decisions: which robot is next, what its strategy sees, and what follows from the answer.

use super::Controller;
use crate::claims::Claim;
use crate::robots::Wait;
use pickline::decision::{Action, Moment};

impl Controller {
    /// Time [s] and robot of the next decision. Ties go to the robot listed first.
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
                // No task is given while the belt or the robot is silent.
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
        // The strategy decides for the moment when the robot can set out.
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
            // There is no candidate after all, so there is nothing to decide.
            self.fleet.get_mut(robot).free_at = time.next_up();
            return;
        }
        let action = decider.decide(station, time, robot);
        self.act(robot, time, action);
    }

    /// Carries out the strategy's answer for `robot`, which can set out at `time` [s].
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
                // An illegal action must neither stop the line nor become a task: the robot waits,
                // the others continue.
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

    /// `robot` claims candidate number `place` and sets out at `start` [s].
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
