//! Mosquitto on a free port.

use crate::programs::{Program, wait_for};
use std::fs;
use std::net::{TcpListener, TcpStream};
use std::path::PathBuf;
use std::process::Command;
use tempfile::TempDir;

/// A broker, or a place where one can be.
pub struct Broker {
    folder: TempDir,
    pub port: u16,
    running: Option<Program>,
}

impl Broker {
    /// A place for a broker; `settings` are lines of its configuration.
    pub fn place(settings: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let place = folder.path().display().to_string();
        let text = format!(
            "listener {port} 127.0.0.1\nset_tcp_nodelay true\npersistence false\nuser root\n{}",
            settings.replace("FOLDER", &place)
        );
        fs::write(folder.path().join("conf"), text).unwrap();
        Self {
            folder,
            port,
            running: None,
        }
    }

    /// A broker that lets everybody in.
    pub fn open() -> Self {
        let mut broker = Self::place("allow_anonymous true\n");
        broker.start();
        broker
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn start(&mut self) {
        let mut command = Command::new("/usr/sbin/mosquitto");
        self.running = Some(Program::start(command.arg("-c").arg(self.path("conf"))));
        wait_for("mosquitto (tests/mqtt/run.sh installs it)", || {
            TcpStream::connect(("127.0.0.1", self.port)).is_ok()
        });
    }

    pub fn signal(&self, signal: &str) {
        self.running.as_ref().unwrap().signal(signal);
    }

    /// Waits until a client is connected.
    pub fn wait_for_a_client(&self) {
        let running = self.running.as_ref().unwrap();
        running.remarks.wait_for("New client connected");
    }

    /// Ends it on the spot, and starts it again after `work`.
    pub fn kill_and_restart(&mut self, work: impl FnOnce()) {
        self.signal("KILL");
        self.running = None;
        work();
        self.start();
    }

    pub fn url(&self) -> String {
        format!("mqtt://127.0.0.1:{}", self.port)
    }

    /// Everything that passes, each line a topic and a payload: a record that owes nothing
    /// to the code under test.
    pub fn watch(&self) -> Program {
        let mut command = Command::new("mosquitto_sub");
        let port = self.port.to_string();
        command.args([
            "-V",
            "5",
            "-q",
            "1",
            "-F",
            "%r %t %p",
            "-t",
            "#",
            "-t",
            "$SYS/broker/version",
        ]);
        let watcher = Program::start(command.args(["-h", "127.0.0.1", "-p", &port]));
        watcher.said.wait_for("$SYS");
        watcher
    }

    pub fn publish(&self, topic: &str, payload: &str, quality: &str) {
        let file = self.path("payload");
        fs::write(&file, payload).unwrap();
        let port = self.port.to_string();
        let mut command = Command::new("mosquitto_pub");
        command.args([
            "-V",
            "5",
            "-h",
            "127.0.0.1",
            "-p",
            &port,
            "-q",
            quality,
            "-t",
            topic,
        ]);
        assert!(command.arg("-f").arg(file).status().unwrap().success());
    }
}
