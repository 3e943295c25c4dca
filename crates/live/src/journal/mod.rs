//! The claims journal: what the node knew, in a file that outlives it.
//!
//! A text file of records, one a line, each with a checksum. The first names the station
//! and the protocol, the second holds the whole state, every further one what has changed
//! ([`Change`]) in one step. Changes rather than the messages that caused them: what was
//! decided holds, and is not decided a second time by a strategy with another budget, on
//! another machine or of another version. A step is in the journal before anything that
//! it says leaves the process. Once the changes outweigh the state, the file is replaced
//! by one that begins with the state as it is, so that its size is bounded.

mod lock;
mod record;

use super::ClockKind;
use super::protocol::VERSION;
use super::state::{Change, State};
use pickline::error::{Error, Result};
use pickline::files;
use lock::Lock;
pub use lock::lock_of;
use record::Header;
pub use record::Reading;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Changes may outweigh the state that they began with by this factor,
const FACTOR: u64 = 3;
/// and by this much [bytes], before the file is started over.
const SLACK: u64 = 1 << 20;

/// Whose journal it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Owner {
    /// Hash of the station.
    pub station: String,
    /// Where the time comes from.
    pub clock: ClockKind,
    /// The program and its version.
    pub program: String,
}

impl Owner {
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

/// A journal that is read and locked, and not yet written to.
#[derive(Debug)]
pub struct Found {
    path: PathBuf,
    lock: Lock,
    header: Header,
    /// What it holds; none of a file that is new or empty.
    pub reading: Option<Reading>,
    /// Whether there is a file, with nothing in it.
    pub is_empty: bool,
}

/// A journal that is written to.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    /// Held while this lives; the system lets go of it with the process.
    _lock: Lock,
    header: Header,
    file: File,
    records: u64,
    size: u64,
    most: u64,
    sync: bool,
}

impl Found {
    /// Locks and reads the journal at `path`, which need not exist yet. Nothing of it is
    /// changed, and of one that is refused no lock file is left.
    ///
    /// # Errors
    /// A journal that another process uses, one of another station or protocol, one that
    /// is damaged; a file that is none, or cannot be read or locked.
    pub fn open(path: &Path, owner: &Owner) -> Result<Self> {
        // Links are followed, so that the file that they name is the one replaced.
        let path = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        files::check_target(&path)?;
        if path.exists() && !path.is_file() {
            return Err(Error::input(
                path.display().to_string(),
                "is no regular file",
                "give the journal a file of its own",
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

    /// Begins the journal with a whole state. With `sync` every record is on the disk, not
    /// only with the system, before it counts as written.
    ///
    /// # Errors
    /// A file that cannot be written; what it held before stays then.
    pub fn begin(self, whole: &Change, sync: bool) -> Result<Journal> {
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
    /// Adds what has changed; whether the journal is so long by now that it should be
    /// started over.
    ///
    /// # Errors
    /// A file that cannot be written. What the change has to say must not be said then.
    pub fn append(&mut self, change: &Change) -> Result<bool> {
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

    /// Replaces all records by the state as it is. Where the process may open no further
    /// file the records stay, and it is tried again once they have grown.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn compact(&mut self, whole: &Change) -> Result<()> {
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
    /// Whether every record is on the disk before it counts as written.
    pub fn is_synced(&self) -> bool {
        self.sync
    }
}

/// Whether this process, or all together, may open no further file (EMFILE, ENFILE).
fn is_out_of_descriptors(error: &std::io::Error) -> bool {
    cfg!(unix) && matches!(error.raw_os_error(), Some(23 | 24))
}

/// Writes a journal of one state, whole or not at all; returns it open at its end, and its
/// size [bytes].
fn write_from_start(path: &Path, header: &Header, whole: &Change) -> std::io::Result<(File, u64)> {
    let text = record::line(header) + &record::line(&record::numbered(1, whole));
    let file = files::replace_and_go_on(path, text.as_bytes())?;
    // The name too has to be on the disk before what follows counts.
    files::sync_folder(path);
    Ok((file, text.len() as u64))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// A pipe takes what is written and cannot be synced, which shows who tries.
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
            let found = Found::open(&path, &owner).unwrap();
            let mut journal = found.begin(&Change::default(), sync).unwrap();
            assert_eq!(journal.is_synced(), sync);
            journal.append(&Change::default()).unwrap();
            let (_reader, writer) = std::io::pipe().unwrap();
            journal.file = File::from(std::os::fd::OwnedFd::from(writer));
            let added = journal.append(&Change::default());
            let told = added.err().map(|error| error.to_string());
            assert_eq!(told.is_some(), sync, "{told:?}");
            // One that is started over goes on as it began.
            journal.compact(&Change::default()).unwrap();
            assert_eq!(journal.is_synced(), sync);
        }
    }
}
