//! Peers that stall, and many of them: nobody holds up the line.

use super::{Peer, is_task, listening, node, now};
use crate::programs::{Program, wait_for};
use serde_json::{Value, json};
use std::io::Write as _;
use std::net::TcpStream;
use std::process::Command;
use std::time::{Duration, Instant};

/// Longer than a robot waits for a task on a busy machine; it was minutes once.
const HELD_UP: Duration = Duration::from_secs(10);

/// Detections of a camera that reads nothing, until it is disconnected and for some statuses
/// more, or for 1,500 statuses; returns the longest time without a task, and whether it was
/// disconnected.
fn beside_a_deaf_camera(hello: &str) -> (Duration, bool) {
    let (node, address) = node("--status-every 0.01");
    let robot = Peer::new(&address);
    let statuses = || robot.count(|message| message["kind"] == "status");
    robot.say(&json!({"kind": "belt", "stamp": now(), "speed": 0.2}));
    robot.idle("r1");
    let camera = TcpStream::connect(&address).unwrap();
    (&camera).write_all(hello.as_bytes()).unwrap();
    let (mut last, mut longest, mut gone) = (Instant::now(), Duration::ZERO, false);
    let (mut number, mut until) = (0, 1500);
    while statuses() < until {
        number += 1;
        let item = json!({"kind": "detection", "stamp": now(), "id": format!("i{number}"),
            "x": 0.9, "y": -0.2});
        let line = format!("{item}\n");
        if (&camera).write_all(line.as_bytes()).is_err() {
            robot.say(&item);
        }
        // Each item lies where the one before has gone from.
        let before = statuses();
        wait_for("statuses", || statuses() >= before + 20);
        let tasks = robot.take_tasks();
        tasks.iter().for_each(|task| robot.pick(task));
        longest = longest.max(last.elapsed());
        if !tasks.is_empty() {
            last = Instant::now();
        }
        let remarks = node.remarks.all();
        if !gone && remarks.iter().any(|line| line.contains("was disconnected")) {
            (gone, until) = (true, statuses() + 100);
        }
    }
    assert!(number > 10, "{number}");
    (longest, gone)
}

/// It once held up all robots for minutes.
#[test]
fn a_camera_that_never_reads_holds_up_nobody() {
    let (longest, gone) = beside_a_deaf_camera("");
    assert!(gone && longest < HELD_UP, "{longest:?} {gone}");
}

#[test]
fn a_camera_that_has_said_hello_need_not_read() {
    let hello = "{\"kind\":\"hello\",\"name\":\"c\",\"role\":\"camera\"}\n";
    let (longest, gone) = beside_a_deaf_camera(hello);
    assert!(!gone && longest < HELD_UP, "{longest:?} {gone}");
}

/// A port scanner's connections once kept the claim of a robot that had died open for ever.
#[test]
fn a_peer_that_only_connects_extends_no_deadline() {
    let (_node, address) = node("--status-every 0.1 --result-timeout 2");
    let robot = Peer::new(&address);
    robot.stop_belt();
    robot.idle("r1");
    robot.see("a", "r1");
    let task = robot.wait_for("a task", is_task);
    robot.say(&json!({"kind": "ack", "stamp": now(), "task": task["id"]}));
    let over = |message: &Value| message["kind"] == "status" && message["missed"]["no_result"] == 1;
    wait_for("the end of a task", || {
        drop(TcpStream::connect(&address).unwrap());
        robot.count(over) > 0
    });
    // Nobody was told of the task again.
    assert_eq!(robot.count(is_task), 1);
}

/// Hundreds of connections once used up the descriptors, and the journal's replacement ended
/// the run.
#[test]
fn many_unknown_peers_harm_neither_robots_nor_the_journal() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("j");
    let mut command = Command::new("sh");
    command.args([
        "-c",
        "ulimit -n 200; exec \"$0\" run --listen 127.0.0.1:0 \
        --status-every 0.1 --max-peers \"$2\" --journal \"$1\"",
        env!("CARGO_BIN_EXE_pickline"),
        journal.to_str().unwrap(),
        "1000",
    ]);
    let (node, address) = listening(Program::start(&mut command));
    let robot = Peer::new(&address);
    robot.stop_belt();
    robot.idle("r1");
    // Each is in the way until it is turned away or has to go.
    let crowd: Vec<TcpStream> = (0..400)
        .filter_map(|_| TcpStream::connect(&address).ok())
        .collect();
    node.remarks.wait_for("ulimit -n");
    let size = || std::fs::metadata(&journal).unwrap().len();
    let (mut done, mut seen, mut largest) = (0, 0, 0);
    wait_for("a new journal", || {
        while seen < done + 100 {
            robot.see(&format!("{}{seen}", "i".repeat(180)), "r1");
            seen += 1;
        }
        let tasks = robot.take_tasks();
        tasks.iter().for_each(|task| robot.pick(task));
        done += tasks.len();
        let is_new = largest > 500_000 && size() < largest / 2;
        largest = largest.max(size());
        is_new
    });
    assert!(done > 100);
    drop(crowd);
}

#[test]
fn there_are_as_many_peers_as_are_allowed_and_those_that_are_silent_make_room() {
    let (node, address) = node("--status-every 0.1 --max-peers 3");
    let silent = Peer::new(&address);
    silent.status();
    let camera = Peer::greeting(&address, "camera", &[]);
    let robot = Peer::greeting(&address, "robot", &["r1"]);
    // Turned away while the silent one may still say who it is.
    let mut observer = None;
    wait_for("room for one more", || {
        let peer = Peer::new(&address);
        let hello = b"{\"kind\":\"hello\",\"name\":\"o\",\"role\":\"observer\"}\n";
        let _ = (&peer.stream).write_all(hello);
        wait_for("an answer", || !peer.heard().is_empty() || peer.is_gone());
        let is_in = peer
            .heard()
            .first()
            .is_some_and(|answer| answer["accepted"] == true);
        observer = is_in.then_some(peer);
        observer.is_some()
    });
    let observer = observer.unwrap();
    silent.wait_for_the_end();
    let late = Peer::new(&address);
    late.wait_for_the_end();
    let reason = late.heard().pop().unwrap()["reason"]
        .as_str()
        .unwrap()
        .to_owned();
    assert!(reason.contains("3 peers"), "{reason}");
    node.remarks.wait_for("--max-peers");
    for peer in [&camera, &robot, &observer] {
        peer.status();
    }
    // Threads do not grow with peers.
    let threads = |id: u32| std::fs::read_dir(format!("/proc/{id}/task")).map(Iterator::count);
    if let Ok(count) = threads(node.id()) {
        assert!(count <= 6, "{count}");
    }
}
