//! A station that is not there: the camera, the belt and the robots, as messages.
//!
//! Like the controller it takes messages and the time and gives messages back. With
//! message time the two take turns ([`Emulator::round`]), and where nothing goes wrong
//! the line picks exactly what a simulation of it picks.

mod robots;
mod trouble;

pub use trouble::Trouble;

use super::protocol::{BeltState, Detection, Incoming, Report, RobotState, RobotStatus, Task};
use super::windows::Key;
use pickline::error::Result;
use pickline::pattern::{Item, Pattern};
use pickline::station::Station;
use std::collections::{BTreeMap, HashMap};
use trouble::Draw;

/// Time between two messages of the belt [s].
const BELT_PERIOD: f64 = 1.0;
/// Detections that are late come up to this much late [s].
const LATE: f64 = 1.0;
/// The camera sees items at least this far ahead of where a robot could leave for them [m].
const LEAD: f64 = 0.05;
/// How far past the belt's end the last item has to be at the end [m].
const PAST_THE_END: f64 = 0.75;

/// What happens at the station.
// Handed on one at a time.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone)]
enum Event {
    /// A message arrives.
    Arrives(Incoming),
    /// The belt's period is over.
    Belt,
    /// The belt stops or goes on.
    BeltTurns,
    /// A robot breaks down or comes back.
    Down(usize, bool),
    /// A robot meets the item of a task, by this revision of it.
    Meets(u64, u32),
    /// A robot is back at its bin.
    Back(usize, u64),
    /// The last item has left.
    End,
}

/// One robot.
#[derive(Debug, Clone, Default)]
struct Arm {
    down: bool,
    task: Option<Task>,
    /// Whether it has met the item already.
    met: bool,
}

/// An emulated station with a pattern on its belt.
#[derive(Debug)]
pub struct Emulator {
    station: Station,
    pattern: Pattern,
    trouble: Trouble,
    /// Stamp of the emulator's time 0 [s].
    origin: f64,
    now: f64,
    events: BTreeMap<Key, Event>,
    sequence: u32,
    arms: Vec<Arm>,
    numbers: HashMap<String, usize>,
    taken: Vec<bool>,
    attempts: Vec<u32>,
    /// What came of each task that is over.
    results: HashMap<u64, Report>,
    /// Times [s] between which the belt stands.
    stop: (f64, f64),
    ended: bool,
    sent: u64,
    ticked: bool,
    picked: Vec<(usize, String)>,
    stranded: usize,
    broken: Vec<String>,
}

