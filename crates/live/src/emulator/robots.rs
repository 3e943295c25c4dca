//! The emulated robots: they take tasks, meet items and report results.

use super::line::EmulatedLine;
use super::schedule::{EmulatorEvent, EmulatorSchedule};
use super::trouble::FaultDraw;
use crate::protocol::{Ack, BeltPoint, Cancel, Incoming, ResultMessage, RobotState, Task, Verdict};
use nalgebra::Point2;
use pickline::kinematics::{Encounter, distance, meeting_range};
use std::collections::HashMap;

/// The gripper grasps an item within this distance of its centre [m].
const GRIP: f64 = 0.01;
/// A robot that leaves more than this [s] after its `start` computes another meeting point.
const LATE: f64 = 1e-9;

/// An emulated robot.
#[derive(Debug, Clone, Default)]
struct EmulatedRobot {
    down: bool,
    task: Option<Task>,
    /// Whether it has already met the item.
    met: bool,
    /// Where its arm was before the task, or is without one [m].
    place: Point2<f64>,
}

/// The robots of an emulated station, the items that they have taken, and the results of their
/// tasks.
#[derive(Debug)]
pub(super) struct EmulatedRobots {
    robots: Vec<EmulatedRobot>,
    /// The items of the pattern by id.
    numbers: HashMap<String, usize>,
    taken: Vec<bool>,
    attempts: Vec<u32>,
    /// The result of each task that is over.
    results: HashMap<u64, ResultMessage>,
    picked: Vec<(usize, String)>,
    stranded: usize,
    broken: Vec<String>,
}

impl EmulatedRobots {
    /// The robots of `line`, without tasks.
    pub(super) fn new(line: &EmulatedLine) -> Self {
        let items = line.pattern.len();
        let ids = line.pattern.items().iter().map(|item| item.id.clone());
        Self {
            robots: line
                .station
                .robots()
                .iter()
                .map(|robot| EmulatedRobot {
                    place: robot.rest,
                    ..EmulatedRobot::default()
                })
                .collect(),
            numbers: ids.zip(0..).collect(),
            taken: vec![false; items],
            attempts: vec![0; items],
            results: HashMap::new(),
            picked: Vec::new(),
            stranded: 0,
            broken: Vec::new(),
        }
    }

    /// Whether any robot has a task.
    pub(super) fn are_at_work(&self) -> bool {
        self.robots.iter().any(|robot| robot.task.is_some())
    }

    /// The picks: index of the robot and id of the item, in the order of the grasps.
    pub(super) fn picked(&self) -> &[(usize, String)] {
        &self.picked
    }

    /// Number of items that were in a gripper when the robot broke down.
    pub(super) fn stranded(&self) -> usize {
        self.stranded
    }

    /// The node's violations of the protocol's guarantees.
    pub(super) fn broken_promises(&self) -> &[String] {
        &self.broken
    }

    /// Handles a task from the node, whose times are by the emulator's clock.
    pub(super) fn take_task(
        &mut self,
        line: &EmulatedLine,
        schedule: &mut EmulatorSchedule,
        mut task: Task,
    ) {
        let Some(robot) = index_of(line, &task.robot) else {
            self.broken
                .push(format!("task {} is for an unknown robot", task.id));
            return;
        };
        let others = self.robots.iter().enumerate();
        let others = others.filter(|(index, _)| *index != robot);
        let mut open = others.filter_map(|(_, robot)| robot.task.as_ref());
        if open.any(|other| other.item == task.item) {
            self.broken.push(format!(
                "two robots have open tasks for item {} at once",
                task.item
            ));
        }
        if self.robots[robot].down {
            return;
        }
        if let Some(report) = self.results.get(&task.id) {
            // Already done, but the node has not received the result.
            schedule.send(Incoming::Result(*report));
            return;
        }
        let current = self.robots[robot].task.as_ref();
        let busy = current.is_some();
        if let Some(revision) = current.filter(|c| c.id == task.id).map(|c| c.revision) {
            acknowledge(line, schedule, &task);
            if task.revision > revision && !self.robots[robot].met {
                if line.differs() {
                    let start = task.start;
                    move_out(line, start, (robot, self.robots[robot].place), &mut task);
                }
                self.set_out(schedule, robot, task);
            }
            return;
        }
        let place = self.robots[robot].place;
        if busy || !leave(line, schedule.now(), (robot, place), &mut task) {
            self.conclude(schedule, task.id, Verdict::Rejected, None);
            return;
        }
        acknowledge(line, schedule, &task);
        self.set_out(schedule, robot, task);
    }

