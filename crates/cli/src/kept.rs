//! What a run of the live node keeps on disk: its journal and its recording.

use super::args::RunArgs;
#[cfg(feature = "mcap")]
use super::live::NodeClock;
use super::live::unix_now;
#[cfg(feature = "mcap")]
use super::log::{Level, Log};
use super::session::Session;
use pickline::decision::Strategy;
use pickline::error::Result;
use pickline::files;
use pickline::station::Station;
use pickline::strategies::policy_file;
use pickline_live::journal::{Journal, OpenedJournal, Owner, lock_of};
use pickline_live::protocol::{Incoming, Outgoing};
use pickline_live::recording::RecordedEvent;
#[cfg(feature = "mcap")]
use pickline_live::recording::{Heading, Recorder};
use pickline_live::{ClockKind, Config, Controller};
use pickline_report::station_hash;
use std::path::{Path, PathBuf};
#[cfg(feature = "mcap")]
use std::sync::Arc;

/// The program's name and version, as recorded.
const PROGRAM: &str = concat!("pickline ", env!("CARGO_PKG_VERSION"));

/// Maximum number of silent steps (steps without output) combined into one record.
const TOGETHER: u32 = 64;

/// The journal and recording of a run.
#[derive(Default)]
pub struct Kept {
    /// Files that this run created.
    created: Vec<PathBuf>,
    journal: Option<Journal>,
    /// Silent steps since the last record.
    unsaid: u32,
    #[cfg(feature = "mcap")]
    recording: Recording,
}

/// A recording, which must not stop the line: if writing fails, the recording ends. The error
/// is logged at once and returned at the end.
#[cfg(feature = "mcap")]
#[derive(Default)]
struct Recording {
    /// The clock for log times, which never go back.
    clock: NodeClock,
    recorder: Option<Recorder>,
    failure: Option<pickline::error::Error>,
    /// Where a failure is logged.
    log: Option<Arc<Log>>,
}

/// Checks, before the work begins, that the journal and the recording can be written and are
/// not input files. Existing content is checked when they are opened: a journal must belong
/// to this line, and a recording must not replace a file.
///
/// # Errors
/// A file that cannot be written, or that is used twice.
pub fn check(args: &RunArgs) -> Result<()> {
    let read = [
        args.station.file(),
        ("--strategy", args.strategy.as_deref().and_then(policy_file)),
    ];
    #[cfg(feature = "mcap")]
    let record = args.kept.record.as_deref();
    #[cfg(not(feature = "mcap"))]
    let record = None;
    let written = [
        ("--journal", args.kept.journal.as_deref()),
        ("--record", record),
    ];
    for file in written.iter().filter_map(|(_, file)| *file) {
        files::check_target(file)?;
        files::try_target(file)?;
    }
    files::check_apart(&read, &written)
}

impl Kept {
    /// Opens the journal and the recording, and creates the controller, which resumes where
    /// the journal ends if there is one. `strategy` is its text and the strategy itself.
    ///
    /// # Errors
    /// As for [`OpenedJournal::open`], [`Controller::restore`] and [`Recorder::create`].
    pub fn open(
        args: &RunArgs,
        session: &Session,
        station: Station,
        strategy: (&str, Box<dyn Strategy>),
        config: Config,
    ) -> Result<(Controller, Self)> {
        #[cfg(feature = "mcap")]
        let mut heading = Heading {
            program: PROGRAM.into(),
            command: session.command(),
            station: pickline::station::to_toml(&station),
            station_hash: station_hash(&station),
            strategy: strategy.0.to_owned(),
            budget_ms: args.budget_ms,
            seed: args.seed,
            ..Heading::of(&config)
        };
        #[cfg(not(feature = "mcap"))]
        let _ = session;
        let owner = Owner {
            station: station_hash(&station),
            clock: config.clock,
            program: PROGRAM.into(),
        };
        let path = args.kept.journal.as_deref();
        let lock = path.map(lock_of);
        let created = path.into_iter().chain(lock.as_deref());
        let created = created
            .filter(|file| file.symlink_metadata().is_err())
            .map(Path::to_owned);
        let mut created: Vec<PathBuf> = created.collect();
        let mut found = path
            .map(|path| OpenedJournal::open(path, &owner))
            .transpose()?;
        let reading = found.as_mut().and_then(|found| found.reading.take());
        let is_restored = reading.is_some();
        let stamp = (is_restored && config.clock == ClockKind::System).then(unix_now);
        let mut controller = match (reading, path) {
            (Some(reading), Some(path)) => {
                let name = path.display().to_string();
                let made = Controller::restore(station, strategy.1, config, reading.state, stamp);
                let controller = made.map_err(|error| error.inside(&name))?;
                args.transport
                    .remark(&resuming(path, reading.torn, &controller));
                controller
            }
            _ => {
                if let Some(path) = path.filter(|_| found.as_ref().is_some_and(|f| f.is_empty)) {
                    args.transport.remark(&starting_over(path));
                }
                Controller::new(station, strategy.1, config)
            }
        };
        let mut kept = Self::default();
        #[cfg(feature = "mcap")]
        if let Some(path) = &args.kept.record {
            heading.restored_at = stamp;
            let state = is_restored.then(|| controller.whole());
            let recorder = Recorder::create(path, &heading, state.as_ref())?;
            kept.recording.recorder = Some(recorder);
            kept.recording.log = Some(Arc::clone(args.transport.log()));
            // A recording never replaces a file.
            kept.created.push(path.clone());
        }
        if let Some(found) = found {
            match found.begin(&controller.whole(), args.kept.fsync) {
                Ok(journal) => kept.journal = Some(journal),
                Err(error) => {
                    kept.discard();
                    return Err(error);
                }
            }
        }
        kept.created.append(&mut created);
        Ok((controller, kept))
    }

