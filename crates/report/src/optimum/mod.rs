//! The result of a search.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs`, `validation.rs`, `rivals.rs` | the figures: ranking, winner on fresh patterns, other strategies |
//! | `race.rs` | a race of assignments, with how it is shown |
//! | `objective.rs` | how figures of the objective are named |
//! | `text.rs`, `csv.rs`, `charts.rs`, `page.rs` | how they are shown |

mod charts;
mod csv;
mod objective;
mod page;
mod race;
mod report;
mod rivals;
mod text;
mod validation;

pub use race::RaceReport;
pub use report::OptimumReport;
pub use rivals::RivalsReport;
pub use validation::ValidationReport;

use crate::charts::ChartKind;
use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

impl VerbReport for OptimumReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::json("optimize.json"),
        ResultFile::csv("ranking.csv", Self::ranking_csv),
        ResultFile::csv_if_any("strategies.csv", Self::strategies_csv),
    ];
    const CHARTS: &'static [ChartKind<Self>] = charts::CHARTS;

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, shown: &Presentation) -> String {
        self.text(shown)
    }

    fn to_csv(&self) -> String {
        self.ranking_csv().text(&self.made)
    }

    fn to_page(&self, shown: &Presentation) -> Option<String> {
        Some(page::page(self, shown))
    }
}
