//! The claims journal: the node's state in a file that survives a crash.
//!
//! A text file with one record per line, each with a checksum. The first names the station and the
//! protocol, the second holds the whole state, and each further one holds what one step has changed
//! ([`StateChange`]). It stores changes, not the messages that caused them, so that a decision stands
//! and is not made again with another time budget, machine or version. A step is in the journal
//! before any of its messages leaves the process. Once the file has grown enough, it is replaced
//! with one that begins with the current state, so its size is bounded.

mod lock;
mod record;

use super::ClockKind;
use super::protocol::VERSION;
use super::state::{LineState, StateChange};
use lock::Lock;
pub(crate) use lock::lock_of;
use pickline::error::{Error, Result};
use pickline::files;
use record::Header;
pub use record::JournalContents;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The file is replaced once it exceeds its size at the start times this factor
const FACTOR: u64 = 3;
/// plus this [bytes].
const SLACK: u64 = 1 << 20;

/// The run that a journal belongs to.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Owner {
    /// Hash of the station.
    pub station: String,
    /// The kind of clock.
    pub clock: ClockKind,
    /// The program and its version.
    pub program: String,
}

impl Owner {
    /// A run of `program` for the station with this hash, by this clock.
    pub fn new(station: &str, clock: ClockKind, program: &str) -> Self {
        Self {
            station: station.to_owned(),
            clock,
            program: program.to_owned(),
        }
    }

    fn header(&self) -> Header {
        Header {
            journal: record::FORMAT,
            protocol: VERSION,
            station: self.station.clone(),
            clock: self.clock.name().to_owned(),
            program: self.program.clone(),
        }
    }
}

/// A journal that is locked and read, but not yet written to.
#[derive(Debug)]
#[non_exhaustive]
pub struct OpenedJournal {
    path: PathBuf,
    lock: Lock,
    header: Header,
    /// The content; none for a new or empty file.
    pub reading: Option<JournalContents>,
    /// Whether the file exists but is empty.
    pub is_empty: bool,
}

/// A journal that is open for writing.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    /// Held until this is dropped; the system releases it when the process ends.
    _lock: Lock,
    header: Header,
    file: File,
    records: u64,
    size: u64,
    most: u64,
    sync: bool,
}

impl OpenedJournal {
    /// Locks and reads the journal at `path`, which need not exist yet. The file is not changed,
    /// and no lock file is left if it is refused.
    ///
    /// # Errors
    /// The journal is in use by another process, belongs to another station or protocol, or is
    /// damaged; or the file is not a journal, or cannot be read or locked.
    pub fn open(path: &Path, owner: &Owner) -> Result<Self> {
        // Follow links, so that the file they point to is replaced, not the link.
        let path = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        files::check_target(&path)?;
        if path.exists() && !path.is_file() {
            return Err(Error::path(
                path.display().to_string(),
                "is not a regular file",
                "give the journal a separate file",
            ));
        }
        let lock = Lock::take(&path)?;
        files::remove_leftovers(&path);
        let header = owner.header();
        let bytes = match std::fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(Error::read(&path, error)),
        };
        let is_empty = bytes.is_empty() && path.exists();
        let reading = if bytes.is_empty() {
            None
        } else {
            let name = path.display().to_string();
            Some(record::read(&bytes, &header).map_err(|error| error.inside(&name))?)
        };
        Ok(Self {
            path,
            lock,
            header,
            reading,
            is_empty,
        })
    }

    /// Starts the journal with the whole state. With `sync` a record counts as written only once it
    /// is on the disk.
    ///
    /// # Errors
    /// The file cannot be written; its old content then stays.
    pub fn begin(self, whole: &StateChange, sync: bool) -> Result<Journal> {
        let written = write_from_start(&self.path, &self.header, whole);
        let (file, size) = written.map_err(|error| Error::write(&self.path, error))?;
        Ok(Journal {
            path: self.path,
            _lock: self.lock.keep(),
            header: self.header,
            file,
            records: 1,
            size,
            most: SLACK + FACTOR * size,
            sync,
        })
    }
}

impl Journal {
    /// Appends a change. Returns whether the journal is so large that it should be compacted.
    ///
    /// # Errors
    /// The file cannot be written. The messages of the change must not be sent then.
    pub fn append(&mut self, change: &StateChange) -> Result<bool> {
        self.records += 1;
        let line = record::line(&record::numbered(self.records, change));
        let written = self.file.write_all(line.as_bytes());
        let synced = written.and_then(|()| {
            if self.sync {
                self.file.sync_data()
            } else {
                Ok(())
            }
        });
        synced.map_err(|error| Error::write(&self.path, error))?;
        self.size += line.len() as u64;
        Ok(self.size > self.most)
    }

    /// Replaces all records with the current state. If the process has no free file descriptor, the
    /// records stay, and this is retried once they have grown.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn compact(&mut self, whole: &StateChange) -> Result<()> {
        match write_from_start(&self.path, &self.header, whole) {
            Ok((file, size)) => {
                (self.file, self.size, self.records) = (file, size, 1);
                self.most = SLACK + FACTOR * size;
                Ok(())
            }
            Err(error) if is_out_of_descriptors(&error) => {
                self.most = self.size + SLACK;
                Ok(())
            }
            Err(error) => Err(Error::write(&self.path, error)),
        }
    }
}

#[cfg(test)]
impl Journal {
    /// Whether every record is synced to the disk before it counts as written.
    pub(crate) fn is_synced(&self) -> bool {
        self.sync
    }
}

/// Whether this process or the system is out of file descriptors (EMFILE, ENFILE).
fn is_out_of_descriptors(error: &std::io::Error) -> bool {
    cfg!(unix) && matches!(error.raw_os_error(), Some(23 | 24))
}

/// Writes a journal with one state, atomically. Returns the file, open at its end, and its size
/// [bytes].
fn write_from_start(
    path: &Path,
    header: &Header,
    whole: &StateChange,
) -> std::io::Result<(File, u64)> {
    let text = record::line(header) + &record::line(&record::numbered(1, whole));
    let file = files::replace_and_go_on(path, text.as_bytes())?;
    // The name must be on the disk too before further records count.
    files::sync_folder(path);
    Ok((file, text.len() as u64))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// A pipe can be written but not synced, which shows whether a sync is tried.
    #[test]
    fn records_are_synced_where_that_is_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let owner = Owner {
            station: "s".into(),
            clock: ClockKind::Messages,
            program: "p".into(),
        };
        for sync in [false, true] {
            let path = folder.path().join(format!("{sync}.journal"));
            let found = OpenedJournal::open(&path, &owner).unwrap();
            let mut journal = found.begin(&StateChange::default(), sync).unwrap();
            assert_eq!(journal.is_synced(), sync);
            journal.append(&StateChange::default()).unwrap();
            let (_reader, writer) = std::io::pipe().unwrap();
            journal.file = File::from(std::os::fd::OwnedFd::from(writer));
            let added = journal.append(&StateChange::default());
            let told = added.err().map(|error| error.to_string());
            assert_eq!(told.is_some(), sync, "{told:?}");
            // After compaction the journal syncs as before.
            journal.compact(&StateChange::default()).unwrap();
            assert_eq!(journal.is_synced(), sync);
        }
    }
}
