//! `pickline run --journal`, killed at random moments under load and started again; and
//! what happens to a run whose peer goes away and comes back.
//!
//! The test is the station: it carries out the tasks that it is given and keeps its own
//! account of what it was told, to which the node is held.

use crate::programs::{let_pass, wait_for};
use pickline::pattern::{Pattern, poisson_disk, random_stream};
use pickline::station::{Station, built_in};
use pickline_live::emulator::{Emulator, InjectedFaults};
use pickline_live::protocol::{
    BeltState, Incoming, Outgoing, Status, Task, Verdict, decode_outgoing, encode,
};
use rand::RngExt as _;
use std::collections::{HashMap, HashSet};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Nothing takes so long unless it is stuck.
const STUCK: Duration = Duration::from_secs(120);

/// A node that connects to the test.
struct Node {
    child: Child,
    stream: TcpStream,
    lines: Receiver<Outgoing>,
}

fn start(listener: &TcpListener, arguments: &[&str]) -> Child {
    let address = listener.local_addr().unwrap().to_string();
    Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["run", "--connect", &address])
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Waits for a node to connect.
fn accept(listener: &TcpListener, mut child: Child) -> Node {
    listener.set_nonblocking(true).unwrap();
    let mut stream = None;
    wait_for("a node", || {
        stream = listener.accept().ok().map(|(stream, _)| stream);
        if child.try_wait().unwrap().is_some() {
            let mut errors = String::new();
            if let Some(mut stderr) = child.stderr.take() {
                stderr.read_to_string(&mut errors).unwrap();
            }
            panic!("it has ended: {errors}");
        }
        stream.is_some()
    });
    let stream = stream.unwrap();
    stream.set_nonblocking(false).unwrap();
    stream.set_nodelay(true).unwrap();
    // A pipe that nobody empties would stop the node.
    if let Some(mut errors) = child.stderr.take() {
        thread::spawn(move || errors.read_to_end(&mut Vec::new()));
    }
    let (sender, lines) = channel();
    let mut reads = BufReader::new(stream.try_clone().unwrap());
    thread::spawn(move || {
        let mut line = Vec::new();
        // A line without an end was never said.
        while reads.read_until(b'\n', &mut line).is_ok() && line.ends_with(b"\n") {
            line.pop();
            if sender.send(decode_outgoing(&line).unwrap()).is_err() {
                return;
            }
            line.clear();
        }
    });
    Node {
        child,
        stream,
        lines,
    }
}

impl Node {
    /// A node without its stream, to which it connects again by itself.
    fn hang_up(self) -> Child {
        let _ = self.stream.shutdown(std::net::Shutdown::Both);
        self.child
    }

    /// A node that has been killed hears nothing; that is noticed by its silence.
    fn say(&mut self, message: &Incoming) {
        let _ = self.stream.write_all(encode(message).as_bytes());
    }
}

/// When the node is killed.
#[derive(Clone, Copy, PartialEq)]
enum Kill {
    At(Instant),
    FirstAnswer,
}

/// What the station was told and what it has answered.
#[derive(Default)]
struct Account {
    /// Item and robot of every task ever given.
    tasks: HashMap<u64, (String, String)>,
    /// The task that is after an item, as long as it has no result.
    claims: HashMap<String, u64>,
    /// Items that the node must know to be picked.
    picked: HashSet<String>,
    repeated: usize,
}

impl Account {
    fn task(&mut self, task: &Task) {
        let this = (task.item.clone(), task.robot.clone());
        if let Some(known) = self.tasks.insert(task.id, this.clone()) {
            assert_eq!(known, this, "task {} is another one now", task.id);
            self.repeated += 1;
            return;
        }
        assert!(!self.picked.contains(&task.item), "picked again: {task:?}");
        let other = self.claims.insert(task.item.clone(), task.id);
        assert!(other.is_none(), "{task:?} is given while {other:?} lives");
    }

    /// The station tells the node, which may not hear it.
    fn tell(&mut self, message: &Incoming) {
        if let Incoming::Result(report) = message
            && let Some((item, _)) = self.tasks.get(&report.task)
            && self.claims.get(item) == Some(&report.task)
        {
            self.claims.remove(item);
        }
    }

    /// The node has heard it.
    fn heard(&mut self, message: &Incoming) {
        if let Incoming::Result(report) = message
            && report.result == Verdict::Picked
        {
            self.picked.insert(self.tasks[&report.task].0.clone());
        }
    }
}

fn line(speed: f64, items: usize, seed: u64) -> (Station, Pattern) {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let station = station.with_belt_speed(speed).unwrap();
    let width = station.belt().width;
    let pattern = poisson_disk(width, 0.12, items, &mut random_stream(seed, 0)).unwrap();
    (station, pattern)
}

