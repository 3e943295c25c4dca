//! A live line of three unlike robots whose reaches overlap, message by message.
#![allow(dead_code)]

use pickline::station::{self, Belt, Overrides, Station};
use pickline::strategies::read_alone;
use pickline_live::protocol::{BeltRequest, Incoming, Outgoing, Status, Task, decode};
use pickline_live::{ClockKind, Config, Controller};

/// The names of the robots.
pub const ROBOTS: [&str; 3] = ["delta-1", "scara-2", "arm-3"];

/// The station's file.
pub const STATION: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../tests/live/support/three.toml"
);

/// The station.
pub fn station() -> Station {
    station::load(STATION, Overrides::default()).unwrap()
}

/// The same belt with only these of the robots.
pub fn station_of(robots: &[&str]) -> Station {
    let station = station();
    let kept = station.robots().iter();
    let kept = kept.filter(|robot| robots.contains(&robot.name.as_str()));
    Station::new(*station.belt(), kept.cloned().collect()).unwrap()
}

/// The station with a belt of another length [m].
pub fn station_of_length(length: f64) -> Station {
    let station = station();
    let belt = Belt {
        length,
        ..*station.belt()
    };
    Station::new(belt, station.robots().to_vec()).unwrap()
}

/// Message time, and a station as it is.
pub fn config() -> Config {
    Config::default().with_clock(ClockKind::Messages)
}

/// The strategy: each robot takes the item that is quickest.
pub fn strategy() -> Box<dyn pickline::decision::Strategy> {
    read_alone("SPT,SPT,SPT", 3).unwrap().make()
}

/// The line, and what it has said since it was last asked.
pub struct Three {
    pub controller: Controller,
    pub said: Vec<Outgoing>,
}

impl Three {
    /// A line of which nothing is known but that its belt runs at `speed` [m/s].
    pub fn new(speed: f64) -> Self {
        Self::with(config(), speed)
    }

    /// The same under another configuration.
    pub fn with(config: Config, speed: f64) -> Self {
        Self::on(station(), strategy(), config, speed)
    }

    /// The same on another station, under another strategy.
    pub fn on(
        station: Station,
        strategy: Box<dyn pickline::decision::Strategy>,
        config: Config,
        speed: f64,
    ) -> Self {
        let mut line = Self::of(Controller::new(station, strategy, config).unwrap());
        line.belt(100.0, speed);
        line
    }

    /// A line of this controller, which has heard nothing here.
    pub fn of(controller: Controller) -> Self {
        Self {
            controller,
            said: Vec::new(),
        }
    }

    /// Two robots on a standing belt that have just been given a task each; what was said is
    /// still to be read.
    pub fn two_with_tasks() -> Self {
        let mut line = Self::new(0.0);
        for robot in ["delta-1", "arm-3"] {
            line.robot(100.0, robot, "idle");
        }
        line.see(100.0, "a", 0.8, 0.0);
        line.see(100.0, "b", 2.6, 0.0);
        line.tick(100.0);
        line
    }

    /// The same when the tasks have been read, and not acknowledged.
    pub fn two_at_work() -> Self {
        let mut line = Self::two_with_tasks();
        assert_eq!(line.told(), ["task 1.0 delta-1 a", "task 2.0 arm-3 b"]);
        line
    }

