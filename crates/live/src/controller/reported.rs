//! The state as it was reported last.

use crate::belt::BeltPlan;
use crate::claims::Claim;
use crate::drive::Drive;
use crate::operation::Operation;
use crate::robots::Fleet;
use crate::state::Counters;
use std::collections::BTreeMap;

/// The state reported last, to find later changes. The items track their changes themselves,
/// because there are too many to compare.
#[derive(Debug)]
pub(super) struct Reported {
    pub claims: BTreeMap<u64, Claim>,
    pub fleet: Fleet,
    pub operation: Operation,
    pub drive: Drive,
    pub counters: Counters,
    pub plan: BeltPlan,
    pub waiting: usize,
    pub now: f64,
}
