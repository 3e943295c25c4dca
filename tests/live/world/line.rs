//! The line: camera, encoder and robots in front of the node, and the account that is kept.

use super::node::Node;
use super::robot::{Finds, Habits, Robot, Tells};
use super::truth::{Fate, Truth, program, scatter};
use crate::support::tracker::{Camera, Mistakes, PERIOD, Tracker};
use pickline::live::protocol::{BeltState, Incoming, Outgoing, Status};
use pickline::pattern::random_stream;
use pickline::station::{self, Overrides};
use rand::{Rng, RngExt as _};
use std::collections::BTreeMap;
use std::fmt;
use std::thread;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

const STATION: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/live/world/station.toml");
const CAMERA: usize = 0;
const ENCODER: usize = 1;
const FIRST_ROBOT: usize = 2;
/// Time between two messages of the encoder [s].
const ENCODER_PERIOD: f64 = 0.02;
/// Time from the node to a robot [s].
const WAY: f64 = 0.003;

/// What the tracker does wrong. 5 mm, the width of the gripper, are three standard deviations.
const MISTAKES: Mistakes = Mistakes {
    jitter: 0.0015,
    ..Mistakes::BAD_DAY
};

/// Where the time comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    Messages,
    Clock,
}

/// What is played.
#[derive(Debug, Clone, Copy)]
pub struct Settings {
    pub pace: Pace,
    pub items: usize,
    /// Belt for one item, on average [m].
    pub gap: f64,
    pub kills: usize,
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            pace: Pace::Messages,
            items: 1000,
            gap: 0.1,
            kills: 0,
            seed: 1,
        }
    }
}

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

