//! Whole studies of a line, one call each: what the verbs of the program run that compute
//! something.
//!
//! A study is made of a station and typed options, runs in an
//! [`Environment`](crate::optimize::Environment) and returns data. It prints nothing.
//!
//! | call | checked first | returns |
//! |---|---|---|
//! | [`compare`] | [`CompareStudy`] | [`Compared`] |
//! | [`sweep`] | [`SweepStudy`] | [`Swept`] |
//! | [`robots_down`] | [`RobotsDownStudy`] | [`HaltedLine`] |
//! | [`optimize`] | [`OptimizeStudy`] | [`Optimized`] |
//! | [`race`] | [`RaceStudy`] | [`Raced`] |
//! | [`game`] | [`GameStudy`] | [`PlayedGame`] |
//! | [`bound`] | [`BoundStudy`] | [`PatternBounds`] |
//! | [`demonstrate`] | | [`Demonstrations`] |
//! | [`simulate_and_check`] | [`SimulateStudy`] | [`SimulatedRun`] |
#![cfg_attr(
    feature = "onnx",
    doc = "| [`train`] | [`TrainStudy`] | [`TrainedPolicy`] |"
)]
//!
//! Making a study checks the options, so that no error is found only after minutes of work.
//! Messages and notes name settings in single quotes, as [`crate::error`] says.

mod blueprint;
mod bound;
mod compare;
mod demonstrate;
mod game;
mod inputs;
mod notes;
mod optimize;
mod options;
mod part;
mod patterns;
mod race;
mod robots_down;
mod robust;
mod simulate;
mod sweep;
mod sweep_options;
#[cfg(feature = "onnx")]
mod train;
mod trials;
mod tuning;
mod values;

pub use blueprint::{BlueprintOptions, PolicyDistance, blueprint, policy_distance};
pub use bound::{BoundStudy, BoundStudyOptions, PatternBounds, bound};
pub use compare::{CompareOptions, CompareSettings, CompareStudy, Compared, compare};
pub use demonstrate::{DemonstrateOptions, Demonstrations, demonstrate};
pub use game::{GameOptions, GameStudy, PlayedGame, game};
pub(crate) use inputs::check_strategies;
pub use notes::{Note, RobustBasis, RobustNote, RobustScope, set_notes};
pub use optimize::{
    OptimizeOptions, OptimizeSettings, OptimizeStudy, Optimized, ScoredRivals, optimize,
};
pub use options::{MethodSettings, StudyOptions};
pub use patterns::{ScoredPatterns, ScoredSet};
pub use race::{RaceOptions, RaceStop, RaceStudy, Raced, Racer, race};
pub use robots_down::{
    HaltedLine, RobotsDownOptions, RobotsDownSettings, RobotsDownStudy, robots_down,
};
pub use robust::{RobustTraining, training_patterns};
pub use simulate::{SimulateOptions, SimulateStudy, SimulatedRun, simulate_and_check};
pub use sweep::{SweepStudy, Swept, sweep};
pub use sweep_options::{DEFAULT_GRID, SweepOptions, SweepSettings};
#[cfg(feature = "onnx")]
pub use train::{
    SavedTraining, TrainOptions, TrainStudy, TrainedPolicy, TrainingEvent, TrainingLine, train,
};
pub use trials::trials;
