//! Certified bounds.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs` | the bound of a pattern |
//! | `certified.rs` | runs and cases compared with their bound |
//! | `rounding.rs` | rounding that keeps a bound a bound |
//! | `text.rs`, `csv.rs` | how it is shown |

mod certified;
mod csv;
mod report;
mod rounding;
mod text;

pub use certified::CertifiedReport;
pub use report::BoundReport;

pub(crate) use certified::CaseBoundReport;
pub(crate) use rounding::rounded_up;

use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

impl VerbReport for BoundReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::json("bound.json"),
        ResultFile::csv("prices.csv", Self::prices_csv),
    ];

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, _: &Presentation) -> String {
        self.text()
    }

    fn to_csv(&self) -> String {
        self.figures_csv().text(&self.made)
    }
}
