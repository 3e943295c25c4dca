//! SPT: shortest processing time.

use super::DispatchingRule;
use crate::decision::{Candidate, Moment};

/// Shortest processing time: the pick that is completed soonest.
pub(super) struct Spt;

impl DispatchingRule for Spt {
    fn name(&self) -> &'static str {
        "SPT"
    }

    fn title(&self) -> &'static str {
        "shortest processing time"
    }

    fn key_text(&self) -> &'static str {
        "processing time"
    }

    #[inline(always)]
    fn key(&self, at: &Moment, candidate: &Candidate) -> f64 {
        at.processing_time(candidate)
    }

    #[inline(always)]
    fn least_key(&self, at: &Moment, candidate: &Candidate) -> f64 {
        at.least_processing_time(candidate)
    }
}
