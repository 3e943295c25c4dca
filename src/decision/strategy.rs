//! What a strategy may do.

use super::snapshot::Snapshot;

/// The answer to a [`Snapshot`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Pick `snapshot.candidates[i]`.
    Pick(usize),
    /// Do nothing before this time [s], later than now.
    WaitUntil(f64),
    /// Do nothing until the next window of an item opens for this robot.
    WaitForNextWindow,
}

/// Decides which robot takes which item. A rule ranks, a strategy decides.
pub trait Strategy {
    /// The answer to one decision.
    fn decide(&mut self, snapshot: &Snapshot) -> Action;

    /// How the strategy is written on the command line.
    fn name(&self) -> String;

    /// Whether [`Snapshot::in_view`] should be filled; costs time per decision.
    fn needs_view(&self) -> bool {
        true
    }
}
