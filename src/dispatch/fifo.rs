//! FIFO: first in, first out.

use super::DispatchingRule;
use crate::decision::{Candidate, Moment};

/// first in, first out: the item that has progressed the furthest.
pub struct Fifo;

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
