//! What has become of an item, as the figures count it.

use super::items::{State, Tracked};
use super::protocol::MissedCounts;
use serde::{Deserialize, Serialize};

/// What has become of an item. Each has exactly one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// It is in a bin.
    Picked,
    /// Some robot is after it.
    Claimed,
    /// It may still be picked.
    OnBelt,
    /// No robot ever had a window for it.
    Unreachable,
    /// Attempted, and no attempt succeeded.
    GraspFailed,
    /// A robot was sent, and came too late or did not find it.
    NotFound,
    /// A robot was sent and never said what came of it.
    NoResult,
    /// Some robot could have picked it, and another action was chosen.
    PassedOver,
    /// Whenever it was in a window, the robot was busy or out of service.
    Busy,
}

impl Fate {
    /// The fate of an item that has left the belt or not.
    pub fn of(tracked: &Tracked, is_past: bool) -> Self {
        match tracked.state {
            State::Picked(_) => Self::Picked,
            State::Claimed(_) => Self::Claimed,
            State::NoResult => Self::NoResult,
            State::Free if !is_past => Self::OnBelt,
            State::GivenUp | State::Free if tracked.failed_grasps > 0 => Self::GraspFailed,
            State::GivenUp => Self::NotFound,
            State::Free if tracked.attempts > 0 => Self::NotFound,
            State::Free if tracked.offered => Self::PassedOver,
            State::Free if tracked.windowed => Self::Busy,
            State::Free => Self::Unreachable,
        }
    }

    /// Why the item was missed, as the figures name it; none when it was not.
    pub fn reason(self) -> Option<&'static str> {
        match self {
            Self::Unreachable => Some("unreachable"),
            Self::GraspFailed => Some("grasp_failed"),
            Self::NotFound => Some("not_found"),
            Self::NoResult => Some("no_result"),
            Self::PassedOver => Some("passed_over"),
            Self::Busy => Some("busy"),
            Self::Picked | Self::Claimed | Self::OnBelt => None,
        }
    }

    /// Its count; none when it was not missed.
    pub fn count(self, missed: &mut MissedCounts) -> Option<&mut u64> {
        match self {
            Self::Unreachable => Some(&mut missed.unreachable),
            Self::GraspFailed => Some(&mut missed.grasp_failed),
            Self::NotFound => Some(&mut missed.not_found),
            Self::NoResult => Some(&mut missed.no_result),
            Self::PassedOver => Some(&mut missed.passed_over),
            Self::Busy => Some(&mut missed.busy),
            Self::Picked | Self::Claimed | Self::OnBelt => None,
        }
    }
}
