//! The reward of an episode.

use crate::decision::Figures;
use crate::error::{Error, Result, shown_number};
use serde::{Deserialize, Serialize};

/// The largest weight: a sum of rewards stays finite with it.
const MOST_WEIGHT: f64 = 1e9;

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
    /// A weight that is not a finite number, or so large that rewards would not be.
    pub fn check(&self) -> Result<()> {
        let weights = [("pick", self.pick), ("rate", self.rate)];
        let is_usable = |weight: f64| weight.abs() <= MOST_WEIGHT;
        match weights.into_iter().find(|(_, weight)| !is_usable(*weight)) {
            None => Ok(()),
            Some((name, weight)) => Err(Error::usage(
                format!("the weight `{name}` of the reward"),
                match weight.is_finite() {
                    true => format!("{} is too large", shown_number(weight)),
                    false => format!("{} is not a finite number", shown_number(weight)),
                },
                format!("give a number, for example 1, at most {MOST_WEIGHT:e}"),
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
