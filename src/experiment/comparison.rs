//! The result of a comparison: all methods on all cases.

use super::case::Case;
use super::class_result::ClassResult;
use super::method::{Method, MethodRun};
use crate::purity::PurityByBin;
use crate::stats::Interval;
use crate::throughput::Throughput;

/// One method on one case.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct MethodResult {
    /// Its run on each pattern, in the order of [`CaseResult::seeds`].
    pub runs: Vec<MethodRun>,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// 95 % interval of that mean; `None` for a single pattern, as for all intervals below.
    pub picked_share_interval: Option<Interval>,
    /// Mean end of the run [s].
    pub end: f64,
    /// Picks per minute in the steady state.
    pub throughput: Throughput,
    /// Mean picking rate [1/min].
    pub picking_rate: f64,
    /// 95 % interval of that mean [1/min].
    pub picking_rate_interval: Option<Interval>,
    /// Mean weighted rate [1/min].
    pub weighted_rate: f64,
    /// 95 % interval of this method's picking rate minus the first method's, paired
    /// over patterns [1/min].
    pub difference: Option<Interval>,
    /// Excess of the mean picking rate over the first method's, as a share.
    pub benefit: f64,
    /// Purity and recovery; `None` unless detections may be wrong.
    pub purity: Option<PurityByBin>,
    /// What it picked of each class; empty if no item has a class that matters on the station.
    pub classes: Vec<ClassResult>,
}

/// All methods on one case.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct CaseResult {
    /// The case, as it was given.
    pub case: Case,
    /// The seed of each pattern; `None` if the case is not random.
    pub seeds: Vec<Option<u64>>,
    /// The methods, in the order given.
    pub methods: Vec<MethodResult>,
    /// What no strategy can exceed, if the bound was requested.
    pub bound: Option<CaseBound>,
    /// Whether items have attributes or classes of different value, so that weight differs from the
    /// count.
    pub weighs: bool,
}

/// All methods on all cases.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Comparison {
    /// The methods, the one that the others are compared against first.
    pub methods: Vec<Method>,
    /// The completed cases; all of them unless the user stopped the comparison.
    pub cases: Vec<CaseResult>,
    /// Number of cases that were asked for; fewer are complete after a stop request.
    pub planned: usize,
    /// The seed of the first pattern of each random case.
    pub first_seed: u64,
}

/// The bounds of one case.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct CaseBound {
    /// Upper bound on the number of items picked from each pattern.
    pub picks: Vec<usize>,
    /// Mean over the patterns of these bounds as shares of the items.
    pub picked_share: f64,
    /// Mean of the highest possible rates [1/min]; `None` if some pattern has no finite bound.
    pub picking_rate: Option<f64>,
    /// 95 % interval of that mean minus the first method's rate, paired over patterns [1/min];
    /// `None` for a single pattern.
    pub difference: Option<Interval>,
    /// Excess over the first method's mean rate, as a share.
    pub benefit: Option<f64>,
    /// For each method: its picks over all patterns as a proven share of the optimum [%].
    pub certified: Vec<f64>,
    /// For each method: its mean rate as a proven share of the highest [%].
    pub certified_rate: Vec<Option<f64>>,
}
