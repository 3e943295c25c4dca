//! A comparison of methods: the paper's Tables 2 and 3 for the user's own line.
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

pub use report::ComparisonReport;

use crate::charts::ChartKind;
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

impl VerbReport for ComparisonReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::csv("throughput.csv", Self::throughput_csv),
        ResultFile::csv("picked_time.csv", Self::picked_time_csv),
        ResultFile::csv("picking_rate.csv", Self::picking_rate_csv),
        ResultFile::csv("runs.csv", Self::runs_csv),
        ResultFile::csv_if_any("purity.csv", Self::purity_csv),
        ResultFile::csv_if_any("classes.csv", Self::classes_csv),
        ResultFile::json("compare.json"),
    ];
    const CHARTS: &'static [ChartKind<Self>] = charts::CHARTS;

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, _: &Presentation) -> String {
        self.text()
    }

    fn to_csv(&self) -> String {
        self.picking_rate_csv().text(&self.made)
    }

    fn to_page(&self, _: &Presentation) -> Option<String> {
        Some(page::page(self))
    }
}
