//! The library's single error type.
//!
//! Every message names the place (file and line, key or flag), the value found there and the cure,
//! so that a user never has to guess what to change.

use std::path::{Path, PathBuf};

/// Result of every fallible function in this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Everything that can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Input that the model does not allow: a file, a flag or a value.
    #[error("{place}: {problem}\n  cure: {cure}")]
    Input {
        /// File with line and key, or the flag.
        place: String,
        /// What is wrong, with the value found.
        problem: String,
        /// How to fix it.
        cure: String,
    },
    /// A file or folder could not be read or written.
    #[error("cannot {action} {}: {source}\n  cure: {}", path.display(), io_cure(action, path, source))]
    Io {
        /// `read` or `write`.
        action: &'static str,
        /// The path as the user gave it.
        path: PathBuf,
        /// The error reported by the operating system.
        source: std::io::Error,
    },
    /// A strategy chose an action that the model forbids.
    #[error(
        "illegal action at t = {time} s by robot `{}`: {problem}",
        shown(robot)
    )]
    IllegalAction {
        /// Time of the decision [s].
        time: f64,
        /// Name of the deciding robot.
        robot: String,
        /// The rule of the model that the action breaks.
        problem: String,
    },
    /// The independent checker found that a run violates the model.
    #[error("the checker rejects this run: {0}")]
    Refuted(String),
    /// The user stopped the program before there was a result to report.
    #[error("interrupted before the first result")]
    Interrupted,
}

impl Error {
    /// Input that is not allowed: `place` says where, `problem` names the value, `cure` says what
    /// to change.
    pub fn input(
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::Input {
            place: place.into(),
            problem: problem.into(),
            cure: cure.into(),
        }
    }

    /// The problem alone, for a message that has its own place and cure.
    pub fn problem(&self) -> String {
        match self {
            Self::Input { problem, .. } | Self::IllegalAction { problem, .. } => problem.clone(),
            other => other.to_string(),
        }
    }

    /// The same error attributed to another place, such as the flag that sets the key.
    pub fn at(self, place: &str) -> Self {
        match self {
            Self::Input { problem, cure, .. } => Self::input(place, problem, cure),
            other => other,
        }
    }

    /// The same error with its place qualified by the enclosing `whole`, such as the file of an
    /// item.
    pub fn inside(self, whole: &str) -> Self {
        match self {
            Self::Input {
                place,
                problem,
                cure,
            } => Self::input(format!("{whole}: {place}"), problem, cure),
            other => other,
        }
    }

    /// A file that could not be read.
    pub fn read(path: &Path, source: std::io::Error) -> Self {
        Self::Io {
            action: "read",
            path: path.to_owned(),
            source,
        }
    }

    /// A file or folder that could not be written.
    pub fn write(path: &Path, source: std::io::Error) -> Self {
        Self::Io {
            action: "write",
            path: path.to_owned(),
            source,
        }
    }
}

/// The cure for a path that cannot be read or written. For a missing file it suggests the file in
/// the same folder with the most similar name.
fn io_cure(action: &str, path: &Path, source: &std::io::Error) -> String {
    use std::io::ErrorKind;
    let folder = folder_of(path);
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
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "free some disk space, or choose a path on another disk".into()
        }
        ErrorKind::ReadOnlyFilesystem => "choose a path on a disk that is not read-only".into(),
        ErrorKind::InvalidFilename => "choose a shorter file name".into(),
        _ => format!("check that the path exists and that you have permission to {action} it"),
    }
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

/// The known name most similar to `given`, for "did you mean" hints. `None` if no name is similar
/// enough to be a typing mistake.
pub fn nearest<'a>(given: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    known
        .into_iter()
        .map(|name| {
            let distance = strsim::damerau_levenshtein(&given.to_lowercase(), &name.to_lowercase());
            (distance, name)
        })
        .filter(|(distance, name)| *distance <= 1 + name.chars().count() / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

/// "did you mean `x`? known: a, b, c", the usual cure for an unknown name.
pub fn known_names(given: &str, known: &[&str]) -> String {
    let list = known.join(", ");
    match nearest(given, known.iter().copied()) {
        Some(name) => format!("did you mean `{name}`? known: {list}"),
        None => format!("known: {list}"),
    }
}

/// A value from a file as messages show it: control characters escaped, long text truncated.
pub fn shown(value: &str) -> String {
    const MOST: usize = 60;
    let mut text: String = value
        .chars()
        .take(MOST)
        .flat_map(char::escape_debug)
        .collect();
    if value.chars().nth(MOST).is_some() {
        text.push_str("...");
    }
    text
}

/// A count with a noun whose plural takes an s: `1 rule`, `2 rules`.
pub fn counted(count: usize, thing: &str) -> String {
    format!("{count} {thing}{}", if count == 1 { "" } else { "s" })
}

/// A count with its digits in groups of three: `1,999`.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A number as messages show it: with an exponent if it would otherwise be hundreds of digits long.
pub fn shown_number(value: f64) -> String {
    let short = format!("{value:?}");
    if short.contains('e') {
        short
    } else {
        value.to_string()
    }
}

/// A computed number rounded to `digits` significant digits, which hides rounding noise: `316.665`
/// for 316.6654896958023.
pub fn rounded(value: f64, digits: usize) -> String {
    let short = format!("{value:.0$e}", digits.saturating_sub(1));
    shown_number(short.parse().unwrap_or(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_finds_slips_and_refuses_strangers() {
        let known = ["speed", "length", "width"];
        assert_eq!(nearest("sped", known), Some("speed"));
        assert_eq!(nearest("WIDHT", known), Some("width"));
        assert_eq!(nearest("colour", known), None);
    }

    #[test]
    fn numbers_are_shown_as_one_would_write_them() {
        for (value, text) in [
            (-1.0, "-1"),
            (0.05, "0.05"),
            (1e300, "1e300"),
            (1e-9, "1e-9"),
        ] {
            assert_eq!(shown_number(value), text);
        }
        assert_eq!(shown_number(f64::NAN), "NaN");
        assert_eq!(rounded(316.6654896958023, 6), "316.665");
        assert_eq!(rounded(-284.34000000000003, 9), "-284.34");
        assert_eq!(rounded(f64::NAN, 9), "NaN");
    }

    #[test]
    fn a_file_that_is_not_there_names_the_nearest() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("my-line.toml"), "").unwrap();
        let missing = |name: &str| {
            let path = folder.path().join(name);
            let source = std::fs::read(&path).unwrap_err();
            Error::read(&path, source).to_string()
        };
        for slip in ["my-lin.toml", "my_line.toml", "my-line"] {
            let message = missing(slip);
            assert!(
                message.contains("cure: did you mean ") && message.contains("my-line.toml?"),
                "{message}"
            );
        }
        for stranger in ["nix.csv", "-", "d", "ours.toml"] {
            for other in ["mixid.csv", "c", "no.toml"] {
                std::fs::write(folder.path().join(other), "").unwrap();
            }
            let message = missing(stranger);
            assert!(message.contains("the file does not exist"), "{message}");
        }
        assert!(missing("other.csv").contains("the file does not exist"));
        assert!(missing("none/a.toml").contains("does not exist; check the path"));
    }

    #[test]
    fn shown_cuts_and_escapes() {
        assert_eq!(shown("a\u{7}b"), "a\\u{7}b");
        assert_eq!(shown(&"x".repeat(100)), format!("{}...", "x".repeat(60)));
    }
}
