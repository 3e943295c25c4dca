//! What an episode is worth.

use crate::decision::Figures;
use serde::{Deserialize, Serialize};

/// Weights of the two rewards of the paper (Jermann et al., section on actions,
/// observations and rewards).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reward {
    /// Of the item's reward r, at its pick.
    pub pick: f64,
    /// Of the reward-weighted picking rate `60 sum(r) / T` [1/min], at the end.
    pub rate: f64,
}

impl Reward {
    /// Both as they are.
    pub const PAPER: Self = Self {
        pick: 1.0,
        rate: 1.0,
    };

    /// At the pick of an item of reward `weight`.
    pub fn of_pick(&self, weight: f64) -> f64 {
        self.pick * weight
    }

    /// At the end of an episode.
    pub fn of_end(&self, figures: &Figures) -> f64 {
        self.rate * figures.weighted_rate()
    }
}