impl Emulator {
    /// The station at time 0.
    ///
    /// # Errors
    /// An item beside the belt, trouble that is none.
    pub fn new(station: Station, pattern: Pattern, trouble: Trouble) -> Result<Self> {
        pattern.check_on(&station)?;
        trouble.check(station.robots().len())?;
        let items = pattern.len();
        let ids = pattern.items().iter().map(|item| item.id.clone());
        let stop = trouble
            .belt_stop
            .map_or((f64::INFINITY, f64::INFINITY), |(at, time)| (at, at + time));
        let mut emulator = Self {
            numbers: ids.zip(0..).collect(),
            arms: vec![Arm::default(); station.robots().len()],
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

    /// The station that is played.
    pub fn station(&self) -> &Station {
        &self.station
    }

    /// Puts the station's time 0 at this stamp [s].
    pub fn start_at(&mut self, origin: f64) {
        self.origin = origin;
    }

    fn begin(&mut self) {
        self.plan(0.0, Event::Belt);
        for robot in 0..self.arms.len() {
            self.tell_state(robot, RobotState::Idle);
        }
        if self.stop.0.is_finite() {
            self.plan(self.stop.0, Event::BeltTurns);
            self.plan(self.stop.1, Event::BeltTurns);
        }
        if let Some((robot, from, time)) = self.trouble.robot_down {
            self.plan(from, Event::Down(robot, true));
            self.plan(from + time, Event::Down(robot, false));
        }
        let camera = self.camera();
        let mut last = f64::INFINITY;
        for index in 0..self.pattern.len() {
            let item = self.pattern.items()[index].clone();
            last = last.min(item.x0);
            self.see(index as u64, &item, camera);
        }
        let end = self.time_of(self.station.belt().length + PAST_THE_END - last);
        self.plan(end, Event::End);
    }

    /// Where the camera looks [m]: upstream of wherever a robot could leave for an item.
    fn camera(&self) -> f64 {
        let belt = self.station.belt();
        let windows = self.pattern.items().iter().flat_map(|item| {
            let robots = self.station.robots().iter();
            let windows = robots.filter_map(|robot| robot.departure_window(belt, item.x0, item.y));
            windows.map(|(open, _)| item.x0 + belt.speed * open)
        });
        windows.fold(0.0, f64::min) - LEAD
    }

    /// Plans the detections of one item.
    fn see(&mut self, index: u64, item: &Item, camera: f64) {
        let mut time = self.time_of((camera - item.x0).max(0.0));
        let mut x = item.x0 + self.travel(time);
        // The reader subtracts the travel again; it should find the item where it is, to
        // the bit, so a stamp is taken for which the sum is exact enough.
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
        let late = self.trouble.draw(Draw::Late, index);
        let share = self.trouble.out_of_order;
        // The share that is late is so evenly up to LATE.
        let delay = if late < share {
            LATE * late / share
        } else {
            0.0
        };
        let arrives = time + delay + self.jitter();
        self.plan(arrives, Event::Arrives(detection(time, x)));
        if self.trouble.draw(Draw::Twice, index) < self.trouble.duplicates {
            let again = time + 0.1;
            let x = item.x0 + self.travel(again);
            let arrives = again + self.jitter();
            self.plan(arrives, Event::Arrives(detection(again, x)));
        }
    }

    /// How late the next message is [s].
    fn jitter(&mut self) -> f64 {
        self.sent += 1;
        if self.trouble.jitter == 0.0 {
            return 0.0;
        }
        self.trouble.jitter * self.trouble.draw(Draw::Jitter, self.sent)
    }

    /// How far the belt has travelled at `time` [m].
    fn travel(&self, time: f64) -> f64 {
        let stood = (time.min(self.stop.1) - self.stop.0).max(0.0);
        let moved = if stood > 0.0 { time - stood } else { time };
        self.station.belt().speed * moved
    }

    /// When the belt has travelled so far [s].
    fn time_of(&self, travel: f64) -> f64 {
        let time = travel / self.station.belt().speed;
        if time > self.stop.0 {
            time + (self.stop.1 - self.stop.0)
        } else {
            time
        }
    }

    fn plan(&mut self, time: f64, event: Event) {
        // Equal times happen in the order in which they were planned.
        self.sequence += 1;
        self.events.insert(Key(time, self.sequence), event);
    }

    /// A message leaves for the node now; it is stamped now.
    fn send(&mut self, message: Incoming) {
        let arrives = self.now + self.jitter();
        self.plan(arrives, Event::Arrives(message));
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

    /// Stamp at which something happens next [s]; none when all is over.
    pub fn next_stamp(&self) -> Option<f64> {
        self.next_event().map(|time| self.origin + time)
    }

    fn next_event(&self) -> Option<f64> {
        let at_work = self.arms.iter().any(|arm| arm.task.is_some());
        let mut events = self.events.iter();
        if self.ended && !at_work {
            // The belt's messages alone are no reason to go on.
            return events
                .find(|(_, event)| !matches!(event, Event::Belt))
                .map(|(key, _)| key.0);
        }
        events.next().map(|(key, _)| key.0)
    }

    /// Lets everything happen that happens up to `stamp` [s]; returns what reaches the node.
    pub fn advance(&mut self, stamp: f64) -> Vec<Incoming> {
        let until = stamp - self.origin;
        let mut arrived = Vec::new();
        while let Some(first) = self.events.first_entry()
            && first.key().0 <= until
        {
            let (key, event) = first.remove_entry();
            self.now = self.now.max(key.0);
            match event {
                Event::Arrives(message) => arrived.push(self.stamped(message)),
                other => self.happen(other),
            }
        }
        self.now = self.now.max(until);
        arrived
    }

    fn happen(&mut self, event: Event) {
        match event {
            Event::Arrives(_) => {}
            Event::Belt => {
                self.tell_belt();
                if !self.ended {
                    self.plan(self.now + BELT_PERIOD, Event::Belt);
                }
            }
            Event::BeltTurns => self.tell_belt(),
            Event::Down(robot, down) => self.break_down(robot, down),
            Event::Meets(task, revision) => self.meet(task, revision),
            Event::Back(robot, task) => self.come_back(robot, task),
            Event::End => self.ended = true,
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

    /// The message with its times put onto the common clock.
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

    /// One turn with message time: what reaches the node next, with a tick at its end;
    /// empty when all is over. `due` is what the node has said to be due next [s].
    pub fn round(&mut self, due: Option<f64>) -> Vec<Incoming> {
        let next = match (self.next_stamp(), due) {
            (Some(own), Some(due)) => own.min(due),
            (Some(own), None) => own,
            // Nothing more happens here; what the node still waits for runs out.
            (None, Some(due)) if !self.ended || !self.ticked => due,
            (None, _) => return Vec::new(),
        };
        self.ticked = self.next_stamp().is_none();
        let mut messages = self.advance(next);
        messages.push(Incoming::Tick { stamp: next });
        messages
    }

    /// What the robots have picked: index of the robot and id of the item, in the order of
    /// the grasps.
    pub fn picked(&self) -> &[(usize, String)] {
        &self.picked
    }

    /// Items that were in the gripper of a robot when it broke down. No bin gets them.
    pub fn stranded(&self) -> usize {
        self.stranded
    }

    /// What the node did that it must never do.
    pub fn broken_promises(&self) -> &[String] {
        &self.broken
    }
}
