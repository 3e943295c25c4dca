//! The life of a task: sent, acknowledged, over; and what robots tell.

use super::Controller;
use crate::error::shown;
use crate::live::claims::{Claim, Stage};
use crate::live::items::State;
use crate::live::protocol::{
    Cancel, Outgoing, Point, Rejected, Rejection, Report, RobotState, RobotStatus, Task, Verdict,
};
use crate::live::robots::{Service, Wait};

impl Controller {
    /// Sends the task of `claim` as it is now.
    pub(super) fn send(&mut self, claim: &Claim) {
        let robot = &self.station().robots()[claim.robot];
        let tracked = self.world.items().get(claim.item);
        let stamp = |time: f64| self.stamps.clock.stamp(time);
        self.output.push(Outgoing::Task(Task {
            id: claim.task,
            revision: claim.revision,
            robot: robot.name.clone(),
            item: tracked.map(|t| t.id.clone()).unwrap_or_default(),
            decided_at: stamp(claim.decided),
            start: stamp(claim.start),
            earliest_start: stamp(claim.window.0),
            latest_start: stamp(claim.window.1),
            meet_at: stamp(claim.meet_at),
            meet: Point {
                x: claim.meet.x,
                y: claim.meet.y,
            },
            bin: Point {
                x: robot.bin.x,
                y: robot.bin.y,
            },
            free_at: stamp(claim.free_at),
            priority: tracked.map_or(0.0, |t| t.weight),
            strategy: self.decider.name().to_owned(),
        }));
    }

    pub(super) fn cancel(&mut self, task: u64, robot: usize, reason: &str) {
        self.output.push(Outgoing::Cancel(Cancel {
            stamp: self.stamps.clock.stamp(self.stamps.now()),
            task,
            robot: self.station().robots()[robot].name.clone(),
            reason: reason.to_owned(),
        }));
    }

    /// The next time that something has to be done about a task [s], and which.
    pub(super) fn next_deadline(&self) -> Option<(f64, u64)> {
        if self.world.awaits_belt() {
            // Where the items are is not known; see `Controller::restore`.
            return None;
        }
        let held = self.held;
        self.tasks
            .next_deadline(|claim| !(held && claim.stage == Stage::Sent))
    }

    /// Nothing was heard of a task for too long.
    pub(super) fn overdue(&mut self, task: u64) {
        let Some(claim) = self.tasks.get(task) else {
            return;
        };
        let (robot, item, acknowledged) = (claim.robot, claim.item, claim.acknowledged);
        if claim.stage == Stage::Sent && !self.stopping {
            self.follow(task);
            return;
        }
        self.close(task);
        let info = self.fleet.get_mut(robot);
        if info.task == Some(task) {
            info.task = None;
            info.service = Service::Silent;
        }
        if acknowledged {
            // It may lie in the bin or on the belt; another robot could reach into nothing.
            self.note("result_timeout");
            self.world.write_off(item, task);
        } else {
            self.note("ack_timeout");
            self.give_back(item, task);
        }
    }

    /// Sends a task again, as things are now: it was not acknowledged, or its item or the
    /// belt is not where it was expected. What cannot be done any more is cancelled.
    pub(super) fn follow(&mut self, task: u64) {
        let now = self.stamps.now();
        let Some(mut claim) = self.tasks.take(task) else {
            return;
        };
        let at = self.world.planned_place(claim.item);
        let over = claim.stage == Stage::Cancelling || (claim.acknowledged && now >= claim.meet_at);
        if let Some(at) = at.filter(|_| !over) {
            let possible = self.world.planning().is_some_and(|station| {
                let (robot, belt) = (&station.robots()[claim.robot], station.belt());
                if claim.acknowledged {
                    claim.redirect(robot, belt, now, at)
                } else {
                    claim.send_anew(robot, belt, now, at)
                }
            });
            let patience = self.config.result_timeout;
            if possible {
                let info = self.fleet.get_mut(claim.robot);
                if info.task == Some(task) {
                    info.free_at = claim.free_at;
                }
                claim.deadline = match claim.stage {
                    Stage::Sent => now + self.config.ack_timeout,
                    _ => claim.free_at + patience,
                };
                self.send(&claim);
            } else {
                claim.stage = Stage::Cancelling;
                claim.deadline = claim.free_at.max(now) + patience;
                self.cancel(task, claim.robot, "too late to meet the item");
            }
        }
        self.tasks.put(claim);
    }

    /// The item of a task that is over is nobody's any more.
    fn give_back(&mut self, item: u32, task: u64) {
        let (most, now) = (self.config.most_attempts, self.stamps.now());
        self.world.give_back(item, task, most, now, &mut self.fleet);
    }

    /// A task is over.
    fn close(&mut self, task: u64) -> Option<Claim> {
        let items = self.world.items();
        // With its item the task is forgotten too.
        self.tasks.close(task, |item| items.get(item).is_some())
    }

    fn unknown_task(&self, task: u64) -> Rejected {
        Rejected::new(
            Rejection::UnknownTask,
            format!("there is no task {task}; expected one that was given, not long ago"),
        )
    }

    /// A robot has understood a task.
    pub(super) fn heed_ack(&mut self, task: u64) -> Result<(), Rejected> {
        let Some(claim) = self.tasks.get_mut(task) else {
            if self.tasks.over(task).is_none() {
                return Err(self.unknown_task(task));
            }
            self.note("late_ack");
            return Ok(());
        };
        if claim.stage == Stage::Sent {
            claim.stage = Stage::Acknowledged;
            claim.deadline = claim.free_at + self.config.result_timeout;
        }
        claim.acknowledged = true;
        Ok(())
    }

