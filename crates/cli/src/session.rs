//! What every verb needs: the command line, the stop flag, stdout.

use super::log::{Log, LogLevel};
use pickline::error::{Error, Result};
use pickline::files;
use pickline::shards::Ledger;
use std::io::{ErrorKind, Write as _};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// One call of the program.
pub(crate) struct Session {
    arguments: Vec<String>,
    /// Whether another program runs this one, so that the executable is not pickline's.
    hosted: bool,
    /// Whether signals of the process are for others.
    unattended: bool,
    stop: Arc<AtomicBool>,
    /// Where errors are written while a line runs.
    log: OnceLock<Arc<Log>>,
    /// The units of a call that is made in shards.
    ledger: OnceLock<Ledger>,
    /// Which shards are missing, if some are.
    missing_shards: Option<String>,
}

/// Flags that make a call a shard, and that they take a value.
const SHARD: [(&str, bool); 2] = [("--shard", true), ("--shard-dir", true)];

/// Flags that cannot change a result, and whether they take a value. They are omitted from
/// the recorded command line.
const WITHOUT_EFFECT: [(&str, bool); 19] = [
    SHARD[0],
    SHARD[1],
    ("--threads", true),
    ("--format", true),
    ("--out", true),
    ("--trace", true),
    ("--html", true),
    ("--svg", true),
    ("--chart", true),
    ("--nfg", true),
    ("--top", true),
    ("--output", true),
    ("-o", true),
    ("--report", true),
    ("--log-format", true),
    ("--force", false),
    ("--strict", false),
    ("--quiet", false),
    ("-q", false),
];

impl Session {
    /// The session of a call with these arguments, without the program's name.
    pub(crate) fn new(arguments: Vec<String>) -> Self {
        Self {
            arguments,
            hosted: false,
            unattended: false,
            stop: Arc::default(),
            log: OnceLock::new(),
            ledger: OnceLock::new(),
            missing_shards: None,
        }
    }

    /// The session of another call with these arguments, which Ctrl-C stops as this one.
    /// `missing_shards` says which of its shards are missing.
    pub(crate) fn of_call(&self, arguments: Vec<String>, missing_shards: Option<String>) -> Self {
        Self {
            hosted: self.hosted,
            missing_shards,
            stop: Arc::clone(&self.stop),
            ..Self::new(arguments)
        }
    }

    /// Makes studies take the units of their work from `ledger`.
    ///
    /// # Errors
    /// None, as a call has one ledger.
    pub(crate) fn set_ledger(&self, ledger: Ledger) -> Result<()> {
        let set = self.ledger.set(ledger);
        set.map_err(|_| Error::internal("a call has two ledgers"))
    }

    /// Which shards are missing, if some are.
    pub(crate) fn missing_shards(&self) -> Option<&str> {
        self.missing_shards.as_deref()
    }

    /// The units of the call's work.
    pub(crate) fn ledger(&self) -> &Ledger {
        self.ledger.get().unwrap_or(Ledger::PLAIN)
    }

    /// The session of a call from another program.
    pub(crate) fn hosted(self) -> Self {
        Self {
            hosted: true,
            ..self
        }
    }

    /// The session of a call that leaves the signals of its process alone.
    pub(crate) fn unattended(self) -> Self {
        Self {
            hosted: true,
            unattended: true,
            ..self
        }
    }

    /// Whether another program made the call.
    pub(crate) fn is_hosted(&self) -> bool {
        self.hosted
    }

    /// Makes Ctrl-C ask the work to stop with the best result so far; pressing it again
    /// exits the program.
    pub(crate) fn catch_interrupts(&self) {
        if self.unattended {
            return;
        }
        let stop = Arc::clone(&self.stop);
        let handler = move || {
            if !stop.swap(true, Ordering::Relaxed) {
                tell("stopping with the results so far, if any; press Ctrl-C again to quit now");
            } else {
                std::process::exit(i32::from(super::INTERRUPTED));
            }
        };
        // If no handler can be set, Ctrl-C ends the program, as usual.
        let _ = ctrlc::set_handler(handler);
    }

