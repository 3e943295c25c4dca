//! The log of `run` and `emulate`: lines on stderr that never hold up the line.
//!
//! A pipe that nobody reads blocks its writer forever, and nobody has to read the program's
//! stderr. Therefore a separate thread writes. Its queue is bounded; lines that do not fit are
//! counted. Repeated remarks of one kind are summed up: the first is written at once, and
//! later ones are counted and written as one line at intervals.

mod kinds;
mod style;

use kinds::Kinds;
use pickline::error::grouped;
use std::collections::VecDeque;
use std::io::Write;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

pub(crate) use kinds::kind_of;
pub(crate) use style::{LogLevel, Style};

/// Maximum number of lines waiting to be written.
const MOST_WAITING: usize = 512;
/// How long to wait at the end for a stderr that nobody reads.
const FLUSH_TIMEOUT: Duration = Duration::from_millis(500);
/// Time from the first remark of a kind to the first summary of those that followed.
const FIRST_SUM: Duration = Duration::from_secs(5);
/// Maximum time that the thread sleeps.
const LONGEST_PAUSE: Duration = Duration::from_secs(3600);

/// The log. When dropped, it writes what is left, but waits only briefly for that.
#[derive(Debug)]
pub(crate) struct Log {
    shared: Arc<LogQueue>,
    style: Style,
}

#[derive(Debug)]
struct LogQueue {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug)]
struct State {
    kinds: Kinds,
    /// Lines to be written, with their newlines.
    waiting: VecDeque<String>,
    /// Number of lines dropped for lack of room since the last one that fitted.
    lost: u64,
    /// Whether no more lines will come.
    ending: bool,
    /// Whether the thread has written everything.
    done: bool,
}

impl Log {
    /// A log on stderr.
    pub(crate) fn on_stderr(style: Style) -> Self {
        Self::start(std::io::stderr(), style, FIRST_SUM)
    }

    fn start(stream: impl Write + Send + 'static, style: Style, first_sum: Duration) -> Self {
        let state = State {
            kinds: Kinds::new(first_sum),
            waiting: VecDeque::new(),
            lost: 0,
            ending: false,
            done: false,
        };
        let shared = Arc::new(LogQueue {
            state: Mutex::new(state),
            changed: Condvar::new(),
        });
        let writer = Arc::clone(&shared);
        thread::spawn(move || writer.write_all(stream, style));
        Self { shared, style }
    }

    /// Logs `text`; repeated remarks of one `kind` are summed up.
    pub(crate) fn say(&self, level: LogLevel, kind: &str, text: &str) {
        let now = Instant::now();
        let mut state = self.shared.lock();
        if let Some(text) = state.kinds.note(now, level, kind, text) {
            state.push(self.style.line(level, &text));
        }
        self.shared.changed.notify_all();
    }

    /// Logs all pending summaries, so that they come before the next remark.
    pub(crate) fn sum_up(&self) {
        self.shared.lock().sum_up(self.style);
        self.shared.changed.notify_all();
    }
}

impl Drop for Log {
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        state.sum_up(self.style);
        state.ending = true;
        self.shared.changed.notify_all();
        // A reader that does not read loses the rest; the program exits anyway.
        let changed = &self.shared.changed;
        let _ = changed.wait_timeout_while(state, FLUSH_TIMEOUT, |state| !state.done);
    }
}

impl LogQueue {
    /// Locks the state, even after a panic elsewhere, which leaves the lines intact.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes lines as they come and summaries when they are due, until the log is dropped.
    fn write_all(&self, mut stream: impl Write, style: Style) {
        while let Some(lines) = self.next_lines(style) {
            // If stderr is full or closed, nothing can be done: the line continues.
            let _ = stream.write_all(lines.as_bytes());
            let _ = stream.flush();
        }
        self.lock().done = true;
        self.changed.notify_all();
    }

    fn next_lines(&self, style: Style) -> Option<String> {
        let mut state = self.lock();
        loop {
            let now = Instant::now();
            for (level, text) in state.kinds.take_due(now) {
                state.push(style.line(level, &text));
            }
            if let Some(lines) = state.take(style) {
                return Some(lines);
            }
            if state.ending {
                return None;
            }
            let pause = state.kinds.next_due().map_or(LONGEST_PAUSE, |due| {
                due.saturating_duration_since(now).min(LONGEST_PAUSE)
            });
            let waited = self.changed.wait_timeout(state, pause);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }
}

impl State {
    /// Queues a line, if there is room.
    fn push(&mut self, line: String) {
        if self.waiting.len() < MOST_WAITING {
            self.waiting.push_back(line);
        } else {
            self.lost += 1;
        }
    }

    /// Queues the summary of every kind.
    fn sum_up(&mut self, style: Style) {
        for (level, text) in self.kinds.take_all() {
            self.push(style.line(level, &text));
        }
    }

    /// Takes the lines to be written now.
    fn take(&mut self, style: Style) -> Option<String> {
        let mut lines: String = self.waiting.drain(..).collect();
        if self.lost > 0 {
            let lost = grouped(std::mem::take(&mut self.lost));
            let text = format!("{lost} more remarks were dropped: stderr is not read fast enough");
            lines += &style.line(LogLevel::Warning, &text);
        }
        (!lines.is_empty()).then_some(lines)
    }
}

#[cfg(test)]
#[path = "../../../../tests/common/gate.rs"]
#[allow(unreachable_pub, reason = "shared with other crates")]
mod gate;

#[cfg(test)]
mod tests {
    use super::gate::Gate;
    use super::*;

    fn log(gate: &Gate) -> Log {
        Log::start(gate.clone(), Style::Text, FIRST_SUM)
    }

    #[test]
    fn repeated_remarks_are_summed_up_at_the_end() {
        let gate = Gate::default();
        gate.open();
        let log = log(&gate);
        for i in 1..=2000 {
            log.say(
                LogLevel::Warning,
                "camera value",
                &format!("line {i}: refused"),
            );
        }
        log.say(LogLevel::Info, "other", "other");
        log.say(LogLevel::Warning, "robot value", "line 9: refused");
        log.say(LogLevel::Warning, "robot value", "line 10: refused");
        drop(log);
        assert_eq!(
            gate.text(),
            "line 1: refused\nother\nline 9: refused\n\
             and 1,999 more, the last: line 2000: refused\nline 10: refused\n"
        );
    }

    #[test]
    fn sums_come_without_an_end() {
        let gate = Gate::default();
        gate.open();
        let log = Log::start(gate.clone(), Style::Text, Duration::from_millis(20));
        (0..5).for_each(|i| log.say(LogLevel::Info, "a", &i.to_string()));
        gate.wait_for("and 4 more, the last: 4\n");
    }

    #[test]
    fn a_peer_that_does_not_read_delays_nobody_and_learns_what_it_missed() {
        let gate = Gate::default();
        let log = log(&gate);
        let began = Instant::now();
        for i in 0..100_000 {
            log.say(LogLevel::Info, &format!("kind {i}"), &"x".repeat(200));
        }
        log.sum_up();
        assert!(log.shared.lock().waiting.len() <= MOST_WAITING);
        drop(log);
        assert!(began.elapsed() < Duration::from_secs(30));
        gate.open();
        // All but the first of each kind and the first one beyond the limit.
        gate.wait_for("and 99,743 more, the last: x");
    }
}
