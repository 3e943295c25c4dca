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

pub use charts::COMPARISON_CHARTS;
pub use page::comparison_page;
pub use report::ComparisonReport;
