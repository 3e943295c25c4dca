//! Who talks to a node over TCP: peers that stall, strangers, roles, tokens, certificates.

use crate::authority;
use crate::programs::{Program, wait_for};
use serde_json::{Value, json};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

fn now() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.unwrap().as_secs_f64()
}

/// A node that listens at a free port of this machine, and where.
fn node(arguments: &str) -> (Program, String) {
    listening(Program::pickline(
        &format!("run --listen 127.0.0.1:0 {arguments}"),
        &[],
    ))
}

fn listening(node: Program) -> (Program, String) {
    node.remarks.wait_for("listening at ");
    let remarks = node.remarks.all();
    let remark = remarks.iter().find(|line| line.contains("listening at "));
    let address = remark.unwrap().rsplit(' ').next().unwrap().to_owned();
    (node, address)
}

/// A peer that reads all that it is sent.
struct Peer {
    stream: TcpStream,
    heard: Arc<Mutex<Vec<Value>>>,
    gone: Arc<Mutex<bool>>,
}

impl Peer {
    fn new(address: &str) -> Self {
        let stream = TcpStream::connect(address).unwrap();
        let (heard, gone) = (Arc::default(), Arc::default());
        let peer = Self {
            stream: stream.try_clone().unwrap(),
            heard: Arc::clone(&heard),
            gone: Arc::clone(&gone),
        };
        thread::spawn(move || {
            for line in BufReader::new(stream).lines().map_while(Result::ok) {
                let message = serde_json::from_str(&line).unwrap();
                heard.lock().unwrap().push(message);
            }
            *gone.lock().unwrap() = true;
        });
        peer
    }

    /// One that begins with a hello.
    fn greeting(address: &str, role: &str, robots: &[&str]) -> Self {
        let peer = Self::new(address);
        let mut hello = json!({"kind": "hello", "name": role, "role": role});
        if !robots.is_empty() {
            hello["robots"] = json!(robots);
        }
        peer.say(&hello);
        peer.wait_for("an answer", |message| message["kind"] == "hello");
        peer
    }

    fn say(&self, message: &Value) {
        (&self.stream)
            .write_all(format!("{message}\n").as_bytes())
            .unwrap();
    }

    fn idle(&self, robot: &str) {
        self.say(&json!({"kind": "robot", "stamp": now(), "name": robot, "state": "idle"}));
    }

    fn stop_belt(&self) {
        self.say(&json!({"kind": "belt", "stamp": now(), "speed": 0.0}));
    }

    /// An item that lies where r1 (y < 0) or r2 (y > 0) reaches it.
    fn see(&self, id: &str, robot: &str) {
        let (x, y) = if robot == "r1" {
            (1.3, -0.2)
        } else {
            (2.9, 0.2)
        };
        self.say(&json!({"kind": "detection", "stamp": now(), "id": id, "x": x, "y": y}));
    }

    fn heard(&self) -> Vec<Value> {
        self.heard.lock().unwrap().clone()
    }

    /// The tasks since the last time.
    fn take_tasks(&self) -> Vec<Value> {
        let mut heard = std::mem::take(&mut *self.heard.lock().unwrap());
        heard.retain(is_task);
        heard
    }

    /// Does a task without delay.
    fn pick(&self, task: &Value) {
        let id = &task["id"];
        self.say(&json!({"kind": "ack", "stamp": now(), "task": id}));
        self.say(&json!({"kind": "result", "stamp": now(), "task": id, "result": "PICKED"}));
    }

    fn count(&self, fits: impl Fn(&Value) -> bool) -> usize {
        self.heard().iter().filter(|message| fits(message)).count()
    }

    fn wait_for(&self, what: &str, fits: impl Fn(&Value) -> bool) -> Value {
        let mut found = None;
        wait_for(what, || {
            found = self.heard().into_iter().find(|message| fits(message));
            found.is_some()
        });
        found.unwrap()
    }

    fn wait_for_the_end(&self) {
        wait_for("the end of a connection", || *self.gone.lock().unwrap());
    }

    /// The next status but one: what was said before counts in it.
    fn status(&self) -> Value {
        let is_status = |message: &Value| message["kind"] == "status";
        let before = self.count(is_status);
        wait_for("a status", || self.count(is_status) > before + 1);
        let mut heard = self.heard();
        heard.retain(is_status);
        heard.pop().unwrap()
    }
}

