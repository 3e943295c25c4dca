//! What a strategy sees when a robot has to decide.

use super::candidate::{Candidate, Moment};
use crate::error::counted;
use crate::station::Station;

/// An unclaimed item on the belt, whoever may reach it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeltItem {
    /// Index of the item in its pattern.
    pub item: u32,
    /// Position along the travel at time 0, as reported [m].
    pub x0: f64,
    /// Position along the travel now, as reported [m].
    pub x: f64,
    /// Position across the belt, as reported [m].
    pub y: f64,
    /// Object-specific reward.
    pub weight: f64,
}

/// The state at one decision.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'a> {
    /// The station.
    pub station: &'a Station,
    /// Time of the decision [s].
    pub time: f64,
    /// Index of the deciding robot, upstream first.
    pub robot: usize,
    /// What it can pick now, downstream first; never empty.
    pub candidates: &'a [Candidate],
    /// When each robot is free [s]; at most `time` for an idle one, infinite for one
    /// that waits for ever.
    pub free_at: &'a [f64],
    /// The unclaimed items on the belt that the camera has seen, downstream first; empty when the strategy
    /// says that it does not look (see `Strategy::needs_view`).
    pub in_view: &'a [BeltItem],
}

impl<'a> Snapshot<'a> {
    /// The deciding robot and the time, for the candidates' figures.
    pub fn moment(&self) -> Moment<'a> {
        Moment::new(self.station, self.robot, self.time)
    }

    /// The decision in words, for messages: who decides between what.
    pub fn in_words(&self) -> String {
        const MOST: usize = 8;
        let moment = self.moment();
        let shown = self.candidates.iter().take(MOST);
        let shown = shown.map(|candidate| {
            let (x, y) = (moment.x(candidate), candidate.y);
            format!("item {} at ({x:.4}, {y:.4}) m", candidate.item)
        });
        let mut text = format!(
            "robot `{}` at t = {} s, {}: {}",
            moment.robot.name,
            self.time,
            counted(self.candidates.len(), "candidate"),
            shown.collect::<Vec<_>>().join(", ")
        );
        if self.candidates.len() > MOST {
            text += ", ...";
        }
        text
    }

    /// Time until robot `index` is free [s]; 0 for an idle one.
    pub fn time_until_free(&self, index: usize) -> f64 {
        (self.free_at[index] - self.time).max(0.0)
    }
}
