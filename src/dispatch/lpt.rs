//! LPT: longest processing time.

use super::DispatchingRule;
use crate::decision::{Candidate, Moment};

/// Longest processing time: the pick that takes longest.
pub(super) struct Lpt;

impl DispatchingRule for Lpt {
    fn name(&self) -> &'static str {
        "LPT"
    }

    fn title(&self) -> &'static str {
        "longest processing time"
    }

    fn key_text(&self) -> &'static str {
        "-(processing time)"
    }

    #[inline(always)]
    fn key(&self, at: &Moment, candidate: &Candidate) -> f64 {
        -at.processing_time(candidate)
    }

    #[inline(always)]
    fn least_key(&self, at: &Moment, candidate: &Candidate) -> f64 {
        -at.most_processing_time(candidate)
    }
}