    /// Removes the files that this run created, if the run could not begin: they would be in
    /// the way of the next one.
    pub fn discard(self) {
        for file in &self.created {
            // They are still locked. A file that cannot be removed does no harm.
            let _ = std::fs::remove_file(file);
        }
    }

    /// Writes changes to the journal. Must be called after every step, before the output that
    /// the controller has `said` is sent; silent steps may wait for a few more steps.
    ///
    /// # Errors
    /// A journal that cannot be written.
    pub fn keep(&mut self, controller: &mut Controller, said: bool) -> Result<()> {
        self.unsaid += 1;
        if !said && self.unsaid < TOGETHER {
            return Ok(());
        }
        self.write(controller, said)
    }

    /// Writes all pending changes while nothing else happens.
    ///
    /// # Errors
    /// A journal that cannot be written.
    pub fn rest(&mut self, controller: &mut Controller) -> Result<()> {
        self.flush();
        self.write(controller, false)
    }

    fn write(&mut self, controller: &mut Controller, said: bool) -> Result<()> {
        self.unsaid = 0;
        let Some(journal) = &mut self.journal else {
            return Ok(());
        };
        let Some(change) = controller.change(said) else {
            return Ok(());
        };
        if journal.append(&change)? {
            journal.compact(&controller.whole())?;
        }
        Ok(())
    }
}

#[cfg(feature = "mcap")]
impl Kept {
    /// Records a message received at `received` [s since 1970].
    pub fn heard(&mut self, message: &Incoming, received: f64) {
        self.recording
            .go_on(|recorder, _| recorder.record_incoming(message, received));
    }

    /// Records a message that is sent.
    pub fn said(&mut self, message: &Outgoing) {
        self.recording
            .go_on(|recorder, now| recorder.record_outgoing(message, now));
    }

    /// Records an event that is not a message.
    pub fn happened(&mut self, event: &RecordedEvent) {
        self.recording
            .go_on(|recorder, now| recorder.record_event(event, now));
    }

    /// Flushes the recording to its file.
    fn flush(&mut self) {
        self.recording.go_on(|recorder, now| recorder.flush(now));
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// A recording that could not be written completely.
    pub fn finish(mut self) -> Result<()> {
        if let Some(recorder) = self.recording.recorder.take() {
            recorder.finish()?;
        }
        self.recording.failure.map_or(Ok(()), Err)
    }
}

#[cfg(feature = "mcap")]
impl Recording {
    fn go_on(&mut self, write: impl FnOnce(&mut Recorder, f64) -> Result<()>) {
        if let Some(recorder) = &mut self.recorder
            && let Err(error) = write(recorder, self.clock.read().stamp)
        {
            let text = format!("the recording has stopped: {error}");
            if let Some(log) = &self.log {
                log.say(Level::Error, &text, &text);
            }
            self.failure = Some(error);
            self.recorder = None;
        }
    }
}

/// Stubs for a build without recordings.
#[cfg(not(feature = "mcap"))]
impl Kept {
    pub fn heard(&mut self, _: &Incoming, _: f64) {}

    pub fn said(&mut self, _: &Outgoing) {}

    pub fn happened(&mut self, _: &RecordedEvent) {}

    fn flush(&mut self) {}

    pub fn finish(self) -> Result<()> {
        Ok(())
    }
}

/// An empty file may be new, or a journal that lost its content.
fn starting_over(path: &Path) -> String {
    let name = path.display();
    format!(
        "{name} is empty, so a new journal is started; if it held a journal, stop this run and \
         restore a copy, or first clear the belt and make sure that all robots are idle"
    )
}

fn resuming(path: &Path, torn: usize, controller: &Controller) -> String {
    let (items, tasks) = controller.load();
    let name = path.display();
    let mut text = format!("resuming from {name}: {items} items, {tasks} open tasks");
    if torn > 0 {
        text += &format!("; its last record ({torn} bytes) is incomplete and was discarded");
    }
    if controller.awaits_belt() {
        text += "; no task is given until the belt reports";
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::args::{Cli, Command};
    use clap::Parser as _;

    #[test]
    fn a_journal_is_synced_where_that_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("line.journal");
        let journal = path.to_str().unwrap();
        let flags = ["pickline", "run", "-q", "--journal", journal, "--fsync"];
        for (count, expected) in [(flags.len() - 1, false), (flags.len(), true)] {
            let Command::Run(args) = Cli::try_parse_from(&flags[..count]).unwrap().command else {
                unreachable!();
            };
            let station = args.station.resolve().unwrap();
            let text = pickline::strategies::default_strategy(station.robots().len());
            let strategy = pickline::strategies::read_alone(&text, station.robots().len());
            let strategy = (text.as_str(), strategy.unwrap().make());
            let session = Session::new(Vec::new());
            let config = Config::default();
            let (_, kept) = Kept::open(&args, &session, station, strategy, config).unwrap();
            assert_eq!(kept.journal.unwrap().is_synced(), expected);
        }
    }
}