    pub fn belt(&mut self, stamp: f64, speed: f64) {
        self.say(&format!(r#""kind":"belt","stamp":{stamp},"speed":{speed}"#));
    }

    pub fn message(fields: &str) -> Incoming {
        decode(format!("{{{fields}}}").as_bytes()).unwrap()
    }

    pub fn say(&mut self, fields: &str) {
        self.controller.handle(Self::message(fields)).unwrap();
        self.said.extend(self.controller.take_output());
    }

    pub fn robot(&mut self, stamp: f64, name: &str, state: &str) {
        self.say(&format!(
            r#""kind":"robot","stamp":{stamp},"name":"{name}","state":"{state}""#
        ));
    }

    pub fn see(&mut self, stamp: f64, id: &str, x: f64, y: f64) {
        self.say(&format!(
            r#""kind":"detection","stamp":{stamp},"id":"{id}","x":{x},"y":{y}"#
        ));
    }

    pub fn ack(&mut self, stamp: f64, task: u64) {
        self.say(&format!(r#""kind":"ack","stamp":{stamp},"task":{task}"#));
    }

    pub fn result(&mut self, stamp: f64, task: u64, result: &str) {
        self.say(&format!(
            r#""kind":"result","stamp":{stamp},"task":{task},"result":"{result}""#
        ));
    }

    pub fn tick(&mut self, stamp: f64) {
        self.say(&format!(r#""kind":"tick","stamp":{stamp}"#));
    }

    /// Tasks since this was last asked, first sendings and others, and cancels with their
    /// reasons.
    pub fn said(&mut self) -> (Vec<Task>, Vec<(u64, String)>) {
        let (mut tasks, mut cancels) = (Vec::new(), Vec::new());
        for message in std::mem::take(&mut self.said) {
            match message {
                Outgoing::Task(task) => tasks.push(task),
                Outgoing::Cancel(cancel) => cancels.push((cancel.task, cancel.reason)),
                _ => {}
            }
        }
        (tasks, cancels)
    }

    /// Every task, cancel and request since this was last asked, in order, in one line each:
    /// what, of which task and revision, to whom, for what or why. Statuses and answers to
    /// ticks are left out.
    pub fn told(&mut self) -> Vec<String> {
        let said = std::mem::take(&mut self.said).into_iter();
        let told = said.filter_map(|message| match message {
            Outgoing::Task(t) => Some(format!(
                "task {}.{} {} {}",
                t.id, t.revision, t.robot, t.item
            )),
            Outgoing::Cancel(c) => Some(format!("cancel {} {}: {}", c.task, c.robot, c.reason)),
            Outgoing::BeltRequest(b) => Some(format!("belt {}: {}", b.speed, b.reason)),
            Outgoing::Status(_) | Outgoing::Due(_) => None,
        });
        told.collect()
    }

    /// What was asked of the drive since this was last asked.
    pub fn requests(&mut self) -> Vec<BeltRequest> {
        let said = std::mem::take(&mut self.said).into_iter();
        let requests = said.filter_map(|message| match message {
            Outgoing::BeltRequest(request) => Some(request),
            _ => None,
        });
        requests.collect()
    }

    /// How often something is counted in `noted` of the status.
    pub fn noted(&self, what: &str) -> u64 {
        self.status().noted.get(what).copied().unwrap_or(0)
    }

    /// The one new task since this was last asked.
    pub fn task(&mut self) -> Task {
        let (tasks, _) = self.said();
        let mut new = tasks.into_iter().filter(|task| task.revision == 0);
        let task = new.next().expect("a task");
        assert!(new.next().is_none(), "one task");
        task
    }

    /// The figures, which have to add up.
    pub fn status(&self) -> Status {
        let status = self.controller.status(false, 0);
        check_sums(&status);
        status
    }
}

/// Every item is in exactly one figure, and whatever a robot has picked is counted once.
pub fn check_sums(status: &Status) {
    let sum = status.picked + status.missed.total() + status.on_belt + status.claimed;
    let sum = sum + status.unwanted.unwrap_or(0);
    assert_eq!(status.seen, sum, "{status:?}");
    assert_eq!(status.claimed, status.open_tasks.len() as u64, "{status:?}");
    let twice = status.noted.get("picked_twice").copied().unwrap_or(0);
    let by_robots: u64 = status.robots.iter().map(|robot| robot.picked).sum();
    assert_eq!(by_robots, status.picked + twice, "{status:?}");
}

/// Every one of `items` was seen and is picked, missed or left on purpose, and no message was refused.
pub fn check_settled(status: &Status, items: u64) {
    assert_eq!(status.seen, items, "{status:?}");
    assert_eq!(
        status.seen,
        status.picked + status.missed.total() + status.unwanted.unwrap_or(0),
        "{status:?}"
    );
    assert!(
        status.rejected.is_empty() && status.open_tasks.is_empty(),
        "{status:?}"
    );
}
