//! The fate of an item, as the figures count it.

use super::items::{ItemState, Tracked};
use super::protocol::MissedCounts;
use serde::{Deserialize, Serialize};

/// The fate of an item. Each item has exactly one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Fate {
    /// It is in a bin.
    Picked,
    /// It is reserved for a robot's task.
    Claimed,
    /// It may still be picked.
    OnBelt,
    /// It is left on the belt on purpose: its class is not wanted, no robot has a bin for it, or
    /// its detection is too uncertain.
    Unwanted,
    /// No robot ever had a departure window for it.
    Unreachable,
    /// It was attempted, and no attempt succeeded.
    GraspFailed,
    /// A robot was sent, but came too late or did not find it.
    NotFound,
    /// A robot was sent but never reported a result.
    NoResult,
    /// A robot could have picked it, but another action was chosen.
    PassedOver,
    /// Whenever it was in a robot's window, the robot was busy or out of service.
    Busy,
}

impl Fate {
    /// The fate of an item; `is_past` is whether it has left the belt, and `is_taken` whether it is
    /// not left on purpose.
    pub(crate) fn of(tracked: &Tracked, is_past: bool, is_taken: bool) -> Self {
        match tracked.state {
            ItemState::Picked(_) => Self::Picked,
            ItemState::Claimed(_) => Self::Claimed,
            ItemState::NoResult => Self::NoResult,
            // A class that is known only after an attempt does not undo the attempt.
            ItemState::Free if !is_taken && tracked.attempts == 0 => Self::Unwanted,
            ItemState::Free if !is_past => Self::OnBelt,
            ItemState::GivenUp | ItemState::Free if tracked.failed_grasps > 0 => Self::GraspFailed,
            ItemState::GivenUp => Self::NotFound,
            ItemState::Free if tracked.attempts > 0 => Self::NotFound,
            ItemState::Free if tracked.offered => Self::PassedOver,
            ItemState::Free if tracked.windowed => Self::Busy,
            ItemState::Free => Self::Unreachable,
        }
    }

    /// The key in the figures for why the item was missed; none if it was not.
    pub(crate) fn reason(self) -> Option<&'static str> {
        match self {
            Self::Unreachable => Some("unreachable"),
            Self::GraspFailed => Some("grasp_failed"),
            Self::NotFound => Some("not_found"),
            Self::NoResult => Some("no_result"),
            Self::PassedOver => Some("passed_over"),
            Self::Busy => Some("busy"),
            Self::Picked | Self::Claimed | Self::OnBelt | Self::Unwanted => None,
        }
    }

    /// The item's count in `missed`; none if it was not missed.
    pub(crate) fn count(self, missed: &mut MissedCounts) -> Option<&mut u64> {
        match self {
            Self::Unreachable => Some(&mut missed.unreachable),
            Self::GraspFailed => Some(&mut missed.grasp_failed),
            Self::NotFound => Some(&mut missed.not_found),
            Self::NoResult => Some(&mut missed.no_result),
            Self::PassedOver => Some(&mut missed.passed_over),
            Self::Busy => Some(&mut missed.busy),
            Self::Picked | Self::Claimed | Self::OnBelt | Self::Unwanted => None,
        }
    }
}