    fn set_out(&mut self, schedule: &mut EmulatorSchedule, robot: usize, task: Task) {
        let event = EmulatorEvent::Meets(task.id, task.revision);
        schedule.add(task.meet_at.max(schedule.now()), event);
        let its = &mut self.robots[robot];
        its.task = Some(task);
        its.met = false;
    }

    /// Ends a task and reports its result to the node.
    fn conclude(
        &mut self,
        schedule: &mut EmulatorSchedule,
        task: u64,
        result: Verdict,
        available_at: Option<f64>,
    ) {
        let report = ResultMessage {
            stamp: schedule.now(),
            task,
            result,
            available_at,
            found: None,
        };
        self.results.insert(task, report);
        schedule.send(Incoming::Result(report));
    }

    /// The robot of task `id` reaches the meeting point of this revision of the task.
    pub(super) fn meet(
        &mut self,
        line: &EmulatedLine,
        schedule: &mut EmulatorSchedule,
        id: u64,
        revision: u32,
    ) {
        let same = |task: &Task| task.id == id && task.revision == revision;
        let mut robots = self.robots.iter();
        let robot = robots.position(|robot| robot.task.as_ref().is_some_and(same));
        let Some(robot) = robot.filter(|robot| !self.robots[*robot].met) else {
            return;
        };
        let Some(task) = self.robots[robot].task.clone() else {
            return;
        };
        let Some(&item) = self.numbers.get(&task.item) else {
            self.broken.push(format!(
                "task {id} is for item {}, which does not exist",
                task.item
            ));
            return;
        };
        self.robots[robot].met = true;
        let it = &line.pattern.items()[item];
        let x = it.x0 + line.travel(schedule.now());
        let off = distance(x - task.meet.x, it.y - task.meet.y);
        let attempt = u64::from(self.attempts[item]);
        let luck = line
            .faults
            .draw(FaultDraw::Grasp, (item as u64) << 16 | attempt);
        self.attempts[item] += 1;
        let verdict = if self.taken[item] || off > GRIP {
            Verdict::Missed
        } else if luck < line.faults.grasp_failures {
            Verdict::GraspFail
        } else {
            self.taken[item] = true;
            self.picked.push((robot, task.item.clone()));
            schedule.add(
                task.free_at.max(schedule.now()),
                EmulatorEvent::Back(robot, id),
            );
            return;
        };
        // The robot knows the result once the gripper has closed, and is on its way back then.
        let known = schedule.now() + line.arm_of(robot).grasp_time;
        let report = ResultMessage {
            stamp: known,
            task: id,
            result: verdict,
            available_at: Some(task.free_at.max(known)),
            found: None,
        };
        self.results.insert(id, report);
        schedule.send_at(known, Incoming::Result(report));
        self.robots[robot].task = None;
        self.robots[robot].place = Point2::new(task.bin.x, task.bin.y);
    }

    /// A robot is back at its bin after a task.
    pub(super) fn come_back(&mut self, schedule: &mut EmulatorSchedule, robot: usize, task: u64) {
        let its = &mut self.robots[robot];
        if let Some(done) = its.task.take_if(|current| current.id == task) {
            its.place = Point2::new(done.bin.x, done.bin.y);
            self.conclude(schedule, task, Verdict::Picked, None);
        }
    }

    /// Handles a cancel from the node.
    pub(super) fn take_cancel(
        &mut self,
        line: &EmulatedLine,
        schedule: &mut EmulatorSchedule,
        cancel: &Cancel,
    ) {
        let Some(robot) = index_of(line, &cancel.robot).filter(|robot| !self.robots[*robot].down)
        else {
            return;
        };
        if let Some(report) = self.results.get(&cancel.task) {
            schedule.send(Incoming::Result(*report));
            return;
        }
        let its = &mut self.robots[robot];
        let mut back = None;
        if let Some(task) = its.task.as_ref().filter(|task| task.id == cancel.task) {
            if its.met {
                return;
            }
            let arm = &line.arm_of(robot).arm;
            let place = its.place;
            let whole = distance(task.meet.x - place.x, task.meet.y - place.y);
            let passed = schedule.now() - task.start;
            let way_back = match arm.constant_speed() {
                Some(speed) => (speed * passed).clamp(0.0, whole) / speed,
                None => passed.clamp(0.0, arm.time(whole)),
            };
            back = Some(schedule.now() + way_back);
            its.task = None;
        }
        self.conclude(schedule, cancel.task, Verdict::Cancelled, back);
    }

