//! SD: shortest distance.

use super::DispatchingRule;
use crate::decision::{Candidate, Moment};

/// Shortest distance: the item nearest to the robot's base.
pub(super) struct Sd;

impl DispatchingRule for Sd {
    fn name(&self) -> &'static str {
        "SD"
    }

    fn title(&self) -> &'static str {
        "shortest distance"
    }

    fn key_text(&self) -> &'static str {
        "distance from item to robot base at the decision"
    }

    #[inline(always)]
    fn key(&self, at: &Moment, candidate: &Candidate) -> f64 {
        at.distance_to_base(candidate)
    }
}
