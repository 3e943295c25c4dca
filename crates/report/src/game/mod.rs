//! The result of solving a line's game.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs`, `solved.rs` | the figures, and how they follow from the game |
//! | `text.rs`, `csv.rs`, `nfg.rs` | how they are shown, and the game for Gambit |

mod csv;
mod nfg;
mod report;
mod solved;
mod text;

pub use nfg::nfg_text;
pub use report::GameReport;

use crate::presentation::Presentation;
use crate::provenance::Provenance;
use crate::verb_report::{ResultFile, VerbReport};

impl VerbReport for GameReport {
    const FILES: &'static [ResultFile<Self>] = &[
        ResultFile::json("game.json"),
        ResultFile::csv("payoffs.csv", Self::payoffs_csv),
        ResultFile::text("game.nfg", |report| report.nfg.clone()),
    ];

    fn provenance(&self) -> Option<&Provenance> {
        Some(&self.made)
    }

    fn to_table(&self, shown: &Presentation) -> String {
        self.text(shown)
    }

    fn to_csv(&self) -> String {
        self.payoffs_csv().text(&self.made)
    }
}
