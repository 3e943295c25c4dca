//! Results as JSON, CSV, tables and pictures, each with its provenance.

// Units are in brackets, [m] or [s], which rustdoc would treat as links.
#![allow(rustdoc::broken_intra_doc_links)]

mod bound;
mod charts;
mod clearance;
mod comparison;
mod description;
pub mod drawing;
mod game;
mod game_table;
mod nfg;
mod optimum;
mod origin;
mod page;
mod palette;
mod provenance;
mod replay;
mod rivals;
mod run;
mod station_picture;
mod sweep;
mod table;
mod throughput;

pub use bound::{BoundReport, CertifiedReport};
#[cfg(feature = "onnx")]
pub use charts::curve_chart;
pub use charts::{COMPARISON_CHARTS, ChartKind, OPTIMUM_CHARTS, SWEEP_CHARTS};
pub use clearance::{ClearanceReport, arms_apart};
pub use comparison::ComparisonReport;
pub use description::{DescriptionReport, description_table};
pub use game::GameReport;
pub use nfg::nfg_text;
pub use optimum::{OptimumReport, ValidationReport};
pub use origin::{is_result_of, origin_comment, with_origin};
pub use page::{comparison_page, optimum_page, sweep_page};
pub use provenance::Provenance;
pub use replay::{check_replay, replay_page};
pub use rivals::RivalsReport;
pub use run::RunReport;
pub use station_picture::station_picture;
pub use sweep::SweepReport;
pub use table::{Table, fixed};
pub use throughput::ThroughputReport;