    /// The flag that asks the work to stop.
    pub(crate) fn stop(&self) -> &AtomicBool {
        &self.stop
    }

    /// Whether Ctrl-C was pressed.
    pub(crate) fn interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Sends errors to this log, so that they do not block either.
    pub(crate) fn log_into(&self, log: &Arc<Log>) {
        let _ = self.log.set(Arc::clone(log));
    }

    /// Reports an error.
    pub(crate) fn complain(&self, text: &str) {
        match self.log.get() {
            Some(log) => log.say(LogLevel::Error, text, text),
            None => tell(text),
        }
    }

    /// The command line, as recorded in results.
    pub(crate) fn command(&self) -> String {
        let words = self.arguments_without(&WITHOUT_EFFECT);
        let words = words.into_iter().map(quoted);
        let words: Vec<String> = std::iter::once("pickline".to_owned())
            .chain(words)
            .collect();
        words.join(" ")
    }

    /// The arguments of the call that this one is a shard of.
    pub(crate) fn arguments_without_shard(&self) -> Vec<String> {
        let words = self.arguments_without(&SHARD);
        words.into_iter().map(str::to_owned).collect()
    }

    /// The arguments without `flags`, of which each says whether it takes a value.
    fn arguments_without(&self, flags: &[(&str, bool)]) -> Vec<&str> {
        let mut words = Vec::new();
        let mut arguments = self.arguments.iter();
        while let Some(argument) = arguments.next() {
            let (name, joined) = match argument.split_once('=') {
                Some((name, _)) => (name, true),
                None => (argument.as_str(), false),
            };
            match flags.iter().find(|(flag, _)| *flag == name) {
                Some((_, takes_value)) => {
                    if *takes_value && !joined {
                        arguments.next();
                    }
                }
                None => words.push(argument.as_str()),
            }
        }
        words
    }

    /// Writes `content` to stdout. A closed pipe is not an error.
    ///
    /// # Errors
    /// Any other failure to write to stdout.
    pub(crate) fn print(&self, content: &[u8]) -> Result<()> {
        let mut stdout = std::io::stdout().lock();
        let written = stdout.write_all(content).and_then(|()| stdout.flush());
        written.or_else(unless_closed)
    }

    /// Writes `content` to `file`, or to stdout if `file` is `None` or `-`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn print_or_write(&self, file: Option<&Path>, content: &[u8]) -> Result<()> {
        match file.filter(|file| *file != Path::new("-")) {
            Some(file) => files::write_whole(file, content),
            None => self.print(content),
        }
    }
}

/// The failure to write to stdout; a closed pipe is not an error.
///
/// # Errors
/// Any other failure.
pub(crate) fn unless_closed(error: std::io::Error) -> Result<()> {
    match error.kind() {
        ErrorKind::BrokenPipe => Ok(()),
        _ => Err(Error::write(Path::new("stdout"), error)),
    }
}

/// Writes a line to stderr. Unlike `eprintln!`, it does not panic if stderr is full or
/// closed: nothing can be done about that, and the result is still valid.
pub(crate) fn tell(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// An argument, quoted for a shell. By hand: the crate shell-words also quotes `=` and `%`, which
/// would change the recorded command of existing results.
fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,=+@%".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        argument.to_owned()
    } else {
        format!("'{}'", argument.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_recorded_command_leaves_out_what_has_no_effect() {
        let words = "optimize --robots 3 --threads 2 -q --format=json --out d --force --strategy [SPT;FIFO]";
        let session = Session::new(words.split(' ').map(str::to_owned).collect());
        assert_eq!(
            session.command(),
            "pickline optimize --robots 3 --strategy '[SPT;FIFO]'"
        );
    }
}
