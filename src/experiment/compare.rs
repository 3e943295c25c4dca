//! Methods by cases, with paired differences.

use super::case::Case;
use super::method::{Method, MethodRun};
use crate::decision::Figures;
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::sim::{Conditions, Scene};
use crate::station::Station;
use crate::stats::{self, Interval};
use rayon::prelude::*;

/// One method on one case.
#[derive(Debug, Clone)]
pub struct MethodResult {
    /// Its run on each pattern.
    pub runs: Vec<MethodRun>,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// Its 95 % interval.
    pub picked_share_interval: Interval,
    /// Mean end of the run [s].
    pub end: f64,
    /// Mean picking rate [1/min].
    pub picking_rate: f64,
    /// Its 95 % interval.
    pub picking_rate_interval: Interval,
    /// Mean weighted rate [1/min].
    pub weighted_rate: f64,
    /// 95 % interval of this method's picking rate minus the first method's, paired
    /// over patterns [1/min].
    pub difference: Interval,
    /// How much higher the mean picking rate is than the first method's, as a share.
    pub benefit: f64,
}

/// All methods on one case.
#[derive(Debug, Clone)]
pub struct CaseResult {
    /// The case.
    pub case: Case,
    /// The seed of each pattern, where it is random.
    pub seeds: Vec<Option<u64>>,
    /// The methods, in the order given.
    pub methods: Vec<MethodResult>,
}

/// All methods on all cases.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// The methods.
    pub methods: Vec<Method>,
    /// The cases.
    pub cases: Vec<CaseResult>,
}

/// Runs `methods` on `cases`; random ones on `replicates` patterns under the seeds
/// `first_seed`, `first_seed + 1`, ... The first method is the one that the others are
/// measured against. Where something goes wrong every case is random: the run of place r
/// has the luck of seed `first_seed + r`. The same input gives the same result on any number of threads.
///
/// # Errors
/// A pattern that cannot be had or does not lie on the belt, an illegal action,
/// [`Error::Interrupted`].
pub fn compare(
    station: &Station,
    methods: Vec<Method>,
    cases: &[Case],
    replicates: usize,
    first_seed: u64,
    conditions: &Conditions,
    environment: &Environment,
) -> Result<Comparison> {
    let mut drawn = Vec::with_capacity(cases.len());
    for case in cases {
        let mut patterns = case.patterns(station.belt().width, replicates, first_seed)?;
        if conditions.disturbances.any() && patterns.iter().all(|(seed, _)| seed.is_none()) {
            let seeds = (0..replicates as u64).map(|r| Some(first_seed.wrapping_add(r)));
            let again = patterns.iter().map(|(_, pattern)| pattern).cycle();
            patterns = seeds.zip(again.cloned()).collect();
        }
        drawn.push(patterns);
    }
    let total: usize = drawn.iter().map(Vec::len).sum();
    environment
        .progress
        .begin("comparing", total as u64, "patterns");
    let mut results = Vec::with_capacity(cases.len());
    for (case, drawn) in cases.iter().zip(drawn) {
        let (seeds, patterns): (Vec<_>, Vec<_>) = drawn.into_iter().unzip();
        let run = |(seed, pattern): (&Option<u64>, &Pattern)| -> Result<Vec<MethodRun>> {
            if environment.stopped() {
                return Err(Error::Interrupted);
            }
            let luck = conditions.with_seed(seed.unwrap_or(first_seed));
            let scene =
                Scene::under(station, pattern, luck).map_err(|error| error.inside(&case.name))?;
            let runs = methods.iter().map(|method| method.run(&scene)).collect();
            environment.progress.advance(1);
            runs
        };
        let by_pattern: Vec<Vec<MethodRun>> = seeds
            .par_iter()
            .zip(&patterns)
            .map(run)
            .collect::<Result<_>>()?;
        results.push(CaseResult {
            case: case.clone(),
            seeds,
            methods: summarise(&by_pattern, methods.len()),
        });
    }
    environment.progress.end();
    Ok(Comparison {
        methods,
        cases: results,
    })
}

fn summarise(by_pattern: &[Vec<MethodRun>], methods: usize) -> Vec<MethodResult> {
    let figure = |method: usize, of: &dyn Fn(&Figures) -> f64| -> Vec<f64> {
        by_pattern
            .iter()
            .map(|runs| of(&runs[method].figures))
            .collect()
    };
    let first = figure(0, &Figures::picking_rate);
    let mean_of_first = stats::mean(&first);
    (0..methods)
        .map(|method| {
            let rates = figure(method, &Figures::picking_rate);
            let differences: Vec<f64> = rates.iter().zip(&first).map(|(a, b)| a - b).collect();
            let picking_rate = stats::mean(&rates);
            let shares = figure(method, &Figures::picked_share);
            MethodResult {
                runs: by_pattern.iter().map(|runs| runs[method].clone()).collect(),
                picked_share: stats::mean(&shares),
                picked_share_interval: stats::mean_interval(&shares),
                end: stats::mean(&figure(method, &|f| f.end)),
                picking_rate,
                picking_rate_interval: stats::mean_interval(&rates),
                weighted_rate: stats::mean(&figure(method, &Figures::weighted_rate)),
                difference: stats::mean_interval(&differences),
                // A line that picks nothing at all has no rate to be better than.
                benefit: if mean_of_first > 0.0 {
                    picking_rate / mean_of_first - 1.0
                } else {
                    0.0
                },
            }
        })
        .collect()
}
