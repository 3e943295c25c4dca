//! Results as JSON, CSV, tables and pictures, each with its provenance.

mod bound;
mod charts;
mod clearance;
mod columns;
mod comparison;
mod csv_rows;
mod description;
pub mod drawing;
mod ends;
mod game;
mod game_theory;
mod optimum;
mod origin;
mod page;
mod palette;
mod presentation;
mod provenance;
mod replay;
mod run;
mod station_picture;
mod sweep;
mod table;
mod throughput;
mod verb_report;

pub use bound::{BoundReport, CertifiedReport};
pub use charts::ChartKind;
#[cfg(feature = "onnx")]
pub use charts::curve_chart;
pub use clearance::{ClearanceReport, arms_apart};
pub use comparison::ComparisonReport;
pub use description::DescriptionReport;
pub use game::{GameReport, nfg_text};
pub use optimum::{OptimumReport, RivalsReport, ValidationReport};
pub use origin::{is_result_of, origin_comment, with_origin};
pub use presentation::Presentation;
pub use provenance::Provenance;
pub use replay::{check_replay, replay_page};
pub use run::RunReport;
pub use station_picture::station_picture;
pub use sweep::SweepReport;
pub use table::{Table, fixed};
pub use throughput::ThroughputReport;
pub use verb_report::{ResultFile, VerbReport, json_text};
