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

pub use certified::{CaseBoundReport, CertifiedReport};
pub use report::BoundReport;

pub(crate) use rounding::rounded_up;
