//! An emulated station: it plays the camera, the belt and the robots by messages.
//!
//! Like the controller it takes messages and the time and gives messages. With message time the two
//! take turns ([`Emulator::round`]), and without faults the line picks exactly what a simulation of
//! it picks.

mod robots;
mod trouble;

pub use trouble::InjectedFaults;

use super::protocol::{
    BeltState, Detection, Incoming, ResultMessage, RobotState, RobotStatus, Task,
};
use super::windows::TimeKey;
use pickline::error::Result;
use pickline::pattern::{Item, Pattern};
use pickline::station::Station;
use std::collections::{BTreeMap, HashMap};
use trouble::FaultDraw;

/// Interval between two belt messages [s].
const BELT_PERIOD: f64 = 1.0;
/// Maximum delay of late detections [s].
const LATE: f64 = 1.0;
/// The camera sees items at least this far upstream of the point where a robot could leave for them
/// [m].
const LEAD: f64 = 0.05;
/// The run ends when the last item is this far past the belt's end [m].
const PAST_THE_END: f64 = 0.75;

/// An event at the station.
// Events are passed on one at a time.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
enum EmulatorEvent {
    /// A message arrives at the node.
    Arrives(Incoming),
    /// The next belt message is due.
    Belt,
    /// The belt stops or restarts.
    BeltTurns,
    /// A robot (index) breaks down (true) or returns to service.
    Down(usize, bool),
    /// A robot meets the item of a task (id), by this revision of it.
    Meets(u64, u32),
    /// A robot (index) is back at its bin after a task (id).
    Back(usize, u64),
    /// The last item has left the belt.
    End,
}

/// An emulated robot.
#[derive(Debug, Clone, Default)]
struct EmulatedRobot {
    down: bool,
    task: Option<Task>,
    /// Whether it has already met the item.
    met: bool,
}

/// An emulated station with a pattern on its belt.
#[derive(Debug)]
pub struct Emulator {
    station: Station,
    pattern: Pattern,
    trouble: InjectedFaults,
    /// Timestamp of the emulator's time 0 [s].
    origin: f64,
    now: f64,
    events: BTreeMap<TimeKey, EmulatorEvent>,
    sequence: u32,
    arms: Vec<EmulatedRobot>,
    numbers: HashMap<String, usize>,
    taken: Vec<bool>,
    attempts: Vec<u32>,
    /// The result of each task that is over.
    results: HashMap<u64, ResultMessage>,
    /// Start and end of the belt's stop [s].
    stop: (f64, f64),
    ended: bool,
    sent: u64,
    ticked: bool,
    picked: Vec<(usize, String)>,
    stranded: usize,
    broken: Vec<String>,
}

impl Emulator {
    /// An emulated station at time 0, with `pattern` on its belt and the faults of `trouble`.
    ///
    /// # Errors
    /// An item beside the belt, or invalid faults.
    pub fn new(station: Station, pattern: Pattern, trouble: InjectedFaults) -> Result<Self> {
        pattern.check_on(&station)?;
        trouble.check(station.robots().len())?;
        let items = pattern.len();
        let ids = pattern.items().iter().map(|item| item.id.clone());
        let stop = trouble
            .belt_stop
            .map_or((f64::INFINITY, f64::INFINITY), |(at, time)| (at, at + time));
        let mut emulator = Self {
            numbers: ids.zip(0..).collect(),
            arms: vec![EmulatedRobot::default(); station.robots().len()],
            station,
            pattern,
            trouble,
            origin: 0.0,
            now: 0.0,
            events: BTreeMap::new(),
            sequence: 0,
            taken: vec![false; items],
            attempts: vec![0; items],
            results: HashMap::new(),
            stop,
            ended: false,
            sent: 0,
            ticked: false,
            picked: Vec::new(),
            stranded: 0,
            broken: Vec::new(),
        };
        emulator.begin();
        Ok(emulator)
    }

    /// The emulated station.
    pub fn station(&self) -> &Station {
        &self.station
    }

    /// Sets the timestamp of the station's time 0 [s].
    pub fn start_at(&mut self, origin: f64) {
        self.origin = origin;
    }

    fn begin(&mut self) {
        self.plan(0.0, EmulatorEvent::Belt);
        for robot in 0..self.arms.len() {
            self.tell_state(robot, RobotState::Idle);
        }
        if self.stop.0.is_finite() {
            self.plan(self.stop.0, EmulatorEvent::BeltTurns);
            self.plan(self.stop.1, EmulatorEvent::BeltTurns);
        }
        if let Some((robot, from, time)) = self.trouble.robot_down {
            self.plan(from, EmulatorEvent::Down(robot, true));
            self.plan(from + time, EmulatorEvent::Down(robot, false));
        }
        let camera = self.camera();
        let mut last = f64::INFINITY;
        for index in 0..self.pattern.len() {
            let item = self.pattern.items()[index].clone();
            last = last.min(item.x0);
            self.see(index as u64, &item, camera);
        }
        let end = self.time_of(self.station.belt().length + PAST_THE_END - last);
        self.plan(end, EmulatorEvent::End);
    }

    /// The camera's x [m]: upstream of every point where a robot could leave for an item.
    fn camera(&self) -> f64 {
        let belt = self.station.belt();
        let windows = self.pattern.items().iter().flat_map(|item| {
            let robots = self.station.robots().iter();
            let windows = robots.filter_map(|robot| robot.departure_window(belt, item.x0, item.y));
            windows.map(|(open, _)| item.x0 + belt.speed * open)
        });
        windows.fold(0.0, f64::min) - LEAD
    }

