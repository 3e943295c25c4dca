//! A trained policy.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs` | how the policy was trained and what it picks |
//! | `text.rs`, `csv.rs` | how it is shown; its chart is in `charts/curve.rs` |

mod csv;
mod report;
mod text;

pub use csv::learning_curve_csv;
pub use report::TrainingReport;

use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

/// The result files are named by their endings: they stand next to the policy. The learning curve
/// as CSV is not one of them, because it belongs to the checkpoint and is written with it.
impl VerbReport for TrainingReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::json("json"),
        ResultFile::text("svg", Self::curve_svg),
    ];

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, _: &Presentation) -> String {
        self.text()
    }

    fn to_csv(&self) -> String {
        learning_curve_csv(&self.curve)
    }
}
