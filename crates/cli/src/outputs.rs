//! The output files of a call: checked before the work begins, written after the result has
//! been printed. [`OutputProtection`] has the rules.

use super::args::{Common, OutputFormat};
use super::flags::flag;
use super::session::Session;
use pickline::error::{Error, Result};
use pickline::files::{self, Named};
use pickline_report::{OutputProtection, Presentation, VerbReport, json_text};
use std::path::{Path, PathBuf};

/// How reports are shown: the whole of them, and settings by their flags.
pub(crate) const WHOLE: Presentation = Presentation::whole(flag);

impl Common {
    /// Checks everything that a call of `verb` writes: `written`, and the result files of its
    /// report `R` in the folder for them.
    ///
    /// # Errors
    /// As for [`OutputProtection::check_report`].
    pub(crate) fn check_outputs<R: VerbReport>(
        &self,
        verb: &str,
        read: &Named,
        written: &Named,
    ) -> Result<()> {
        let protection = OutputProtection::of(verb).with_force(self.force);
        protection.check_report::<R>(self.out.as_deref(), read, written)
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
