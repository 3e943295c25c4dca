//! Clocks that are set, sources that fall silent: a line whose two clocks the test holds.

mod silence;
mod steps;

use crate::support::line::Line;
use crate::support::three;
use pickline::strategies::read_alone;
use pickline_live::protocol::{Outgoing, SourceReport, Status};
use pickline_live::{Config, Controller, SteadyClock};
use std::collections::{BTreeMap, BTreeSet};

/// The robots of the line.
const ROBOTS: [&str; 2] = ["delta-1", "arm-3"];

/// Whose clock a peer goes by.
#[derive(Clone, Copy, PartialEq)]
enum Whose {
    /// The machine's, with its steps.
    Machine,
    /// One of its own, which is ahead by so much [s] and is never set.
    Own(f64),
}

/// A line with a true belt of 0.3 m/s, its camera, encoder and robots, by the system's clock.
struct World {
    controller: Controller,
    steady: SteadyClock,
    /// True time [s].
    now: f64,
    /// By how much the machine's clock is ahead of it [s].
    wall: f64,
    camera: Whose,
    robots: Whose,
    /// When the belt stops [s].
    stop: f64,
    /// Until when the encoder speaks [s].
    encoder_until: f64,
    /// Where each item would be at time 0 [m], along the belt and across.
    items: BTreeMap<String, (f64, f64)>,
    /// Results to come: when, of which task, of whom.
    open: Vec<(f64, u64)>,
    /// When each task was given [s], by how much its meeting point is off [m], and to whom.
    given: Vec<(f64, f64, String)>,
    /// The items of these tasks.
    sent_to: Vec<String>,
    remarks: Vec<String>,
    refused: Vec<String>,
}

const START: f64 = 1.75e9;

/// How the machine's clock is set: when [s], and how far ahead it is from then on [s].
const STEPS: [(&str, &[(f64, f64)]); 6] = [
    ("is not set", &[]),
    ("is set back by 5 s", &[(5.0, -5.0)]),
    ("is set forward by 5 s", &[(5.0, 5.0)]),
    ("is 100 s ahead for 2 s", &[(5.0, 100.0), (7.0, 0.0)]),
    ("is set back by an hour", &[(5.0, -3600.0)]),
    (
        "goes 0.2 s back and forth",
        &[(5.0, -0.2), (8.0, 0.2), (8.5, 0.0)],
    ),
];

impl World {
    fn new(config: Config) -> Self {
        let station = three::station_of(&ROBOTS);
        let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
        let mut world = Self {
            controller: Controller::new(station, strategy, config).unwrap(),
            steady: SteadyClock::default(),
            now: 0.0,
            wall: 0.0,
            camera: Whose::Machine,
            robots: Whose::Machine,
            stop: f64::INFINITY,
            encoder_until: f64::INFINITY,
            items: BTreeMap::new(),
            open: Vec::new(),
            given: Vec::new(),
            sent_to: Vec::new(),
            remarks: Vec::new(),
            refused: Vec::new(),
        };
        world.step();
        world
    }

    fn travel(&self, time: f64) -> f64 {
        0.3 * time.min(self.stop)
    }

    fn stamp(&self, whose: Whose, time: f64) -> f64 {
        START
            + time
            + match whose {
                Whose::Machine => self.wall,
                Whose::Own(ahead) => ahead,
            }
    }

    /// The controller takes a message that was sent just now, 2 ms ago.
    fn say(&mut self, whose: Whose, fields: &str) {
        self.say_of(whose, self.now - 0.002, fields);
    }

