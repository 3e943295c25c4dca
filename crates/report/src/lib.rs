//! Results as JSON, CSV, tables and pictures, each with its provenance.

mod bound;
mod charts;
mod clearance;
mod comparison;
mod description;
pub mod drawing;
mod game;
mod optimum;
mod origin;
mod page;
mod palette;
mod provenance;
mod replay;
mod run;
mod station_picture;
mod sweep;
mod table;
mod throughput;

pub use bound::{BoundReport, CertifiedReport};
pub use charts::ChartKind;
#[cfg(feature = "onnx")]
pub use charts::curve_chart;
pub use clearance::{ClearanceReport, arms_apart};
pub use comparison::{COMPARISON_CHARTS, ComparisonReport, comparison_page};
pub use description::{DescriptionReport, description_table};
pub use game::{GameReport, nfg_text};
pub use optimum::{OPTIMUM_CHARTS, OptimumReport, RivalsReport, ValidationReport, optimum_page};
pub use origin::{is_result_of, origin_comment, with_origin};
pub use provenance::{Provenance, station_hash};
pub use replay::{check_replay, replay_page};
pub use run::RunReport;
pub use station_picture::station_picture;
pub use sweep::{SWEEP_CHARTS, SweepReport, sweep_page};
pub use table::{Table, fixed};
pub use throughput::ThroughputReport;
