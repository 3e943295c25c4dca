//! The library's single error type.
//!
//! Every message names the place (file and line, key or setting), the value found there and the
//! cure, so that a user never has to guess what to change. [`Error::kind`] says what sort of
//! failure it is.
//!
//! A message writes a setting, such as an option of a search, in single quotes: `'flow'`. The names
//! are those of the library; a program that spells them otherwise passes its errors through
//! [`Error::spell_settings`].

use std::error::Error as StdError;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// Result of every fallible function in this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Everything that can go wrong: a kind, a message with place, problem and cure, and the error
/// beneath it where there is one.
pub struct Error(Box<Details>);

/// The sort of a failure, by which a program chooses its exit code or its answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A setting has a value that is not allowed, or settings contradict each other.
    Usage,
    /// A file or a value in it is not what the model or the format allows.
    Input,
    /// A path cannot be used as given: it does not exist, is a folder, or may not be accessed.
    Path,
    /// Reading or writing failed although the path is usable: a full disk, a broken device.
    Io,
    /// The operating system has no memory or no thread left.
    Resources,
    /// A strategy chose an action that the model forbids.
    IllegalAction,
    /// A check found that a result violates what it promises.
    Refuted,
    /// The user stopped the work before there was a result to report.
    Interrupted,
    /// A defect of this library.
    Internal,
}

/// What a message is made of.
#[derive(Debug)]
enum Details {
    Described {
        kind: ErrorKind,
        place: String,
        problem: String,
        cure: String,
        source: Option<Box<dyn StdError + Send + Sync>>,
    },
    File {
        /// `read` or `write`.
        action: &'static str,
        /// The path as the user gave it.
        path: PathBuf,
        source: io::Error,
    },
    IllegalAction {
        /// Time of the decision [s].
        time: f64,
        /// Name of the deciding robot.
        robot: String,
        problem: String,
    },
    Refuted(String),
    Interrupted,
    Internal(String),
}

impl Error {
    /// Input that is not allowed: `place` says where, `problem` names the value, `cure` says what
    /// to change.
    pub fn input(
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::described(ErrorKind::Input, place.into(), problem.into(), cure.into())
    }

    /// A setting that is not allowed. `place` names it in single quotes, with its value if that
    /// is a long text; `problem` names the value, `cure` says what to change.
    pub fn usage(
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::described(ErrorKind::Usage, place.into(), problem.into(), cure.into())
    }

    /// What the operating system could not provide, such as memory or a thread.
    pub fn resources(
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::described(
            ErrorKind::Resources,
            place.into(),
            problem.into(),
            cure.into(),
        )
    }

    fn described(kind: ErrorKind, place: String, problem: String, cure: String) -> Self {
        Self(Box::new(Details::Described {
            kind,
            place,
            problem,
            cure,
            source: None,
        }))
    }

    /// A file that could not be read.
    pub fn read(path: &Path, source: io::Error) -> Self {
        Self::file("read", path, source)
    }

    /// A file or folder that could not be written.
    pub fn write(path: &Path, source: io::Error) -> Self {
        Self::file("write", path, source)
    }

    fn file(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self(Box::new(Details::File {
            action,
            path: path.to_owned(),
            source,
        }))
    }

    /// An action that the model forbids, chosen at `time` [s] for the robot of that name.
    pub fn illegal_action(time: f64, robot: impl Into<String>, problem: impl Into<String>) -> Self {
        Self(Box::new(Details::IllegalAction {
            time,
            robot: robot.into(),
            problem: problem.into(),
        }))
    }

    /// A result that a check rejects.
    pub fn refuted(problem: impl Into<String>) -> Self {
        Self(Box::new(Details::Refuted(problem.into())))
    }

    /// The user stopped the work before the first result.
    pub fn interrupted() -> Self {
        Self(Box::new(Details::Interrupted))
    }

    /// A state that the library's own code should have excluded.
    pub fn internal(problem: impl Into<String>) -> Self {
        Self(Box::new(Details::Internal(problem.into())))
    }