    /// A robot says what came of a task.
    pub(super) fn heed_result(&mut self, time: f64, report: &Report) -> Result<(), Rejected> {
        let task = report.task;
        let free = report
            .available_at
            .map_or(time, |stamp| self.stamps.clock.time(stamp));
        let Some(claim) = self.close(task) else {
            return self.heed_late_result(time, report);
        };
        let info = self.fleet.get_mut(claim.robot);
        if info.task == Some(task) && info.service != Service::Fault {
            if info.told_at.is_some_and(|told| time < told) {
                // It has said since when it is free.
                let free = info.free_at;
                info.free_from(free);
            } else {
                info.tells_free(time, free);
            }
        }
        match report.result {
            Verdict::Picked => {
                info.picked += 1;
                self.world.pick(claim.item, claim.meet_at.min(time));
                return Ok(());
            }
            Verdict::GraspFail | Verdict::Missed => {
                info.failed += 1;
                self.world.count_attempt(claim.item);
            }
            Verdict::Rejected => {
                self.note("task_rejected");
                self.world.refuse(claim.item, claim.robot);
            }
            Verdict::Cancelled => self.note("task_cancelled"),
        }
        self.give_back(claim.item, task);
        Ok(())
    }

    /// A result that is not waited for any more: what was picked after all is picked.
    fn heed_late_result(&mut self, time: f64, report: &Report) -> Result<(), Rejected> {
        let Some(item) = self.tasks.over(report.task) else {
            return Err(self.unknown_task(report.task));
        };
        self.note("late_result");
        let state = self.world.items().get(item).map(|tracked| tracked.state);
        if report.result != Verdict::Picked || matches!(state, Some(State::Picked(_))) {
            return Ok(());
        }
        self.world.pick(item, time);
        if let Some(State::Claimed(other)) = state
            && let Some(claim) = self.tasks.get_mut(other)
        {
            // Another robot is after what is in a bin already. Its answer frees it.
            claim.stage = Stage::Cancelling;
            claim.deadline = claim.free_at.max(self.stamps.now()) + self.config.result_timeout;
            let robot = claim.robot;
            self.cancel(other, robot, "another robot has picked the item");
        }
        Ok(())
    }

    /// A robot says what it is doing.
    pub(super) fn heed_robot(&mut self, time: f64, status: &RobotStatus) -> Result<(), Rejected> {
        let robots = self.station().robots();
        let Some(index) = robots.iter().position(|robot| robot.name == status.name) else {
            let known: Vec<&str> = robots.iter().map(|robot| robot.name.as_str()).collect();
            return Err(Rejected::new(
                Rejection::UnknownRobot,
                format!(
                    "there is no robot `{}`; expected one of {}",
                    shown(&status.name),
                    known.join(", ")
                ),
            ));
        };
        // What it said before it said something newer is over: a robot at fault must not be
        // given a task because word of its better days came late.
        if self
            .fleet
            .get(index)
            .said_at
            .is_some_and(|said| time < said)
        {
            self.note("late_robot");
            return Ok(());
        }
        self.fleet.get_mut(index).said_at = Some(time);
        let free = status
            .available_at
            .map(|stamp| self.stamps.clock.time(stamp));
        let current = self.fleet.get(index).task;
        let claim = current.and_then(|task| self.tasks.get(task));
        // It may not have heard of its task when it said this.
        let crossed = claim.is_some_and(|c| !c.acknowledged || time < c.decided);
        let info = self.fleet.get_mut(index);
        // Before its last result it was not yet what that has made it.
        let is_over = info.service == Service::Ready && info.told_at.is_some_and(|at| time < at);
        match status.state {
            RobotState::Fault => {
                self.fault(index);
                return Ok(());
            }
            RobotState::Idle | RobotState::Busy if crossed => {}
            RobotState::Idle | RobotState::Busy if is_over => self.note("late_robot"),
            RobotState::Idle => {
                // Said again by one that is free already it must not end its wait; one that
                // had announced a later time is free before.
                let is_early = info.wait == Wait::No && info.free_at > time && info.is_news(time);
                if !info.is_ready() || free.is_some() || is_early {
                    info.tells_free(time, free.unwrap_or(time));
                }
            }
            RobotState::Busy => match (free, current) {
                (Some(free), Some(_)) => {
                    info.free_at = free;
                    info.told_at = Some(time);
                }
                (Some(free), None) => info.tells_free(time, free),
                (None, Some(_)) => {}
                (None, None) => info.service = Service::Working,
            },
        }
        Ok(())
    }

    /// A robot is out of service. What it was after goes back to the pool, unless it may
    /// have it in its gripper.
    fn fault(&mut self, index: usize) {
        let now = self.stamps.now();
        let info = self.fleet.get_mut(index);
        if info.service == Service::Fault {
            return;
        }
        (info.service, info.task) = (Service::Fault, None);
        let its = self.tasks.iter().filter(|claim| claim.robot == index);
        let its: Vec<u64> = its.map(|claim| claim.task).collect();
        for task in its {
            let Some(claim) = self.close(task) else {
                continue;
            };
            self.cancel(task, index, "the robot has reported a fault");
            if now < claim.meet_at || !claim.acknowledged {
                self.give_back(claim.item, task);
            } else {
                self.world.write_off(claim.item, task);
            }
        }
        // Others may have waited because this one was to take their items.
        self.world.rebuild_windows(now, &mut self.fleet);
    }
}
