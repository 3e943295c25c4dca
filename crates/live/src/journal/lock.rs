//! The lock of a journal: a file beside it. The journal itself is replaced now and then, and a lock
//! would stay on the old file.

use pickline::error::{Error, Result};
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Number of attempts to create a lock file that other processes keep removing.
const MOST_TRIES: u32 = 100;

/// A lock that is held until this is dropped. The system releases it when the process ends.
#[derive(Debug)]
pub(super) struct Lock {
    beside: PathBuf,
    _file: File,
    /// Whether the file is removed at the end, because it is new and the journal was not started.
    is_passing: bool,
}

impl Lock {
    /// Locks the journal at `path`.
    ///
    /// # Errors
    /// Another process uses the journal, or the lock file cannot be created.
    pub(super) fn take(path: &Path) -> Result<Self> {
        let beside = lock_of(path);
        for _ in 0..MOST_TRIES {
            let (file, is_new) = open(&beside).map_err(|error| Error::write(&beside, error))?;
            match file.try_lock() {
                Ok(()) if is_at(&file, &beside) => {
                    return Ok(Self {
                        beside,
                        _file: file,
                        is_passing: is_new,
                    });
                }
                // Its last holder has removed it, so the lock would not exclude anyone.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => break,
                Err(TryLockError::Error(error)) => return Err(Error::write(&beside, error)),
            }
        }
        Err(Error::path(
            path.display().to_string(),
            "another process is using this journal",
            "stop that process first; two nodes must not command the same robots",
        ))
    }

    /// Keeps the file when the lock is released, for a journal that was started.
    pub(super) fn keep(mut self) -> Self {
        self.is_passing = false;
        self
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if self.is_passing {
            // The lock is still held. A file that cannot be removed does no harm.
            let _ = std::fs::remove_file(&self.beside);
        }
    }
}

/// The lock file of the journal at `path`.
pub(crate) fn lock_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".lock");
    PathBuf::from(name)
}

/// Opens the lock file. Returns it and whether it is new.
fn open(beside: &Path) -> std::io::Result<(File, bool)> {
    match File::options().write(true).create_new(true).open(beside) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            let mut options = File::options();
            let options = options.write(true).create(true).truncate(false);
            Ok((options.open(beside)?, false))
        }
        opened => Ok((opened?, true)),
    }
}

/// Whether `file` is still the file at `path`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let place = |about: std::fs::Metadata| (about.dev(), about.ino());
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(held), Ok(found)) => place(held) == place(found),
        _ => false,
    }
}

/// It is, on systems where open files cannot be removed.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}
