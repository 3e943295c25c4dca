//! The line: camera, encoder and robots in front of the node, and the account that is kept.

mod events;
mod figures;
mod settings;

pub use figures::Figures;
pub use settings::{Pace, Settings};

use super::node::Node;
use super::robot::Robot;
use super::truth::{Truth, program, scatter};
use crate::programs::let_pass;
use crate::support::three::STATION;
use crate::support::tracker::{Camera, Tracker};
use pickline::pattern::random_stream;
use pickline::station::{self, Overrides};
use pickline_live::protocol::{Incoming, Outgoing, Status};
use rand::{Rng, RngExt as _};
use settings::{MISTAKES, faults, habits, stretches};
use std::collections::BTreeMap;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

const CAMERA: usize = 0;
const ENCODER: usize = 1;
const FIRST_ROBOT: usize = 2;

/// What happens next in the world.
enum Event {
    Picture,
    Encoder,
    ToNode(usize, Incoming),
    ToRobot(usize, Outgoing),
    Kill,
    Restart,
    HangUp(usize),
    Reconnect(usize),
}

pub struct Line {
    settings: Settings,
    truth: Truth,
    robots: Vec<Robot<Box<dyn Rng>>>,
    tracker: Tracker<Box<dyn Rng>>,
    node: Node,
    queue: Vec<(f64, u64, Event)>,
    events: u64,
    /// With message time, when the node has something to do.
    due: f64,
    now: f64,
    end: f64,
    rng: Box<dyn Rng>,
    /// Results that a robot could not send.
    unsent: Vec<Vec<Incoming>>,
    is_cut_off: Vec<bool>,
    /// Tasks, with their robots.
    tasks: BTreeMap<u64, usize>,
    /// What each robot is after.
    targets: Vec<Option<usize>>,
    status: Option<Status>,
    figures: Counts,
}

#[derive(Default)]
struct Counts {
    kills: usize,
    breaks: usize,
    two_after_one: usize,
    statuses: usize,
}

fn unix_now() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.unwrap().as_secs_f64()
}

fn luck(seed: u64, stream: u64) -> Box<dyn Rng> {
    Box::new(random_stream(seed, stream))
}

impl Line {
    /// Plays it all.
    pub fn play(settings: Settings) -> Figures {
        let folder = tempfile::tempdir().unwrap();
        let journal = folder.path().join("journal");
        let (start, clock) = match settings.pace {
            Pace::Messages => (1000.0, "messages"),
            Pace::Clock => (unix_now() + 1.0, "system"),
        };
        let arguments = format!(
            "run --station {STATION} --listen 127.0.0.1:0 --clock {clock} --lead 0.01 --journal {}",
            journal.display()
        );
        let mut line = Self::new(settings, start, arguments);
        let began = unix_now();
        line.go();
        line.finish(unix_now() - began)
    }

    fn new(settings: Settings, start: f64, arguments: String) -> Self {
        let seed = settings.seed;
        let world = scatter(
            settings.items,
            settings.gap,
            0.04,
            program(start, stretches(settings.pace)),
            seed,
        );
        let end = world.time_at(4.6 - world.items[world.items.len() - 1][0]);
        let tracker = Tracker::new(&world, Camera::Area, MISTAKES, luck(seed, 10));
        let plan = station::load(STATION, Overrides::default()).unwrap();
        let mut rng = luck(seed, 11);
        let hello = |role: &str, name: &str, robots: &str| {
            format!("{{\"kind\":\"hello\",\"name\":\"{name}\",\"role\":\"{role}\"{robots}}}\n")
        };
        let mut hellos = vec![hello("camera", "eye", ""), hello("encoder", "wheel", "")];
        let mut robots = Vec::new();
        for (index, (plan, habits)) in plan.robots().iter().zip(habits()).enumerate() {
            let faults = faults(start, end, &mut rng);
            let luck = luck(seed, 20 + index as u64);
            let names = format!(",\"robots\":[\"{}\"]", plan.name);
            hellos.push(hello("robot", &plan.name, &names));
            robots.push(Robot::new(index, plan.clone(), habits, faults, start, luck));
        }
        let mut line = Self {
            truth: Truth::new(world),
            unsent: robots.iter().map(|_| Vec::new()).collect(),
            targets: vec![None; robots.len()],
            is_cut_off: vec![false; hellos.len()],
            robots,
            tracker,
            node: Node::new(arguments, hellos),
            queue: Vec::new(),
            events: 0,
            due: f64::INFINITY,
            now: start,
            end,
            rng,
            tasks: BTreeMap::new(),
            status: None,
            figures: Counts::default(),
            settings,
        };
        line.plan(start, end);
        line
    }