    /// What sort of failure it is.
    pub fn kind(&self) -> ErrorKind {
        match &*self.0 {
            Details::Described { kind, .. } => *kind,
            Details::File { source, .. } if is_path_problem(source) => ErrorKind::Path,
            Details::File { .. } => ErrorKind::Io,
            Details::IllegalAction { .. } => ErrorKind::IllegalAction,
            Details::Refuted(_) => ErrorKind::Refuted,
            Details::Interrupted => ErrorKind::Interrupted,
            Details::Internal(_) => ErrorKind::Internal,
        }
    }

    /// Whether the user stopped the work before the first result.
    pub fn is_interrupted(&self) -> bool {
        self.kind() == ErrorKind::Interrupted
    }

    /// Where it went wrong: file with line and key, or setting. `None` for failures that are at no
    /// such place.
    pub fn place(&self) -> Option<&str> {
        match &*self.0 {
            Details::Described { place, .. } => Some(place),
            Details::File { path, .. } => path.to_str(),
            _ => None,
        }
    }

    /// The problem alone, for a message that has its own place and cure.
    pub fn problem(&self) -> String {
        match &*self.0 {
            Details::Described { problem, .. } | Details::IllegalAction { problem, .. } => {
                problem.clone()
            }
            _ => self.to_string(),
        }
    }

    /// The same error with the error that caused it.
    #[must_use]
    pub fn caused_by(mut self, cause: impl Into<Box<dyn StdError + Send + Sync>>) -> Self {
        if let Details::Described { source, .. } = &mut *self.0 {
            *source = Some(cause.into());
        }
        self
    }

    /// The same error attributed to another place, such as the setting that gives the key.
    #[must_use]
    pub fn at(mut self, elsewhere: &str) -> Self {
        if let Details::Described { place, .. } = &mut *self.0 {
            *place = elsewhere.to_owned();
        }
        self
    }

    /// The same error with its place qualified by the enclosing `whole`, such as the file of an
    /// item.
    #[must_use]
    pub fn inside(mut self, whole: &str) -> Self {
        if let Details::Described { place, .. } = &mut *self.0 {
            *place = format!("{whole}: {place}");
        }
        self
    }

