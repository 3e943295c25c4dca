//! LD: longest distance.

use super::DispatchingRule;
use crate::decision::{Candidate, Moment};

/// Longest distance: the item farthest from the robot's base.
pub(super) struct Ld;

impl DispatchingRule for Ld {
    fn name(&self) -> &'static str {
        "LD"
    }

    fn title(&self) -> &'static str {
        "longest distance"
    }

    fn key_text(&self) -> &'static str {
        "-(distance from item to robot base at the decision)"
    }

    #[inline(always)]
    fn key(&self, at: &Moment, candidate: &Candidate) -> f64 {
        -at.distance_to_base(candidate)
    }
}
