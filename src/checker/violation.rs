//! What contradicts the model, and what a run is judged by besides it.

use crate::decision::Pick;
use crate::error::{Error, Result, shown_number};
use crate::setters::setters;

/// What a run is judged by, besides station and pattern. The default is the plain model, with
/// nothing but rounding allowed for.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Terms {
    /// How far each time may be off [s], and each position by as much as the belt moves meanwhile.
    pub tolerance: f64,
    /// Position of the camera [m]: no robot leaves for an item that has not passed it.
    pub camera_x: Option<f64>,
    /// Robots leave only at multiples of `1 / update_hz` seconds; 0 for any time [Hz].
    pub update_hz: f64,
}

setters!(Terms {
    /// With times that may be off by this [s].
    fn with_tolerance(tolerance: f64);
    /// With a camera at this position [m], or without one.
    fn with_camera_x(camera_x: impl Into<Option<f64>>);
    /// With robots that leave only at multiples of `1 / update_hz` seconds; 0 for any time [Hz].
    fn with_update_hz(update_hz: f64);
});

/// Largest tolerance [s]. Whatever a robot does in a longer time would go unnoticed.
const MOST_TOLERANCE: f64 = 10.0;

impl Terms {
    /// Checks the tolerance.
    ///
    /// # Errors
    /// A tolerance out of range.
    pub fn check(&self) -> Result<()> {
        if (0.0..=MOST_TOLERANCE).contains(&self.tolerance) {
            return Ok(());
        }
        Err(Error::usage(
            "'tolerance'",
            format!("{} s is out of range", shown_number(self.tolerance)),
            format!("give a time from 0 to {MOST_TOLERANCE} s, such as 0.001"),
        ))
    }

    /// The tolerance and the conditions in words, one text per fact.
    pub fn describe(&self) -> Vec<String> {
        let mut lines = Vec::new();
        if self.tolerance > 0.0 {
            let tolerance = shown_number(self.tolerance);
            lines.push(format!("times may be off by {tolerance} s"));
        }
        if let Some(x) = self.camera_x {
            lines.push(format!(
                "only items past x = {} m are known",
                shown_number(x)
            ));
        }
        if self.update_hz > 0.0 {
            let hz = shown_number(self.update_hz);
            lines.push(format!("decisions at multiples of 1/{hz} s"));
        }
        lines
    }
}

/// What a violation is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, strum::IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum ViolationKind {
    /// The robot, the item or the bin does not exist.
    Unknown,
    /// Times that no run has: negative, or not finite.
    Times,
    /// The item is not to be picked.
    Unwanted,
    /// It goes into another bin.
    Bin,
    /// The way to the item does not take this time.
    TravelTime,
    /// Grasp, way to the bin and release do not take this time.
    ReturnTime,
    /// The item is out of the robot's reach.
    Reach,
    /// The item is not on the belt.
    OffBelt,
    /// The item is elsewhere.
    Meeting,
    /// The robot found nothing where it could have met the item.
    Vain,
    /// The grasp failed although no grasp of this item does.
    SureGrasp,
    /// Another attempt has the item, or has had it.
    Claimed,
    /// The robot is still busy with another item.
    Busy,
    /// The robot is down.
    Down,
    /// The item has not passed the camera.
    Unseen,
    /// The robot leaves between two updates.
    OffBeat,
}

impl ViolationKind {
    /// The name used in files, in snake case.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// What contradicts the model.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Violation {
    /// Index of the attempt in the list that was checked.
    pub attempt: usize,
    /// Index of the robot.
    pub robot: usize,
    /// Index of the item in its pattern.
    pub item: u32,
    /// When the robot left for the item [s].
    pub time: f64,
    /// What it is about.
    pub kind: ViolationKind,
    /// What is wrong, and what would be right.
    pub problem: String,
    /// The least tolerance [s] with which this would be accepted; `None` if none helps.
    pub accepted_from: Option<f64>,
}

impl From<Violation> for Error {
    fn from(violation: Violation) -> Self {
        Self::refuted(format!(
            "robot {} picking item {} at t = {} s: {}",
            violation.robot, violation.item, violation.time, violation.problem
        ))
    }
}

/// What is wrong with one attempt.
pub(super) struct Problem {
    kind: ViolationKind,
    text: String,
    accepted_from: Option<f64>,
}

impl Problem {
    /// A problem that no tolerance excuses.
    pub(super) fn of(kind: ViolationKind, text: impl Into<String>) -> Self {
        let text = text.into();
        let accepted_from = None;
        Self {
            kind,
            text,
            accepted_from,
        }
    }

    /// A deviation that a tolerance of this time [s] would excuse; none if no tolerance may be so large.
    pub(super) fn off(kind: ViolationKind, tolerance: f64, text: String) -> Self {
        Self {
            kind,
            text,
            accepted_from: (tolerance <= MOST_TOLERANCE).then_some(tolerance),
        }
    }

    /// The problem as a violation by `pick`, which is number `attempt` of its list.
    pub(super) fn in_pick(self, attempt: usize, pick: &Pick) -> Violation {
        Violation {
            attempt,
            robot: pick.robot,
            item: pick.item,
            time: pick.decide,
            kind: self.kind,
            problem: self.text,
            accepted_from: self.accepted_from,
        }
    }
}
