//! The library's single error type.
//!
//! Every message names the place (file and line, key or setting), the value found there and the
//! cure, so that a user never has to guess what to change. [`Error::kind`] says what sort of
//! failure it is.
//!
//! A message writes a setting, such as an option of a search, in single quotes. The names are those
//! of the library: `'flow'` is set by `with_flow`, and `'no_bound'` is `with_bound(false)`. An option
//! that shares its name with another has a prefix: `'sweep_axis'` is `SweepOptions::with_axis`,
//! `'mqtt_ca'` a file of the MQTT transport. A program that spells them otherwise passes its errors
//! through [`Error::spell_settings`].

mod details;
mod kind;
mod path_cure;
mod settings;
mod wording;

pub use kind::ErrorKind;
pub use path_cure::nearest_file;
pub use settings::spell_settings;
pub use wording::{
    counted, grouped, known_names, listed, nearest, rounded, shown, shown_number, significant,
};

use details::{Details, ErrorContent};
use std::error::Error as StdError;
use std::fmt;
use std::io;
use std::path::Path;

/// Result of every fallible function in this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Everything that can go wrong: a kind, a message with place, problem and cure, and the error
/// beneath it where there is one.
pub struct Error(Box<ErrorContent>);

impl Error {
    /// Data that is not allowed ([`ErrorKind::Input`]): `place` says where in which file or part of
    /// the data, `problem` names the value, `cure` says what to change.
    pub fn input(
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::described(ErrorKind::Input, place.into(), problem.into(), cure.into())
    }

    /// A setting that is not allowed ([`ErrorKind::Usage`]). `place` names it in single quotes, with
    /// its value if that is a long text; `problem` names the value, `cure` says what to change.
    pub fn usage(
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::described(ErrorKind::Usage, place.into(), problem.into(), cure.into())
    }

