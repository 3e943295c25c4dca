//! Handles the robots' answers to tasks: acknowledgements and results, in time or late.

use super::Controller;
use crate::lifecycle::TaskEvent;
use crate::protocol::{Rejected, Rejection, ResultMessage, Verdict};
use crate::robots::Service;
use nalgebra::Point2;
use pickline::error::rounded;

/// A `found` further than this [m] from where the robot was sent is not used.
const ELSEWHERE: f64 = 0.5;
/// Typical delay of late timestamps [s].
const LATE: f64 = 0.1;

impl Controller {
    fn unknown_task(&self, task: u64) -> Rejected {
        Rejected::new(
            Rejection::UnknownTask,
            format!("there is no task {task}; expected a task that was given recently"),
        )
    }

    /// Handles an `ack` of a robot at `time` [s].
    pub(super) fn hear_ack(&mut self, time: f64, task: u64) -> Result<(), Rejected> {
        let Some(claim) = self.tasks.get_mut(task) else {
            if self.tasks.over(task).is_none() {
                return Err(self.unknown_task(task));
            }
            self.note("late_ack");
            return Ok(());
        };
        claim.acknowledged.get_or_insert(time);
        if claim.stage.is_cancelled() {
            // The robot has set out without receiving the cancel, or the two have crossed.
            claim.repeat_at = claim.repeat_at.map(|_| self.stamps.clock.now);
            self.note("late_ack");
            return Ok(());
        }
        self.step(task, TaskEvent::Ack, None);
        Ok(())
    }

    /// Handles the result of a task at `time` [s].
    pub(super) fn hear_result(
        &mut self,
        time: f64,
        report: &ResultMessage,
    ) -> Result<(), Rejected> {
        let task = report.task;
        let free = report
            .available_at
            .map_or(time, |stamp| self.stamps.clock.time(stamp));
        let Some(claim) = self.tasks.get(task) else {
            return self.hear_late_result(time, free, report);
        };
        let (robot, is_asked) = (claim.robot, claim.stage.is_cancelled());
        // A robot that does not meet its item goes back to where it came from.
        let back_at = (claim.from != claim.bin).then_some(claim.from);
        let (meet, holds) = (claim.meet, claim.stage.holds_item());
        let speed = self.speed_at_picture(claim.item);
        self.take_aim((robot, meet), speed, report);
        if !holds {
            self.note("late_result");
        }
        let info = self.fleet.get_mut(robot);
        if info.task == Some(task) && info.service != Service::Fault {
            if info.told_at.is_some_and(|told| time < told) {
                // The robot has since reported when it is free.
                let free = info.free_at;
                info.free_from(free);
            } else {
                info.tells_free(time, free);
            }
        }
        info.count(None, report.result);
        match report.result {
            Verdict::Rejected => self.note("task_rejected"),
            Verdict::Cancelled => self.note("task_cancelled"),
            Verdict::Picked | Verdict::GraspFail | Verdict::Missed => {}
        }
        let turns_back = matches!(report.result, Verdict::Rejected | Verdict::Cancelled);
        if let Some(place) = back_at.filter(|_| turns_back) {
            self.move_arm(robot, place);
        }
        self.note_dropping(robot, report.result == Verdict::Cancelled && !is_asked);
        let event = match report.result {
            Verdict::Picked => TaskEvent::Picked,
            Verdict::GraspFail => TaskEvent::GraspFailed,
            Verdict::Missed => TaskEvent::NotFound,
            Verdict::Rejected => TaskEvent::Refused,
            Verdict::Cancelled => TaskEvent::Dropped,
        };
        self.step_by_result(task, event, report.result, time);
        Ok(())
    }

    /// The belt's speed [m/s] up to the last picture of an item. A late timestamp shifts the item
    /// in proportion to this speed, not to the speed at the robot's arrival.
    fn speed_at_picture(&self, item: u32) -> f64 {
        let motion = self.world.motion();
        let Some(tracked) = self.world.items().get(item) else {
            return motion.speed();
        };
        let at = tracked.measured;
        (motion.travel(at) - motion.travel(at - LATE)) / LATE
    }

    /// Learns from the `found` of a robot that was sent to `meet` [m]; the belt moved at `speed`
    /// [m/s] when the picture was taken.
    fn take_aim(
        &mut self,
        (robot, meet): (usize, Point2<f64>),
        speed: f64,
        report: &ResultMessage,
    ) {
        let off = report.found.map(|at| (at.x - meet.x, at.y - meet.y));
        match off {
            Some((x, y)) if x.hypot(y) > ELSEWHERE => {
                self.tally.note("found_elsewhere");
                if self.aim.find_elsewhere(robot) {
                    let name = &self.world.station().robots()[robot].name;
                    self.remarks.push(format!(
                        "robot `{}`: the `found` of task {} is {} m from where the robot was \
                         sent\n  send the item's position at `meet_at`, in the belt frame [m]; \
                         further ones are only counted, as found_elsewhere in the status",
                        pickline::error::shown(name),
                        report.task,
                        rounded(x.hypot(y), 3)
                    ));
                }
            }
            Some(off) => self.aim.find(robot, off, speed),
            None => self.aim.conclude(robot, report.result),
        }
        let robots = self.world.station().robots().iter();
        let names: Vec<&str> = robots.map(|robot| robot.name.as_str()).collect();
        let (delay, camera) = (self.config.camera_delay, self.sources.camera_offset());
        if let Some(remark) = self.aim.remark(delay, camera, speed, &names) {
            self.tally.note("systematic_offset");
            self.remarks.push(remark);
        }
    }

    /// Pauses a robot that keeps dropping tasks unasked.
    fn note_dropping(&mut self, robot: usize, drops: bool) {
        let now = self.stamps.now();
        let info = self.fleet.get_mut(robot);
        if !drops {
            info.dropped = 0;
        } else if info.drops_task(now) {
            self.note("robot_rested");
            let name = &self.station().robots()[robot].name;
            let remark = format!(
                "robot `{}` has answered CANCELLED to {} tasks in a row that were not cancelled; \
                 it gets its next ones after increasing pauses\n  check why it drops them; a robot \
                 that must not work should report `fault`",
                pickline::error::shown(name),
                self.fleet.get(robot).dropped,
            );
            self.remarks.push(remark);
        }
    }

    /// Handles the result of a task that is over: if the item was picked after all, it counts as
    /// picked.
    fn hear_late_result(
        &mut self,
        time: f64,
        free: f64,
        report: &ResultMessage,
    ) -> Result<(), Rejected> {
        let Some(over) = self.tasks.over(report.task) else {
            return Err(self.unknown_task(report.task));
        };
        self.note("late_result");
        let info = self.fleet.get_mut(over.robot);
        if info.service == Service::Silent && info.task.is_none() && info.is_news(time) {
            // This is the overdue result.
            info.tells_free(time, free);
        }
        let is_correction = report.result == Verdict::Picked || over.verdict.is_none();
        if over.verdict == Some(Verdict::Picked) || !is_correction {
            return Ok(());
        }
        info.count(over.verdict, report.result);
        self.tasks.conclude(report.task, report.result);
        if report.result == Verdict::Picked {
            self.pick(over.item, report.task, time);
        }
        Ok(())
    }
}
