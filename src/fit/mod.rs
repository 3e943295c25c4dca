//! The travel-time law of each arm, estimated from recorded moves.
//!
//! A pick takes `T(|from - meet| + 2 h)` from departure to grasp, and grasp time, `T(|meet - bin| + 2
//! h)` and release time from grasp to release (`docs/real-lines.md`). Given such times, the parameters
//! of T, the lift h and the dwell are estimated for each robot by nonlinear least squares with a
//! robust loss (`robust.rs`), with intervals by bootstrap (`intervals.rs`) and by the profile of the loss
//! (`profile.rs`). Where that law does not fit, T is a monotone table (`table.rs`).
//!
//! Not every parameter can be told from every recording, and what cannot is said instead of guessed
//! (`determined.rs`): only the sum of grasp and release time is in a pick; the top speed is unknown if no
//! move is long enough to reach it; lift and acceleration are one if all moves are long. Nor do rounded
//! stamps tell more than their step (`resolution.rs`), or places that the station does not have
//! (`places.rs`).

mod arm_fit;
mod arm_result;
mod bench;
mod describe;
mod determined;
mod intervals;
mod law_fit;
mod line_fit;
mod model;
mod moves_file;
mod options;
mod parameter;
mod places;
mod profile;
mod remarks;
mod resolution;
mod robust;
mod station;
mod table;
mod timed_move;

pub use arm_result::{ArmFit, FitError, FittedLaw, MoveResidual};
pub use intervals::HalfOpen;
pub use line_fit::{LineFit, fit_line};
pub use moves_file::{MovesFile, read_moves};
pub use options::{FitLaw, FitOptions};
pub use parameter::FittedParameter;
pub use station::fitted_station;
pub use timed_move::{Chased, TimedMove};
