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
        self.world.offer(
            robot,
            time,
            &mut decider.candidates,
            &mut decider.candidate_odds,
        );
        self.fleet.free_at(&mut decider.free_at);
        let robots = self.world.station().robots();
        let places = self.fleet.iter().zip(robots);
        decider.places.clear();
        decider
            .places
            .extend(places.map(|((_, info), robot)| info.place_of(robot)));
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
        let from = self.fleet.get(robot).place_of(&station.robots()[robot]);
        let moves = station.robots()[robot].places() > 1;
        let moment = Moment::new(station, robot, usize::from(from), start);
        let task = self.tasks.next_number();
        let mut claim = Claim::new(task, (robot, from), &moment, &candidate);
        claim.decided = now;
        claim.deadline = now + self.config.ack_timeout;
        self.world.claim(candidate.item, task);
        let info = self.fleet.get_mut(robot);
        info.task = Some(task);
        info.idle_said = false;
        info.free_at = claim.free_at;
        info.wait = Wait::No;
        let bin = claim.bin;
        self.send(&claim);
        self.tasks.put(claim);
        if moves {
            self.move_arm(robot, bin);
        }
    }

    /// The arm of `robot`, which has several places, is at `place` when it is free next: its windows
    /// from there.
    pub(super) fn move_arm(&mut self, robot: usize, place: u16) {
        self.fleet.get_mut(robot).place = Some(place);
        let now = self.stamps.now();
        self.world.reopen_windows(robot, now, &mut self.fleet);
    }
}
