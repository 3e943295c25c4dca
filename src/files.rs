//! Reads text files, and writes result files atomically.

use crate::error::{Error, Result};
use sha2::{Digest, Sha256};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// The text of a file.
///
/// # Errors
/// If the file cannot be read or is not UTF-8; the error names the line.
pub fn read_text(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).map_err(|source| Error::read(path, source))?;
    utf8(bytes, &path.display().to_string())
}

/// Decodes the bytes of the file `name` as UTF-8.
///
/// # Errors
/// If the bytes are not UTF-8; the error names the line.
pub fn utf8(bytes: Vec<u8>, name: &str) -> Result<String> {
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid]
            .iter()
            .filter(|&&byte| byte == b'\n')
            .count();
        // The encoding that spreadsheets call "Unicode text".
        let is_utf16 = [[0xff, 0xfe], [0xfe, 0xff]]
            .iter()
            .any(|mark| error.as_bytes().starts_with(mark));
        Error::input(
            format!("{name}:{line}"),
            format!("byte 0x{:02x} is not UTF-8 text", error.as_bytes()[valid]),
            match is_utf16 {
                true => "the file is UTF-16; save it as UTF-8 (in a spreadsheet: CSV UTF-8)",
                false => "save the file as UTF-8 (plain ASCII is UTF-8)",
            },
        )
        .caused_by(error.utf8_error())
    })
}

/// Writes `content` to `path` through a temporary file in the same folder, so that the path holds
/// either all of it or its previous content. Links are followed. A device, pipe or other special
/// file is written to directly and never replaced.
///
/// # Errors
/// If the folder or file cannot be written; no partial file is left behind.
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

/// Writes `content` to `path`, which must be a regular file or not exist, as [`write_whole`] does.
/// Returns the new file, opened for appending. It needs only one file descriptor.
///
/// # Errors
/// The error of the operating system; `path` then keeps its previous content.
pub fn replace_and_go_on(path: &Path, content: &[u8]) -> std::io::Result<std::fs::File> {
    write_by_rename(&followed(path), content)
}

/// Longest chain of links that is followed before it is treated as a cycle.
const MOST_LINKS: usize = 40;

/// The file that `path` refers to after following links, whether or not it exists.
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

/// Writes a temporary file, lets `sync` flush it to disk, and renames it to `path`.
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
        // Report the first error; there may be no temporary file to remove.
        let _ = std::fs::remove_file(&temporary);
    })
}

/// Removes the temporary files that killed writers of `path` left beside it. Call it only while no
/// other process writes `path`.
pub fn remove_leftovers(path: &Path) {
    let name = short_name(path);
    let entries = std::fs::read_dir(folder_of(path)).into_iter().flatten();
    for entry in entries.flatten() {
        let other = entry.file_name().to_string_lossy().into_owned();
        let rest = other
            .strip_prefix(&format!(".{name}."))
            .and_then(|rest| rest.strip_suffix(".part"));
        if rest.is_some_and(|pid| !pid.is_empty() && pid.bytes().all(|b| b.is_ascii_digit())) {
            // A leftover that cannot be removed only wastes space.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Flushes the directory entries of the folder of `path` to disk, if the system supports it.
pub fn sync_folder(path: &Path) {
    // Not every system supports this; the file itself has been synced.
    let _ = std::fs::File::open(folder_of(path)).and_then(|folder| folder.sync_all());
}

/// Whether `name` is written as a path, so that it does not mean something built in.
pub(crate) fn is_path(name: &str) -> bool {
    name.contains(['/', '\\', '.'])
}

/// The folder that `path` is in.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Checks without writing anything that a file could be written to `path`, so that a mistyped path
/// is found before any work is done or any other file is written.
///
/// # Errors
/// If the path is a folder, or its folder does not exist.
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

/// Checks that [`write_whole`] could write `path`, by creating and removing its temporary file.
/// Special files are not touched.
///
/// # Errors
/// If the folder or file cannot be written.
pub fn try_target(path: &Path) -> Result<()> {
    let real = followed(path);
    if real.exists() && !real.is_file() {
        return Ok(());
    }
    // The temporary file has a short name even if this one is too long.
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

/// The temporary path to which the content of `path` is written first.
fn temporary(path: &Path) -> PathBuf {
    let name = short_name(path);
    path.with_file_name(format!(".{name}.{}.part", std::process::id()))
}

/// The file name of `path`, shortened to leave room for the temporary affixes: file systems allow
/// names of at most 255 bytes.
fn short_name(path: &Path) -> String {
    const LONGEST: usize = 200;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    match name.len() {
        0..=LONGEST => name.into_owned(),
        _ => fingerprint(name.as_bytes()),
    }
}

/// Checks that `path` is not read-only, which a rename would ignore.
///
/// # Errors
/// If the file is read-only.
pub fn check_not_read_only(flag: &str, path: &Path) -> Result<()> {
    match std::fs::metadata(path) {
        Ok(about) if about.is_file() && about.permissions().readonly() => Err(Error::path(
            flag,
            format!("{} is read-only", path.display()),
            "make it writable (chmod u+w), or choose another file",
        )),
        _ => Ok(()),
    }
}

/// Checks that `folder` exists or could be created, without creating it: a file is created in its
/// nearest existing ancestor, then removed.
///
/// # Errors
/// If the path is not a folder, lies below a file, or is not writable.
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

/// Creates `folder` and its parents.
///
/// # Errors
/// If the folder cannot be created.
pub fn make_folder(folder: &Path) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|source| Error::write(folder, source))
}

/// Identifies a text or other content by the first 16 hexadecimal digits of its SHA-256.
pub fn fingerprint(content: impl AsRef<[u8]>) -> String {
    let digest = Sha256::digest(content.as_ref());
    digest[..8]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect()
}

/// Starts a comment line in a CSV file; readers can be set to skip such lines (pandas:
/// `read_csv(..., comment="#")`).
const COMMENT: u8 = b'#';

/// Rows of fields as CSV text. A field is quoted if necessary, also if it contains the comment
/// character.
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
        // Writing to memory cannot fail, and rows may differ in length.
        let _ = writer.write_record(row);
    }
    String::from_utf8_lossy(&writer.into_inner().unwrap_or_default()).into_owned()
}

/// `text` as comment lines of a CSV file.
pub fn csv_comment(text: &str) -> String {
    // Some readers also treat a lone carriage return as the end of a line.
    let lines = text.split(['\n', '\r']).filter(|line| !line.is_empty());
    lines.map(|line| format!("# {line}\n")).collect()
}

/// The files of one invocation, each with its flag; `None` if the flag is not given.
pub type Named<'n> = [(&'n str, Option<&'n Path>)];

/// Checks that no output of an invocation overwrites one of its inputs or another output. Devices
/// and pipes may be shared.
///
/// # Errors
/// The first two paths that refer to the same file.
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
            return Err(Error::usage(
                flag,
                format!("{} is already used by {other}", file.display()),
                "use a separate file for each",
            ));
        }
    }
    Ok(())
}

/// The canonical path of `file`, which need not exist yet.
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

    /// Even if the power fails, the path holds one complete text.
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

    /// The old text remains reachable through another hard link.
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
