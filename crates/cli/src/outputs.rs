//! The output files of a call: checked before the work begins, written after the result has
//! been printed.
//!
//! This module guards every output of every verb: no output is also an input or another
//! output, none replaces a file that is not a result of the same verb without `--force`,
//! and every folder is tested by writing to it.

use super::args::{Common, OutputFormat};
use super::flags::flag;
use super::session::Session;
use pickline::error::{Error, Result};
use pickline::files::{self, Named};
use pickline::pattern::is_pattern_name;
use pickline_report::{Presentation, VerbReport, is_result_of, json_text};
use std::path::{Path, PathBuf};

/// How reports are shown: the whole of them, and settings by their flags.
pub(crate) const WHOLE: Presentation = Presentation::whole(flag);

/// Larger files are not results of this program [bytes].
const LARGEST_RESULT: u64 = 1 << 30;

/// Checks everything that a call of `verb` writes, before any of it is written.
///
/// # Errors
/// A file that cannot be written, that is also an input or another output, or that already
/// exists and is not a result of `verb`, unless `force` is set.
pub(crate) fn check(verb: &str, force: bool, read: &Named, written: &Named) -> Result<()> {
    for file in written.iter().filter_map(|(_, file)| *file) {
        files::check_target(file)?;
    }
    // A policy's weights may be in separate files next to it.
    let mut weights = Vec::new();
    for (flag, file) in read {
        let file = file.filter(|file| file.is_file());
        let beside = file.map(pickline::strategies::weight_files);
        weights.extend(beside.into_iter().flatten().map(|file| (*flag, file)));
    }
    check_not_inputs(read, written)?;
    let weights = weights.iter().map(|(flag, file)| (*flag, Some(&**file)));
    let read: Vec<_> = read.iter().copied().chain(weights).collect();
    files::check_apart(&read, written)?;
    for (flag, file) in written {
        let Some(file) = file else { continue };
        if !force {
            check_own(verb, flag, file)?;
        }
        files::try_target(file)?;
    }
    Ok(())
}

/// Checks that no output goes into a folder of input patterns: the next call would read it
/// as one of them.
///
/// # Errors
/// The first such file.
fn check_not_inputs(read: &Named, written: &Named) -> Result<()> {
    let real = |path: &Path| std::fs::canonicalize(path).ok();
    let folders = read.iter().filter_map(|(flag, path)| {
        let folder = path.filter(|path| path.is_dir())?;
        Some((flag, folder, real(folder)?))
    });
    for (from, folder, folder_real) in folders {
        for (flag, file) in written {
            let Some(file) = file.filter(|file| is_pattern_name(file)) else {
                continue;
            };
            if real(files::folder_of(file)).as_ref() == Some(&folder_real) {
                return Err(Error::usage(
                    *flag,
                    format!(
                        "{} would be among the patterns in {from} {}",
                        file.display(),
                        folder.display()
                    ),
                    "use another folder",
                ));
            }
        }
    }
    Ok(())
}

/// Checks that `file` may be replaced by a result of `verb`. An empty file may always be
/// replaced.
fn check_own(verb: &str, flag: &str, file: &Path) -> Result<()> {
    let Ok(about) = std::fs::metadata(file) else {
        return Ok(());
    };
    if !about.is_file() || about.len() == 0 {
        return Ok(());
    }
    let refused = |problem: &str| {
        Err(Error::path(
            flag,
            format!("{} {problem}", file.display()),
            "name another file, or add --force to overwrite it",
        ))
    };
    if about.permissions().readonly() {
        return refused("exists and is read-only");
    }
    let content = match about.len() {
        ..=LARGEST_RESULT => std::fs::read(file).unwrap_or_default(),
        _ => Vec::new(),
    };
    if is_result_of(&content, verb) {
        return Ok(());
    }
    refused(&format!("exists and was not written by `pickline {verb}`"))
}

