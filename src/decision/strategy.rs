//! What a strategy may do.

use super::snapshot::Snapshot;
use crate::error::{Error, Result};

/// The answer to a [`Snapshot`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Pick `snapshot.candidates[i]`.
    Pick(usize),
    /// Do nothing before this time [s], later than now.
    WaitUntil(f64),
    /// Do nothing until the next window of an item opens for this robot.
    WaitForNextWindow,
    /// The strategy has come to no answer that makes sense; [`Strategy::trouble`] says why.
    /// A simulation ends with an error; a live line gives no task and goes on.
    NoAnswer,
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

    /// Why its last answer was [`Action::NoAnswer`], with what it saw.
    fn trouble(&self) -> Option<String> {
        None
    }
}

/// The answer of `strategy` to `snapshot`, checked to be one that the model allows.
///
/// # Errors
/// Any other, with the strategy, the decision and what it saw.
pub fn answer(strategy: &mut dyn Strategy, snapshot: &Snapshot) -> Result<Action> {
    let action = strategy.decide(snapshot);
    let problem = match action {
        Action::Pick(place) if place < snapshot.candidates.len() => return Ok(action),
        Action::WaitUntil(until) if until > snapshot.time => return Ok(action),
        Action::WaitForNextWindow => return Ok(action),
        Action::Pick(place) => format!(
            "it picks candidate {place} of {}",
            snapshot.candidates.len()
        ),
        Action::WaitUntil(until) => format!("it waits until {until} s, which is not later"),
        Action::NoAnswer => strategy
            .trouble()
            .unwrap_or_else(|| "it has no answer".into()),
    };
    Err(Error::IllegalAction {
        time: snapshot.time,
        robot: snapshot.station.robots()[snapshot.robot].name.clone(),
        problem: format!(
            "the strategy {}: {problem}\n  seen: {}\n  cure: use another strategy, or mend this \
             one (a policy: train it on stations and patterns like these and export it again)",
            strategy.name(),
            snapshot.in_words(),
        ),
    })
}
