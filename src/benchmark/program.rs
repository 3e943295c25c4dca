//! An outside program that writes picks.

use super::instance::Instance;
use crate::error::{Error, Result, shown_number};
use crate::files;
use crate::optimize::Stop;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// How often it is looked whether a program has ended.
const LOOK_EVERY: Duration = Duration::from_millis(5);
/// The longest part of a program's last words that a message quotes [characters].
const LONGEST_WORDS: usize = 200;

/// A program that is called with the files of a station and of a pattern, and with the file into which it
/// writes its picks.
#[derive(Debug, Clone, PartialEq)]
pub struct OutsideProgram {
    words: Vec<String>,
    timeout: Duration,
}

impl OutsideProgram {
    /// The program `call`, a command with its first arguments, separated by spaces, which may take `timeout_s`
    /// [s] for an instance.
    ///
    /// # Errors
    /// No command, or a time that is not positive or longer than a day.
    pub fn new(call: &str, timeout_s: f64) -> Result<Self> {
        let words: Vec<String> = call.split_whitespace().map(str::to_owned).collect();
        if words.is_empty() {
            return Err(Error::usage(
                "'program'",
                "there is no command",
                "give the command that runs the program, such as 'python3 my.py'",
            ));
        }
        if !(timeout_s > 0.0 && timeout_s <= 86_400.0) {
            return Err(Error::usage(
                "'timeout'",
                format!("{} s is out of range", shown_number(timeout_s)),
                "give seconds, above 0 and at most 86400",
            ));
        }
        Ok(Self {
            words,
            timeout: Duration::from_secs_f64(timeout_s),
        })
    }

    /// How it is called.
    pub(super) fn text(&self) -> String {
        self.words.join(" ")
    }

    /// The text that it writes for `instance`, and the time that it took.
    ///
    /// # Errors
    /// A program that cannot be started, that fails, that takes too long or that writes no picks;
    /// [`Interrupted`](crate::error::ErrorKind::Interrupted).
    pub(super) fn run(&self, instance: &Instance, stop: &dyn Stop) -> Result<(String, Duration)> {
        let scratch = Scratch::new()?;
        // No instance has such names.
        let (picks, words) = (scratch.0.join(".picks.csv"), scratch.0.join(".stderr"));
        // Copies, so that no program can spoil the benchmark.
        let copy = |file: PathBuf| {
            let to = scratch.0.join(file.file_name().unwrap_or_default());
            let copied = std::fs::copy(&file, &to);
            copied.map_err(|source| Error::read(&file, source))?;
            Ok::<PathBuf, Error>(to)
        };
        let station = copy(instance.station_file())?;
        let pattern = copy(instance.pattern_file())?;
        let told = File::create(&words).map_err(|source| Error::write(&words, source))?;
        let begun = Instant::now();
        let mut call = Command::new(&self.words[0]);
        // A group of its own, so that what the program has started can be stopped with it.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut call, 0);
        let mut child = call
            .args(&self.words[1..])
            .args([&station, &pattern, &picks])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(told)
            .spawn()
            .map_err(|error| failed(format!("does not start: {error}")))?;
        let status = self.wait(&mut child, begun, stop)?;
        let spent = begun.elapsed();
        if !status.success() {
            let said = last_words(&words);
            return Err(failed(format!("failed with {status}{said}")));
        }
        if !picks.is_file() {
            let said = last_words(&words);
            return Err(failed(format!("wrote no picks{said}")));
        }
        let bytes = std::fs::read(&picks).map_err(|source| Error::read(&picks, source))?;
        Ok((files::utf8(bytes, "its picks")?, spent))
    }

    fn wait(&self, child: &mut Child, begun: Instant, stop: &dyn Stop) -> Result<ExitStatus> {
        let outcome = loop {
            match child.try_wait() {
                Ok(Some(status)) => return Ok(status),
                Ok(None) if stop.is_set() => break Error::interrupted(),
                Ok(None) if begun.elapsed() >= self.timeout => {
                    let limit = shown_number(self.timeout.as_secs_f64());
                    break failed(format!("took longer than {limit} s"));
                }
                Ok(None) => std::thread::sleep(LOOK_EVERY),
                Err(error) => break failed(format!("was lost: {error}")),
            }
        };
        // They may have ended meanwhile, which is as well.
        #[cfg(unix)]
        let _ = Command::new("kill")
            .args(["-KILL", "--", &format!("-{}", child.id())])
            .stderr(Stdio::null())
            .status();
        let _ = child.kill();
        let _ = child.wait();
        Err(outcome)
    }
}

/// What is wrong with a program.
fn failed(problem: String) -> Error {
    Error::input(
        "the program",
        problem,
        "run it by hand on the files of this instance",
    )
}

/// The last line that a program wrote to stderr, for a message; nothing if there is none.
fn last_words(file: &Path) -> String {
    let bytes = std::fs::read(file).unwrap_or_default();
    let text = String::from_utf8_lossy(&bytes);
    let line = text.lines().rev().find(|line| !line.trim().is_empty());
    line.map_or(String::new(), |line| {
        let line = line.trim().chars().take(LONGEST_WORDS);
        let line: String = line.flat_map(char::escape_debug).collect();
        format!("; it said: {line}")
    })
}

/// A folder of its own for a call, which is removed with all that is in it.
struct Scratch(PathBuf);

impl Scratch {
    fn new() -> Result<Self> {
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let parent = std::env::temp_dir();
        loop {
            let number = NEXT.fetch_add(1, Ordering::Relaxed);
            let folder = parent.join(format!(
                "pickline-benchmark-{}-{number}",
                std::process::id()
            ));
            match std::fs::create_dir(&folder) {
                Ok(()) => return Ok(Self(folder)),
                // Left behind by a process with this number.
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(Error::write(&folder, error)),
            }
        }
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // What cannot be removed is in the folder for what is temporary.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
