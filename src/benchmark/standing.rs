//! How each entrant did on all instances.

use super::instance::Instance;
use super::study::{BenchmarkResult, Entry};
use std::time::Duration;

/// One entrant on all instances. Means are over instances; an instance without a solution counts as none
/// picked.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Standing {
    /// Index of the entrant.
    pub entrant: usize,
    /// Instances that it was run on.
    pub runs: usize,
    /// Those without a solution.
    pub failed: usize,
    /// Sum of the picks.
    pub picked: usize,
    /// Mean of picks / picks of the best known solution, over the instances that have one.
    pub of_known: Option<f64>,
    /// Mean of picks / certified bound, over the instances that have one.
    pub of_bound: Option<f64>,
    /// Mean of picking rate / certified bound of it.
    pub of_rate_bound: Option<f64>,
    /// Number of decisions.
    pub decisions: u64,
    /// The time that they took.
    pub spent: Duration,
}

/// How each entrant did, the best first: by the mean share of the best known picks (of the bound, or of all
/// items, where nothing is known), then by the mean share of the bound of the rate, then in the order in which
/// they were given.
pub fn standings(instances: &[Instance], result: &BenchmarkResult) -> Vec<Standing> {
    let of = |entrant: usize| {
        let entries = result.entries.iter();
        let entries: Vec<&Entry> = entries.filter(|entry| entry.entrant == entrant).collect();
        Standing::new(entrant, &entries, instances)
    };
    let mut all: Vec<Standing> = (0..result.entrants.len()).map(of).collect();
    all.retain(|standing| standing.runs > 0);
    let score = |standing: &Standing| {
        let picks = standing.of_known.or(standing.of_bound);
        (
            picks.unwrap_or(standing.picked as f64),
            standing.of_rate_bound.unwrap_or_default(),
        )
    };
    all.sort_by(|a, b| {
        let (a, b) = (score(a), score(b));
        b.0.total_cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    all
}

impl Standing {
    fn new(entrant: usize, entries: &[&Entry], instances: &[Instance]) -> Self {
        let picked = |entry: &Entry| {
            let solution = entry.solved.as_ref();
            solution.map_or(0, |solution| solution.figures.picked)
        };
        let rate = |entry: &Entry| {
            let solution = entry.solved.as_ref();
            solution.map_or(0.0, |solution| solution.figures.picking_rate())
        };
        let mean = |share: &dyn Fn(&Entry, &Instance) -> Option<f64>| {
            let shares = entries.iter();
            let shares: Vec<f64> = shares
                .filter_map(|entry| share(entry, &instances[entry.instance]))
                .collect();
            (!shares.is_empty()).then(|| crate::stats::mean(&shares))
        };
        let share = |part: f64, whole: f64| (whole > 0.0).then(|| part / whole);
        Self {
            entrant,
            runs: entries.len(),
            failed: entries.iter().filter(|entry| entry.solved.is_err()).count(),
            picked: entries.iter().map(|entry| picked(entry)).sum(),
            of_known: mean(&|entry, instance| {
                share(picked(entry) as f64, instance.known.picked? as f64)
            }),
            of_bound: mean(&|entry, instance| {
                share(picked(entry) as f64, instance.known.picks_bound? as f64)
            }),
            of_rate_bound: mean(&|entry, instance| share(rate(entry), instance.known.rate_bound?)),
            decisions: entries.iter().map(|entry| entry.decisions).sum(),
            spent: entries.iter().map(|entry| entry.spent).sum(),
        }
    }
}
