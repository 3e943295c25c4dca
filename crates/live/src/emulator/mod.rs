//! An emulated station: it plays the camera, the belt and the robots by messages.
//!
//! Like the controller it takes messages and the time and gives messages. With message time the two
//! take turns ([`Emulator::round`]), and without faults the line picks exactly what a simulation of
//! it picks.

mod line;
mod robots;
mod schedule;
mod trouble;

pub use trouble::InjectedFaults;

use super::protocol::{Detection, Incoming, Outgoing, RobotState, Task};
use line::EmulatedLine;
use pickline::error::{Error, Result};
use pickline::pattern::{Item, Pattern};
use pickline::station::{Robot, Station};
use robots::EmulatedRobots;
use schedule::{EmulatorEvent, EmulatorSchedule};
use trouble::FaultDraw;

/// Interval between two belt messages [s].
const BELT_PERIOD: f64 = 1.0;
/// Maximum delay of late detections [s].
const LATE: f64 = 1.0;
/// A detection that is sent twice is sent again after this time [s].
const REPEATED_AFTER: f64 = 0.1;

/// An emulated station with a pattern on its belt.
#[derive(Debug)]
pub struct Emulator {
    line: EmulatedLine,
    schedule: EmulatorSchedule,
    robots: EmulatedRobots,
    /// Timestamp of the emulator's time 0 [s].
    origin: f64,
    /// Whether the last item has left the belt.
    ended: bool,
    /// Whether the last turn found nothing more to happen here.
    ticked: bool,
}

impl Emulator {
    /// An emulated station at time 0, with `pattern` on its belt and the faults of `trouble`.
    ///
    /// # Errors
    /// An item beside the belt, or invalid faults.
    pub fn new(station: Station, pattern: Pattern, trouble: InjectedFaults) -> Result<Self> {
        let line = EmulatedLine::new(station, pattern, trouble)?;
        let mut emulator = Self {
            schedule: EmulatorSchedule::new(trouble),
            robots: EmulatedRobots::new(&line),
            line,
            origin: 0.0,
            ended: false,
            ticked: false,
        };
        emulator.begin();
        Ok(emulator)
    }

    /// The same emulator with arms that move like those of another station with the same robots,
    /// while the protocol and the node's plan are those of its own.
    ///
    /// # Errors
    /// A station with another belt, or with other robots, bases, bins or another reach.
    pub fn with_true_station(mut self, true_station: &Station) -> Result<Self> {
        let (planned, real) = (self.line.station.robots(), true_station.robots());
        let place = |robot: &Robot| {
            let bins = robot.bins.iter();
            let bins: Vec<_> = bins.map(|bin| (bin.at, bin.classes.clone())).collect();
            (
                robot.name.clone(),
                robot.base,
                robot.rest,
                robot.reach,
                bins,
            )
        };
        let cure = "change only how the arms move: speed, acceleration, travel, lift, grasp_time and \
                    release_time";
        if self.line.station.belt() != true_station.belt() {
            let problem = "its belt is not that of the station";
            return Err(Error::usage("'true_station'", problem, cure));
        }
        if !planned.iter().map(place).eq(real.iter().map(place)) {
            return Err(Error::usage(
                "'true_station'",
                "its robots have other names, bases, bins or another reach than those of the station",
                cure,
            ));
        }
        self.line.arms = Some(real.to_vec());
        Ok(self)
    }

    /// The station as given in its file.
    pub fn station(&self) -> &Station {
        &self.line.station
    }

    /// Sets the timestamp of the station's time 0 [s].
    pub fn start_at(&mut self, origin: f64) {
        self.origin = origin;
    }

    fn begin(&mut self) {
        let (line, schedule) = (&self.line, &mut self.schedule);
        schedule.add(0.0, EmulatorEvent::Belt);
        for robot in 0..line.station.robots().len() {
            schedule.send(line.robot_status(robot, RobotState::Idle, 0.0));
        }
        let (stops, restarts) = line.belt_stop;
        if stops.is_finite() {
            schedule.add(stops, EmulatorEvent::BeltTurns);
            schedule.add(restarts, EmulatorEvent::BeltTurns);
        }
        if let Some((robot, from, time)) = line.faults.robot_down {
            schedule.add(from, EmulatorEvent::Down(robot, true));
            schedule.add(from + time, EmulatorEvent::Down(robot, false));
        }
        let camera = line.camera();
        for (index, item) in (0..).zip(line.pattern.items()) {
            see(line, schedule, index, item, camera);
        }
        schedule.add(line.end(), EmulatorEvent::End);
    }

    /// Handles a message from the node, now.
    pub fn receive(&mut self, message: Outgoing) {
        let (line, schedule) = (&self.line, &mut self.schedule);
        match message {
            Outgoing::Task(task) => {
                let task = by_own_clock(task, self.origin);
                self.robots.take_task(line, schedule, task);
            }
            Outgoing::Cancel(cancel) => self.robots.take_cancel(line, schedule, &cancel),
            Outgoing::BeltRequest(_) | Outgoing::Status(_) | Outgoing::Due(_) => {}
        }
    }

    /// Timestamp of the next event [s]; none when everything is over.
    pub fn next_stamp(&self) -> Option<f64> {
        self.next_event().map(|time| self.origin + time)
    }

    fn next_event(&self) -> Option<f64> {
        // Belt messages alone do not keep the run going.
        let is_over = self.ended && !self.robots.are_at_work();
        let counts = |event: &EmulatorEvent| !is_over || !matches!(event, EmulatorEvent::Belt);
        self.schedule.first(counts)
    }

