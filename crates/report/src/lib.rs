//! Results as JSON, CSV, tables and pictures, each with its provenance.

mod bound;
mod charts;
mod classes;
mod clearance;
mod columns;
mod comparison;
mod csv_rows;
mod description;
pub mod drawing;
mod ends;
mod fit;
mod game;
mod game_theory;
mod optimum;
mod origin;
mod page;
mod palette;
mod presentation;
mod protection;
mod provenance;
mod purity;
mod replay;
mod run;
mod station_picture;
mod sweep;
mod table;
mod throughput;
#[cfg(feature = "onnx")]
mod training;
mod verb_report;
mod verification;

pub use bound::{BoundReport, CertifiedReport};
pub use charts::ChartKind;
pub use classes::ClassReport;
pub use clearance::{ClearanceReport, arms_apart};
pub use comparison::ComparisonReport;
pub use description::DescriptionReport;
pub use fit::FitReport;
pub use game::{GameReport, nfg_text};
pub use optimum::{OptimumReport, RivalsReport, ValidationReport};
pub use origin::{origin_comment, with_origin};
pub use presentation::Presentation;
pub use protection::OutputProtection;
pub use provenance::Provenance;
pub use replay::{check_replay, replay_page};
pub use run::RunReport;
pub use station_picture::station_picture;
pub use sweep::SweepReport;
pub use table::{Table, fixed};
pub use throughput::ThroughputReport;
#[cfg(feature = "onnx")]
pub use training::{TrainingReport, learning_curve_csv};
pub use verb_report::{ResultFile, VerbReport, json_text};
pub use verification::{VerificationReport, ViolationReport};
