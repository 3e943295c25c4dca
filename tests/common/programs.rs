//! Programs that are started, watched and ended.
#![allow(dead_code)]

use std::io::{BufRead as _, BufReader, Read, Write as _};
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// More than any step takes on a slow machine.
const STEP_TIMEOUT: Duration = Duration::from_secs(300);
/// Time between two looks, the first and the longest.
const PAUSES: [Duration; 2] = [Duration::from_millis(1), Duration::from_millis(20)];

/// Waits until something has happened. A test that has to wait for a program waits here, for
/// what the program does, and not for a time by which it should have done it.
pub fn wait_for(what: &str, mut happened: impl FnMut() -> bool) {
    let until = Instant::now() + STEP_TIMEOUT;
    let mut pause = PAUSES[0];
    while !happened() {
        assert!(Instant::now() < until, "waited in vain for {what}");
        thread::sleep(pause);
        pause = (2 * pause).min(PAUSES[1]);
    }
}

/// Lets time pass for which nothing is waited: until a program is killed at any moment, while
/// a belt goes on by the clock.
pub fn let_pass(time: Duration) {
    thread::sleep(time);
}

/// Starts a program of which all streams are ours.
pub fn piped(command: &mut Command) -> Child {
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Runs a program on `input`: what it answers, and whether it has read all. One that refuses
/// its arguments reads nothing.
pub fn feed(command: &mut Command, input: &[u8]) -> (Output, std::io::Result<()>) {
    let mut child = piped(command);
    let mut stdin = child.stdin.take().unwrap();
    thread::scope(|scope| {
        let feeder = scope.spawn(move || stdin.write_all(input));
        let output = child.wait_with_output().unwrap();
        (output, feeder.join().unwrap())
    })
}

/// Lines as they come.
#[derive(Clone, Default)]
pub struct Lines(Arc<Mutex<Vec<String>>>);

impl Lines {
    fn follow(stream: impl Read + Send + 'static) -> (Self, JoinHandle<()>) {
        let lines = Self::default();
        let kept = lines.clone();
        let reader = thread::spawn(move || {
            for line in BufReader::new(stream).lines() {
                kept.0.lock().unwrap().push(line.unwrap());
            }
        });
        (lines, reader)
    }

    /// All so far.
    pub fn all(&self) -> Vec<String> {
        self.0.lock().unwrap().clone()
    }

    /// Waits for a line that holds `word`.
    pub fn wait_for(&self, word: &str) {
        wait_for(word, || self.all().iter().any(|line| line.contains(word)));
    }
}

/// A program at work; it ends with the test at the latest.
pub struct Program {
    child: Child,
    /// What it says on stdout.
    pub said: Lines,
    /// What it says on stderr.
    pub remarks: Lines,
    readers: Vec<JoinHandle<()>>,
}

impl Program {
    pub fn start(command: &mut Command) -> Self {
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (said, out) = Lines::follow(child.stdout.take().unwrap());
        let (remarks, err) = Lines::follow(child.stderr.take().unwrap());
        Self {
            child,
            said,
            remarks,
            readers: vec![out, err],
        }
    }

    /// `pickline` with these arguments, separated by blanks.
    pub fn pickline(arguments: &str, environment: &[(&str, &str)]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
        command.args(arguments.split_whitespace());
        command.env_remove("PICKLINE_MQTT_PASSWORD");
        Self::start(command.envs(environment.iter().copied()))
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    pub fn is_running(&mut self) -> bool {
        matches!(self.child.try_wait(), Ok(None))
    }

    pub fn signal(&self, signal: &str) {
        let id = self.child.id().to_string();
        let kill = Command::new("kill").args(["-s", signal, &id]).status();
        assert!(kill.unwrap().success());
    }

    /// Waits for its end: the exit code and all remarks.
    pub fn finish(&mut self) -> (Option<i32>, String) {
        let mut code = None;
        wait_for("a program's end", || {
            code = self.child.try_wait().unwrap().map(|status| status.code());
            code.is_some()
        });
        for reader in self.readers.drain(..) {
            reader.join().unwrap();
        }
        (code.unwrap(), self.remarks.all().join("\n"))
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
