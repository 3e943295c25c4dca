//! The types shared by simulation and live control: what a decision maker sees, what it may do, and
//! the outcome.

mod candidate;
mod event;
pub mod observation;
mod odds;
mod outcome;
mod snapshot;
mod strategy;

pub use candidate::{Candidate, Moment};
pub use event::{Event, Observer};
pub use odds::Odds;
pub(crate) use outcome::picked_shares;
pub use outcome::{
    Downtime, Failure, FailureCause, Figures, LeftItem, LeftReason, Miss, MissReason, Outcome,
    Pick, RobotFigures,
};
pub use snapshot::{BeltItem, Snapshot};
pub(crate) use strategy::answer;
pub use strategy::{Action, Strategy};