/// Everything is accounted for, and nothing was promised twice.
fn check_end(emulator: &Emulator, status: &Status, items: usize) {
    let broken = emulator.broken_promises();
    assert!(broken.is_empty(), "{broken:?}");
    assert_eq!(status.seen, items as u64, "{status:?}");
    let sum = status.picked + status.missed.total();
    assert_eq!(
        (status.seen, status.open_tasks.len()),
        (sum, 0),
        "{status:?}"
    );
    let in_bins = emulator.picked().len() as u64;
    let doubtful = status.missed.no_result;
    let picked = status.picked..=status.picked + doubtful;
    assert!(picked.contains(&in_bins), "{in_bins} {status:?}");
}

/// With message time the answer to a tick says that everything before it is known, so the
/// station knows what it has to say again. Some kills come while the node is starting.
#[test]
fn killed_two_hundred_times_with_message_time() {
    const KILLS: usize = 220;
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("journal");
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let items = 1000;
    let (station, pattern) = line(0.05, items, 1);
    let trouble = InjectedFaults::default()
        .with_grasp_failures(0.1)
        .with_duplicates(0.1)
        .with_out_of_order(0.05)
        .with_jitter(0.05);
    let mut emulator = Emulator::new(station, pattern, trouble).unwrap();
    let mut luck = random_stream(1, 1);
    let arguments = [
        "--clock",
        "messages",
        "--journal",
        journal.to_str().unwrap(),
    ];
    let mut node = accept(&listener, start(&listener, &arguments));
    let mut account = Account::default();
    let (mut due, mut kills) = (None, 0);
    loop {
        let round = emulator.round(due);
        if round.is_empty() {
            break;
        }
        round.iter().for_each(|message| account.tell(message));
        let mut kill = None;
        if kills < KILLS && luck.random_range(0..12) == 0 {
            // With its first answer: a task is on the wire, and little else has happened
            // since. Or whenever it is: unheard, in the midst of it, or all answered.
            kill = Some(match luck.random_range(0..2) {
                0 => Kill::FirstAnswer,
                _ => Kill::At(Instant::now() + Duration::from_micros(luck.random_range(0..500))),
            });
        }
        due = 'answered: loop {
            for message in &round {
                node.say(message);
            }
            let mut alive = true;
            loop {
                let patience = match kill {
                    Some(Kill::At(time)) => time.saturating_duration_since(Instant::now()),
                    _ => STUCK,
                };
                let heard = node.lines.recv_timeout(patience);
                let is_time = match heard {
                    Err(RecvTimeoutError::Timeout) => true,
                    _ => kill == Some(Kill::FirstAnswer),
                };
                if is_time {
                    assert!(kill.take().is_some(), "no answer");
                    node.child.kill().unwrap();
                    alive = false;
                }
                match heard {
                    Ok(Outgoing::Due(answer)) => {
                        if alive && kill.is_none() {
                            break 'answered answer.next;
                        }
                        // It dies after all; what follows is no news for another one.
                        round.iter().for_each(|message| account.heard(message));
                    }
                    Ok(message) => {
                        if let Outgoing::Task(task) = &message {
                            account.task(task);
                        }
                        emulator.receive(message);
                    }
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
            }
            assert!(!alive, "it has ended by itself");
            kills += 1;
            node.child.wait().unwrap();
            let mut child = start(&listener, &arguments);
            while kills < KILLS && luck.random_range(0..4) == 0 {
                let_pass(Duration::from_micros(luck.random_range(0..30_000)));
                child.kill().unwrap();
                child.wait().unwrap();
                kills += 1;
                // It may have connected before it died.
                listener.set_nonblocking(true).unwrap();
                while listener.accept().is_ok() {}
                child = start(&listener, &arguments);
            }
            node = accept(&listener, child);
        };
        round.iter().for_each(|message| account.heard(message));
    }
    node.stream.shutdown(std::net::Shutdown::Write).unwrap();
    let last = node.lines.iter().last();
    let Some(Outgoing::Status(status)) = last.filter(|_| node.child.wait().unwrap().success())
    else {
        panic!("no last status");
    };
    check_end(&emulator, &status, items);
    assert!(
        kills >= KILLS && account.repeated > 20,
        "{kills} {}",
        account.repeated
    );
    assert!(emulator.picked().len() > items / 4);
    let mut names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    names.retain(|entry| !entry.as_ref().unwrap().path().ends_with("journal"));
    assert_eq!(names.len(), 1, "{names:?}");
}

fn unix_now() -> f64 {
    let now = std::time::SystemTime::now();
    let since = now.duration_since(std::time::UNIX_EPOCH);
    since.unwrap().as_secs_f64()
}

/// What happens to the node now and then.
#[derive(Clone, Copy, PartialEq)]
enum Mishap {
    /// It is killed and started again, with its journal.
    Killed,
    /// Its peer goes away and comes back.
    LeftAlone,
}

