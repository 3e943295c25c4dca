//! Cures for paths that cannot be read or written.

use super::kind::is_out_of_files;
use super::wording::{nearest, shown};
use std::io;
use std::path::{Path, PathBuf};

/// The cure for a path that cannot be read or written. For a missing file it suggests the file in
/// the same folder with the most similar name.
pub(super) fn io_cure(action: &str, path: &Path, source: &io::Error) -> String {
    use io::ErrorKind;
    let folder = folder_of(path);
    let usual =
        || format!("check that the path exists and that you have permission to {action} it");
    match source.kind() {
        ErrorKind::NotFound if !folder.exists() => {
            format!(
                "the folder {} does not exist; check the path",
                folder.display()
            )
        }
        ErrorKind::NotFound if action == "read" => match nearest_file(path) {
            Some(meant) => format!("did you mean {}?", shown(&meant.display().to_string())),
            None => "the file does not exist; check the path".into(),
        },
        ErrorKind::IsADirectory => "this is a folder; give the path of a file".into(),
        ErrorKind::NotADirectory => match not_a_folder(path) {
            Some(file) => format!("{} is not a folder; choose another path", file.display()),
            None => usual(),
        },
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "free some disk space, or choose a path on another disk".into()
        }
        ErrorKind::ReadOnlyFilesystem => "choose a path on a disk that is not read-only".into(),
        ErrorKind::InvalidFilename => "choose a shorter file name".into(),
        ErrorKind::OutOfMemory => "close other programs to free some memory".into(),
        _ if is_out_of_files(source) => {
            "close other programs, or raise the limit of open files (ulimit -n)".into()
        }
        _ => usual(),
    }
}

/// The part of `path`, or all of it, that exists but is not a folder.
fn not_a_folder(path: &Path) -> Option<&Path> {
    let mut parts = path.ancestors();
    parts.find(|part| part.exists() && !part.is_dir())
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The file in the folder of `path` whose name is most similar to the given one, with or without
/// its extension. `None` if no name is similar enough to be a typing mistake.
pub fn nearest_file(path: &Path) -> Option<PathBuf> {
    let entries = std::fs::read_dir(folder_of(path)).ok()?.flatten();
    let files = entries.map(|entry| PathBuf::from(entry.file_name()));
    let mut files: Vec<PathBuf> = files.filter(|name| name.to_str().is_some()).collect();
    // Sorted, so that a tie does not depend on the order in which the system lists the files.
    files.sort_unstable();
    let wanted = Path::new(path.file_name()?);
    let text = |path: &Path| path.to_string_lossy().into_owned();
    let names: Vec<String> = match wanted.extension() {
        Some(_) => files.iter().map(|name| text(name)).collect(),
        None => files
            .iter()
            .map(|name| text(&name.with_extension("")))
            .collect(),
    };
    let given = text(wanted);
    let name = nearest(&given, names.iter().map(String::as_str))?;
    if !is_slip(&given, name) {
        return None;
    }
    let at = names.iter().position(|other| other == name)?;
    Some(path.with_file_name(&files[at]))
}

/// Whether `given` may be a mistyped `other`. Stricter than [`nearest`]: a folder holds more names
/// than a format has keys, and short names are all similar to one another.
fn is_slip(given: &str, other: &str) -> bool {
    let [given, other] = [given, other].map(str::to_lowercase);
    let distance = strsim::damerau_levenshtein(&given, &other);
    let stem = |name: &str| Path::new(name).with_extension("").as_os_str().len();
    let shorter = stem(&given).min(stem(&other));
    distance == 0 || shorter > 2 && distance <= 1 + shorter / 6
}
