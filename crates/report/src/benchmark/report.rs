//! The figures of a benchmark.

use crate::provenance::Provenance;
use pickline::benchmark::{BenchmarkResult, Entrant, Entry, Instance, standings};
use serde::Serialize;

/// A benchmark as printed and written; the JSON field names are the product's format. Times are measured, so
/// they are in no file.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct BenchmarkReport {
    /// Who took part, the best first.
    pub ranking: Vec<StandingReport>,
    /// Every run: by instance, then by entrant.
    pub runs: Vec<EntryReport>,
    /// Where the result comes from.
    pub made: Provenance,
    /// Number of entrants.
    #[serde(skip)]
    pub(super) entrants: usize,
}

/// One entrant on all instances; an instance without a valid run counts as none picked.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct StandingReport {
    /// Its name.
    pub entrant: String,
    /// `online` or `clairvoyant`: what it knew when.
    pub track: &'static str,
    /// Instances that it was run on.
    pub runs: usize,
    /// Those without a valid run.
    pub failed: usize,
    /// Sum of the picks.
    pub picked: usize,
    /// Mean over instances of how far its picks are below the best known [%]; negative if above.
    pub gap_to_best_percent: Option<f64>,
    /// Mean over instances of how far its picks are below the certified bound [%].
    pub gap_to_bound_percent: Option<f64>,
    /// Mean over instances of how far its picking rate is below the certified bound of it [%].
    pub rate_gap_to_bound_percent: Option<f64>,
    /// Mean time of a decision [ms].
    #[serde(skip)]
    pub(super) decision_ms: Option<f64>,
}

/// One entrant on one instance.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct EntryReport {
    /// Name of the instance.
    pub instance: String,
    /// Name of the entrant.
    pub entrant: String,
    /// `online` or `clairvoyant`: what it knew when.
    pub track: &'static str,
    /// Number of items in the pattern.
    pub items: usize,
    /// Picks of the best known solution.
    pub best_known: Option<usize>,
    /// Certified bound on the picks.
    pub picks_upper_bound: Option<usize>,
    /// Certified bound on the picking rate [1/min].
    pub picking_rate_upper_bound_per_min: Option<f64>,
    /// Number of items picked; `None` without a valid run.
    pub picked: Option<usize>,
    /// Picks per minute.
    pub picking_rate_per_min: Option<f64>,
    /// How far the picks are below the best known [%]; negative if above.
    pub gap_to_best_percent: Option<f64>,
    /// How far the picks are below the certified bound [%].
    pub gap_to_bound_percent: Option<f64>,
    /// How far the picking rate is below the certified bound of it [%].
    pub rate_gap_to_bound_percent: Option<f64>,
    /// Whether it is better than the best known: more picks, or as many at a higher rate.
    pub better: bool,
    /// Why there is no valid run.
    pub failure: Option<String>,
}

impl BenchmarkReport {
    /// The report of `result` on `instances`; bounds that were computed anew count where they are tighter.
    pub fn new(instances: &[Instance], result: &BenchmarkResult, made: Provenance) -> Self {
        let mut instances = instances.to_vec();
        for entry in &result.entries {
            if let Some(found) = entry.bound {
                instances[entry.instance].known.tighten(found);
            }
        }
        let instances = instances.as_slice();
        let ranking = standings(instances, result).into_iter().map(|standing| {
            let entrant = &result.entrants[standing.entrant];
            let gap = |share: Option<f64>| share.map(|share| 100.0 * (1.0 - share));
            StandingReport {
                entrant: entrant.name(),
                track: entrant.track().name(),
                runs: standing.runs,
                failed: standing.failed,
                picked: standing.picked,
                gap_to_best_percent: gap(standing.of_known),
                gap_to_bound_percent: gap(standing.of_bound),
                rate_gap_to_bound_percent: gap(standing.of_rate_bound),
                decision_ms: (standing.decisions > 0 && !standing.spent.is_zero())
                    .then(|| 1e3 * standing.spent.as_secs_f64() / standing.decisions as f64),
            }
        });
        let ranking = ranking.collect();
        let runs = result.entries.iter();
        let runs = runs.map(|entry| EntryReport::new(entry, instances, result));
        Self {
            ranking,
            runs: runs.collect(),
            made,
            entrants: result.entrants.len(),
        }
    }
}

impl EntryReport {
    fn new(entry: &Entry, instances: &[Instance], result: &BenchmarkResult) -> Self {
        let instance = &instances[entry.instance];
        let entrant = &result.entrants[entry.entrant];
        let known = &instance.known;
        let figures = entry.solved.as_ref().ok().map(|solution| solution.figures);
        let picked = figures.map(|figures| figures.picked);
        let rate = figures.map(|figures| figures.picking_rate());
        let gap = |part: Option<f64>, whole: Option<f64>| {
            let (part, whole) = (part?, whole.filter(|whole| *whole > 0.0)?);
            Some(100.0 * (1.0 - part / whole))
        };
        let number = |count: Option<usize>| count.map(|count| count as f64);
        Self {
            instance: instance.name.clone(),
            entrant: entrant.name(),
            track: entrant.track().name(),
            items: instance.pattern.len(),
            best_known: known.picked,
            picks_upper_bound: known.picks_bound,
            picking_rate_upper_bound_per_min: known.rate_bound,
            picked,
            picking_rate_per_min: rate,
            gap_to_best_percent: gap(number(picked), number(known.picked)),
            gap_to_bound_percent: gap(number(picked), number(known.picks_bound)),
            rate_gap_to_bound_percent: gap(rate, known.rate_bound),
            better: *entrant != Entrant::Best
                && figures.is_some_and(|figures| known.is_beaten_by(&figures)),
            failure: entry.solved.as_ref().err().cloned(),
        }
    }
}
