//! The fit of a line's travel-time laws.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs` | the figures, as printed and written |
//! | `text.rs` | the tables for the terminal |
//! | `csv.rs` | one row for each parameter |
//! | `charts.rs` | residuals and times by the length of the way |

mod charts;
mod csv;
mod report;
mod text;

pub use report::FitReport;

use crate::charts::ChartKind;
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

impl VerbReport for FitReport {
    const FILES: &'static [ResultFile<Self>] = &[];

    const CHARTS: &'static [ChartKind<Self>] = charts::CHARTS;

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, shown: &Presentation) -> String {
        text::text(self, shown)
    }

    fn to_csv(&self) -> String {
        csv::csv(self)
    }
}