    /// A robot breaks down (`down`), or returns to service.
    pub(super) fn break_down(
        &mut self,
        line: &EmulatedLine,
        schedule: &mut EmulatorSchedule,
        robot: usize,
        down: bool,
    ) {
        let its = &mut self.robots[robot];
        its.down = down;
        let task = its.task.take();
        if let Some(task) = task.filter(|_| its.met) {
            // The item is in the gripper and does not reach the bin.
            self.picked.retain(|(_, item)| *item != task.item);
            self.stranded += 1;
        }
        its.met = false;
        let state = if down {
            RobotState::Fault
        } else {
            RobotState::Idle
        };
        schedule.send(line.robot_status(robot, state, schedule.now()));
    }
}

fn index_of(line: &EmulatedLine, name: &str) -> Option<usize> {
    let mut robots = line.station.robots().iter();
    robots.position(|robot| robot.name == name)
}

fn acknowledge(line: &EmulatedLine, schedule: &mut EmulatorSchedule, task: &Task) {
    let luck = line
        .faults
        .draw(FaultDraw::Ack, task.id << 16 | u64::from(task.revision));
    if luck >= line.faults.lost_acks {
        let (stamp, task) = (schedule.now(), task.id);
        schedule.send(Incoming::Ack(Ack { stamp, task }));
    }
}

/// Lets a robot, with its arm at `place` [m], that received its task too late meet the item further
/// downstream: it leaves at `now` [s]. So does one that moves otherwise than the station says. Returns
/// whether it can.
fn leave(
    line: &EmulatedLine,
    now: f64,
    (index, place): (usize, Point2<f64>),
    task: &mut Task,
) -> bool {
    let is_late = now - task.start > LATE;
    if !is_late && !line.differs() {
        return true;
    }
    let start = if is_late { now } else { task.start };
    move_out(line, start, (index, place), task)
}

/// Enters into `task` when and where a robot really meets the item that leaves `place` [m] at `start`
/// [s], and when it is free. Returns whether it meets the item in its workspace.
fn move_out(
    line: &EmulatedLine,
    start: f64,
    (index, place): (usize, Point2<f64>),
    task: &mut Task,
) -> bool {
    let (robot, belt) = (line.arm_of(index), line.station.belt());
    let x = task.meet.x - (line.travel(task.meet_at) - line.travel(start));
    let travel = robot.arm.travel_time(&Encounter {
        dx: x - place.x,
        dy: task.meet.y - place.y,
        belt_speed: belt.speed,
        upstream: -x,
        downstream: belt.length - x,
    });
    let off = |way| line.faults.time_off(way, task.id);
    let travel = (travel + off(FaultDraw::WayOut)).max(0.0);
    let (base, y) = (robot.base, task.meet.y);
    let range = meeting_range(base.x, base.y, robot.reach, y, belt.length);
    // One that is earlier than planned waits where the item comes into its reach.
    let edge = range.filter(|_| line.differs()).map(|(low, _)| low);
    let travel = edge.map_or(travel, |low| travel.max((low - x) / belt.speed));
    let x = x + belt.speed * travel;
    // Rounding does not put it back out of reach.
    let x = edge.map_or(x, |low| x.max(low));
    let back = robot
        .arm
        .time(distance(x - task.bin.x, task.meet.y - task.bin.y));
    let back = (back + off(FaultDraw::WayHome)).max(0.0);
    task.start = start;
    task.meet_at = start + travel;
    task.meet = BeltPoint { x, y };
    let at = Point2::new(task.bin.x, task.bin.y);
    let mut bins = robot.bins.iter();
    let bin = bins.find(|bin| bin.at == at).unwrap_or(&robot.bins[0]);
    task.free_at = task.meet_at + robot.grasp_time + back + bin.release_time;
    range.is_some_and(|(low, high)| (low..=high).contains(&x))
}
