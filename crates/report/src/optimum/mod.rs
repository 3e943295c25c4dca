//! The result of a search.
//!
//! | file | what it is |
//! |---|---|
//! | `report.rs`, `validation.rs`, `rivals.rs` | the figures: ranking, winner on fresh patterns, other strategies |
//! | `objective.rs` | how figures of the objective are named |
//! | `text.rs`, `csv.rs`, `charts.rs`, `page.rs` | how they are shown |

mod charts;
mod csv;
mod objective;
mod page;
mod report;
mod rivals;
mod text;
mod validation;

pub use charts::OPTIMUM_CHARTS;
pub use page::optimum_page;
pub use report::OptimumReport;
pub use rivals::RivalsReport;
pub use validation::ValidationReport;
