//! What every verb hands back.

use crate::charts::ChartKind;
use crate::csv_rows::{Column, CsvRows};
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
                _ => file.rows(self).map(|rows| match self.provenance() {
                    Some(made) => rows.text(made),
                    None => rows.plain_text(),
                }),
            };
            files.extend(content.map(|content| (file.name, content)));
        }
        Ok(files)
    }

    /// The columns of every CSV file that [`VerbReport::files`] returns, by the name of the file
    /// without `.csv`.
    fn tables(&self) -> Vec<(&'static str, Vec<Column>)> {
        let table = |file: &ResultFile<Self>| {
            let name = file.name.strip_suffix(".csv")?;
            Some((name, file.rows(self)?.columns()))
        };
        Self::FILES.iter().filter_map(table).collect()
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
    Csv(fn(&R) -> CsvRows),
    CsvIfAny(fn(&R) -> Option<CsvRows>),
}

impl<R> ResultFile<R> {
    /// The whole report as JSON.
    pub(crate) const fn json(name: &'static str) -> Self {
        let content = Content::Json;
        Self { name, content }
    }

    /// A file of text that every report has.
    pub(crate) const fn text(name: &'static str, text: fn(&R) -> String) -> Self {
        let content = Content::Text(text);
        Self { name, content }
    }

    /// A CSV file that every report has.
    pub(crate) const fn csv(name: &'static str, rows: fn(&R) -> CsvRows) -> Self {
        let content = Content::Csv(rows);
        Self { name, content }
    }

    /// A CSV file that some reports do not have.
    pub(crate) const fn csv_if_any(name: &'static str, rows: fn(&R) -> Option<CsvRows>) -> Self {
        let content = Content::CsvIfAny(rows);
        Self { name, content }
    }

    /// The rows of a CSV file.
    fn rows(&self, report: &R) -> Option<CsvRows> {
        match self.content {
            Content::Csv(rows) => Some(rows(report)),
            Content::CsvIfAny(rows) => rows(report),
            Content::Json | Content::Text(_) => None,
        }
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
