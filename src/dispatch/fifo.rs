//! FIFO: first in, first out.

use super::DispatchingRule;
use crate::decision::{Candidate, Moment};

/// First in, first out: the item that is furthest downstream.
pub(super) struct Fifo;

impl DispatchingRule for Fifo {
    fn name(&self) -> &'static str {
        "FIFO"
    }

    fn title(&self) -> &'static str {
        "first in, first out"
    }

    fn key_text(&self) -> &'static str {
        "-(x position at the decision)"
    }

    #[inline(always)]
    fn key(&self, at: &Moment, candidate: &Candidate) -> f64 {
        -at.x(candidate)
    }
}
