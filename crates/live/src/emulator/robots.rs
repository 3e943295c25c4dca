//! The emulated robots: they take tasks, meet items and report results.

use super::trouble::FaultDraw;
use super::{Emulator, EmulatorEvent};
use crate::protocol::{
    Ack, BeltPoint, Cancel, Incoming, Outgoing, ResultMessage, RobotState, Task, Verdict,
};
use pickline::kinematics::{distance, meeting_range, travel_time};

/// The gripper grasps an item within this distance of its centre [m].
const GRIP: f64 = 0.01;
/// A robot that leaves more than this [s] after its `start` computes another meeting point.
const LATE: f64 = 1e-9;

impl Emulator {
    /// Handles a message from the node, now.
    pub fn receive(&mut self, message: Outgoing) {
        match message {
            Outgoing::Task(task) => self.take_task(task),
            Outgoing::Cancel(cancel) => self.take_cancel(&cancel),
            Outgoing::BeltRequest(_) | Outgoing::Status(_) | Outgoing::Due(_) => {}
        }
    }

    fn index_of(&self, name: &str) -> Option<usize> {
        self.station
            .robots()
            .iter()
            .position(|robot| robot.name == name)
    }

    fn take_task(&mut self, mut task: Task) {
        for time in [
            &mut task.decided_at,
            &mut task.start,
            &mut task.earliest_start,
            &mut task.latest_start,
            &mut task.meet_at,
            &mut task.free_at,
        ] {
            *time -= self.origin;
        }
        let Some(robot) = self.index_of(&task.robot) else {
            self.broken
                .push(format!("task {} is for an unknown robot", task.id));
            return;
        };
        let others = self
            .arms
            .iter()
            .enumerate()
            .filter(|(index, _)| *index != robot);
        let same_item = |other: &Task| other.item == task.item;
        if others
            .filter_map(|(_, arm)| arm.task.as_ref())
            .any(same_item)
        {
            self.broken.push(format!(
                "two robots have open tasks for item {} at once",
                task.item
            ));
        }
        if self.arms[robot].down {
            return;
        }
        if let Some(report) = self.results.get(&task.id) {
            // Already done, but the node has not received the result.
            self.send(Incoming::Result(*report));
            return;
        }
        let current = self.arms[robot].task.as_ref();
        let busy = current.is_some();
        if let Some(revision) = current.filter(|c| c.id == task.id).map(|c| c.revision) {
            self.acknowledge(&task);
            if task.revision > revision && !self.arms[robot].met {
                self.set_out(robot, task);
            }
            return;
        }
        if busy || !self.leave(robot, &mut task) {
            self.conclude(task.id, Verdict::Rejected, None);
            return;
        }
        self.acknowledge(&task);
        self.set_out(robot, task);
    }

    fn acknowledge(&mut self, task: &Task) {
        let luck = self
            .trouble
            .draw(FaultDraw::Ack, task.id << 16 | u64::from(task.revision));
        if luck >= self.trouble.lost_acks {
            let (stamp, task) = (self.now, task.id);
            self.send(Incoming::Ack(Ack { stamp, task }));
        }
    }

    /// Lets a robot that received its task too late meet the item further downstream. Returns
    /// whether it can.
    fn leave(&self, index: usize, task: &mut Task) -> bool {
        let (robot, belt) = (&self.station.robots()[index], self.station.belt());
        let late = self.now - task.start;
        if late <= LATE {
            return true;
        }
        let x = task.meet.x - (self.travel(task.meet_at) - self.travel(self.now));
        let (dx, dy) = (x - robot.bin.x, task.meet.y - robot.bin.y);
        let travel = travel_time(dx, dy, belt.speed, robot.speed);
        let x = x + belt.speed * travel;
        let (base, y) = (robot.base, task.meet.y);
        let range = meeting_range(base.x, base.y, robot.reach, y, belt.length);
        task.start = self.now;
        task.meet_at = self.now + travel;
        task.meet = BeltPoint { x, y };
        let back = distance(x - robot.bin.x, dy) / robot.speed;
        task.free_at = task.meet_at + robot.grasp_time + back + robot.release_time;
        range.is_some_and(|(low, high)| (low..=high).contains(&x))
    }