    /// What is certain to happen.
    fn plan(&mut self, start: f64, end: f64) {
        self.at(start, Event::Restart);
        self.at(start, Event::Encoder);
        self.at(start, Event::Picture);
        let kills = self.settings.kills;
        for number in 0..kills {
            // One in each part of the time, so that they do not fall together.
            let part = (end - start - 10.0) / kills as f64;
            let at = start + 3.0 + part * (number as f64 + self.rng.random_range(0.0..0.6));
            self.at(at, Event::Kill);
        }
        for robot in 0..self.robots.len() {
            for third in 0..3 {
                let part = (end - start) / 3.0;
                let at = start + part * (f64::from(third) + self.rng.random_range(0.1..0.9));
                self.at(at, Event::HangUp(FIRST_ROBOT + robot));
            }
        }
    }

    fn at(&mut self, time: f64, event: Event) {
        self.events += 1;
        self.queue.push((time, self.events, event));
    }

    /// When something happens next.
    fn next(&self) -> f64 {
        let queue = self.queue.iter().map(|entry| entry.0);
        let robots = self.robots.iter().map(Robot::next);
        let due = if self.node.is_up() {
            self.due
        } else {
            f64::INFINITY
        };
        queue.chain(robots).fold(due, f64::min)
    }

    /// The next thing that happens by `time`, in order.
    fn pop(&mut self, time: f64) -> Option<Event> {
        let due = self
            .queue
            .iter()
            .enumerate()
            .filter(|(_, entry)| entry.0 <= time);
        let first = due.min_by(|(_, a), (_, b)| (a.0, a.1).partial_cmp(&(b.0, b.1)).unwrap());
        let (place, _) = first?;
        Some(self.queue.swap_remove(place).2)
    }

    fn is_over(&self) -> bool {
        if self.now < self.end + 1.0 || !self.node.is_up() {
            return false;
        }
        let is_told = self.unsent.iter().all(Vec::is_empty)
            && !self.queue.iter().any(|(_, _, event)| {
                matches!(
                    event,
                    Event::ToNode(_, Incoming::Result(_)) | Event::ToRobot(..) | Event::Restart
                )
            });
        let is_done = self
            .status
            .as_ref()
            .is_some_and(|status| status.stamp > self.end && status.on_belt + status.claimed == 0);
        let at_rest = !self.robots.iter().any(Robot::is_working);
        assert!(self.now < self.end + 200.0, "no end: {:?}", self.status);
        is_told && is_done && at_rest
    }

    fn go(&mut self) {
        while !self.is_over() {
            let next = self.next();
            if self.settings.pace == Pace::Clock {
                let patience = Duration::from_secs_f64((next - unix_now()).clamp(0.0, 0.01));
                if self.node.is_up() {
                    let said = self.node.hear(patience);
                    self.now = unix_now();
                    self.hear(said);
                } else {
                    let_pass(patience);
                }
                if next > unix_now() {
                    continue;
                }
            }
            self.now = next;
            self.step();
        }
    }

    fn step(&mut self) {
        for index in 0..self.robots.len() {
            if self.robots[index].next() <= self.now {
                let sent = self.robots[index].advance(self.now, &mut self.truth);
                self.send(index, sent);
                if !self.robots[index].is_working() {
                    self.targets[index] = None;
                }
            }
        }
        let (mut spoke, mut is_killed) = (vec![false; self.is_cut_off.len()], false);
        while let Some(event) = self.pop(self.now) {
            self.happen(event, &mut spoke, &mut is_killed);
        }
        if !self.node.is_up() {
            return;
        }
        let mut ticks = 0;
        if self.settings.pace == Pace::Messages {
            if self.due <= self.now || is_killed {
                spoke[ENCODER] = true;
            }
            for (peer, spoke) in spoke.iter().enumerate() {
                if *spoke && self.node.is_connected(peer) {
                    self.node.say(peer, &Incoming::Tick { stamp: self.now });
                    ticks += 1;
                }
            }
        }
        if is_killed {
            self.kill();
        } else if ticks > 0 {
            let said = self.node.until_due(self.now, ticks);
            self.hear(said);
        }
    }
}