impl Common {
    /// Checks everything that a call of `verb` writes: `written`, and the result files of its
    /// report `R` in the folder for them.
    ///
    /// # Errors
    /// As for [`check`]; a folder that cannot be created.
    pub(crate) fn check_outputs<R: VerbReport>(
        &self,
        verb: &str,
        read: &Named,
        written: &Named,
    ) -> Result<()> {
        if let Some(folder) = &self.out {
            files::check_folder(folder)?;
        }
        // A folder that does not exist yet has no files to protect.
        let out = self.out.iter();
        let out: Vec<PathBuf> = out
            .flat_map(|folder| R::file_names().into_iter().map(|name| folder.join(name)))
            .collect();
        let there = out.iter().filter(|file| files::folder_of(file).exists());
        let there = there.map(|file| ("--out", Some(file.as_path())));
        let all: Vec<_> = out
            .iter()
            .map(|file| ("--out", Some(file.as_path())))
            .collect();
        files::check_apart(&all, written)?;
        // Another output may go into the folder that will be created.
        let made = |file: &Path| {
            let parts = |path: &Path| path.components().collect::<PathBuf>();
            let out = self.out.as_ref().filter(|folder| !folder.exists());
            out.is_some_and(|folder| parts(folder) == parts(files::folder_of(file)))
        };
        let written = written.iter().copied();
        let written = written.filter(|(_, file)| !file.is_some_and(made));
        let written: Vec<_> = written.chain(there).collect();
        check(verb, self.force, read, &written)
    }

    /// Prints `report` in the chosen format, then writes its result files and `more`.
    ///
    /// # Errors
    /// The first output that cannot be written; all others are written.
    pub(crate) fn deliver<R: VerbReport>(
        &self,
        session: &Session,
        report: &R,
        shown: &Presentation,
        more: Outputs,
    ) -> Result<()> {
        let text = rendered(report, self.format, shown)?;
        self.deliver_as(session, &text, report, more)
    }

    /// The same with `text` printed instead of the report.
    ///
    /// # Errors
    /// As for [`Common::deliver`].
    pub(crate) fn deliver_as(
        &self,
        session: &Session,
        text: &str,
        report: &impl VerbReport,
        mut more: Outputs,
    ) -> Result<()> {
        if let Some(folder) = &self.out {
            more.folder = Some(folder.clone());
            for (name, content) in report.files()? {
                more.add(Some(&folder.join(name)), || content);
            }
        }
        more.deliver(session, text)
    }
}

/// `report` in `format`.
///
/// # Errors
/// As for [`pickline_report::json_text`].
pub(crate) fn rendered<R: VerbReport>(
    report: &R,
    format: OutputFormat,
    shown: &Presentation,
) -> Result<String> {
    Ok(match format {
        OutputFormat::Table => report.to_table(shown),
        OutputFormat::Json => json_text(report)?,
        OutputFormat::Csv => report.to_csv(),
    })
}

/// The files of a call, until they are written.
#[derive(Default)]
pub(crate) struct Outputs {
    files: Vec<(PathBuf, Vec<u8>)>,
    folder: Option<PathBuf>,
    /// The first content that could not be made.
    failure: Option<Error>,
}

impl Outputs {
    /// Adds `content` for `file`, unless that is `None`.
    pub(crate) fn add(&mut self, file: Option<&Path>, content: impl FnOnce() -> String) {
        if let Some(file) = file {
            self.files.push((file.to_owned(), content().into_bytes()));
        }
    }

    /// Adds `content` for `file`, unless that is `None`. If it cannot be made, the error is
    /// returned after everything else is written.
    pub(crate) fn try_add(
        &mut self,
        file: Option<&Path>,
        content: impl FnOnce() -> Result<String>,
    ) {
        if file.is_none() {
            return;
        }
        match content() {
            Ok(content) => self.add(file, || content),
            Err(error) => self.failure = self.failure.take().or(Some(error)),
        }
    }

    /// Prints `text`, then writes the files, so that the result is visible even if the disk
    /// is full.
    ///
    /// # Errors
    /// The first output that cannot be written; all others are written.
    pub(crate) fn deliver(self, session: &Session, text: &str) -> Result<()> {
        let printed = session.print(text.as_bytes());
        printed.and(self.write())
    }

    /// Writes the files.
    ///
    /// # Errors
    /// The first file that cannot be written, or else made; all others are written.
    pub(crate) fn write(self) -> Result<()> {
        // The folder is created only now, so that a failed call leaves nothing behind.
        let made = self.folder.as_deref().map_or(Ok(()), files::make_folder);
        let write = |(file, content): &(PathBuf, Vec<u8>)| files::write_whole(file, content);
        let written = self.files.iter().map(write);
        // Try every file before returning the first error.
        std::iter::once(made)
            .chain(written)
            .fold(Ok(()), Result::and)
            .and(self.failure.map_or(Ok(()), Err))
    }
}
