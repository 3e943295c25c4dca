//! The view of a live line on the dashboard.

use super::latency::DecisionTimes;
use super::protocol::{Latency, Status};
use super::trend::TrendView;
use serde::Serialize;

/// The line at one moment; positions in m, times in s.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct LineView {
    /// The figures, as in the status message of this moment.
    pub status: Status,
    /// Durations of decisions, with either clock.
    pub latency: Latency,
    /// The same durations as counts within fixed limits; not sent to browsers.
    #[serde(skip)]
    pub decision_times: DecisionTimes,
    /// Whether time runs by itself between two views, as with the system clock.
    pub steady: bool,
    /// Last measured speed of the belt [m/s].
    pub belt_speed: f64,
    /// Travel of the belt since the first message [m].
    pub belt_travel: f64,
    /// Items near the belt that are not in a bin, in the order of their first detection.
    pub items: Vec<ItemView>,
    /// Number of further items that are not shown, because there are too many.
    pub left_out: usize,
    /// The tasks without a result yet, oldest first.
    pub claims: Vec<ClaimView>,
    /// Where each arm is when it is free [m]: at the bin that it went to last, or at rest. Omitted if
    /// every robot has only one place.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<[f64; 2]>,
    /// Recent rates and utilisation.
    pub trend: TrendView,
}

/// An item in a view.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct ItemView {
    /// Its id. It comes from outside, as does the class.
    pub id: String,
    /// Position along the travel [m].
    pub x: f64,
    /// Position across the belt [m].
    pub y: f64,
    /// Object-specific reward.
    pub weight: f64,
    /// Class of the item.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// `waiting`, `claimed`, `missed`, or `left` if it is left on the belt on purpose.
    pub fate: &'static str,
    /// Why it was missed, as in the figures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<&'static str>,
    /// Index of the robot that it is assigned to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<usize>,
}

/// An open task in a view.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ClaimView {
    /// Id of the task.
    pub task: u64,
    /// How often it was sent before.
    pub revision: u32,
    /// Index of the robot.
    pub robot: usize,
    /// Id of the item; empty if it is forgotten.
    pub item: String,
    /// `sent`, `acknowledged` or `cancelling`.
    pub stage: &'static str,
    /// Timestamp at which the robot leaves its bin [s].
    pub start: f64,
    /// Timestamp at which the robot meets the item [s].
    pub meet_at: f64,
    /// Where the robot meets the item [m].
    pub meet: [f64; 2],
    /// Timestamp at which the robot is expected to be free again [s].
    pub free_at: f64,
    /// Where the robot leaves from [m]; none if it only ever leaves its only bin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<[f64; 2]>,
    /// Name of the bin that the item goes into; none if the robot has one bin for everything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bin: Option<String>,
}