fn is_task(message: &Value) -> bool {
    message["kind"] == "task"
}

/// Detections of a camera that reads nothing, until it is disconnected and for a second more,
/// or for 15 s; returns the longest time without a task, and whether it was disconnected.
fn beside_a_deaf_camera(hello: &str) -> (Duration, bool) {
    let (node, address) = node("--status-every 0.01");
    let robot = Peer::new(&address);
    robot.say(&json!({"kind": "belt", "stamp": now(), "speed": 0.2}));
    robot.idle("r1");
    let camera = TcpStream::connect(&address).unwrap();
    (&camera).write_all(hello.as_bytes()).unwrap();
    let began = Instant::now();
    let (mut last, mut longest, mut gone) = (Instant::now(), Duration::ZERO, None::<Instant>);
    for number in 0.. {
        let until = gone.map_or(began + Duration::from_secs(15), |at| {
            at + Duration::from_secs(1)
        });
        if Instant::now() > until {
            break;
        }
        let item = json!({"kind": "detection", "stamp": now(), "id": format!("i{number}"),
            "x": 0.9, "y": -0.2});
        let line = format!("{item}\n");
        if (&camera).write_all(line.as_bytes()).is_err() {
            robot.say(&item);
        }
        let tasks = robot.take_tasks();
        tasks.iter().for_each(|task| robot.pick(task));
        longest = longest.max(last.elapsed());
        if !tasks.is_empty() {
            last = Instant::now();
        }
        let remarks = node.remarks.all();
        if gone.is_none() && remarks.iter().any(|line| line.contains("was disconnected")) {
            gone = Some(Instant::now());
        }
        thread::sleep(Duration::from_millis(250));
    }
    (longest, gone.is_some())
}

/// It once held up all robots for minutes.
#[test]
fn a_camera_that_never_reads_holds_up_nobody() {
    let (longest, gone) = beside_a_deaf_camera("");
    assert!(
        gone && longest < Duration::from_secs(2),
        "{longest:?} {gone}"
    );
}

#[test]
fn a_camera_that_has_said_hello_need_not_read() {
    let hello = "{\"kind\":\"hello\",\"name\":\"c\",\"role\":\"camera\"}\n";
    let (longest, gone) = beside_a_deaf_camera(hello);
    assert!(
        !gone && longest < Duration::from_secs(2),
        "{longest:?} {gone}"
    );
}

/// A port scanner's connections once kept the claim of a robot that had died open for ever.
#[test]
fn who_only_connects_renews_no_deadline() {
    let (_node, address) = node("--status-every 0.1 --result-timeout 2");
    let robot = Peer::new(&address);
    robot.stop_belt();
    robot.idle("r1");
    robot.see("a", "r1");
    let task = robot.wait_for("a task", is_task);
    robot.say(&json!({"kind": "ack", "stamp": now(), "task": task["id"]}));
    let free = task["free_at"].as_f64().unwrap();
    let over = |message: &Value| message["kind"] == "status" && message["missed"]["no_result"] == 1;
    while robot.count(over) == 0 {
        assert!(now() < free + 2.0 + 10.0);
        drop(TcpStream::connect(&address).unwrap());
        thread::sleep(Duration::from_millis(500));
    }
    // Nobody was told of the task again.
    assert_eq!(robot.count(is_task), 1);
}

