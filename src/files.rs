//! Reading text files and writing result files whole or not at all.

use crate::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The text of a file.
///
/// # Errors
/// A file that cannot be read, or bytes that are not UTF-8 (named with their line).
pub fn read_text(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).map_err(|source| Error::read(path, source))?;
    utf8(bytes, &path.display().to_string())
}

/// The text of the bytes of `name`.
///
/// # Errors
/// Bytes that are not UTF-8, named with their line.
pub fn utf8(bytes: Vec<u8>, name: &str) -> Result<String> {
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid]
            .iter()
            .filter(|&&byte| byte == b'\n')
            .count();
        // What spreadsheets call Unicode text.
        let is_utf16 = [[0xff, 0xfe], [0xfe, 0xff]]
            .iter()
            .any(|mark| error.as_bytes().starts_with(mark));
        Error::input(
            format!("{name}:{line}"),
            format!("byte 0x{:02x} is not UTF-8 text", error.as_bytes()[valid]),
            match is_utf16 {
                true => "it is UTF-16: save the file as UTF-8, in a spreadsheet as CSV UTF-8",
                false => "save the file as UTF-8 (plain ASCII is UTF-8)",
            },
        )
    })
}

/// Writes `content` to `path` by way of a temporary file in the same folder, so
/// that the path holds the whole of it or what it held before. A link is followed, and
/// what is no regular file (a device, a pipe) is written to as it is, never replaced.
///
/// # Errors
/// A folder or file that cannot be written; nothing is left behind then.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<()> {
    let real = followed(path);
    if real.exists() && !real.is_file() {
        let written = std::fs::OpenOptions::new()
            .write(true)
            .open(&real)
            .and_then(|mut file| file.write_all(content));
        return written.map_err(|source| Error::write(path, source));
    }
    let written = write_by_rename(&real, content).map(drop);
    written.map_err(|source| Error::write(path, source))
}

/// Writes `content` to `path`, which is a regular file or none, as [`write_whole`] does, and
/// returns the new file, to be written on at its end. It takes one descriptor, as it did
/// before there was a new file.
///
/// # Errors
/// What the system says; the path holds what it held before then.
pub fn replace_and_go_on(path: &Path, content: &[u8]) -> std::io::Result<std::fs::File> {
    write_by_rename(&followed(path), content)
}

/// Links in a chain of them that are followed before it is taken for a ring.
const MOST_LINKS: usize = 40;

/// The file that `path` names, links followed, whether it exists yet or not.
fn followed(path: &Path) -> PathBuf {
    if let Ok(real) = std::fs::canonicalize(path) {
        return real;
    }
    let mut real = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(target) = std::fs::read_link(&real) else {
            break;
        };
        real = folder_of(&real).join(target);
    }
    real
}

fn write_by_rename(path: &Path, content: &[u8]) -> std::io::Result<std::fs::File> {
    write_and_rename(path, content, &std::fs::File::sync_all)
}

/// Writes a temporary file, has `sync` put it on the disk, and gives it the name of `path`.
fn write_and_rename(
    path: &Path,
    content: &[u8],
    sync: &dyn Fn(&std::fs::File) -> std::io::Result<()>,
) -> std::io::Result<std::fs::File> {
    let temporary = temporary(path);
    let written = std::fs::File::create(&temporary)
        .and_then(|mut file| {
            file.write_all(content)?;
            sync(&file)?;
            Ok(file)
        })
        .and_then(|file| std::fs::rename(&temporary, path).map(|()| file));
    written.inspect_err(|_| {
        // The first error is the one to report; a leftover may not even exist.
        let _ = std::fs::remove_file(&temporary);
    })
}

