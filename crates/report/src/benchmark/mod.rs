//! Entrants judged on the benchmark.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs` | the figures |
//! | `text.rs`, `csv.rs` | how they are shown |

mod csv;
mod report;
mod text;

pub use report::BenchmarkReport;

use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

impl VerbReport for BenchmarkReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::json("benchmark.json"),
        ResultFile::csv("ranking.csv", Self::ranking_csv),
        ResultFile::csv("runs.csv", Self::runs_csv),
    ];

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, shown: &Presentation) -> String {
        self.text(shown)
    }

    fn to_csv(&self) -> String {
        self.runs_csv().text(&self.made)
    }
}
