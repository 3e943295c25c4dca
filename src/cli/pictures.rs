//! The pictures of a result: a page, a chart.

use super::args::Pictures;
use crate::error::Result;
use crate::files;
use crate::report::{ChartKind, Provenance};
use std::path::Path;

/// The chart that was asked for among `kinds`, once everything asked of pictures is
/// known to be possible: a long computation must not end in a slip of the pen.
///
/// # Errors
/// An unknown chart, a file that cannot be written, one file for two pictures.
pub fn checked<R>(
    pictures: &Pictures,
    kinds: &'static [ChartKind<R>],
) -> Result<&'static ChartKind<R>> {
    files::check_target(pictures.html.as_deref())?;
    files::check_target(pictures.svg.as_deref())?;
    files::check_apart(&[], &pictures.files())?;
    ChartKind::named(kinds, pictures.chart.as_deref())
}

impl Pictures {
    /// Where they go.
    pub fn files(&self) -> [(&'static str, Option<&Path>); 2] {
        [
            ("--html", self.html.as_deref()),
            ("--svg", self.svg.as_deref()),
        ]
    }

    /// Writes the pictures of `report` that were asked for.
    ///
    /// # Errors
    /// A report that has nothing for `chart`, a file that cannot be written.
    pub fn write<R>(
        &self,
        chart: &ChartKind<R>,
        report: &R,
        made: &Provenance,
        page: impl FnOnce() -> String,
    ) -> Result<()> {
        // Drawn before either is written, so that nothing is left of a call that failed.
        let svg = match &self.svg {
            Some(file) => Some((file, chart.svg(report, made)?)),
            None => None,
        };
        if let Some(file) = &self.html {
            files::write_whole(file, page().as_bytes())?;
        }
        if let Some((file, svg)) = svg {
            files::write_whole(file, svg.as_bytes())?;
        }
        Ok(())
    }
}