#[test]
fn who_comes_is_told_of_tasks_as_they_stand_and_again_once_it_speaks_for_the_robot() {
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

/// A page in a browser can send anything but the first line.
#[test]
fn a_web_page_commands_nothing() {
    let (node, address) = node("--status-every 0.1");
    let observer = Peer::new(&address);
    let mut browser = TcpStream::connect(&address).unwrap();
    let body = format!(
        "\n{}\n{}\n",
        json!({"kind": "robot", "stamp": now(), "name": "r1", "state": "idle"}),
        json!({"kind": "detection", "stamp": now(), "id": "a", "x": 1.3, "y": -0.2}),
    );
    let request = format!(
        "POST / HTTP/1.1\r\nHost: {address}\r\nContent-Type: text/plain\r\n\
         Content-Length: {}\r\n\r\n{body}",
        body.len()
    );
    browser.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    browser.read_to_string(&mut answer).unwrap();
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(
        (&answer["kind"], &answer["accepted"]),
        (&json!("hello"), &json!(false))
    );
    let status = observer.status();
    assert_eq!(status["seen"], 0);
    assert_eq!(status["rejected"], json!({"syntax": 1}));
    assert_eq!(status["robots"][0]["state"], "unknown");
    node.remarks.wait_for("it begins `POST / HTTP/1.1`");
    // JSON of another kind, a version to come, and what only looks like JSON.
    for line in [
        r#"{"jsonrpc":"2.0","method":"x"}"#,
        r#"{"v":2,"kind":"tick","stamp":1}"#,
        "{nonsense",
    ] {
        let stranger = Peer::new(&address);
        let line = format!("{line}\n");
        (&stranger.stream).write_all(line.as_bytes()).unwrap();
        stranger.wait_for_the_end();
        assert_eq!(stranger.heard().last().unwrap()["accepted"], false);
    }
    // One flawed message is no reason, a hundred are.
    let camera = Peer::new(&address);
    for i in 0..99 {
        camera.say(&json!({"kind": "detection", "stamp": now(), "x": i, "y": "nowhere"}));
    }
    camera.see("b", "r1");
    let status = observer.status();
    assert_eq!(status["rejected"]["field"], 99);
    assert_eq!(status["seen"], 1);
    for i in 0..100 {
        camera.say(&json!({"kind": "detection", "stamp": now(), "x": i, "y": "nowhere"}));
    }
    camera.wait_for_the_end();
}

#[test]
fn each_role_hears_and_says_what_it_is_there_for() {
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
    back.stream.shutdown(Shutdown::Both).unwrap();
    thread::sleep(Duration::from_millis(300));
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
fn a_hello_that_cannot_be_is_refused_with_the_reason() {
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
        reason.contains("(robot `north`) speaks for `r1`"),
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
fn a_hello_in_csv_that_cannot_be_is_answered_and_ends_the_connection() {
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

fn secret(folder: &Path) -> String {
    let file = folder.join("token");
    std::fs::write(&file, "0123456789abcdef0123456789abcdef\n").unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
    file.to_str().unwrap().to_owned()
}

#[test]
fn where_a_token_is_asked_for_nobody_is_heard_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let token = secret(folder.path());
    let (node, address) = node(&format!("--status-every 0.1 --token {token}"));
    let hello = |token: Option<&str>| {
        let peer = Peer::new(&address);
        let mut hello = json!({"kind": "hello", "name": "c", "role": "camera"});
        if let Some(token) = token {
            hello["token"] = json!(token);
        }
        peer.say(&hello);
        peer
    };
    let camera = hello(Some("0123456789abcdef0123456789abcdef"));
    let answer = camera.wait_for("an answer", |message| message["kind"] == "hello");
    assert_eq!(answer["accepted"], true);
    for peer in [
        hello(None),
        hello(Some("0123456789abcdef")),
        hello(Some("")),
    ] {
        peer.wait_for_the_end();
        assert_eq!(peer.heard().len(), 1);
        let reason = peer.heard()[0]["reason"].as_str().unwrap().to_owned();
        assert!(reason.contains("token"), "{reason}");
    }
    // Without a hello, and without a word.
    let rude = Peer::new(&address);
    rude.see("a", "r1");
    let mute = Peer::new(&address);
    for peer in [rude, mute] {
        peer.wait_for_the_end();
        assert_eq!(peer.heard().len(), 1, "{:?}", peer.heard());
        assert_eq!(peer.heard()[0]["accepted"], false);
    }
    assert_eq!(camera.status()["seen"], 0);
    let said = format!("{:?}{:?}", node.remarks.all(), camera.heard());
    assert!(!said.contains("0123456789abcdef"), "{said}");
    // The station shows it.
    let emulate = |more: &str| {
        let line = format!("emulate --connect {address} --belt-speed 0.4 {more}");
        Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(line.split_whitespace())
            .output()
            .unwrap()
    };
    let refused = emulate("");
    let text = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{text}");
    assert!(
        text.contains("its hello has no token") && text.contains("cure: "),
        "{text}"
    );
    let played = emulate(&format!("--token {token}"));
    let text = String::from_utf8_lossy(&played.stderr).into_owned();
    assert_eq!(played.status.code(), Some(0), "{text}");
    assert!(text.contains("of 50 items in the bins"), "{text}");
}

#[test]
fn addresses_that_others_reach_ask_for_something() {
    let folder = tempfile::tempdir().unwrap();
    let token = secret(folder.path());
    let run = |line: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(line.split_whitespace())
            .stdin(std::process::Stdio::null())
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), text)
    };
    for (line, word) in [
        ("run --listen 0.0.0.0:0", "--token FILE"),
        ("run --listen [::]:0", "--insecure"),
        ("run --dashboard 0.0.0.0:0", "could watch the line"),
        ("run --connect 192.0.2.1:9", "--tls-ca"),
        ("emulate --listen 0.0.0.0:0", "--insecure"),
        (&format!("run --token {token}"), "nobody is asked for it"),
        (
            &format!("run --connect 127.0.0.1:9 --token {token}"),
            "nobody is asked for it",
        ),
        ("run --listen 127.0.0.1:0 --token /no/such/file", "/no/such"),
    ] {
        let (code, text) = run(line);
        assert_eq!(code, Some(2), "{line}: {text}");
        assert!(
            text.contains(word) && text.contains("cure: "),
            "{line}: {text}"
        );
    }
    // The dashboard alone may be open to others with a token.
    let (code, text) = run(&format!("run --dashboard 0.0.0.0:0 --token {token}"));
    assert_eq!(code, Some(0), "{text}");
    assert!(!text.contains("anybody"), "{text}");
}

