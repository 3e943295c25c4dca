//! The reward of an episode.

use crate::decision::Figures;
use crate::error::{Error, Result, shown_number};
use serde::{Deserialize, Serialize};

/// Weights of the paper's two rewards (Jermann et al., section on actions, observations and
/// rewards).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reward {
    /// Weight of the item's reward r, paid at its pick.
    pub pick: f64,
    /// Weight of the reward-weighted picking rate `60 sum(r) / T` [1/min], paid at the end.
    pub rate: f64,
}

impl Reward {
    /// Both rewards with weight 1.
    pub const PAPER: Self = Self {
        pick: 1.0,
        rate: 1.0,
    };

    /// Checks the weights.
    ///
    /// # Errors
    /// A weight that is not a finite number.
    pub fn check(&self) -> Result<()> {
        let weights = [("pick", self.pick), ("rate", self.rate)];
        match weights.into_iter().find(|(_, weight)| !weight.is_finite()) {
            None => Ok(()),
            Some((name, weight)) => Err(Error::usage(
                format!("the weight `{name}` of the reward"),
                format!("{} is not a finite number", shown_number(weight)),
                "give a number, for example 1",
            )),
        }
    }

    /// The reward for the pick of an item of reward `weight`.
    pub(crate) fn of_pick(&self, weight: f64) -> f64 {
        self.pick * weight
    }

    /// The reward at the end of an episode.
    pub(crate) fn of_end(&self, figures: &Figures) -> f64 {
        self.rate * figures.weighted_rate()
    }
}