    /// The same error in the words of a program: each setting is replaced by what `spelling` makes
    /// of its name ([`spell_settings`]).
    #[must_use]
    pub fn spell_settings(mut self, spelling: impl Fn(&str) -> String) -> Self {
        if let Details::Described {
            place,
            problem,
            cure,
            ..
        } = &mut *self.0
        {
            for text in [place, problem, cure] {
                *text = spell_settings(text, &spelling);
            }
        }
        self
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &*self.0 {
            Details::Described {
                place,
                problem,
                cure,
                ..
            } => write!(f, "{place}: {problem}\n  cure: {cure}"),
            Details::File {
                action,
                path,
                source,
            } => {
                let cure = io_cure(action, path, source);
                let path = path.display();
                write!(f, "cannot {action} {path}: {source}\n  cure: {cure}")
            }
            Details::IllegalAction {
                time,
                robot,
                problem,
            } => {
                let robot = shown(robot);
                write!(
                    f,
                    "illegal action at t = {time} s by robot `{robot}`: {problem}"
                )
            }
            Details::Refuted(problem) => write!(f, "the checker rejects this run: {problem}"),
            Details::Interrupted => f.write_str("interrupted before the first result"),
            Details::Internal(problem) => write!(
                f,
                "{problem}\n  cure: this is a defect of pickline; please report it with the command \
                 line and the files"
            ),
        }
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl StdError for Error {
    fn source(&self) -> Option<&(dyn StdError + 'static)> {
        match &*self.0 {
            Details::Described { source, .. } => Some(source.as_deref()?),
            Details::File { source, .. } => Some(source),
            _ => None,
        }
    }
}

/// Whether another path, or other rights to it, would help. Everything else is the machine's: a
/// full disk, a device that fails, too many open files.
fn is_path_problem(source: &io::Error) -> bool {
    use io::ErrorKind;
    matches!(
        source.kind(),
        ErrorKind::NotFound
            | ErrorKind::PermissionDenied
            | ErrorKind::AlreadyExists
            | ErrorKind::NotADirectory
            | ErrorKind::IsADirectory
            | ErrorKind::DirectoryNotEmpty
            | ErrorKind::ReadOnlyFilesystem
            | ErrorKind::InvalidFilename
            | ErrorKind::InvalidInput
            | ErrorKind::InvalidData
            | ErrorKind::ExecutableFileBusy
            | ErrorKind::ResourceBusy
            | ErrorKind::NotSeekable
            | ErrorKind::Unsupported
    )
}

/// The text with each setting, a name of at least two letters or digits in single quotes such as
/// `'update_hz'`, replaced by what `spelling` makes of the name. Apostrophes and other quoted texts
/// stay.
pub fn spell_settings(text: &str, spelling: impl Fn(&str) -> String) -> String {
    let mut spelled = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find('\'') {
        let (before, quoted) = (&rest[..at], &rest[at + 1..]);
        spelled.push_str(before);
        let is_name = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        let name = &quoted[..quoted.find(|c| !is_name(c)).unwrap_or(quoted.len())];
        let is_setting = name.len() > 1
            && name.starts_with(|c: char| c.is_ascii_lowercase())
            && !before.ends_with(char::is_alphanumeric)
            && quoted[name.len()..].starts_with('\'');
        if is_setting {
            spelled.push_str(&spelling(name));
            rest = &quoted[name.len() + 1..];
        } else {
            spelled.push('\'');
            rest = quoted;
        }
    }
    spelled + rest
}

/// The cure for a path that cannot be read or written. For a missing file it suggests the file in
/// the same folder with the most similar name.
fn io_cure(action: &str, path: &Path, source: &io::Error) -> String {
    use io::ErrorKind;
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
    fn kinds_tell_a_wrong_path_from_a_full_disk() {
        use io::ErrorKind as System;
        let kind = |source: System| Error::write(Path::new("a"), source.into()).kind();
        for source in [System::NotFound, System::PermissionDenied] {
            assert_eq!(kind(source), ErrorKind::Path, "{source:?}");
        }
        for source in [System::StorageFull, System::OutOfMemory, System::Other] {
            assert_eq!(kind(source), ErrorKind::Io, "{source:?}");
        }
        assert!(Error::interrupted().is_interrupted());
    }

    #[test]
    fn the_error_beneath_is_kept() {
        let number = "x".parse::<f64>().unwrap_err();
        let error = Error::input("a.toml", "not a number", "give one").caused_by(number.clone());
        assert_eq!(error.source().unwrap().to_string(), number.to_string());
        assert_eq!(error.to_string(), "a.toml: not a number\n  cure: give one");
        let error = Error::read(Path::new("a"), io::ErrorKind::NotFound.into());
        assert!(error.source().unwrap().is::<io::Error>());
    }

    #[test]
    fn settings_are_spelled_as_the_program_does_and_other_quotes_stay() {
        let flag = |name: &str| format!("--{}", name.replace('_', "-"));
        for (text, spelled) in [
            (
                "give 'update_hz' or 'flow' 60",
                "give --update-hz or --flow 60",
            ),
            (
                "a robot's arm, the robots' arms",
                "a robot's arm, the robots' arms",
            ),
            ("'two words', 'x' and '", "'two words', 'x' and '"),
            ("'ros2' on '10'", "--ros2 on '10'"),
            ("none", "none"),
        ] {
            assert_eq!(spell_settings(text, flag), spelled);
        }
        let error = Error::usage("'flow'", "0 items/min", "give 'flow' 60");
        assert_eq!(error.kind(), ErrorKind::Usage);
        assert_eq!(
            error.spell_settings(flag).to_string(),
            "--flow: 0 items/min\n  cure: give --flow 60"
        );
    }

    #[test]
    fn shown_cuts_and_escapes() {
        assert_eq!(shown("a\u{7}b"), "a\\u{7}b");
        assert_eq!(shown(&"x".repeat(100)), format!("{}...", "x".repeat(60)));
    }
}
