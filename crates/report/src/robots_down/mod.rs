//! What a line still does with one of its robots halted.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs` | the figures |
//! | `text.rs`, `csv.rs`, `charts.rs`, `page.rs` | how they are shown |

mod charts;
mod csv;
mod page;
mod report;
mod text;

pub use report::RobotsDownReport;

use crate::charts::ChartKind;
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

impl VerbReport for RobotsDownReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::csv("sweep.csv", Self::points_csv),
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
