//! PP: priority picking.

use super::DispatchingRule;
use crate::decision::{Candidate, Moment};

/// Priority picking: the item with the highest object-specific reward.
pub(super) struct Pp;

impl DispatchingRule for Pp {
    fn name(&self) -> &'static str {
        "PP"
    }

    fn title(&self) -> &'static str {
        "priority picking"
    }

    fn key_text(&self) -> &'static str {
        "-(item weight)"
    }

    #[inline(always)]
    fn key(&self, _at: &Moment, candidate: &Candidate) -> f64 {
        -candidate.weight
    }

    fn ranks_by_reward(&self) -> bool {
        true
    }
}
