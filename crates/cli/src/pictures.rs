//! The pictures of a result: an HTML page and an SVG chart.

use super::args::Pictures;
use super::outputs::Outputs;
use pickline::error::{Error, Result};
use pickline_report::{ChartKind, Presentation, VerbReport};
use std::path::Path;

/// Looks up the requested chart of the report `R`, before the work begins.
///
/// # Errors
/// An unknown chart.
pub(crate) fn checked<R: VerbReport>(pictures: &Pictures) -> Result<&'static ChartKind<R>> {
    ChartKind::named(R::CHARTS, pictures.chart.as_deref()).map_err(|error| error.at(CHART))
}

/// The error for a report that lacks the data for `chart`.
pub(crate) fn missing<R>(chart: &ChartKind<R>) -> Error {
    chart.missing().at(CHART)
}

const CHART: &str = "--chart";

impl Pictures {
    /// The flags and output files of the pictures.
    pub(crate) fn files(&self) -> [(&'static str, Option<&Path>); 2] {
        [
            ("--html", self.html.as_deref()),
            ("--svg", self.svg.as_deref()),
        ]
    }

    /// The requested pictures of `report`.
    pub(crate) fn draw<R: VerbReport>(
        &self,
        chart: &ChartKind<R>,
        report: &R,
        shown: &Presentation,
    ) -> Outputs {
        let mut outputs = Outputs::default();
        if let Some(page) = self.html.as_ref().and_then(|_| report.to_page(shown)) {
            outputs.add(self.html.as_deref(), || page);
        }
        outputs.try_add(self.svg.as_deref(), || {
            let svg = chart.svg(report, report.provenance());
            svg.map_err(|error| error.at(CHART))
        });
        outputs
    }
}
