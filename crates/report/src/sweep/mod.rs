//! A sweep: figures over one varied quantity, and up to which value everything is picked.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs` | the figures |
//! | `words.rs` | limits and recommendations in words |
//! | `text.rs`, `csv.rs`, `charts.rs`, `page.rs` | how they are shown |

mod charts;
mod csv;
mod page;
mod report;
mod text;
mod words;

pub use charts::SWEEP_CHARTS;
pub use page::sweep_page;
pub use report::SweepReport;