    /// A path that cannot be used as given ([`ErrorKind::Path`]), although the operating system
    /// would use it or does not say why it cannot: a file that must not be replaced, a device that
    /// should be a file. `place` is the path or the setting that gives it.
    pub fn path(
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::described(ErrorKind::Path, place.into(), problem.into(), cure.into())
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

    fn of(details: Details) -> Self {
        Self(Box::new(ErrorContent {
            details,
            cause: None,
        }))
    }

    fn described(kind: ErrorKind, place: String, problem: String, cure: String) -> Self {
        Self::of(Details::Described {
            kind,
            place,
            problem,
            cure,
        })
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
        Self::of(Details::File {
            action,
            path: path.to_owned(),
            source,
        })
    }

    /// An action that the model forbids, chosen at `time` [s] for the robot of that name.
    pub fn illegal_action(
        (time, robot): (f64, &str),
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::of(Details::IllegalAction {
            time,
            robot: robot.into(),
            problem: problem.into(),
            cure: cure.into(),
        })
    }

    /// A result that a check rejects.
    pub fn refuted(problem: impl Into<String>) -> Self {
        Self::of(Details::Refuted(problem.into()))
    }

    /// The result at `place` violates what it promises, otherwise than a run.
    pub fn contradiction(
        place: impl Into<String>,
        problem: impl Into<String>,
        cure: impl Into<String>,
    ) -> Self {
        Self::described(
            ErrorKind::Refuted,
            place.into(),
            problem.into(),
            cure.into(),
        )
    }

    /// The user stopped the work before the first result.
    pub fn interrupted() -> Self {
        Self::of(Details::Interrupted)
    }

    /// The shard of the work that was to be done is done; there is no result of the whole.
    pub fn sharded() -> Self {
        Self::of(Details::Sharded)
    }

    /// A state that the library's own code should have excluded.
    pub fn internal(problem: impl Into<String>) -> Self {
        Self::of(Details::Internal(problem.into()))
    }

    /// What sort of failure it is.
    pub fn kind(&self) -> ErrorKind {
        match &self.0.details {
            Details::Described { kind, .. } => *kind,
            Details::File { source, .. } => ErrorKind::of_file(source),
            Details::IllegalAction { .. } => ErrorKind::IllegalAction,
            Details::Refuted(_) => ErrorKind::Refuted,
            Details::Interrupted => ErrorKind::Interrupted,
            Details::Sharded => ErrorKind::Sharded,
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
        match &self.0.details {
            Details::Described { place, .. } => Some(place),
            Details::File { path, .. } => path.to_str(),
            _ => None,
        }
    }

    /// The problem alone, for a message that has its own place and cure.
    pub fn problem(&self) -> String {
        match &self.0.details {
            Details::Described { problem, .. } | Details::IllegalAction { problem, .. } => {
                problem.clone()
            }
            _ => self.to_string(),
        }
    }

    /// What to do about it, without the rest of the message; empty if the message does not say it in words
    /// of its own.
    pub fn cure(&self) -> &str {
        match &self.0.details {
            Details::Described { cure, .. } | Details::IllegalAction { cure, .. } => cure,
            _ => "",
        }
    }

    /// The same error with the error that caused it, which replaces any earlier cause.
    #[must_use]
    pub fn caused_by(mut self, cause: impl Into<Box<dyn StdError + Send + Sync>>) -> Self {
        self.0.cause = Some(cause.into());
        self
    }

    /// The same error about data that a setting of the caller made, so that the caller has to change
    /// the setting: [`ErrorKind::Input`] becomes [`ErrorKind::Usage`].
    #[must_use]
    pub fn into_usage(self) -> Self {
        self.with_kind(ErrorKind::Input, ErrorKind::Usage)
    }

    /// The same error about a setting that is content of a file: [`ErrorKind::Usage`] becomes
    /// [`ErrorKind::Input`].
    #[must_use]
    pub fn into_input(self) -> Self {
        self.with_kind(ErrorKind::Usage, ErrorKind::Input)
    }

    /// The same error with the kind `to` if its kind is `from`.
    fn with_kind(mut self, from: ErrorKind, to: ErrorKind) -> Self {
        if let Details::Described { kind, .. } = &mut self.0.details
            && *kind == from
        {
            *kind = to;
        }
        self
    }

    /// The same error attributed to another place, such as the setting that gives the key.
    #[must_use]
    pub fn at(mut self, elsewhere: &str) -> Self {
        if let Details::Described { place, .. } = &mut self.0.details {
            *place = elsewhere.to_owned();
        }
        self
    }

    /// The same error with its place qualified by the enclosing `whole`, such as the file of an
    /// item.
    #[must_use]
    pub fn inside(mut self, whole: &str) -> Self {
        if let Details::Described { place, .. } = &mut self.0.details {
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
        } = &mut self.0.details
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
        fmt::Display::fmt(&self.0.details, f)
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0, f)
    }
}

impl StdError for Error {
    fn source(&self) -> Option<&(dyn StdError + 'static)> {
        match (&self.0.cause, &self.0.details) {
            (Some(cause), _) => Some(&**cause),
            (None, Details::File { source, .. }) => Some(source),
            (None, _) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn kinds_distinguish_a_wrong_path_from_a_full_disk() {
        use io::ErrorKind as System;
        let kind = |source: System| Error::write(Path::new("a"), source.into()).kind();
        for source in [System::NotFound, System::PermissionDenied] {
            assert_eq!(kind(source), ErrorKind::Path, "{source:?}");
        }
        for source in [System::StorageFull, System::Other] {
            assert_eq!(kind(source), ErrorKind::Io, "{source:?}");
        }
        assert_eq!(kind(System::OutOfMemory), ErrorKind::Resources);
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
        for error in [
            error,
            Error::illegal_action((1.0, "r1"), "a", "b"),
            Error::refuted("a"),
            Error::interrupted(),
            Error::internal("a"),
        ] {
            let message = error.to_string();
            let error = error.caused_by(number.clone());
            assert_eq!(error.source().unwrap().to_string(), number.to_string());
            assert_eq!(error.to_string(), message);
        }
    }

    /// The limits on files are the machine's: another path does not help.
    #[cfg(unix)]
    #[test]
    fn too_many_open_files_are_a_lack_of_resources() {
        for code in [23, 24] {
            let source = io::Error::from_raw_os_error(code);
            let error = Error::read(Path::new("src"), source);
            assert_eq!(error.kind(), ErrorKind::Resources);
            let message = error.to_string();
            assert!(message.contains("cure: close other programs"), "{message}");
        }
    }

    #[test]
    fn a_path_through_a_file_names_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        std::fs::write(&file, "").unwrap();
        let cure = format!("cure: {} is not a folder", file.display());
        for path in [file.clone(), file.join("a"), file.join("a/b")] {
            let message = Error::write(&path, io::ErrorKind::NotADirectory.into()).to_string();
            assert!(message.contains(&cure), "{message}");
        }
        let none = Error::write(Path::new("none"), io::ErrorKind::NotADirectory.into());
        assert!(none.to_string().contains("check that the path exists"));
    }

    #[test]
    fn who_gave_a_value_decides_the_kind() {
        let kinds = |error: fn() -> Error| {
            [
                error(),
                error().into_usage(),
                error().into_input(),
                error().inside("a").at("b"),
            ]
            .map(|error| error.kind())
        };
        use ErrorKind::{Input, Path, Resources, Usage};
        let all: [(fn() -> Error, _); 4] = [
            (|| Error::input("a", "b", "c"), [Input, Usage, Input, Input]),
            (|| Error::usage("a", "b", "c"), [Usage, Usage, Input, Usage]),
            (|| Error::path("a", "b", "c"), [Path; 4]),
            (|| Error::resources("a", "b", "c"), [Resources; 4]),
        ];
        for (error, expected) in all {
            assert_eq!(kinds(error), expected);
        }
    }

    #[test]
    fn the_settings_of_place_and_cure_are_spelled() {
        let flag = |name: &str| format!("--{name}");
        let error = Error::usage("'flow'", "0 items/min", "give 'flow' 60");
        assert_eq!(error.kind(), ErrorKind::Usage);
        assert_eq!(
            error.spell_settings(flag).to_string(),
            "--flow: 0 items/min\n  cure: give --flow 60"
        );
    }
}
