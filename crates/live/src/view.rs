//! What whoever watches a live line sees of it.

use super::latency::DecisionTimes;
use super::protocol::{Latency, Status};
use super::trend::TrendView;
use serde::Serialize;

/// The line at one moment; positions in m, times in s.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct View {
    /// The figures, as in the status message of this moment.
    pub status: Status,
    /// How long decisions took, whatever the clock.
    pub latency: Latency,
    /// The same as counts within fixed limits; no browser needs it.
    #[serde(skip)]
    pub decision_times: DecisionTimes,
    /// Whether time goes on by itself between two views: with the system clock.
    pub steady: bool,
    /// Speed of the belt as measured last [m/s].
    pub belt_speed: f64,
    /// How far the belt has travelled since the first message [m].
    pub belt_travel: f64,
    /// Items near the belt that are not in a bin, in the order in which they were seen.
    pub items: Vec<ItemView>,
    /// How many more there are: a picture of too many shows a part of them.
    pub left_out: usize,
    /// The tasks whose result is not known, oldest first.
    pub claims: Vec<ClaimView>,
    /// Rates and utilisation over the time just past.
    pub trend: TrendView,
}

/// One item.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ItemView {
    /// Its id; comes from outside, as does the class.
    pub id: String,
    /// Position along the travel [m].
    pub x: f64,
    /// Position across the belt [m].
    pub y: f64,
    /// Object-specific reward.
    pub weight: f64,
    /// What it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub class: Option<String>,
    /// `waiting`, `claimed` or `missed`.
    pub fate: &'static str,
    /// Why it is missed, as in the figures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<&'static str>,
    /// Index of the robot that is after it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<usize>,
}

/// One task whose result is not known.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClaimView {
    /// Id of the task.
    pub task: u64,
    /// How often it was sent before.
    pub revision: u32,
    /// Index of the robot.
    pub robot: usize,
    /// Id of the item; empty when that is forgotten.
    pub item: String,
    /// `sent`, `acknowledged` or `cancelling`.
    pub stage: &'static str,
    /// Stamp at which the robot leaves its bin [s].
    pub start: f64,
    /// Stamp at which it meets the item [s].
    pub meet_at: f64,
    /// Where [m].
    pub meet: [f64; 2],
    /// Stamp at which it is expected to be free again [s].
    pub free_at: f64,
}