    /// The controller takes a message about the time `then` [s].
    fn say_of(&mut self, whose: Whose, then: f64, fields: &str) {
        let stamp = self.stamp(whose, then);
        let message = Line::message(&format!(r#""stamp":{stamp},{fields}"#));
        let reading = self.steady.read(self.now, START + self.now + self.wall);
        self.controller.set_clock_ahead(reading.ahead);
        if let Err(rejected) = self.controller.hear(message, reading.stamp) {
            self.refused.push(rejected.message);
        }
    }

    fn step(&mut self) {
        let reading = self.steady.read(self.now, START + self.now + self.wall);
        self.controller.set_clock_ahead(reading.ahead);
        self.controller.advance(reading.stamp);
        self.remarks.append(&mut self.controller.take_remarks());
        for message in self.controller.take_output() {
            let Outgoing::Task(task) = message else {
                continue;
            };
            let now = self.stamp(self.robots, self.now);
            self.say(self.robots, &format!(r#""kind":"ack","task":{}"#, task.id));
            if task.revision > 0 {
                continue;
            }
            let lead = task.meet_at - now;
            let x = self.items[&task.item].0 + self.travel(self.now + lead);
            // Nobody knows of a stop before it comes.
            let is_crossed = self.now < self.stop && self.now + lead > self.stop;
            let off = if is_crossed {
                0.0
            } else {
                (x - task.meet.x).abs()
            };
            self.given.push((self.now, off, task.robot));
            self.sent_to.push(task.item);
            self.open
                .push((self.now + lead.clamp(0.2, 3.0) + 0.2, task.id));
        }
    }

    /// Plays until `until` [s], with these steps of the machine's clock: when, and to what.
    fn play(&mut self, until: f64, steps: &[(f64, f64)]) {
        let belt = |world: &World| {
            let travel = world.travel(world.now - 0.002);
            let speed = if world.now >= world.stop { 0.0 } else { 0.3 };
            format!(r#""kind":"belt","speed":{speed},"position":{travel}"#)
        };
        if self.now == 0.0 {
            let first = belt(self);
            self.say(Whose::Machine, &first);
            for name in ROBOTS {
                let idle = format!(r#""kind":"robot","name":"{name}","state":"idle""#);
                self.say(self.robots, &idle);
            }
        }
        while self.now < until {
            self.now += 0.01;
            let hundredth = (self.now * 100.0).round() as u32;
            let at = |every: u32| hundredth.is_multiple_of(every);
            if let Some((_, wall)) = steps.iter().rfind(|(at, _)| *at <= self.now) {
                self.wall = *wall;
            }
            if at(10) && self.now <= self.encoder_until {
                let text = belt(self);
                self.say(Whose::Machine, &text);
            }
            if at(25) && self.now < self.stop {
                let id = format!("i{}", self.items.len());
                let y = 0.1 * (self.items.len() % 5) as f64 - 0.2;
                let x = 0.2 - self.travel(self.now - 0.002);
                self.items.insert(id.clone(), (x, y));
                let text = format!(r#""kind":"detection","x":0.2,"y":{y},"id":"{id}""#);
                self.say(self.camera, &text);
            }
            let now = self.now;
            let (due, open) = std::mem::take(&mut self.open)
                .into_iter()
                .partition::<Vec<_>, _>(|(at, _)| *at <= now);
            self.open = open;
            for (_, task) in due {
                let text = format!(r#""kind":"result","task":{task},"result":"PICKED""#);
                self.say(self.robots, &text);
            }
            self.step();
        }
    }

    fn status(&self) -> Status {
        self.controller.status(false, 0)
    }

    fn source(&self, name: &str) -> SourceReport {
        let found = self.status().sources.into_iter();
        found.into_iter().find(|s| s.name == name).unwrap()
    }

    /// Tasks that met their items more than 5 mm off.
    fn wrong(&self) -> Vec<&(f64, f64, String)> {
        self.given.iter().filter(|given| given.1 > 0.005).collect()
    }

    /// Items to which a robot was sent although another robot had been sent there: each task here is
    /// picked.
    fn sent_twice(&self) -> Vec<String> {
        let mut seen = BTreeSet::new();
        let twice = self.sent_to.iter().filter(|item| !seen.insert(*item));
        twice.cloned().collect()
    }

    /// The longest time between two tasks [s].
    fn longest_gap(&self) -> f64 {
        let gaps = self.given.windows(2).map(|pair| pair[1].0 - pair[0].0);
        gaps.fold(0.0, f64::max)
    }

    /// Tasks were given all the time, to where their items were.
    fn check(&self, case: &str) {
        assert!(self.wrong().is_empty(), "{case}: {:?}", self.wrong());
        let gap = self.longest_gap();
        assert!(gap < 2.0, "{case}: {gap} s without a task");
        let last = self.now.min(self.stop) - self.given.last().unwrap().0;
        assert!(last < 2.0, "{case}: none in the last {last} s");
        assert!(self.refused.is_empty(), "{case}: {:?}", self.refused);
        let status = self.status();
        assert_eq!(status.noted.get("late_belt"), None, "{case}");
        assert!(
            status.picked as f64 > 0.8 * self.given.len() as f64,
            "{case}"
        );
    }
}
