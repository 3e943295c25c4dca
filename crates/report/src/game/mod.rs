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
