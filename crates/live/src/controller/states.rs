//! Handles the states that robots report: idle, busy, fault.

use super::Controller;
use crate::claims::{Claim, Reason};
use crate::lifecycle::TaskEvent;
use crate::protocol::{Rejected, Rejection, RobotState, RobotStatus};
use crate::robots::{RobotInfo, Service, Wait};
use pickline::error::shown;

impl Controller {
    /// The index of the robot called `name`.
    ///
    /// # Errors
    /// The station has no such robot.
    pub(super) fn robot_named(&self, name: &str) -> Result<usize, Rejected> {
        let robots = self.station().robots();
        robots
            .iter()
            .position(|robot| robot.name == name)
            .ok_or_else(|| {
                let known: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
                let (name, known) = (shown(name), known.join(", "));
                let problem = format!("there is no robot `{name}`; expected one of {known}");
                Rejected::new(Rejection::UnknownRobot, problem)
            })
    }

    /// Handles a robot's state at `time` [s].
    pub(super) fn hear_robot(&mut self, time: f64, status: &RobotStatus) -> Result<(), Rejected> {
        let index = self.robot_named(&status.name)?;
        if status.state == RobotState::Fault {
            self.hear_fault(index, time);
            return Ok(());
        }
        let info = self.fleet.get_mut(index);
        // A state that is older than a newer report no longer holds.
        let is_late = info.said_at.is_some_and(|said| time < said)
            || info.fault_at.is_some_and(|fault| time <= fault);
        if is_late {
            self.note("late_robot");
            return Ok(());
        }
        info.said_at = Some(time);
        info.fault_at = None;
        let current = info.task;
        let free = status
            .available_at
            .map(|stamp| self.stamps.clock.time(stamp));
        if status.state == RobotState::Busy
            && let Some(task) = status.task.filter(|task| Some(*task) == current)
            && self
                .tasks
                .get(task)
                .is_some_and(|c| c.acknowledged.is_none())
        {
            // The robot is busy with this task, so it has received it.
            self.hear_ack(time, task)?;
        }
        let claim = current.and_then(|task| self.tasks.get(task));
        if claim.is_some_and(|claim| is_crossed(claim, time, status.task)) {
            return Ok(());
        }
        let info = self.fleet.get_mut(index);
        // A state from before the robot's last result no longer holds.
        if info.service == Service::Ready && info.told_at.is_some_and(|at| time < at) {
            self.note("late_robot");
            return Ok(());
        }
        if status.state == RobotState::Busy {
            hear_busy(info, time, free);
            return Ok(());
        }
        // A state that is polled cyclically lags behind: without the task's id an early `idle` may
        // be from before the task. It counts from the expected end of the task on.
        let is_early = claim.is_some_and(|claim| time < claim.free_at);
        if is_early && status.task.is_none() && free.is_none() {
            info.idle_said = true;
        } else {
            hear_idle(info, time, free);
        }
        Ok(())
    }

    /// Handles the `fault` of a robot (index) at `time` [s]. It counts however late it comes, and
    /// lasts until the robot reports another state later.
    fn hear_fault(&mut self, index: usize, time: f64) {
        let info = self.fleet.get_mut(index);
        let newest = info.said_at.map_or(time, |said| said.max(time));
        info.said_at = Some(newest);
        info.fault_at = Some(newest);
        self.fault(index);
    }

    /// A robot is out of service. Its item returns to the pool, unless it may be in the gripper.
    fn fault(&mut self, index: usize) {
        let now = self.stamps.now();
        let info = self.fleet.get_mut(index);
        let is_new = info.service != Service::Fault;
        (info.service, info.task, info.idle_said) = (Service::Fault, None, false);
        let its = self.tasks.holding().filter(|claim| claim.robot == index);
        let its: Vec<(u64, bool)> = its
            .map(|claim| {
                let before = now < claim.meet_at || claim.acknowledged.is_none();
                (claim.task, before)
            })
            .collect();
        for (task, before) in its {
            let event = if before {
                TaskEvent::FaultBefore
            } else {
                TaskEvent::FaultAfter
            };
            self.step(task, event, Some(Reason::Fault));
        }
        if is_new {
            // Others may have waited because this robot was to take their items.
            self.world.rebuild_windows(now, &mut self.fleet);
        }
    }
}

/// Whether a robot may not have received its task when it sent a state at `time` [s], which names
/// `said` as its task if any.
fn is_crossed(claim: &Claim, time: f64, said: Option<u64>) -> bool {
    let knows = said.is_none_or(|task| task == claim.task);
    let since = claim.acknowledged.map(|at| at.max(claim.decided));
    !knows || since.is_none_or(|since| time < since)
}

/// Handles an `idle` at `time` [s] of a robot that is free from `free` [s] on, if it says when.
fn hear_idle(info: &mut RobotInfo, time: f64, free: Option<f64>) {
    // A repeated `idle` of a free robot must not end its wait; but a robot that had announced a
    // later time is free now.
    let is_early = info.wait == Wait::No && info.free_at > time && info.is_news(time);
    if !info.is_ready() || info.task.is_some() || free.is_some() || is_early {
        info.tells_free(time, free.unwrap_or(time));
    }
}

/// Handles a `busy` at `time` [s] of a robot that is free from `free` [s] on, if it says when.
fn hear_busy(info: &mut RobotInfo, time: f64, free: Option<f64>) {
    info.idle_said = false;
    match (free, info.task) {
        (Some(free), Some(_)) => {
            info.free_at = free;
            info.told_at = Some(time);
        }
        (Some(free), None) => info.tells_free(time, free),
        (None, Some(_)) => {}
        (None, None) => info.service = Service::Working,
    }
}
