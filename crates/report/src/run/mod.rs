//! One simulated run.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs` | the figures, as printed and written |
//! | `text.rs` | the tables for the terminal |
//! | `csv.rs` | one row for each attempt |

mod csv;
mod report;
mod text;

pub use report::RunReport;

use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

impl VerbReport for RunReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::json("run.json"),
        ResultFile::csv("picks.csv", Self::picks_csv),
    ];

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, shown: &Presentation) -> String {
        self.text(shown)
    }

    fn to_csv(&self) -> String {
        self.picks_csv().text(&self.made)
    }
}
