//! The lock of a journal: a file beside it. The journal itself is replaced now and then, and
//! a lock would stay with what it was.

use pickline::error::{Error, Result};
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// How often a lock file that another process removes is made again before giving up.
const MOST_TRIES: u32 = 100;

/// Held while this lives; the system lets go of it with the process.
#[derive(Debug)]
pub struct Lock {
    beside: PathBuf,
    _file: File,
    /// Whether the file is removed in the end: it is new, and the journal was not begun.
    is_passing: bool,
}

impl Lock {
    /// Locks the journal at `path`.
    ///
    /// # Errors
    /// A journal that another process uses, a lock file that cannot be made.
    pub fn take(path: &Path) -> Result<Self> {
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
                // Its last holder has removed it: the lock would keep nobody out.
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => break,
                Err(TryLockError::Error(error)) => return Err(Error::write(&beside, error)),
            }
        }
        Err(Error::input(
            path.display().to_string(),
            "another process is using this journal",
            "end that process first; two must not command the same robots",
        ))
    }

    /// Leaves the file where it is when the lock is let go, for a journal that was begun.
    pub fn keep(mut self) -> Self {
        self.is_passing = false;
        self
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        if self.is_passing {
            // Still locked. A file that cannot be removed only lies about.
            let _ = std::fs::remove_file(&self.beside);
        }
    }
}

/// The lock file of the journal at `path`.
pub fn lock_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".lock");
    PathBuf::from(name)
}

/// The lock file, and whether it is new.
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

/// Whether `file` is the one that now stands at `path`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let place = |about: std::fs::Metadata| (about.dev(), about.ino());
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(held), Ok(found)) => place(held) == place(found),
        _ => false,
    }
}

/// Where open files cannot be removed, it is.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}
