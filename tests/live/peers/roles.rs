//! What each peer is told and may say, by its hello.

use super::{Peer, is_task, node, now};
use crate::programs::wait_for;
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::net::{Shutdown, TcpStream};

#[test]
fn a_new_peer_receives_open_tasks_and_again_once_it_speaks_for_the_robot() {
    let (_node, address) = node("--status-every 0.1 --ack-timeout 100");
    let robot = Peer::new(&address);
    robot.stop_belt();
    robot.idle("r1");
    robot.idle("r2");
    robot.see("a", "r1");
    robot.see("b", "r2");
    wait_for("two tasks", || robot.count(is_task) == 2);
    let other = Peer::new(&address);
    wait_for("two tasks", || other.count(is_task) == 2);
    assert_eq!(other.count(|m| m["revision"] == 0), 2);
    other.status();
    assert_eq!(robot.count(is_task), 2);
    // It speaks for r2 now: that task alone is sent again.
    other.idle("r2");
    let is_again = |message: &Value| is_task(message) && message["revision"] == 1;
    wait_for("one task", || robot.count(is_again) == 1);
    other.idle("r2");
    other.status();
    let again: Vec<Value> = other.heard().into_iter().filter(is_again).collect();
    assert_eq!(again.len(), 1);
    assert_eq!(again[0]["robot"], "r2");
}

#[test]
fn each_role_receives_and_sends_its_own_messages() {
    let (node, address) = node("--status-every 0.1");
    let camera = Peer::greeting(&address, "camera", &[]);
    let first = Peer::greeting(&address, "robot", &["r1"]);
    let second = Peer::greeting(&address, "robot", &["r2"]);
    let observer = Peer::greeting(&address, "observer", &[]);
    let stranger = Peer::new(&address);
    assert_eq!(camera.heard()[0]["robots"], json!(["r1", "r2"]));
    camera.stop_belt();
    // Others may not speak for a robot that somebody has said hello for.
    for peer in [&camera, &second, &observer, &stranger] {
        peer.idle("r1");
    }
    observer.see("x", "r1");
    let status = first.status();
    assert_eq!(status["rejected"], json!({"not_allowed": 5}));
    assert_eq!(
        (&status["seen"], &status["robots"][0]["state"]),
        (&json!(0), &json!("unknown"))
    );
    first.idle("r1");
    second.idle("r2");
    camera.see("a", "r1");
    camera.see("b", "r2");
    for (peer, robot) in [(&first, "r1"), (&second, "r2")] {
        let task = peer.wait_for("a task", is_task);
        assert_eq!(task["robot"], robot);
        // Nor answer for it.
        observer.say(
            &json!({"kind": "result", "stamp": now(), "task": task["id"],
            "result": "PICKED"}),
        );
        stranger.say(&json!({"kind": "ack", "stamp": now(), "task": task["id"]}));
        peer.say(&json!({"kind": "ack", "stamp": now(), "task": task["id"]}));
    }
    let status = camera.status();
    assert_eq!(status["rejected"], json!({"not_allowed": 9}));
    let tasks = [&first, &second, &observer, &camera].map(|peer| peer.count(is_task));
    assert_eq!(tasks, [1, 1, 2, 0]);
    node.remarks.wait_for("refused (not_allowed)");
    // A robot whose peer has gone is given nothing, whoever else is there.
    drop(first.stream.shutdown(Shutdown::Both));
    let task = &first.wait_for("a task", is_task)["id"];
    let back = Peer::greeting(&address, "robot", &["r1"]);
    back.wait_for("the task again", |m| {
        is_task(m) && m["id"] == *task && m["revision"] == 0
    });
    back.say(&json!({"kind": "result", "stamp": now(), "task": task, "result": "PICKED"}));
    back.stream.shutdown(Shutdown::Write).unwrap();
    back.wait_for_the_end();
    camera.see("c", "r1");
    let status = camera.status();
    assert_eq!(
        (&status["picked"], &status["on_belt"]),
        (&json!(1), &json!(1))
    );
    let back = Peer::greeting(&address, "robot", &["r1"]);
    back.wait_for("a task", |message| {
        is_task(message) && message["item"] == "c"
    });
}

