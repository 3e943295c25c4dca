//! Whole studies of a line, one call each: what `pickline compare`, `sweep` and `optimize` run.
//!
//! A study is made of a station and typed options, runs in an
//! [`Environment`](crate::optimize::Environment) and returns data. It prints nothing.
//!
//! | call | checked first | returns |
//! |---|---|---|
//! | [`compare`] | [`CompareStudy`] | [`Compared`] |
//! | [`sweep`] | [`SweepStudy`] | [`Swept`] |
//! | [`optimize`] | [`OptimizeStudy`] | [`Optimized`] |
//!
//! Making a study checks the options, so that no error is found only after minutes of work.
//! Messages and notes name settings in single quotes, as [`crate::error`] says.

mod blueprint;
mod compare;
mod notes;
mod optimize;
mod options;
mod part;
mod patterns;
mod robust;
mod sweep;
mod values;

pub use blueprint::{BlueprintOptions, PolicyDistance, blueprint, policy_distance};
pub use compare::{CompareOptions, CompareSettings, CompareStudy, Compared, compare};
pub use notes::{Note, RobustBasis, RobustNote, RobustScope, set_notes};
pub use optimize::{
    OptimizeOptions, OptimizeSettings, OptimizeStudy, Optimized, ScoredRivals, optimize,
};
pub use options::{MethodSettings, StudyOptions};
pub use patterns::{ScoredPatterns, ScoredSet};
pub use robust::RobustTraining;
pub use sweep::{DEFAULT_GRID, SweepOptions, SweepSettings, SweepStudy, Swept, sweep};