/// A station in real time. A status tells how many items are known: as they are seen one
/// after another, those that were sent and are not known are the last ones, and are sent
/// again.
fn by_the_clock(mishap: Mishap, least: usize) {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("journal");
    let journal = journal.to_str().unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let (speed, items) = (0.4, 150);
    let (station, pattern) = line(speed, items, 2);
    let trouble = InjectedFaults::default().with_grasp_failures(0.1);
    let mut emulator = Emulator::new(station, pattern, trouble).unwrap();
    let text = ["--belt-speed", "0.4", "--status-every", "0.05", "-q"];
    let mut arguments = text.to_vec();
    if mishap == Mishap::Killed {
        arguments.extend(["--journal", journal]);
    }
    let mut luck = random_stream(2, 1);
    let mut node = accept(&listener, start(&listener, &arguments));
    let mut account = Account::default();
    let origin = unix_now();
    emulator.start_at(origin);
    // All items that were seen, and how many of them the node has said it knows.
    let (mut seen, mut known): (Vec<Incoming>, usize) = (Vec::new(), 0);
    let (mut synced, mut mishaps) = (true, 0);
    let mut next_mishap = origin + 1.0;
    let status = loop {
        for message in emulator.advance(unix_now()) {
            account.tell(&message);
            let is_item = matches!(message, Incoming::Detection(_));
            if synced || !is_item {
                node.say(&message);
            }
            if is_item {
                seen.push(message);
            }
        }
        let is_over = emulator.next_stamp().is_none();
        match node.lines.recv_timeout(Duration::from_millis(2)) {
            Ok(Outgoing::Status(status)) => {
                let now_known = status.seen as usize;
                assert!(
                    now_known >= known,
                    "{} items are forgotten",
                    known - now_known
                );
                known = now_known;
                if !synced {
                    seen[known..].iter().for_each(|message| node.say(message));
                    synced = true;
                }
                if is_over && known == items && status.on_belt + status.claimed == 0 {
                    break status;
                }
            }
            Ok(message) => {
                if let Outgoing::Task(task) = &message {
                    account.task(task);
                    if luck.random_range(0..4) == 0 {
                        next_mishap = 0.0;
                    }
                }
                emulator.receive(message);
            }
            Err(_) => {}
        }
        if is_over {
            assert!(
                unix_now() < origin + STUCK.as_secs_f64(),
                "{known} items are known"
            );
        } else if unix_now() > next_mishap {
            next_mishap = unix_now() + luck.random_range(0.05..0.5);
            mishaps += 1;
            let child = match mishap {
                Mishap::Killed => {
                    node.child.kill().unwrap();
                    node.child.wait().unwrap();
                    start(&listener, &arguments)
                }
                Mishap::LeftAlone => node.hang_up(),
            };
            node = accept(&listener, child);
            synced = false;
            // Whoever connects says how the belt is.
            let stamp = unix_now();
            let position = Some(speed * (stamp - origin));
            node.say(&Incoming::Belt(BeltState {
                stamp,
                speed,
                position,
                source: None,
            }));
        }
    };
    check_end(&emulator, &status, items);
    assert!(mishaps >= least, "{mishaps}");
    assert!(account.repeated >= least / 10, "{}", account.repeated);
    assert!(emulator.picked().len() > 5, "{status:?}");
    node.child.kill().unwrap();
    node.child.wait().unwrap();
}

#[test]
fn killed_again_and_again_by_the_clock() {
    by_the_clock(Mishap::Killed, 20);
}

#[test]
fn a_peer_that_goes_away_and_comes_back_finds_all_as_it_was() {
    by_the_clock(Mishap::LeftAlone, 20);
}

/// Message by message: a task that nobody has acknowledged, one that somebody has.
#[test]
fn open_tasks_come_again_when_the_peer_is_back() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut node = accept(
        &listener,
        start(&listener, &["-q", "--ack-timeout", "1000"]),
    );
    let say = |node: &mut Node, fields: &str| {
        let line = format!("{{\"stamp\":{},{fields}}}\n", unix_now());
        node.stream.write_all(line.as_bytes()).unwrap();
    };
    let task = |node: &Node| loop {
        match node.lines.recv_timeout(STUCK).unwrap() {
            Outgoing::Task(task) => break task,
            Outgoing::Status(_) => {}
            other => panic!("{other:?}"),
        }
    };
    say(&mut node, r#""kind":"robot","name":"r1","state":"idle""#);
    say(&mut node, r#""kind":"detection","id":"a","x":0.9,"y":-0.2"#);
    say(&mut node, r#""kind":"detection","id":"b","x":0.8,"y":-0.2"#);
    let first = task(&node);
    let mut node = accept(&listener, node.hang_up());
    let again = task(&node);
    assert_eq!((again.id, again.revision), (first.id, 1));
    assert!(again.item == first.item && again.start > first.start);
    say(&mut node, &format!(r#""kind":"ack","task":{}"#, first.id));
    // A status after the one that was under way has heard of the acknowledgement.
    for _ in 0..2 {
        let status = node.lines.recv_timeout(STUCK).unwrap();
        assert!(matches!(status, Outgoing::Status(_)), "{status:?}");
    }
    let mut node = accept(&listener, node.hang_up());
    assert_eq!(task(&node), again);
    let done = format!(r#""kind":"result","task":{},"result":"PICKED""#, first.id);
    say(&mut node, &done);
    let second = task(&node);
    assert!(second.id != first.id && second.item != first.item);
    node.child.kill().unwrap();
    node.child.wait().unwrap();
}