#[test]
fn an_invalid_hello_is_refused_with_the_reason() {
    let (_node, address) = node("--status-every 0.1");
    for (hello, word) in [
        (
            json!({"name": "a", "role": "robot", "robots": ["r9"]}),
            "no robot `r9`",
        ),
        (
            json!({"name": "a", "role": "robot", "robots": ["r11"]}),
            "did you mean `r1`",
        ),
        (json!({"name": "a", "role": "Camera"}), "Camera"),
        (json!({"name": "a", "role": "king"}), "king"),
        (json!({"role": "camera"}), "missing field `name`"),
        (json!({"name": "", "role": "camera"}), "name"),
        (json!({"name": " a", "role": "camera"}), "name"),
        (
            json!({"name": "a", "role": "camera", "x": 1}),
            "unknown field `x`",
        ),
        (json!({"name": "a", "role": "camera", "v": 2}), "version 1"),
        (json!({"name": "a", "role": "robot"}), "robots is empty"),
        (
            json!({"name": "a", "role": "camera", "robots": ["r1"]}),
            "role `camera`",
        ),
        (
            json!({"name": "a", "role": "operator", "robots": ["r1"]}),
            "role `operator`",
        ),
    ] {
        let mut hello = hello;
        hello["kind"] = json!("hello");
        let peer = Peer::new(&address);
        peer.say(&hello);
        // Nobody listens any more to what it says next.
        let _ = (&peer.stream).write_all(b"{\"kind\":\"stop\",\"stamp\":0}\n");
        peer.wait_for_the_end();
        let answer = peer.heard().pop().unwrap();
        assert_eq!(answer["accepted"], false);
        assert!(
            answer["reason"].as_str().unwrap().contains(word),
            "{answer}"
        );
    }
    let twice = Peer::new(&address);
    let line = b"{\"kind\":\"hello\",\"name\":\"a\",\"name\":\"b\",\"role\":\"camera\"}\n";
    (&twice.stream).write_all(line).unwrap();
    twice.wait_for_the_end();
    let status = Peer::greeting(&address, "observer", &[]).status();
    assert_eq!(
        (&status["rejected"], &status["mode"]),
        (
            &json!({"not_allowed": 2, "field": 5, "value": 5, "version": 1}),
            &json!("running")
        )
    );
}

#[test]
fn a_robot_has_one_peer_at_a_time() {
    let (_node, address) = node("--status-every 0.1");
    let hello = |name: &str, robots: &[&str]| {
        let peer = Peer::new(&address);
        peer.say(&json!({"kind": "hello", "name": name, "role": "robot", "robots": robots}));
        let answer = peer.wait_for("an answer", |message| message["kind"] == "hello");
        (peer, answer)
    };
    let (first, answer) = hello("north", &["r1"]);
    assert_eq!(answer["accepted"], true);
    let (second, answer) = hello("south", &["r2", "r1"]);
    assert_eq!(answer["accepted"], false);
    let reason = answer["reason"].as_str().unwrap();
    assert!(
        reason.contains("(robot `north`) already speaks for `r1`"),
        "{reason}"
    );
    second.wait_for_the_end();
    let (other, answer) = hello("south", &["r2"]);
    assert_eq!(answer["accepted"], true);
    // Under its own name it takes the place of its old connection.
    let (again, answer) = hello("north", &["r1"]);
    assert_eq!(answer["accepted"], true);
    first.wait_for_the_end();
    // Once it has gone, another one may come.
    again.stream.shutdown(Shutdown::Both).unwrap();
    again.wait_for_the_end();
    wait_for("the place of a robot that has gone", || {
        hello("west", &["r1"]).1["accepted"] == true
    });
    drop(other);
}

#[test]
fn an_invalid_hello_in_csv_is_answered_and_ends_the_connection() {
    let (_node, address) = node("--dialect csv --status-every 0.1");
    let mut stream = TcpStream::connect(&address).unwrap();
    let body = "H,0,x,Q,";
    let (mut low, mut high) = (0u16, 0u16);
    for byte in body.bytes() {
        low = (low + u16::from(byte)) % 255;
        high = (high + low) % 255;
    }
    let line = format!("{body}*{:05}\r\n", high * 256 + low);
    stream.write_all(line.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("H,0,0,"), "{answer}");
}

/// Holding and telling again are recorded, robot by robot.
#[cfg(feature = "mcap")]
#[test]
fn a_recording_of_peers_that_come_and_go_replays_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("r.mcap");
    let (mut node, address) = node(&format!("--status-every 0.1 --record {}", file.display()));
    let camera = Peer::greeting(&address, "camera", &[]);
    camera.stop_belt();
    let first = Peer::greeting(&address, "robot", &["r1"]);
    first.idle("r1");
    let second = Peer::greeting(&address, "robot", &["r2"]);
    second.idle("r2");
    camera.see("a", "r1");
    first.wait_for("a task", is_task);
    first.stream.shutdown(Shutdown::Both).unwrap();
    camera.status();
    camera.see("b", "r2");
    let task = second.wait_for("a task", is_task);
    second.pick(&task);
    let back = Peer::greeting(&address, "robot", &["r1"]);
    let task = back.wait_for("a task", is_task);
    back.pick(&task);
    second.idle("r1");
    wait_for("two picks", || camera.status()["picked"] == 2);
    node.signal("TERM");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["run", "--replay", file.to_str().unwrap()])
        .output()
        .unwrap();
    let verdict = String::from_utf8(output.stderr).unwrap();
    assert!(
        verdict.contains("as recorded") && !verdict.contains("differ"),
        "{verdict}"
    );
    let text = std::fs::read(&file).unwrap();
    let holds = |word: &str| text.windows(word.len()).any(|part| part == word.as_bytes());
    assert!(holds("\"held_robots\":[0]") && holds("\"kind\":\"spoken\""));
}
