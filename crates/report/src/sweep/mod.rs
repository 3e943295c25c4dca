//! A sweep: figures over one varied quantity, and up to which value everything is picked.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs` | the figures |
//! | `thresholds.rs` | the thresholds of detections for a wanted purity |
//! | `words.rs` | limits and recommendations in words |
//! | `text.rs`, `csv.rs`, `charts.rs`, `page.rs` | how they are shown; of charts, `purity_chart.rs` has one and `chart_parts.rs` what several use |

mod chart_parts;
mod charts;
mod csv;
mod page;
mod purity_chart;
mod report;
mod text;
mod thresholds;
mod words;

pub(crate) use chart_parts::method_words;
pub use report::SweepReport;

use crate::charts::ChartKind;
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

impl VerbReport for SweepReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::csv("sweep.csv", Self::points_csv),
        ResultFile::csv_if_any("purity.csv", Self::purity_csv),
        ResultFile::csv_if_any("thresholds.csv", Self::thresholds_csv),
        ResultFile::csv_if_any("classes.csv", Self::classes_csv),
        ResultFile::json("sweep.json"),
    ];
    const CHARTS: &'static [ChartKind<Self>] = charts::CHARTS;

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, _: &Presentation) -> String {
        self.text()
    }

    fn to_csv(&self) -> String {
        self.points_csv().text(&self.made)
    }

    fn to_page(&self, _: &Presentation) -> Option<String> {
        Some(page::page(self))
    }
}
