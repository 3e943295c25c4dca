//! The program at a terminal, where it shows its progress and hears Ctrl-C.

use crate::programs::wait_for;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;

/// A terminal that `script` of util-linux makes.
pub struct Terminal {
    script: Child,
    keys: ChildStdin,
    shown: Arc<Mutex<Vec<u8>>>,
}

impl Terminal {
    /// `pickline` with these arguments, separated by blanks. Its stdout goes into a file.
    pub fn pickline(arguments: &str, stdout: &Path) -> Self {
        let program = env!("CARGO_BIN_EXE_pickline");
        let call = format!("exec {program} {arguments} >{}", stdout.display());
        let mut script = Command::new("script")
            .args(["-q", "-e", "-f", "-c", &call, "/dev/null"])
            .env("SHELL", "/bin/sh")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let keys = script.stdin.take().unwrap();
        let mut screen = script.stdout.take().unwrap();
        let shown = Arc::<Mutex<Vec<u8>>>::default();
        let kept = Arc::clone(&shown);
        thread::spawn(move || {
            let mut part = [0; 4096];
            while let Ok(count @ 1..) = screen.read(&mut part) {
                kept.lock().unwrap().extend_from_slice(&part[..count]);
            }
        });
        Self {
            script,
            keys,
            shown,
        }
    }

    /// All that was shown so far.
    pub fn shown(&self) -> String {
        String::from_utf8_lossy(&self.shown.lock().unwrap()).into_owned()
    }

    /// Waits until the bar of `stage` shows that more than `count` steps are done.
    pub fn wait_for_more_than(&self, count: u64, stage: &str) {
        wait_for(stage, || {
            let shown = self.shown();
            let last = shown.rsplit(stage).next().unwrap();
            let done = last
                .split_once("] ")
                .and_then(|(_, rest)| rest.split_once('/'));
            let done = done.and_then(|(done, _)| done.replace(',', "").parse::<u64>().ok());
            shown.contains(stage) && done.is_some_and(|done| done > count)
        });
    }

    pub fn press_ctrl_c(&mut self) {
        self.keys.write_all(b"\x03").unwrap();
    }

    /// Waits for its end, and returns the exit code.
    pub fn finish(&mut self) -> Option<i32> {
        let mut code = None;
        wait_for("a program's end", || {
            code = self.script.try_wait().unwrap().map(|status| status.code());
            code.is_some()
        });
        code.unwrap()
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        let _ = self.script.kill();
        let _ = self.script.wait();
    }
}
