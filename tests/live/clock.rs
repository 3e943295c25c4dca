//! Clocks that are set, sources that fall silent: a line whose two clocks the test holds.

use crate::support::line::Line;
use pickline::live::protocol::{Outgoing, SourceReport, Status};
use pickline::live::{Config, Controller, SteadyClock, Timeouts};
use pickline::station::{Overrides, parse};
use pickline::strategies::read_alone;
use std::collections::BTreeMap;

const STATION: &str = r#"
[belt]
speed = 0.3
width = 0.6
length = 4.0

[[robot]]
name = "delta"
base = [1.0, 0.0]
bin = [1.0, -0.4]
reach = 0.6
speed = 3.0
grasp_time = 0.05
release_time = 0.05

[[robot]]
name = "arm"
base = [2.3, -0.4]
bin = [2.6, -0.45]
reach = 0.85
speed = 1.2
grasp_time = 0.15
release_time = 0.2
"#;

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
    items: BTreeMap<String, f64>,
    /// Results to come: when, of which task, of whom.
    open: Vec<(f64, u64)>,
    /// When each task was given [s], by how much its meeting point is off [m], and to whom.
    given: Vec<(f64, f64, String)>,
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
        let none = Overrides {
            robots: None,
            belt_speed: None,
        };
        let station = parse(STATION, "the test's station", none).unwrap();
        let strategy = read_alone("SPT,FIFO", 2).unwrap().make();
        let mut world = Self {
            controller: Controller::new(station, strategy, config),
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
        let stamp = self.stamp(whose, self.now - 0.002);
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
            let x = self.items[&task.item] + self.travel(self.now + lead);
            // Nobody knows of a stop before it comes.
            let is_crossed = self.now < self.stop && self.now + lead > self.stop;
            let off = if is_crossed {
                0.0
            } else {
                (x - task.meet.x).abs()
            };
            self.given.push((self.now, off, task.robot));
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
            for name in ["delta", "arm"] {
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
                self.items
                    .insert(id.clone(), 0.2 - self.travel(self.now - 0.002));
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

    /// Tasks were given all the time, to where their items were.
    fn check(&self, case: &str) {
        let wrong: Vec<_> = self
            .given
            .iter()
            .filter(|(_, off, _)| *off > 0.005)
            .collect();
        assert!(wrong.is_empty(), "{case}: {wrong:?}");
        let times = self.given.windows(2).map(|pair| pair[1].0 - pair[0].0);
        let gap = times.fold(0.0, f64::max);
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

#[test]
fn the_line_goes_on_however_the_machines_clock_is_set() {
    for (case, steps) in STEPS {
        let mut world = World::new(Config::default());
        world.play(20.0, steps);
        world.check(case);
        let noted = world.status().noted;
        let count = noted.get("clock_step").copied().unwrap_or(0);
        assert_eq!(count, steps.len() as u64, "{case}");
        assert_eq!(
            world.remarks.len(),
            steps.len(),
            "{case}: {:?}",
            world.remarks
        );
        let stamp = world.status().stamp;
        assert!(
            (stamp - world.stamp(Whose::Machine, 20.0)).abs() < 0.02,
            "{case}"
        );
        assert_eq!(world.source("camera").mapped, None, "{case}");
        let offset = world.source("belt").offset.unwrap();
        assert!((offset - 0.002).abs() < 1e-3, "{case}: {offset}");
    }
}

#[test]
fn a_stop_just_after_the_clock_was_set_back_is_heard() {
    let mut world = World::new(Config::default());
    world.stop = 6.0;
    world.play(12.0, &[(5.0, -5.0)]);
    world.check("stop");
    // Nothing is sent after the belt to where it would be if it ran.
    assert!(!world.status().noted.contains_key("late_belt"));
}

#[test]
fn peers_with_clocks_of_their_own_are_mapped_and_keep_their_time() {
    let steps = [(5.0, -5.0), (12.0, 3.0)];
    for (camera, robots) in [(0.0, 0.0), (3.0, 0.5), (1000.0, 1.0)] {
        let mut world = World::new(Config::default());
        (world.camera, world.robots) = (Whose::Own(camera), Whose::Own(robots));
        world.play(20.0, &steps);
        let case = format!("{camera} {robots}");
        // A robot's first word after a step tells whose clock that was: its answer to a task.
        let mut heard = std::collections::BTreeSet::new();
        let mut is_first = |at: f64, robot: &str| {
            let step = steps.iter().filter(|(step, _)| *step <= at).count();
            heard.insert((step, robot.to_owned()))
        };
        let given = world.given.iter();
        let known = given.filter(|(at, _, robot)| !is_first(*at, robot));
        let wrong: Vec<_> = known.filter(|(_, off, _)| *off > 0.01).collect();
        assert!(wrong.is_empty(), "{case}: {wrong:?}");
        assert!(
            world.given.len() > 25 && world.given.last().unwrap().0 > 18.0,
            "{case}"
        );
        assert!(world.refused.len() <= 2, "{case}: {:?}", world.refused);
        let mapped = world.source("camera").mapped.unwrap();
        assert!((mapped - (3.0 - camera)).abs() < 0.03, "{case}: {mapped}");
    }
}

/// Behind by 3 s or slow by 3 s: nobody can tell, so it is not passed over in silence.
#[test]
fn a_source_that_is_always_late_is_told_of() {
    let mut world = World::new(Config::default());
    world.camera = Whose::Own(-3.0);
    world.play(12.0, &[]);
    assert!(
        world.remarks.len() == 1 && world.remarks[0].contains("come 3 s after their stamps"),
        "{:?}",
        world.remarks
    );
    assert!((world.source("camera").offset.unwrap() - 3.002).abs() < 1e-3);
}

#[test]
fn a_belt_that_falls_silent_stops_new_tasks_until_it_is_heard() {
    for (belt, last) in [(None, 1.0), (Some(3.0), 3.0), (Some(0.0), f64::INFINITY)] {
        let config = Config {
            timeouts: Timeouts { belt, robot: None },
            ..Config::default()
        };
        let mut world = World::new(config);
        world.encoder_until = 6.0;
        world.play(20.0, &[]);
        let given = world.given.last().unwrap().0;
        if last.is_infinite() {
            assert!(given > 18.0, "{given}");
            assert!(world.remarks.is_empty() && !world.source("belt").overdue);
            continue;
        }
        assert!((6.0..=6.02 + last).contains(&given), "{belt:?}: {given}");
        assert!(world.source("belt").overdue);
        assert!((world.source("belt").age - 14.0).abs() < 0.02);
        assert!(
            world.remarks.len() == 1 && world.remarks[0].contains("--belt-timeout"),
            "{:?}",
            world.remarks
        );
        world.encoder_until = f64::INFINITY;
        world.play(25.0, &[]);
        assert!(world.given.last().unwrap().0 > 24.0);
        assert!(world.remarks[1].contains("`belt` is heard again"));
        assert!(!world.source("belt").overdue);
    }
}

#[test]
fn a_robot_that_falls_silent_gets_no_task_until_it_is_heard() {
    let mut line = Line::silent(0.0);
    let idle = |stamp: f64, name: &str| {
        format!(r#""kind":"robot","stamp":{stamp},"name":"{name}","state":"idle""#)
    };
    // One that reports all the time, and one that says how it is once.
    for i in 0..60 {
        line.say(&idle(0.1 * f64::from(i), "r1"));
    }
    line.say(&idle(5.9, "r2"));
    line.see(6.0, "a", 1.0, -0.2);
    assert_eq!(line.task(6.0).robot, "r1");
    line.result(6.1, 1, "PICKED");
    line.see(8.0, "b", 1.0, -0.3);
    line.see(8.0, "c", 2.6, 0.3);
    let task = line.task(8.0);
    assert_eq!((task.robot.as_str(), task.item.as_str()), ("r2", "c"));
    let sources = line.0.status(false, 0).sources;
    let overdue: Vec<_> = sources
        .iter()
        .map(|s| (s.name.as_str(), s.overdue))
        .collect();
    assert_eq!(overdue, [("camera", false), ("r1", true), ("r2", false)]);
    assert!(line.0.take_remarks()[0].contains("robot `r1` has been silent for 1.9 s"));
    line.say(&idle(9.0, "r1"));
    let (tasks, _) = line.tick(9.0);
    assert!(
        tasks
            .iter()
            .any(|task| task.item == "b" && task.robot == "r1")
    );
}

/// What is not overdue with ticks of one size is not with ticks of another.
#[test]
fn with_message_time_silence_is_told_by_the_stamps() {
    let play = |ticks: &[f64]| {
        let mut line = Line::silent(1.0);
        for i in 0..=60 {
            let stamp = 0.1 * f64::from(i);
            line.say(&format!(r#""kind":"belt","stamp":{stamp},"speed":0.05"#));
        }
        line.say(r#""kind":"robot","stamp":6,"name":"r1","state":"idle""#);
        // It reaches the robot while the belt is silent.
        line.see(6.0, "a", 0.3, -0.2);
        let mut said = Vec::new();
        for tick in ticks {
            line.say(&format!(r#""kind":"tick","stamp":{tick}"#));
            said.append(&mut line.0.take_output());
        }
        said.retain(|message| !matches!(message, Outgoing::Due(_)));
        said
    };
    let said = play(&[30.0]);
    assert!(said.iter().all(|message| message.kind() == "status"));
    assert_eq!(said, play(&[8.0, 8.1, 9.7, 20.0, 30.0]));
}

/// `cargo test --test live clock:: -- --ignored --nocapture` prints the table of docs/live.md.
#[test]
#[ignore = "prints a table"]
fn table_of_steps() {
    println!(
        "| the machine's clock | tasks | off by more than 5 mm | longest time without one [s] |"
    );
    println!("|---|---|---|---|");
    for (case, steps) in STEPS {
        let mut world = World::new(Config::default());
        world.play(60.0, steps);
        let wrong = world.given.iter().filter(|given| given.1 > 0.005).count();
        let gaps = world.given.windows(2).map(|pair| pair[1].0 - pair[0].0);
        let gap = gaps.fold(0.0, f64::max);
        println!("| {case} | {} | {wrong} | {gap:.1} |", world.given.len());
    }
}

/// The program itself, whose clock libfaketime sets: it goes on, and its recording replays.
#[test]
#[cfg(all(feature = "mcap", target_os = "linux"))]
fn the_program_goes_on_when_its_clock_is_set() {
    use std::io::{BufRead as _, BufReader, Write as _};
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

    let folders = std::fs::read_dir("/usr/lib")
        .into_iter()
        .flatten()
        .flatten();
    let library = folders
        .map(|folder| folder.path().join("faketime/libfaketimeMT.so.1"))
        .find(|file| file.exists());
    let Some(library) = library else {
        println!("skipped: libfaketime is not there; on Debian `apt-get install faketime`");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let (file, next) = (folder.path().join("ahead"), folder.path().join("next"));
    let recording = folder.path().join("a.mcap");
    let set = |ahead: f64| {
        std::fs::write(&next, format!("{ahead:+.3}\n")).unwrap();
        std::fs::rename(&next, &file).unwrap();
    };
    set(0.0);
    let mut node = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["run", "--status-every", "0.5", "--record"])
        .arg(&recording)
        .envs([
            ("LD_PRELOAD", library.as_os_str()),
            ("FAKETIME_TIMESTAMP_FILE", file.as_os_str()),
        ])
        .envs([
            ("FAKETIME_NO_CACHE", "1"),
            ("FAKETIME_DONT_FAKE_MONOTONIC", "1"),
        ])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = node.stdin.take().unwrap();
    let stdout = BufReader::new(node.stdout.take().unwrap());
    let reader = std::thread::spawn(move || stdout.lines().map(Result::unwrap).collect::<Vec<_>>());
    let (began, mut ahead) = (Instant::now(), 0.0);
    let mut say = |ahead: f64, fields: &str| {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
        let stamp = now.as_secs_f64() + ahead;
        writeln!(stdin, r#"{{"stamp":{stamp},{fields}}}"#).unwrap();
    };
    say(ahead, r#""kind":"robot","name":"r1","state":"idle""#);
    for i in 0..60 {
        let now = match i {
            20..35 => -5.0,
            35..45 => 100.0,
            _ => 0.0,
        };
        if now != ahead {
            ahead = now;
            set(ahead);
        }
        let position = 0.05 * began.elapsed().as_secs_f64();
        say(
            ahead,
            &format!(r#""kind":"belt","speed":0.05,"position":{position}"#),
        );
        let text = format!(
            r#""kind":"detection","id":"i{i}","x":{},"y":0.1"#,
            -0.04 * f64::from(i % 20)
        );
        say(ahead, &text);
        std::thread::sleep(Duration::from_millis(100));
    }
    drop(stdin);
    let lines = reader.join().unwrap();
    let output = node.wait_with_output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{errors}");
    let last = lines.last().unwrap();
    assert!(last.contains(r#""clock_step":3"#), "{last}");
    assert!(last.contains(r#""rejected":{}"#), "{last}");
    assert!(
        errors.contains("the machine's clock was set back by 5 s"),
        "{errors}"
    );
    let replay = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["run", "--replay"])
        .arg(&recording)
        .output()
        .unwrap();
    let told = String::from_utf8(replay.stderr).unwrap();
    assert!(
        told.contains(&format!("all {} messages are as recorded", lines.len())),
        "{told}"
    );
}

/// Nobody has seen a clock being set that was off from the first message on.
#[test]
fn a_clock_that_is_off_from_the_first_message_on_was_not_set() {
    for (ahead, words) in [
        (100.0, "s ahead of the node's"),
        (-100.0, "s behind the node's"),
    ] {
        let mut world = World::new(Config::default());
        world.camera = Whose::Own(ahead);
        world.play(5.0, &[]);
        let of_camera = |world: &World| {
            let remarks = world.remarks.iter();
            let remarks = remarks.filter(|remark| remark.starts_with("camera `camera`: its clock"));
            remarks.cloned().collect::<Vec<String>>()
        };
        let remarks = of_camera(&world);
        assert_eq!(remarks.len(), 1, "{:?}", world.remarks);
        assert!(
            remarks[0].contains("its clock is ") && remarks[0].contains(words),
            "{remarks:?}"
        );
        world.camera = Whose::Own(ahead + 50.0);
        world.play(10.0, &[]);
        let remarks = of_camera(&world);
        assert!(remarks[1].contains("was set forward by "), "{remarks:?}");
    }
}
