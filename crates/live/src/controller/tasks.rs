//! The life of a task: sent, sent again, cancelled, over. The effect of each event is in the table
//! of [`crate::lifecycle`].

use super::Controller;
use crate::claims::{Claim, Reason};
use crate::fate::Fate;
use crate::items::ItemState;
use crate::lifecycle::{Effect, Stage, TaskEvent};
use crate::protocol::{BeltPoint, Cancel, Outgoing, Task, Verdict};
use crate::robots::Service;
use pickline::error::shown;

/// Number of unacknowledged transmissions after which a task is cancelled.
const MOST_UNHEARD: u32 = 60;

/// Why the plan of a task is checked again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum RecheckCause {
    /// The task was not acknowledged.
    Unheard,
    /// The belt does not move as planned.
    Belt,
    /// The item has moved.
    Item,
}

impl Controller {
    /// Sends the task of `claim` with its present times.
    pub(super) fn send(&mut self, claim: &Claim) {
        let robot = &self.station().robots()[claim.robot];
        let bin = &robot.bins[usize::from(claim.bin)];
        let tracked = self.world.items().get(claim.item);
        let features = tracked.map(|t| t.features.clone()).unwrap_or_default();
        let stamp = |time: f64| self.stamp_for(claim.robot, time);
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
            meet: BeltPoint {
                x: claim.meet.x,
                y: claim.meet.y,
            },
            bin: BeltPoint {
                x: bin.at.x,
                y: bin.at.y,
            },
            bin_name: (!robot.has_only_bin()).then(|| bin.name.clone()),
            free_at: stamp(claim.free_at),
            priority: tracked.map_or(0.0, |t| t.weight),
            strategy: self.decider.name().to_owned(),
            class: features.class,
            angle: features.angle,
            height: features.height,
            size: features.size,
            data: features.data,
        }));
    }

    /// Asks the robot to drop a task, now and repeatedly until it answers.
    pub(super) fn cancel(&mut self, claim: &mut Claim) {
        let now = self.stamps.now();
        claim.note_cancel(now, self.config.ack_timeout);
        self.send_cancel(claim);
    }

    /// Sends the `cancel` of a task.
    pub(super) fn send_cancel(&mut self, claim: &Claim) {
        self.output.push(Outgoing::Cancel(Cancel {
            stamp: self.stamp_for(claim.robot, self.stamps.now()),
            task: claim.task,
            robot: self.station().robots()[claim.robot].name.clone(),
            reason: claim
                .reason
                .map(Reason::text)
                .unwrap_or_default()
                .to_owned(),
        }));
    }

    /// Time [s] and task of the next deadline.
    pub(super) fn next_deadline(&self) -> Option<(f64, u64)> {
        if self.world.awaits_belt() {
            // The positions of the items are unknown; see `Controller::restore`.
            return None;
        }
        self.tasks.next_deadline(|robot| self.is_held(robot))
    }

    /// Handles the deadline of a task.
    pub(super) fn overdue(&mut self, task: u64) {
        let now = self.stamps.now();
        let Some(claim) = self.tasks.get(task) else {
            return;
        };
        let event = match claim.stage {
            Stage::Sent => return self.unheard(task),
            stage if stage.is_cancelled() && now < claim.deadline => {
                if let Some(mut claim) = self.tasks.take(task) {
                    self.cancel(&mut claim);
                    self.tasks.put(claim);
                }
                return;
            }
            Stage::Recalled => TaskEvent::Moot,
            _ if claim.acknowledged.is_some() => TaskEvent::NoResult,
            _ => TaskEvent::NoAnswer,
        };
        let robot = claim.robot;
        let info = self.fleet.get_mut(robot);
        if info.task == Some(task) {
            info.task = None;
            info.service = Service::Silent;
            let name = shown(&self.station().robots()[robot].name);
            let owed = match event {
                TaskEvent::NoAnswer => "has not acknowledged its task",
                _ => "has not reported the result of its task",
            };
            self.remarks.push(format!(
                "robot `{name}` {owed}: it gets no further task until it is heard again"
            ));
        }
        match event {
            TaskEvent::NoResult => self.note("result_timeout"),
            TaskEvent::NoAnswer => self.note("ack_timeout"),
            _ => {}
        }
        self.step(task, event, None);
    }

    /// Handles a task that was not acknowledged. It is sent again, but not for ever: if the belt
    /// stands, its last start may be days away, and another robot could take the item.
    fn unheard(&mut self, task: u64) {
        let Some(claim) = self.tasks.get_mut(task) else {
            return;
        };
        claim.unheard += 1;
        if claim.unheard < MOST_UNHEARD {
            self.follow(task, RecheckCause::Unheard);
        } else {
            self.step(task, TaskEvent::Impossible, Some(Reason::NoAck));
        }
    }

    /// Checks a task again with the present state: it was not acknowledged, or its item or the belt
    /// is not where it was expected. If it can no longer be done, it is cancelled.
    pub(super) fn follow(&mut self, task: u64, cause: RecheckCause) {
        let now = self.stamps.now();
        let Some(mut claim) = self.tasks.take(task) else {
            return;
        };
        let is_under_way = claim.acknowledged.is_some();
        let over = claim.stage.is_cancelled() || (is_under_way && now >= claim.meet_at);
        let Some(at) = self.world.planned_place(claim.item).filter(|_| !over) else {
            self.tasks.put(claim);
            return;
        };
        let possible = self.world.planning().is_some_and(|station| {
            let (robot, belt) = (&station.robots()[claim.robot], station.belt());
            if is_under_way {
                claim.redirect(robot, belt, now, at)
            } else {
                let start = now + self.config.lead_of(claim.robot);
                let latest = start + self.config.result_timeout;
                claim.plan_again(robot, belt, (start, latest), at)
            }
        });
        if !possible {
            self.tasks.put(claim);
            self.step(
                task,
                TaskEvent::Impossible,
                Some(self.why_impossible(cause)),
            );
            return;
        }
        let info = self.fleet.get_mut(claim.robot);
        if info.task == Some(task) {
            info.free_at = claim.free_at;
        }
        claim.deadline = match claim.stage {
            Stage::Sent => now + self.config.ack_timeout,
            _ => claim.free_at + self.config.result_timeout,
        };
        self.send(&claim);
        self.tasks.put(claim);
        if cause == RecheckCause::Unheard {
            self.step(task, TaskEvent::Unheard, None);
        }
    }

    fn why_impossible(&self, cause: RecheckCause) -> Reason {
        let speed = self.world.motion().speed();
        match cause {
            _ if speed < 0.0 => Reason::BeltBackwards,
            _ if self.world.planning().is_none() => Reason::BeltTooFast,
            RecheckCause::Belt if self.world.motion().stands() => Reason::BeltStopped,
            RecheckCause::Belt => Reason::BeltSpeed,
            RecheckCause::Item => Reason::ItemMoved,
            RecheckCause::Unheard => Reason::NoAck,
        }
    }

    /// Applies the table's entry for `event`. `reason` is the reason if the task is cancelled.
    pub(super) fn step(&mut self, task: u64, event: TaskEvent, reason: Option<Reason>) {
        self.step_with(task, event, reason, None);
    }

    /// The same as [`Controller::step`] for a result `verdict` of the robot; a pick happened `at`
    /// [s].
    pub(super) fn step_by_result(
        &mut self,
        task: u64,
        event: TaskEvent,
        verdict: Verdict,
        at: f64,
    ) {
        self.step_with(task, event, None, Some((verdict, at)));
    }

    fn step_with(
        &mut self,
        task: u64,
        event: TaskEvent,
        reason: Option<Reason>,
        result: Option<(Verdict, f64)>,
    ) {
        let Some(mut claim) = self.tasks.take(task) else {
            return;
        };
        let Some((next, effect)) = claim.stage.after(event) else {
            self.tasks.put(claim);
            return;
        };
        let now = self.stamps.now();
        let was_cancelled = claim.stage.is_cancelled();
        match next {
            None => self.tasks.close(&claim, result.map(|(verdict, _)| verdict)),
            Some(stage) => {
                claim.stage = stage;
                if stage.is_cancelled() && !was_cancelled {
                    claim.reason = reason;
                    self.cancel(&mut claim);
                }
                claim.deadline = match stage {
                    Stage::Sent => claim.deadline,
                    Stage::Acknowledged => claim.free_at + self.config.result_timeout,
                    Stage::Cancelling => claim.free_at.max(now) + self.config.result_timeout,
                    Stage::Recalled => claim.moot_from(self.config.result_timeout).max(now),
                };
                self.tasks.put(claim.clone());
            }
        }
        let at = result.map_or(now, |(_, at)| at);
        self.affect(&claim, event, effect, at);
    }

    /// Applies the effect of a step to the item of `claim`; a pick happened `at` [s].
    fn affect(&mut self, claim: &Claim, event: TaskEvent, effect: Effect, at: f64) {
        let (item, task, now) = (claim.item, claim.task, self.stamps.now());
        match effect {
            Effect::Keep => return,
            Effect::Pick => return self.pick(item, task, claim.meet_at.min(at)),
            Effect::WriteOff => return self.world.write_off(item, task),
            Effect::Return => {}
            Effect::Attempt => {
                let grasp = event == TaskEvent::GraspFailed;
                self.world.count_attempt(item, grasp);
            }
            Effect::Refuse => self.world.refuse(item, claim.robot),
            Effect::Withhold => self.world.withhold(item, claim.robot, now),
        }
        let most = self.config.most_attempts;
        self.world.give_back(item, task, most, now, &mut self.fleet);
    }

    /// The robot of `task` has picked the item, at `time` [s]. Any other robot that was sent to it
    /// is recalled.
    pub(super) fn pick(&mut self, item: u32, task: u64, time: f64) {
        let Some(state) = self.world.items().get(item).map(|tracked| tracked.state) else {
            match self.tasks.picked_after_all(item) {
                Some(Fate::Picked) => self.note("picked_twice"),
                Some(fate) => self.tally.correct(fate),
                None => {}
            }
            return;
        };
        match state {
            ItemState::Picked(_) => return self.note("picked_twice"),
            ItemState::Claimed(other) if other != task => {
                let robot = |task: u64| {
                    let open = self.tasks.get(task).map(|claim| claim.robot);
                    open.or_else(|| self.tasks.over(task).map(|over| over.robot))
                };
                let reason = if robot(task) == robot(other) {
                    Reason::PickedBefore
                } else {
                    Reason::TakenByOther
                };
                self.step(other, TaskEvent::TakenByOther, Some(reason));
            }
            _ => {}
        }
        self.world.pick(item, time);
    }
}