/// What came of it.
pub struct Figures {
    pub clock: &'static str,
    pub items: usize,
    pub kills: usize,
    pub breaks: usize,
    pub tasks: usize,
    pub grasped: usize,
    pub failed: usize,
    pub beside: Vec<f64>,
    pub taken: usize,
    pub nothing: usize,
    pub second: usize,
    pub refused: usize,
    pub two_after_one: usize,
    pub in_bins: Vec<usize>,
    pub dropped: usize,
    pub statuses: usize,
    pub picked: u64,
    pub status: Status,
    pub seconds: f64,
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

/// Three robots that tell differently what they do, and have different habits.
fn habits() -> [Habits; 3] {
    let usual = Habits {
        tells: Tells::Changes,
        lost_acks: 0.03,
        failing: 0.03,
        late: 0.05,
        very_late: 0.005,
    };
    [
        usual,
        Habits {
            tells: Tells::Work,
            ..usual
        },
        Habits {
            tells: Tells::Cycle,
            late: 0.1,
            ..usual
        },
    ]
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
        let stretches = match settings.pace {
            Pace::Messages => [
                (0.3, 60.0),
                (0.0, 6.0),
                (0.25, 50.0),
                (0.35, 40.0),
                (0.0, 10.0),
                (0.3, 70.0),
                (0.2, 30.0),
                (0.0, 2.0),
                (0.3, 1.0),
            ]
            .to_vec(),
            Pace::Clock => [(0.3, 8.0), (0.0, 2.0), (0.25, 8.0), (0.3, 1.0)].to_vec(),
        };
        let world = scatter(
            settings.items,
            settings.gap,
            0.04,
            program(start, &stretches),
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
                    thread::sleep(patience);
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

    fn send(&mut self, robot: usize, sent: Vec<(f64, Incoming)>) {
        for (at, message) in sent {
            self.at(at, Event::ToNode(FIRST_ROBOT + robot, message));
        }
    }

    fn happen(&mut self, event: Event, spoke: &mut [bool], is_killed: &mut bool) {
        let now = self.now;
        match event {
            Event::Picture => {
                self.at(now + PERIOD, Event::Picture);
                let picture = self.tracker.picture(&self.truth.world, now);
                let delay = match self.rng.random_range(0..100) {
                    0 => return,
                    1 => 0.3,
                    _ => self.rng.random_range(0.03..0.05),
                };
                for message in picture {
                    self.at(now + delay, Event::ToNode(CAMERA, message));
                }
            }
            Event::Encoder => {
                self.at(now + ENCODER_PERIOD, Event::Encoder);
                let speed = self.truth.world.speed(now);
                let noise = self.rng.random_range(-1.0..1.0);
                let belt = Incoming::Belt(BeltState {
                    stamp: now,
                    speed: speed + noise * (0.005 * speed).max(1e-5),
                    position: Some((1e4 * self.truth.world.travel(now)).round() / 1e4),
                    source: None,
                });
                self.at(now + 0.002, Event::ToNode(ENCODER, belt));
            }
            Event::ToNode(peer, message) => {
                if self.node.is_up() && self.node.is_connected(peer) {
                    self.node.say(peer, &message);
                    spoke[peer] = true;
                } else if let Incoming::Result(_) = message {
                    self.unsent[peer - FIRST_ROBOT].push(message);
                }
            }
            Event::ToRobot(robot, message) => {
                let sent = self.robots[robot].hear(now, &message);
                self.send(robot, sent);
                if !self.robots[robot].is_working() {
                    self.targets[robot] = None;
                }
            }
            Event::Kill if !self.node.is_up() => {}
            Event::Kill if self.settings.pace == Pace::Messages => *is_killed = true,
            Event::Kill => self.kill(),
            Event::Restart => {
                while self.figures.kills > 0 && self.rng.random_range(0..5) == 0 {
                    let after = Duration::from_micros(self.rng.random_range(0..30_000));
                    self.node.start_in_vain(after);
                    self.figures.kills += 1;
                }
                self.node.start();
                for peer in 0..self.is_cut_off.len() {
                    if !self.is_cut_off[peer] {
                        self.connect(peer);
                    }
                }
            }
            Event::HangUp(peer) => {
                self.node.hang_up(peer);
                self.is_cut_off[peer] = true;
                self.figures.breaks += 1;
                let lasts = self.rng.random_range(0.5..3.0);
                self.at(now + lasts, Event::Reconnect(peer));
            }
            Event::Reconnect(peer) => {
                self.is_cut_off[peer] = false;
                if self.node.is_up() {
                    self.connect(peer);
                }
            }
        }
    }

    /// A peer connects; a robot says how it is, and what it could not say.
    fn connect(&mut self, peer: usize) {
        self.node.connect(peer);
        let Some(robot) = peer.checked_sub(FIRST_ROBOT) else {
            return;
        };
        let introduction = self.robots[robot].introduce(self.now);
        self.at(self.now, Event::ToNode(peer, introduction));
        for message in std::mem::take(&mut self.unsent[robot]) {
            self.at(self.now, Event::ToNode(peer, message));
        }
    }

    /// The node is killed, soon after it was last spoken to; and comes back.
    fn kill(&mut self) {
        thread::sleep(Duration::from_micros(self.rng.random_range(0..500)));
        let said = self.node.kill();
        self.figures.kills += 1;
        self.hear(said);
        self.due = f64::INFINITY;
        let back = self.now + self.rng.random_range(0.1..0.8);
        self.at(back, Event::Restart);
    }

    fn hear(&mut self, said: Vec<(usize, Outgoing)>) {
        for (peer, message) in said {
            match message {
                Outgoing::Due(due) => self.due = due.next.unwrap_or(f64::INFINITY),
                Outgoing::Status(status) if peer == ENCODER => self.check(*status),
                Outgoing::Task(_) | Outgoing::Cancel(_) => {
                    let Some(robot) = peer.checked_sub(FIRST_ROBOT) else {
                        continue;
                    };
                    if message.robot() != Some(self.robots[robot].name()) {
                        continue;
                    }
                    if let Outgoing::Task(task) = &message {
                        let known = self.tasks.insert(task.id, robot);
                        assert!(known.is_none_or(|known| known == robot), "{task:?}");
                        if known.is_none() {
                            self.aim(robot, task);
                        }
                    }
                    self.at(self.now + WAY, Event::ToRobot(robot, message));
                }
                Outgoing::Status(_) | Outgoing::BeltRequest(_) => {}
            }
        }
    }

    /// A robot gets a new task; is another one after the same item?
    fn aim(&mut self, robot: usize, task: &pickline::live::protocol::Task) {
        let speed = self.truth.world.speed(self.now);
        let x = task.meet.x - speed * (task.meet_at - self.now);
        let travel = self.truth.world.travel(self.now);
        let items = self.truth.world.items.iter().enumerate();
        let near = items
            .map(|(i, at)| (i, (at[0] + travel - x).hypot(at[1] - task.meet.y)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .filter(|near| near.1 < 0.015);
        let target = near.map(|near| near.0);
        if target.is_some() && self.targets.contains(&target) {
            self.figures.two_after_one += 1;
        }
        self.targets[robot] = target;
    }

    /// The figures of a moment against each other and against the world.
    fn check(&mut self, status: Status) {
        self.figures.statuses += 1;
        let sum = status.picked + status.missed.total() + status.on_belt + status.claimed;
        assert_eq!(status.seen, sum, "{status:?}");
        let by_robots: u64 = status.robots.iter().map(|robot| robot.picked).sum();
        assert_eq!(by_robots, status.picked, "{status:?}");
        for (index, robot) in status.robots.iter().enumerate() {
            let in_bin = self.truth.in_bin(index) as u64;
            assert!(robot.picked <= in_bin, "{in_bin} in the bin: {robot:?}");
        }
        if let Some(before) = &self.status {
            assert!(status.picked >= before.picked, "{before:?} {status:?}");
        }
        self.status = Some(status);
    }

    fn finish(mut self, seconds: f64) -> Figures {
        let by_clock = self.settings.pace == Pace::Clock;
        let (said, remarks) = self.node.finish(by_clock);
        self.hear(said);
        let status = self.status.take().expect("a status");
        assert!(status.last, "{status:?} {remarks}");
        let all = self.robots.iter().fold(Finds::default(), |mut all, robot| {
            let finds = &robot.finds;
            all.grasped += finds.grasped;
            all.failed += finds.failed;
            all.beside.extend(&finds.beside);
            all.taken += finds.taken;
            all.nothing += finds.nothing;
            all.second += finds.second;
            all.refused += finds.refused;
            all
        });
        let fates = &self.truth.fates;
        Figures {
            clock: if by_clock { "system" } else { "messages" },
            items: fates.len(),
            kills: self.figures.kills,
            breaks: self.figures.breaks,
            tasks: self.tasks.len(),
            grasped: all.grasped,
            failed: all.failed,
            beside: all.beside,
            taken: all.taken,
            nothing: all.nothing,
            second: all.second,
            refused: all.refused,
            two_after_one: self.figures.two_after_one,
            in_bins: (0..self.robots.len())
                .map(|robot| self.truth.in_bin(robot))
                .collect(),
            dropped: fates.iter().filter(|fate| **fate == Fate::Dropped).count(),
            statuses: self.figures.statuses,
            picked: status.picked,
            status,
            seconds,
        }
    }
}

/// Some faults of 2 s to 15 s.
fn faults(start: f64, end: f64, rng: &mut impl Rng) -> Vec<(f64, f64)> {
    let count = ((end - start) / 80.0).ceil() as usize;
    let part = (end - start) / count as f64;
    let faults = (0..count).map(|number| {
        let from = start + part * (number as f64 + rng.random_range(0.1..0.6));
        (from, from + rng.random_range(2.0..15.0_f64.min(0.3 * part)))
    });
    faults.collect()
}

impl Figures {
    /// Robots were sent to where nothing is, per 1,000 items.
    fn ghosts(&self) -> f64 {
        1e3 * (self.taken + self.nothing) as f64 / self.items as f64
    }

    /// What has to hold.
    pub fn check(&self) {
        let status = &self.status;
        let in_bins: usize = self.in_bins.iter().sum();
        // What is in the bins was counted, but for what nobody ever said.
        let doubtful = status.missed.no_result;
        let picked = status.picked..=status.picked + doubtful;
        assert!(picked.contains(&(in_bins as u64)), "{self}");
        for (in_bin, robot) in self.in_bins.iter().zip(&status.robots) {
            let picked = robot.picked..=robot.picked + doubtful;
            assert!(picked.contains(&(*in_bin as u64)), "{self}");
        }
        assert_eq!(status.seen, status.picked + status.missed.total(), "{self}");
        assert!(status.open_tasks.is_empty(), "{self}");
        assert_eq!(status.noted.get("picked_twice"), None, "{self}");
        assert_eq!(self.grasped, in_bins + self.dropped, "{self}");
        assert_eq!(self.second, 0, "{self}");
        // What the camera makes up is 5 items in 1,000, and three attempts at each.
        let few = 0.02 * self.items as f64 + 2.0;
        assert!((self.taken + self.nothing) as f64 <= 1.5 * few, "{self}");
        assert!((self.two_after_one as f64) < few, "{self}");
        assert!(
            (status.seen as f64 - self.items as f64).abs() <= few,
            "{self}"
        );
    }
}

impl fmt::Display for Figures {
    /// A row of the table in docs/live.md, and the rest below it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (status, missed) = (&self.status, &self.status.missed);
        let others = missed.total() - missed.not_found - missed.no_result;
        writeln!(
            f,
            "| {} | {} | {}, {} | {} | {} | {} | {}, {}, {} | {} | {} | {} ({:.0} per 1,000 items) |",
            self.clock,
            self.items,
            self.kills,
            self.breaks,
            status.seen,
            status.picked,
            self.in_bins.iter().sum::<usize>(),
            missed.not_found,
            missed.no_result,
            others,
            self.tasks,
            self.beside.len(),
            self.taken + self.nothing,
            self.ghosts(),
        )?;
        let worst = self.beside.iter().fold(0.0, |a: f64, b| a.max(*b));
        writeln!(
            f,
            "{:.0} s, {} statuses; {} grasped, {} slipped, at most {:.0} mm beside, {} taken before, \
             {} never there, {} too late, {} second tasks, {} after the item of another",
            self.seconds,
            self.statuses,
            self.grasped,
            self.failed,
            1e3 * worst,
            self.taken,
            self.nothing,
            self.refused,
            self.second,
            self.two_after_one
        )?;
        write!(
            f,
            "in the bins {:?}, {} dropped; {missed:?}, noted {:?}, refused {:?}, {:?}",
            self.in_bins, self.dropped, status.noted, status.rejected, status.robots
        )
    }
}
