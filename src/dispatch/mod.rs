//! Dispatching rules: one fixed way of choosing, robot by robot.

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
    /// The short name of the field, for example `SPT`.
    fn name(&self) -> &'static str;

    /// The name in words.
    fn title(&self) -> &'static str;

    /// What the key is, in words, for help texts and the docs.
    fn key_text(&self) -> &'static str;

    /// The rank of a candidate; the smallest is picked.
    fn key(&self, at: &Moment, candidate: &Candidate) -> f64;

    /// Position of the candidate with the smallest key. Equal keys go to the item
    /// further downstream, then to the lower index. `candidates` is not empty.
    ///
    /// Provided once here so that a call through `dyn DispatchingRule` costs one
    /// indirect jump a decision, not one a candidate.
    fn choose(&self, at: &Moment, candidates: &[Candidate]) -> usize {
        let mut best = 0;
        let mut best_key = f64::INFINITY;
        for (i, candidate) in candidates.iter().enumerate() {
            let key = self.key(at, candidate);
            if key < best_key || (key == best_key && candidate.is_before(&candidates[best])) {
                (best, best_key) = (i, key);
            }
        }
        best
    }
}
