//! What a node keeps on disk: its journal and its recording.

#[cfg(feature = "mcap")]
use super::clock::NodeClock;
use super::clock::unix_now;
use super::monitor::{NodeMonitor, Severity};
use super::options::NodeOptions;
use crate::journal::{Journal, OpenedJournal, Owner, lock_of};
use crate::protocol::{Incoming, Outgoing};
use crate::recording::RecordedEvent;
#[cfg(feature = "mcap")]
use crate::recording::{Heading, Recorder};
use crate::{ClockKind, Controller};
use pickline::decision::Strategy;
use pickline::error::Result;
use pickline::station::{Station, station_hash};
use std::path::{Path, PathBuf};

/// Maximum number of silent steps (steps without output) combined into one record.
const TOGETHER: u32 = 64;

/// The journal and recording of a run.
#[derive(Default)]
pub(super) struct KeptFiles {
    /// Files that this run created.
    created: Vec<PathBuf>,
    journal: Option<Journal>,
    /// Silent steps since the last record.
    unsaid: u32,
    #[cfg(feature = "mcap")]
    recording: RunRecording,
}

/// A recording, which must not stop the line: if writing fails, the recording ends. The error
/// is reported at once and returned at the end.
#[cfg(feature = "mcap")]
#[derive(Default)]
struct RunRecording {
    /// The clock for log times, which never go back.
    clock: NodeClock,
    recorder: Option<Recorder>,
    failure: Option<pickline::error::Error>,
    /// The failure as a remark that was not made yet.
    remark: Option<String>,
}

impl KeptFiles {
    /// Opens the journal and the recording, and creates the controller, which resumes where
    /// the journal ends if there is one.
    ///
    /// # Errors
    /// As for [`OpenedJournal::open`], [`Controller::restore`] and [`Recorder::create`].
    pub(super) fn open(
        options: &NodeOptions,
        station: Station,
        strategy: Box<dyn Strategy>,
        monitor: &mut dyn NodeMonitor,
    ) -> Result<(Controller, Self)> {
        let config = options.config.clone();
        #[cfg(feature = "mcap")]
        let mut heading = heading(options, &station);
        let owner = Owner {
            station: station_hash(&station),
            clock: config.clock,
            program: options.origin.program.clone(),
        };
        let path = options.journal.as_deref();
        let created = created_by(path);
        let mut found = path
            .map(|path| OpenedJournal::open(path, &owner))
            .transpose()?;
        let reading = found.as_mut().and_then(|found| found.reading.take());
        let is_restored = reading.is_some();
        let stamp = (is_restored && config.clock == ClockKind::System).then(unix_now);
        let mut controller = match (reading, path) {
            (Some(reading), Some(path)) => {
                let name = path.display().to_string();
                let made = Controller::restore(station, strategy, config, reading.state, stamp);
                let controller = made.map_err(|error| error.inside(&name))?;
                let text = resuming(path, reading.torn, &controller);
                monitor.remark(Severity::Info, None, &text);
                controller
            }
            _ => {
                if let Some(path) = path.filter(|_| found.as_ref().is_some_and(|f| f.is_empty)) {
                    monitor.remark(Severity::Info, None, &starting_over(path));
                }
                Controller::new(station, strategy, config)?
            }
        };
        let mut kept = Self::default();
        #[cfg(feature = "mcap")]
        if let Some(path) = &options.record {
            heading.restored_at = stamp;
            let state = is_restored.then(|| controller.whole());
            let recorder = Recorder::create(path, &heading, state.as_ref())?;
            kept.recording.recorder = Some(recorder);
            // A recording never replaces a file.
            kept.created.push(path.clone());
        }
        if let Some(found) = found {
            match found.begin(&controller.whole(), options.sync) {
                Ok(journal) => kept.journal = Some(journal),
                Err(error) => {
                    kept.discard();
                    return Err(error);
                }
            }
        }
        kept.created.extend(created);
        Ok((controller, kept))
    }