/// Removes what writers of `path` that were killed have left beside it. To be called where
/// nobody else writes it.
pub fn remove_leftovers(path: &Path) {
    let name = short_name(path);
    let entries = std::fs::read_dir(folder_of(path)).into_iter().flatten();
    for entry in entries.flatten() {
        let other = entry.file_name().to_string_lossy().into_owned();
        let rest = other
            .strip_prefix(&format!(".{name}."))
            .and_then(|rest| rest.strip_suffix(".part"));
        if rest.is_some_and(|pid| !pid.is_empty() && pid.bytes().all(|b| b.is_ascii_digit())) {
            // Whatever cannot be removed only takes room.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Has the system put the names in the folder of `path` onto the disk, where it can.
pub fn sync_folder(path: &Path) {
    // Not every system can; the file itself has been synced.
    let _ = std::fs::File::open(folder_of(path)).and_then(|folder| folder.sync_all());
}

/// The folder that `path` is in.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Checks that a file could be written to `path` by what there is to see, without a trace:
/// so that work is not done, nor another file written, for a slip in a path.
///
/// # Errors
/// A path that is a folder, or in a folder that does not exist.
pub fn check_target(path: &Path) -> Result<()> {
    let real = followed(path);
    let folder = folder_of(&real);
    let kind = std::fs::metadata(folder).map_err(|source| Error::write(path, source))?;
    if !kind.is_dir() {
        return Err(Error::write(path, ErrorKind::NotADirectory.into()));
    }
    if path.is_dir() {
        return Err(Error::write(path, ErrorKind::IsADirectory.into()));
    }
    Ok(())
}

/// Tries whether [`write_whole`] could write `path`: makes the temporary file that it would
/// make, and removes it. Special files are left alone.
///
/// # Errors
/// A folder or file that cannot be written.
pub fn try_target(path: &Path) -> Result<()> {
    let real = followed(path);
    if real.exists() && !real.is_file() {
        return Ok(());
    }
    // The temporary file has a short name whatever this one is.
    if let Err(error) = std::fs::symlink_metadata(&real)
        && error.kind() == ErrorKind::InvalidFilename
    {
        return Err(Error::write(path, error));
    }
    try_file(&temporary(&real)).map_err(|source| Error::write(path, source))
}

fn try_file(temporary: &Path) -> std::io::Result<()> {
    std::fs::File::create(temporary)?;
    std::fs::remove_file(temporary)
}

/// Where the content of `path` is written first.
fn temporary(path: &Path) -> PathBuf {
    let name = short_name(path);
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

/// The name of `path` with room for what temporary names add to it: file systems take
/// names of 255 bytes.
fn short_name(path: &Path) -> String {
    const LONGEST: usize = 200;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match name.len() {
        0..=LONGEST => name.into_owned(),
        _ => fingerprint(name.as_bytes()),
    }
}

/// Checks that `path` may be replaced: a rename would not ask whether it is read-only.
///
/// # Errors
/// A file that is read-only.
pub fn check_not_read_only(flag: &str, path: &Path) -> Result<()> {
    match std::fs::metadata(path) {
        Ok(about) if about.is_file() && about.permissions().readonly() => Err(Error::input(
            flag,
            format!("{} is read-only", path.display()),
            "make it writable (chmod u+w), or name another file",
        )),
        _ => Ok(()),
    }
}

/// Checks that `folder` exists or could be made, without making it: a file is made in what
/// there is of it, and removed.
///
/// # Errors
/// A path that is no folder, that lies below a file, or that must not be written to.
pub fn check_folder(folder: &Path) -> Result<()> {
    let there = folder.ancestors().find(|path| path.exists());
    let there = match there {
        Some(there) if !there.is_dir() => {
            return Err(Error::write(folder, ErrorKind::NotADirectory.into()));
        }
        Some(there) => there,
        // A relative path of which nothing exists yet.
        None => Path::new("."),
    };
    let temporary = there.join(format!(".pickline.{}.part", std::process::id()));
    try_file(&temporary).map_err(|source| Error::write(folder, source))
}

/// Makes `folder` and its parents.
///
/// # Errors
/// A folder that cannot be made.
pub fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|source| Error::write(folder, source))
}

/// Identifies a text or other content: the first 16 hexadecimal digits of its SHA-256.
pub fn fingerprint(content: impl AsRef<[u8]>) -> String {
    let digest = Sha256::digest(content.as_ref());
    digest[..8]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Begins a line of a CSV file that is no row: readers skip it when they know the sign
/// (pandas: `read_csv(..., comment="#")`).
pub const COMMENT: u8 = b'#';

/// Rows of fields as CSV text, quoted where a field needs it, also where it holds the sign
/// of a comment.
pub fn csv_text<R, F>(rows: impl IntoIterator<Item = R>) -> String
where
    R: IntoIterator<Item = F>,
    F: AsRef<[u8]>,
{
    let mut writer = csv::WriterBuilder::new()
        .flexible(true)
        .comment(Some(COMMENT))
        .from_writer(Vec::new());
    for row in rows {
        // Writing to memory cannot fail, and the rows may be of any length.
        let _ = writer.write_record(row);
    }
    String::from_utf8_lossy(&writer.into_inner().unwrap_or_default()).into_owned()
}

/// `text` as comment lines of a CSV file.
pub fn csv_comment(text: &str) -> String {
    // A lone carriage return ends a line for some readers too.
    let lines = text.split(['\n', '\r']).filter(|line| !line.is_empty());
    lines.map(|line| format!("# {line}\n")).collect()
}

/// Files of a call, each with the flag that names it; none where it is not given.
pub type Named<'n> = [(&'n str, Option<&'n Path>)];

/// Checks that what a call writes overwrites neither what it reads nor something else that
/// it writes. Devices and pipes may be shared.
///
/// # Errors
/// The first pair that is one file.
pub fn check_apart(read: &Named, written: &Named) -> Result<()> {
    for (i, &(flag, file)) in written.iter().enumerate() {
        let Some(file) = file else { continue };
        if file.exists() && !file.is_file() {
            continue;
        }
        let same = |other: &Path| resolved(other) == resolved(file);
        let mut others = read.iter().chain(&written[..i]);
        let other = others.find(|(_, other)| other.is_some_and(same));
        if let Some((other, _)) = other {
            return Err(Error::input(
                flag,
                format!("{} is also the file of {other}", file.display()),
                "give each a file of its own",
            ));
        }
    }
    Ok(())
}

/// The path that `file` is, however it is written; it may not exist yet.
fn resolved(file: &Path) -> PathBuf {
    let whole = |path: &Path| std::fs::canonicalize(path).ok();
    let real = followed(file);
    whole(&real)
        .or_else(|| Some(whole(folder_of(&real))?.join(real.file_name()?)))
        .unwrap_or_else(|| real.components().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_are_checked_without_a_trace() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("file"), "x").unwrap();
        assert!(check_folder(&path("new/newer")).is_ok());
        assert!(check_folder(Path::new("new")).is_ok());
        assert!(check_folder(&path("file")).is_err());
        assert!(check_folder(&path("file/below")).is_err());
        assert!(check_target(&path("new")).is_ok());
        assert!(check_target(&path("file")).is_ok());
        assert!(check_target(Path::new("new")).is_ok());
        for bad in ["file/below", "no-folder/file", ""] {
            assert!(check_target(&path(bad)).is_err(), "{bad}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_pipes_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::write(path("real"), "old").unwrap();
        std::os::unix::fs::symlink(path("real"), path("link")).unwrap();
        write_whole(&path("link"), b"new").unwrap();
        assert_eq!(std::fs::read(path("real")).unwrap(), b"new");
        assert!(
            std::fs::symlink_metadata(path("link"))
                .unwrap()
                .is_symlink()
        );
        let pipe = path("pipe");
        assert!(
            std::process::Command::new("mkfifo")
                .arg(&pipe)
                .status()
                .unwrap()
                .success()
        );
        let reader = {
            let pipe = pipe.clone();
            std::thread::spawn(move || std::fs::read(pipe).unwrap())
        };
        write_whole(&pipe, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), b"through");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
    }

    #[cfg(unix)]
    #[test]
    fn links_to_files_that_do_not_exist_yet_are_followed() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        std::fs::create_dir(path("sub")).unwrap();
        std::os::unix::fs::symlink("sub/real", path("link")).unwrap();
        check_target(&path("link")).unwrap();
        try_target(&path("link")).unwrap();
        write_whole(&path("link"), b"new").unwrap();
        assert_eq!(std::fs::read(path("sub/real")).unwrap(), b"new");
        assert!(
            std::fs::symlink_metadata(path("link"))
                .unwrap()
                .is_symlink()
        );
        std::os::unix::fs::symlink("none/real", path("lost")).unwrap();
        assert!(check_target(&path("lost")).is_err());
    }

    #[test]
    fn names_as_long_as_the_system_takes_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = |length| folder.path().join("x".repeat(length));
        try_target(&path(250)).unwrap();
        write_whole(&path(250), b"new").unwrap();
        assert_eq!(std::fs::read(path(250)).unwrap(), b"new");
        assert!(try_target(&path(300)).is_err());
    }

    /// Whenever the power fails, the path holds one text whole.
    #[test]
    fn a_file_is_whole_on_the_disk_before_it_takes_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("file");
        let read = || std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, "old").unwrap();
        let failing = |_: &std::fs::File| Err(ErrorKind::StorageFull.into());
        assert!(write_and_rename(&path, b"new", &failing).is_err());
        assert_eq!(read(), "old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let synced = std::cell::Cell::new(0);
        let sync = |file: &std::fs::File| {
            synced.set(synced.get() + 1);
            assert_eq!((read().as_str(), file.metadata()?.len()), ("old", 5));
            Ok(())
        };
        write_and_rename(&path, b"newer", &sync).unwrap();
        assert_eq!((synced.get(), read().as_str()), (1, "newer"));
    }

    /// The old text stays where another name leads to it.
    #[test]
    fn a_file_is_replaced_and_not_written_over() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for go_on in [false, true] {
            std::fs::write(path("file"), "old").unwrap();
            std::fs::hard_link(path("file"), path("kept")).unwrap();
            match go_on {
                true => drop(replace_and_go_on(&path("file"), b"new").unwrap()),
                false => write_whole(&path("file"), b"new").unwrap(),
            }
            assert_eq!(std::fs::read(path("file")).unwrap(), b"new");
            assert_eq!(std::fs::read(path("kept")).unwrap(), b"old");
            std::fs::remove_file(path("kept")).unwrap();
        }
    }

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("taken");
        std::fs::create_dir(&target).unwrap();
        std::fs::write(target.join("file"), "x").unwrap();
        assert!(write_whole(&target, b"new").is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let file = folder.path().join("fresh");
        write_whole(&file, b"one").unwrap();
        write_whole(&file, b"two").unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"two");
        for name in [".fresh.123.part", ".fresh.x.part", ".other.123.part"] {
            std::fs::write(folder.path().join(name), "x").unwrap();
        }
        remove_leftovers(&file);
        assert!(!folder.path().join(".fresh.123.part").exists());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 4);
    }
}