    /// Schedules the detections of one item.
    fn see(&mut self, index: u64, item: &Item, camera: f64) {
        let mut time = self.time_of((camera - item.x0).max(0.0));
        let mut x = item.x0 + self.travel(time);
        // The reader subtracts the travel again and should find the item's position bit-exactly, so
        // choose a timestamp for which the sum is exact enough.
        for _ in 0..64 {
            if x - self.travel(time) == item.x0 {
                break;
            }
            time = time.next_up();
            x = item.x0 + self.travel(time);
        }
        let detection = |time: f64, x: f64| {
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
        };
        let late = self.trouble.draw(FaultDraw::Late, index);
        let share = self.trouble.out_of_order;
        // Delays of the late share are uniform up to LATE.
        let delay = if late < share {
            LATE * late / share
        } else {
            0.0
        };
        let arrives = time + delay + self.jitter();
        self.plan(arrives, EmulatorEvent::Arrives(detection(time, x)));
        if self.trouble.draw(FaultDraw::Twice, index) < self.trouble.duplicates {
            let again = time + 0.1;
            let x = item.x0 + self.travel(again);
            let arrives = again + self.jitter();
            self.plan(arrives, EmulatorEvent::Arrives(detection(again, x)));
        }
    }

    /// Delay of the next message [s].
    fn jitter(&mut self) -> f64 {
        self.sent += 1;
        if self.trouble.jitter == 0.0 {
            return 0.0;
        }
        self.trouble.jitter * self.trouble.draw(FaultDraw::Jitter, self.sent)
    }

    /// The belt's travel at `time` [m].
    fn travel(&self, time: f64) -> f64 {
        let stood = (time.min(self.stop.1) - self.stop.0).max(0.0);
        let moved = if stood > 0.0 { time - stood } else { time };
        self.station.belt().speed * moved
    }

    /// The time at which the belt's travel is `travel` [s].
    fn time_of(&self, travel: f64) -> f64 {
        let time = travel / self.station.belt().speed;
        if time > self.stop.0 {
            time + (self.stop.1 - self.stop.0)
        } else {
            time
        }
    }

    fn plan(&mut self, time: f64, event: EmulatorEvent) {
        // Events at equal times happen in the order in which they were scheduled.
        self.sequence += 1;
        self.events.insert(TimeKey(time, self.sequence), event);
    }

    /// Sends a message to the node now, with the present timestamp.
    fn send(&mut self, message: Incoming) {
        let arrives = self.now + self.jitter();
        self.plan(arrives, EmulatorEvent::Arrives(message));
    }

    fn tell_state(&mut self, robot: usize, state: RobotState) {
        self.send(Incoming::Robot(RobotStatus {
            stamp: self.now,
            name: self.station.robots()[robot].name.clone(),
            state,
            available_at: None,
            task: None,
        }));
    }

    /// Timestamp of the next event [s]; none when everything is over.
    pub fn next_stamp(&self) -> Option<f64> {
        self.next_event().map(|time| self.origin + time)
    }

    fn next_event(&self) -> Option<f64> {
        let at_work = self.arms.iter().any(|arm| arm.task.is_some());
        let mut events = self.events.iter();
        if self.ended && !at_work {
            // Belt messages alone do not keep the run going.
            return events
                .find(|(_, event)| !matches!(event, EmulatorEvent::Belt))
                .map(|(key, _)| key.0);
        }
        events.next().map(|(key, _)| key.0)
    }

    /// Plays all events up to `stamp` [s]. Returns the messages that reach the node.
    pub fn advance(&mut self, stamp: f64) -> Vec<Incoming> {
        let until = stamp - self.origin;
        let mut arrived = Vec::new();
        while let Some(first) = self.events.first_entry()
            && first.key().0 <= until
        {
            let (key, event) = first.remove_entry();
            self.now = self.now.max(key.0);
            match event {
                EmulatorEvent::Arrives(message) => arrived.push(self.stamped(message)),
                other => self.happen(other),
            }
        }
        self.now = self.now.max(until);
        arrived
    }

    fn happen(&mut self, event: EmulatorEvent) {
        match event {
            EmulatorEvent::Arrives(_) => {}
            EmulatorEvent::Belt => {
                self.tell_belt();
                if !self.ended {
                    self.plan(self.now + BELT_PERIOD, EmulatorEvent::Belt);
                }
            }
            EmulatorEvent::BeltTurns => self.tell_belt(),
            EmulatorEvent::Down(robot, down) => self.break_down(robot, down),
            EmulatorEvent::Meets(task, revision) => self.meet(task, revision),
            EmulatorEvent::Back(robot, task) => self.come_back(robot, task),
            EmulatorEvent::End => self.ended = true,
        }
    }

    fn tell_belt(&mut self) {
        let stands = (self.stop.0..self.stop.1).contains(&self.now);
        let speed = if stands {
            0.0
        } else {
            self.station.belt().speed
        };
        self.send(Incoming::Belt(BeltState {
            stamp: self.now,
            speed,
            position: Some(self.travel(self.now)),
            source: None,
        }));
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
        &self.picked
    }

    /// Number of items that were in a gripper when the robot broke down. They reach no bin.
    pub fn stranded(&self) -> usize {
        self.stranded
    }

    /// The node's violations of the protocol's guarantees.
    pub fn broken_promises(&self) -> &[String] {
        &self.broken
    }
}
