//! What every verb hands back.

use crate::charts::ChartKind;
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use pickline::error::{Error, Result};
use serde::Serialize;

/// The result of a verb, in every form in which it is printed and written. As JSON it is what it
/// serialises as.
pub trait VerbReport: Serialize + Sized + 'static {
    /// The result files, in the order in which they are written.
    const FILES: &'static [ResultFile<Self>];

    /// The charts, the main one first; none for a report that has no charts.
    const CHARTS: &'static [ChartKind<Self>] = &[];

    /// Where the result comes from; `None` if nothing was simulated.
    fn provenance(&self) -> Option<&Provenance>;

    /// The report as text for the terminal.
    fn to_table(&self, shown: &Presentation) -> String;

    /// The main table as CSV.
    fn to_csv(&self) -> String;

    /// The report as a page, if it has one.
    fn to_page(&self, _shown: &Presentation) -> Option<String> {
        None
    }

    /// The content of every result file, by name.
    ///
    /// # Errors
    /// As for [`json_text`].
    fn files(&self) -> Result<Vec<(&'static str, String)>> {
        let mut files = Vec::new();
        for file in Self::FILES {
            let content = match file.content {
                Content::Json => Some(json_text(self)?),
                Content::Text(text) => Some(text(self)),
                Content::IfAny(text) => text(self),
            };
            files.extend(content.map(|content| (file.name, content)));
        }
        Ok(files)
    }

    /// The names of all files that [`VerbReport::files`] may return, known before the work.
    fn file_names() -> Vec<&'static str> {
        Self::FILES.iter().map(|file| file.name).collect()
    }
}

/// A result file of the report `R`: its name, and how its content follows from the report.
#[derive(Debug)]
pub struct ResultFile<R> {
    name: &'static str,
    content: Content<R>,
}

#[derive(Debug)]
enum Content<R> {
    Json,
    Text(fn(&R) -> String),
    IfAny(fn(&R) -> Option<String>),
}

impl<R> ResultFile<R> {
    /// The whole report as JSON.
    pub(crate) const fn json(name: &'static str) -> Self {
        let content = Content::Json;
        Self { name, content }
    }

    /// A file that every report has.
    pub(crate) const fn text(name: &'static str, text: fn(&R) -> String) -> Self {
        let content = Content::Text(text);
        Self { name, content }
    }

    /// A file that some reports do not have.
    pub(crate) const fn if_any(name: &'static str, text: fn(&R) -> Option<String>) -> Self {
        let content = Content::IfAny(text);
        Self { name, content }
    }
}

/// `value` as indented JSON with a trailing newline.
///
/// # Errors
/// Never for the reports of this crate; returned so that nothing panics.
pub fn json_text(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Error::internal(format!("cannot write the result as JSON: {error}")))?;
    Ok(text + "\n")
}
