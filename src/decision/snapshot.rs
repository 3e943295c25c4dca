//! What a strategy sees when a robot must decide.

use super::candidate::{Candidate, Moment};
use super::odds::Odds;
use crate::error::counted;
use crate::station::{ClassId, Station};

/// An unclaimed item on the belt, whether or not the robot can reach it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeltItem {
    /// Index of the item in its pattern.
    pub item: u32,
    /// Position along the travel at time 0, as reported [m].
    pub x0: f64,
    /// Current position along the travel, as reported [m].
    pub x: f64,
    /// Position across the belt, as reported [m].
    pub y: f64,
    /// Object-specific reward r of the item, 0 or more.
    pub weight: f64,
    /// Its class on the station.
    pub class: ClassId,
    /// What can go wrong with it.
    pub odds: Odds,
}

/// The state at a decision.
#[derive(Debug, Clone, Copy)]
pub struct Snapshot<'a> {
    /// The station that the run is on.
    pub station: &'a Station,
    /// Time of the decision [s].
    pub time: f64,
    /// Index of the deciding robot, upstream first.
    pub robot: usize,
    /// The items that the robot can pick now, downstream first; never empty.
    pub candidates: &'a [Candidate],
    /// What can go wrong with each of them; empty if nothing can.
    pub candidate_odds: &'a [Odds],
    /// When each robot is free [s]: at most `time` if it is idle, infinite if it waits forever.
    pub free_at: &'a [f64],
    /// Where each robot's arm is, or will be once it is free: an index for
    /// [`Robot::place`](crate::station::Robot::place).
    pub places: &'a [u16],
    /// The unclaimed items on the belt that the camera has seen, downstream first. Empty if the
    /// strategy does not use it (see `Strategy::needs_view`).
    pub in_view: &'a [BeltItem],
}

impl<'a> Snapshot<'a> {
    /// The deciding robot and the time, for computing the figures of the candidates.
    pub fn moment(&self) -> Moment<'a> {
        let place = usize::from(self.places[self.robot]);
        Moment::new(self.station, self.robot, place, self.time)
    }

    /// The decision in words, for messages: the robot and its candidates.
    pub(crate) fn in_words(&self) -> String {
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

    /// What can go wrong with candidate number `place`.
    pub fn odds_of(&self, place: usize) -> Odds {
        self.candidate_odds.get(place).copied().unwrap_or_default()
    }

    /// Time until robot `index` is free [s]; 0 if it is idle.
    pub fn time_until_free(&self, index: usize) -> f64 {
        (self.free_at[index] - self.time).max(0.0)
    }
}