/// Hundreds of connections once used up the descriptors, and the journal's replacement ended
/// the run.
#[test]
fn crowds_of_strangers_harm_neither_robots_nor_the_journal() {
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
    let mut is_begun_anew = false;
    let until = Instant::now() + Duration::from_secs(90);
    while !is_begun_anew {
        assert!(
            Instant::now() < until,
            "{done} tasks, {largest} bytes: {:?}",
            node.remarks.all()
        );
        while seen < done + 100 {
            robot.see(&format!("{}{seen}", "i".repeat(180)), "r1");
            seen += 1;
        }
        let tasks = robot.take_tasks();
        tasks.iter().for_each(|task| robot.pick(task));
        done += tasks.len();
        is_begun_anew = largest > 500_000 && size() < largest / 2;
        largest = largest.max(size());
        thread::sleep(Duration::from_millis(2));
    }
    assert!(done > 100);
    drop(crowd);
}

#[test]
fn there_are_as_many_peers_as_are_allowed_and_those_that_are_silent_make_room() {
    let (node, address) = node("--status-every 0.1 --max-peers 3");
    let silent = Peer::new(&address);
    silent.status();
    thread::sleep(Duration::from_secs(1));
    let camera = Peer::greeting(&address, "camera", &[]);
    let robot = Peer::greeting(&address, "robot", &["r1"]);
    let observer = Peer::greeting(&address, "observer", &[]);
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

/// What the dashboard at `address` answers to a plain request.
fn status_line(address: &str, authorization: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!("GET /dashboard.css HTTP/1.1\r\nHost: {address}\r\n{authorization}\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut line = String::new();
    let _ = BufReader::new(stream).read_line(&mut line);
    line.trim().to_owned()
}

/// The address of a node's dashboard.
fn dashboard(node: &Program) -> String {
    node.remarks.wait_for("dashboard at ");
    let remarks = node.remarks.all();
    let remark = remarks.iter().find(|line| line.contains("dashboard at "));
    let url = remark.unwrap().rsplit(' ').next().unwrap();
    let address = url.split("//").nth(1).unwrap();
    address.trim_end_matches('/').to_owned()
}

#[test]
fn the_dashboard_asks_for_the_token_too() {
    let folder = tempfile::tempdir().unwrap();
    let token = secret(folder.path());
    let (node, _) = node(&format!("--dashboard 127.0.0.1:0 --token {token}"));
    let address = dashboard(&node);
    for (authorization, answer) in [
        ("", "HTTP/1.1 401 Unauthorized"),
        (
            "Authorization: Bearer 0123456789abcdef\r\n",
            "HTTP/1.1 401 Unauthorized",
        ),
        (
            "Authorization: Bearer 0123456789abcdef0123456789abcdef\r\n",
            "HTTP/1.1 200 OK",
        ),
        (
            // `me:` and the token.
            "Authorization: Basic bWU6MDEyMzQ1Njc4OWFiY2RlZjAxMjM0NTY3ODlhYmNkZWY=\r\n",
            "HTTP/1.1 200 OK",
        ),
    ] {
        assert_eq!(
            status_line(&address, authorization),
            answer,
            "{authorization}"
        );
    }
}

#[test]
fn certificates_of_both_sides_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let (ours, theirs) = (folder.path().join("ours"), folder.path().join("theirs"));
    for folder in [&ours, &theirs] {
        std::fs::create_dir(folder).unwrap();
        authority::authority(folder, &["node", "station"]);
    }
    let files = |folder: &Path, name: &str| {
        let folder = folder.display();
        format!("--tls-cert {folder}/{name}.pem --tls-key {folder}/{name}.key")
    };
    let (ca, node_files) = (ours.join("ca.pem"), files(&ours, "node"));
    let (node, address) = node(&format!(
        "--dashboard 127.0.0.1:0 --tls-ca {} {node_files}",
        ca.display()
    ));
    let emulate = |more: &str| {
        let line = format!("emulate --connect {address} --belt-speed 0.4 {more}");
        Program::pickline(&line, &[])
    };
    // In the clear, without a certificate, and with one of somebody else.
    let mut in_the_clear = TcpStream::connect(&address).unwrap();
    let tick = format!("{}\n", json!({"kind": "tick", "stamp": now()}));
    in_the_clear.write_all(tick.as_bytes()).unwrap();
    let mut rest = Vec::new();
    let _ = in_the_clear.read_to_end(&mut rest);
    assert!(!rest.starts_with(b"{"));
    node.remarks.wait_for("no TLS with it");
    let ca = ca.display();
    for more in [
        format!("--tls-ca {ca}"),
        format!("--tls-ca {ca} {}", files(&theirs, "station")),
        format!(
            "--tls-ca {}/ca.pem {}",
            theirs.display(),
            files(&ours, "station")
        ),
    ] {
        let stranger = emulate(&more);
        let refused = |line: &String| line.contains("no TLS with it");
        let before = node
            .remarks
            .all()
            .iter()
            .filter(|line| refused(line))
            .count();
        let told = || {
            let remarks = node.remarks.all();
            remarks.iter().filter(|line| refused(line)).count() > before
                || remarks.iter().any(|line| line.contains("more"))
                || stranger
                    .remarks
                    .all()
                    .iter()
                    .any(|line| line.contains("nobody to talk to"))
        };
        wait_for("a refusal", told);
    }
    let mut station = emulate(&format!("--tls-ca {ca} {}", files(&ours, "station")));
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(
        remarks.contains("of 50 items in the bins; the node says"),
        "{remarks}"
    );
    // The dashboard has the same certificate, and asks for one too.
    let at = dashboard(&node);
    assert!(!status_line(&at, "").starts_with("HTTP"));
    let shown = Command::new("openssl")
        .args([
            "s_client",
            "-quiet",
            "-verify_return_error",
            "-connect",
            &at,
        ])
        .args(["-CAfile", &ca.to_string()])
        .args(["-cert", ours.join("station.pem").to_str().unwrap()])
        .args(["-key", ours.join("station.key").to_str().unwrap()])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn();
    let mut shown = shown.unwrap();
    let mut stdin = shown.stdin.take().unwrap();
    write!(stdin, "GET /dashboard.css HTTP/1.1\r\nHost: {at}\r\n\r\n").unwrap();
    let mut line = String::new();
    let mut page = BufReader::new(shown.stdout.take().unwrap());
    page.read_line(&mut line).unwrap();
    assert_eq!(line.trim(), "HTTP/1.1 200 OK");
    drop(stdin);
    shown.kill().unwrap();
    shown.wait().unwrap();
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
    let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
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