    /// Plays all events up to `stamp` [s]. Returns the messages that reach the node.
    pub fn advance(&mut self, stamp: f64) -> Vec<Incoming> {
        let until = stamp - self.origin;
        let mut arrived = Vec::new();
        while let Some(event) = self.schedule.take_until(until) {
            match event {
                EmulatorEvent::Arrives(message) => arrived.push(self.stamped(message)),
                other => self.happen(other),
            }
        }
        arrived
    }

    fn happen(&mut self, event: EmulatorEvent) {
        let (line, schedule) = (&self.line, &mut self.schedule);
        let now = schedule.now();
        match event {
            EmulatorEvent::Arrives(_) => {}
            EmulatorEvent::Belt => {
                schedule.send(line.belt_state(now));
                if !self.ended {
                    schedule.add(now + BELT_PERIOD, EmulatorEvent::Belt);
                }
            }
            EmulatorEvent::BeltTurns => schedule.send(line.belt_state(now)),
            EmulatorEvent::Down(robot, down) => self.robots.break_down(line, schedule, robot, down),
            EmulatorEvent::Meets(task, revision) => {
                self.robots.meet(line, schedule, task, revision);
            }
            EmulatorEvent::Back(robot, task) => self.robots.come_back(schedule, robot, task),
            EmulatorEvent::End => self.ended = true,
        }
    }

    /// The message with its times on the common clock.
    fn stamped(&self, mut message: Incoming) -> Incoming {
        let origin = self.origin;
        let later = |time: &mut Option<f64>| *time = time.map(|time| origin + time);
        match &mut message {
            Incoming::Detection(m) => m.stamp += origin,
            Incoming::Belt(m) => m.stamp += origin,
            Incoming::Ack(m) => m.stamp += origin,
            Incoming::Pause(order)
            | Incoming::Resume(order)
            | Incoming::Drain(order)
            | Incoming::Stop(order) => order.stamp += origin,
            Incoming::Tick { stamp } => *stamp += origin,
            Incoming::Robot(m) => {
                m.stamp += origin;
                later(&mut m.available_at);
            }
            Incoming::Result(m) => {
                m.stamp += origin;
                later(&mut m.available_at);
            }
        }
        message
    }

    /// One turn with message time: the messages that reach the node next, with a tick at the end;
    /// empty when everything is over. `due` is the node's next due time [s].
    pub fn round(&mut self, due: Option<f64>) -> Vec<Incoming> {
        let next = match (self.next_stamp(), due) {
            (Some(own), Some(due)) => own.min(due),
            (Some(own), None) => own,
            // Nothing more happens here; let the node's timeouts pass.
            (None, Some(due)) if !self.ended || !self.ticked => due,
            (None, _) => return Vec::new(),
        };
        self.ticked = self.next_stamp().is_none();
        let mut messages = self.advance(next);
        messages.push(Incoming::Tick { stamp: next });
        messages
    }

    /// The robots' picks: index of the robot and id of the item, in the order of the grasps.
    pub fn picked(&self) -> &[(usize, String)] {
        self.robots.picked()
    }

    /// Number of items that were in a gripper when the robot broke down. They reach no bin.
    pub fn stranded(&self) -> usize {
        self.robots.stranded()
    }

    /// The node's violations of the protocol's guarantees.
    pub fn broken_promises(&self) -> &[String] {
        self.robots.broken_promises()
    }
}

/// Schedules the detections of item number `index`, which passes a camera at x = `camera` [m].
fn see(line: &EmulatedLine, schedule: &mut EmulatorSchedule, index: u64, item: &Item, camera: f64) {
    let mut time = line.time_of((camera - item.x0).max(0.0));
    let mut x = item.x0 + line.travel(time);
    // The reader subtracts the travel again and should find the item's position bit-exactly, so
    // choose a timestamp for which the sum is exact enough.
    for _ in 0..64 {
        if x - line.travel(time) == item.x0 {
            break;
        }
        time = time.next_up();
        x = item.x0 + line.travel(time);
    }
    let late = line.faults.draw(FaultDraw::Late, index);
    let share = line.faults.out_of_order;
    // Delays of the late share are uniform up to LATE.
    let delay = if late < share {
        LATE * late / share
    } else {
        0.0
    };
    schedule.send_at(time + delay, detection(item, time, x));
    if line.faults.draw(FaultDraw::Twice, index) < line.faults.duplicates {
        let again = time + REPEATED_AFTER;
        let x = item.x0 + line.travel(again);
        schedule.send_at(again, detection(item, again, x));
    }
}

/// The detection of an item at `time` [s] and `x` [m].
fn detection(item: &Item, time: f64, x: f64) -> Incoming {
    Incoming::Detection(Detection {
        stamp: time,
        id: Some(item.id.clone()),
        x,
        y: item.y,
        area_cm2: item.area_cm2,
        p_detection: item.p_detection,
        p_grasp: item.p_grasp,
        weight: item.weight,
        class: item.class.clone(),
        ..Detection::default()
    })
}

/// The task with its times [s] since `origin` [s].
fn by_own_clock(mut task: Task, origin: f64) -> Task {
    for time in [
        &mut task.decided_at,
        &mut task.start,
        &mut task.earliest_start,
        &mut task.latest_start,
        &mut task.meet_at,
        &mut task.free_at,
    ] {
        *time -= origin;
    }
    task
}
