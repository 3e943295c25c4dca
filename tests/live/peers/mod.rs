//! Who talks to a node over TCP: peers that stall, strangers, roles, tokens, certificates.

mod access;
mod crowds;
mod roles;

use crate::programs::{Program, wait_for};
use serde_json::{Value, json};
use std::io::{BufRead as _, BufReader, Write as _};
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{SystemTime, UNIX_EPOCH};

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
        let mut heard = self.heard.lock().unwrap();
        heard.extract_if(.., |message| is_task(message)).collect()
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

    fn is_gone(&self) -> bool {
        *self.gone.lock().unwrap()
    }

    fn wait_for_the_end(&self) {
        wait_for("the end of a connection", || self.is_gone());
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

fn secret(folder: &Path) -> String {
    let file = folder.join("token");
    std::fs::write(&file, "0123456789abcdef0123456789abcdef\n").unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
    file.to_str().unwrap().to_owned()
}
