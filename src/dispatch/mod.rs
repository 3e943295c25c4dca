//! Dispatching rules: fixed criteria by which each robot chooses an item.

mod assignment;
mod fifo;
mod ld;
mod lpt;
mod pp;
mod registry;
mod sd;
mod spt;

pub use assignment::{RuleAssignment, RuleStrategy};
pub use registry::{RULES, Rule};

use crate::decision::{Candidate, Moment};

/// Ranks the candidates of one robot.
pub trait DispatchingRule: Sync {
    /// The abbreviation used in the literature, for example `SPT`.
    fn name(&self) -> &'static str;

    /// The full name.
    fn title(&self) -> &'static str;

    /// The key in words, for help texts and the documentation.
    fn key_text(&self) -> &'static str;

    /// The rank of a candidate; the one with the smallest rank is picked.
    fn key(&self, at: &Moment, candidate: &Candidate) -> f64;

    /// A number that the key is not below, if one costs much less than the key; otherwise negative
    /// infinity. It only saves time.
    #[inline(always)]
    fn least_key(&self, _at: &Moment, _candidate: &Candidate) -> f64 {
        f64::NEG_INFINITY
    }

    /// Whether the key depends on the items' rewards only, so that items of equal reward are picked as by
    /// FIFO.
    fn ranks_by_reward(&self) -> bool {
        false
    }

    /// Index of the candidate with the smallest key. Ties go to the item further downstream, then
    /// to the lower index. `candidates` must not be empty.
    ///
    /// Implemented here so that a call through `dyn DispatchingRule` costs one indirect jump per
    /// decision rather than one per candidate.
    fn choose(&self, at: &Moment, candidates: &[Candidate]) -> usize {
        let mut best = 0;
        let mut best_key = f64::INFINITY;
        for (i, candidate) in candidates.iter().enumerate() {
            if self.least_key(at, candidate) > best_key {
                continue;
            }
            let key = self.key(at, candidate);
            if key < best_key || (key == best_key && candidate.is_before(&candidates[best])) {
                (best, best_key) = (i, key);
            }
        }
        best
    }
}
