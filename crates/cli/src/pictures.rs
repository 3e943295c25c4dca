//! The pictures of a result: an HTML page and an SVG chart.

use super::args::Pictures;
use super::outputs::Outputs;
use pickline::error::Result;
use pickline_report::{ChartKind, Provenance};
use std::path::Path;

/// Looks up the requested chart in `kinds`, before the work begins.
///
/// # Errors
/// An unknown chart.
pub fn checked<R>(
    pictures: &Pictures,
    kinds: &'static [ChartKind<R>],
) -> Result<&'static ChartKind<R>> {
    ChartKind::named(kinds, pictures.chart.as_deref())
}

impl Pictures {
    /// The flags and output files of the pictures.
    pub fn files(&self) -> [(&'static str, Option<&Path>); 2] {
        [
            ("--html", self.html.as_deref()),
            ("--svg", self.svg.as_deref()),
        ]
    }

    /// Adds the requested pictures of `report` to `outputs`.
    ///
    /// # Errors
    /// A report without data for `chart`.
    pub fn draw<R>(
        &self,
        outputs: &mut Outputs,
        chart: &ChartKind<R>,
        report: &R,
        made: &Provenance,
        page: impl FnOnce() -> String,
    ) -> Result<()> {
        outputs.add(self.html.as_deref(), page);
        if self.svg.is_some() {
            let svg = chart.svg(report, made)?;
            outputs.add(self.svg.as_deref(), || svg);
        }
        Ok(())
    }
}