    fn set_out(&mut self, robot: usize, task: Task) {
        let event = EmulatorEvent::Meets(task.id, task.revision);
        self.plan(task.meet_at.max(self.now), event);
        let arm = &mut self.arms[robot];
        arm.task = Some(task);
        arm.met = false;
    }

    /// Ends a task and reports its result to the node.
    fn conclude(&mut self, task: u64, result: Verdict, available_at: Option<f64>) {
        let report = ResultMessage {
            stamp: self.now,
            task,
            result,
            available_at,
            found: None,
        };
        self.results.insert(task, report);
        self.send(Incoming::Result(report));
    }

    pub(super) fn meet(&mut self, id: u64, revision: u32) {
        let same = |task: &Task| task.id == id && task.revision == revision;
        let robot = self
            .arms
            .iter()
            .position(|arm| arm.task.as_ref().is_some_and(same));
        let Some(robot) = robot.filter(|robot| !self.arms[*robot].met) else {
            return;
        };
        let Some(task) = self.arms[robot].task.clone() else {
            return;
        };
        let Some(&item) = self.numbers.get(&task.item) else {
            self.broken.push(format!(
                "task {id} is for item {}, which does not exist",
                task.item
            ));
            return;
        };
        self.arms[robot].met = true;
        let it = &self.pattern.items()[item];
        let x = it.x0 + self.travel(self.now);
        let off = distance(x - task.meet.x, it.y - task.meet.y);
        let attempt = u64::from(self.attempts[item]);
        let luck = self
            .trouble
            .draw(FaultDraw::Grasp, (item as u64) << 16 | attempt);
        self.attempts[item] += 1;
        let verdict = if self.taken[item] || off > GRIP {
            Verdict::Missed
        } else if luck < self.trouble.grasp_failures {
            Verdict::GraspFail
        } else {
            self.taken[item] = true;
            self.picked.push((robot, task.item.clone()));
            self.plan(task.free_at.max(self.now), EmulatorEvent::Back(robot, id));
            return;
        };
        // The robot knows the result once the gripper has closed, and is on its way back then.
        let known = self.now + self.station.robots()[robot].grasp_time;
        let report = ResultMessage {
            stamp: known,
            task: id,
            result: verdict,
            available_at: Some(task.free_at.max(known)),
            found: None,
        };
        self.results.insert(id, report);
        let arrives = known + self.jitter();
        self.plan(arrives, EmulatorEvent::Arrives(Incoming::Result(report)));
        self.arms[robot].task = None;
    }

    pub(super) fn come_back(&mut self, robot: usize, task: u64) {
        let arm = &mut self.arms[robot];
        if arm.task.as_ref().is_some_and(|current| current.id == task) {
            arm.task = None;
            self.conclude(task, Verdict::Picked, None);
        }
    }

    fn take_cancel(&mut self, cancel: &Cancel) {
        let Some(robot) = self
            .index_of(&cancel.robot)
            .filter(|robot| !self.arms[*robot].down)
        else {
            return;
        };
        if let Some(report) = self.results.get(&cancel.task) {
            self.send(Incoming::Result(*report));
            return;
        }
        let arm = &mut self.arms[robot];
        let mut back = None;
        if let Some(task) = arm.task.as_ref().filter(|task| task.id == cancel.task) {
            if arm.met {
                return;
            }
            let speed = self.station.robots()[robot].speed;
            let whole = distance(task.meet.x - task.bin.x, task.meet.y - task.bin.y);
            let gone = (speed * (self.now - task.start)).clamp(0.0, whole);
            back = Some(self.now + gone / speed);
            arm.task = None;
        }
        self.conclude(cancel.task, Verdict::Cancelled, back);
    }

    pub(super) fn break_down(&mut self, robot: usize, down: bool) {
        let arm = &mut self.arms[robot];
        arm.down = down;
        let task = arm.task.take();
        if let Some(task) = task.filter(|_| arm.met) {
            // The item is in the gripper and does not reach the bin.
            self.picked.retain(|(_, item)| *item != task.item);
            self.stranded += 1;
        }
        arm.met = false;
        self.tell_state(
            robot,
            if down {
                RobotState::Fault
            } else {
                RobotState::Idle
            },
        );
    }
}