    /// Removes the files that this run created, if the run could not begin: they would be in
    /// the way of the next one.
    pub(super) fn discard(self) {
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
    pub(super) fn keep(&mut self, controller: &mut Controller, said: bool) -> Result<()> {
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
    pub(super) fn rest(&mut self, controller: &mut Controller) -> Result<()> {
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
impl KeptFiles {
    /// Records a message received at `received` [s since 1970].
    pub(super) fn heard(&mut self, message: &Incoming, received: f64) {
        self.recording
            .go_on(|recorder, _| recorder.record_incoming(message, received));
    }

    /// Records a message that is sent.
    pub(super) fn said(&mut self, message: &Outgoing) {
        self.recording
            .go_on(|recorder, now| recorder.record_outgoing(message, now));
    }

    /// Records an event that is not a message.
    pub(super) fn happened(&mut self, event: &RecordedEvent) {
        self.recording
            .go_on(|recorder, now| recorder.record_event(event, now));
    }

    /// Flushes the recording to its file.
    fn flush(&mut self) {
        self.recording.go_on(|recorder, now| recorder.flush(now));
    }

    /// What went wrong with the recording since the last call, if anything.
    pub(super) fn take_remark(&mut self) -> Option<String> {
        self.recording.remark.take()
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// A recording that could not be written completely.
    pub(super) fn finish(mut self) -> Result<()> {
        if let Some(recorder) = self.recording.recorder.take() {
            recorder.finish()?;
        }
        self.recording.failure.map_or(Ok(()), Err)
    }
}

#[cfg(feature = "mcap")]
impl RunRecording {
    fn go_on(&mut self, write: impl FnOnce(&mut Recorder, f64) -> Result<()>) {
        if let Some(recorder) = &mut self.recorder
            && let Err(error) = write(recorder, self.clock.read().stamp)
        {
            self.remark = Some(format!("the recording has stopped: {error}"));
            self.failure = Some(error);
            self.recorder = None;
        }
    }
}

/// Stubs for a build without recordings.
#[cfg(not(feature = "mcap"))]
impl KeptFiles {
    pub(super) fn heard(&mut self, _: &Incoming, _: f64) {}

    pub(super) fn said(&mut self, _: &Outgoing) {}

    pub(super) fn happened(&mut self, _: &RecordedEvent) {}

    fn flush(&mut self) {}

    pub(super) fn take_remark(&mut self) -> Option<String> {
        None
    }

    pub(super) fn finish(self) -> Result<()> {
        Ok(())
    }
}

/// The journal and its lock, as far as they do not exist yet.
fn created_by(journal: Option<&Path>) -> Vec<PathBuf> {
    let lock = journal.map(lock_of);
    let files = journal.into_iter().chain(lock.as_deref());
    let missing = files.filter(|file| file.symlink_metadata().is_err());
    missing.map(Path::to_owned).collect()
}

/// The settings of the run, as recorded.
#[cfg(feature = "mcap")]
fn heading(options: &NodeOptions, station: &Station) -> Heading {
    let origin = &options.origin;
    Heading {
        program: origin.program.clone(),
        command: origin.command.clone(),
        station: pickline::station::to_toml(station),
        station_hash: station_hash(station),
        strategy: origin.strategy.clone(),
        budget_ms: origin.budget_ms,
        seed: origin.seed,
        ..Heading::of(&options.config)
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
    use super::super::Unwatched;
    use super::*;
    use pickline::strategies::{default_strategy, read_alone};

    #[test]
    fn a_journal_is_synced_where_the_options_say_so() {
        let folder = tempfile::tempdir().unwrap();
        let station = pickline::station::built_in("paper").unwrap();
        let station = station.station(None).unwrap();
        let robots = station.robots().len();
        for sync in [false, true] {
            let strategy = read_alone(&default_strategy(robots), robots)
                .unwrap()
                .make();
            let journal = folder.path().join(format!("{sync}.journal"));
            let options = NodeOptions::default().with_journal(journal, sync);
            let opened = KeptFiles::open(&options, station.clone(), strategy, &mut Unwatched);
            assert_eq!(opened.unwrap().1.journal.unwrap().is_synced(), sync);
        }
    }
}
