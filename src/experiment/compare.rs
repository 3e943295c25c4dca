//! Compares methods on cases, with paired differences.

use super::bounds::{PatternBound, bounds_of};
use super::case::Case;
use super::class_result::class_results;
use super::comparison::{CaseResult, Comparison, MethodResult};
use super::draws::Draws;
use super::method::{Method, MethodRun};
use crate::decision::{Figures, picked_shares};
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::purity::PurityByBin;
use crate::shards::none_complete;
use crate::sim::Scene;
use crate::station::Station;
use crate::stats;
use crate::throughput::Throughput;
use rayon::prelude::*;

/// Runs `methods` on `cases`; random cases on as many patterns as `draws` has replicates, with the
/// seeds that follow its first. The other methods are compared with the first. If failures are
/// simulated, every case is random: run r draws its random events from the first seed + r. The same
/// input gives the same result on any number of threads. A stop request takes effect after a whole
/// case.
///
/// # Errors
/// A pattern that cannot be generated or read or that does not fit on the belt, an illegal
/// action, or [`Interrupted`](crate::error::ErrorKind) before the first case is complete.
pub fn compare_methods(
    station: &Station,
    methods: Vec<Method>,
    cases: &[Case],
    draws: Draws,
    environment: &Environment,
) -> Result<Comparison> {
    let mut drawn = Vec::with_capacity(cases.len());
    for case in cases {
        drawn.push(draws.patterns(case, station)?);
    }
    let total: usize = drawn.iter().map(Vec::len).sum();
    environment
        .progress
        .begin("comparing", total as u64, "patterns");
    let mut results = Vec::with_capacity(cases.len());
    for (case, drawn) in cases.iter().zip(drawn) {
        let name = runs_of(case);
        let run = |(place, (seed, pattern)): (usize, &(Option<u64>, Pattern))| {
            let runs = environment.ledger.unit(&name, place, || {
                let scene = draws.scene(*seed, pattern, station);
                let scene = scene.map_err(|error| error.inside(&case.name))?;
                all_methods_on(&methods, &scene, environment)
            });
            environment.progress.advance(1);
            runs.transpose()
        };
        let by_pattern = drawn.par_iter().enumerate().map(run);
        let by_pattern: Option<Result<Vec<Vec<MethodRun>>>> = by_pattern.collect();
        let by_pattern = match by_pattern.transpose() {
            Err(error) if error.is_interrupted() && !results.is_empty() => break,
            by_pattern => by_pattern?,
        };
        // Missing in a part of the shards.
        let Some(by_pattern) = by_pattern else {
            continue;
        };
        let (seeds, patterns): (Vec<_>, Vec<_>) = drawn.into_iter().unzip();
        results.push(CaseResult {
            case: case.clone(),
            seeds,
            methods: summarise(&by_pattern, methods.len()),
            bound: None,
            weighs: patterns.iter().any(|pattern| pattern.weighs_on(station)),
        });
    }
    environment.progress.end();
    if results.is_empty() {
        return Err(none_complete("case"));
    }
    Ok(Comparison {
        methods,
        cases: results,
        planned: cases.len(),
        first_seed: draws.first_seed,
    })
}

/// Runs the methods, and with `bounded` computes the bounds, on the patterns that the shard of the
/// environment's ledger owns, which records them.
///
/// # Errors
/// As for [`compare_methods`] and [`add_bounds`](super::add_bounds).
pub fn compare_in_shard(
    station: &Station,
    methods: &[Method],
    cases: &[Case],
    (draws, bounded): (Draws, bool),
    environment: &Environment,
) -> Result<()> {
    let Environment {
        progress, ledger, ..
    } = environment;
    let mut own = Vec::new();
    let mut unit = 0;
    for case in cases {
        for (place, (seed, pattern)) in draws.patterns(case, station)?.into_iter().enumerate() {
            if ledger.owns(unit) {
                own.push((case, place, seed, pattern));
            }
            unit += 1;
        }
    }
    progress.begin("comparing", own.len() as u64, "patterns");
    own.par_iter()
        .try_for_each(|(case, place, seed, pattern)| {
            let scene = draws.scene(*seed, pattern, station);
            let scene = scene.map_err(|error| error.inside(&case.name))?;
            let run = || all_methods_on(methods, &scene, environment);
            let runs = ledger.unit(&runs_of(case), *place, run)?;
            if let (true, Some(runs)) = (bounded, runs) {
                let runs: Vec<&MethodRun> = runs.iter().collect();
                let bound = || PatternBound::beside(&runs, &scene, environment);
                ledger.unit(&bounds_of(case), *place, bound)?;
            }
            progress.advance(1);
            Result::Ok(())
        })?;
    progress.end();
    Ok(())
}

/// The name of the runs on the patterns of a case, among the units of work.
fn runs_of(case: &Case) -> String {
    format!("runs of case {}", case.name)
}

/// All methods on one pattern.
fn all_methods_on(
    methods: &[Method],
    scene: &Scene,
    environment: &Environment,
) -> Result<Vec<MethodRun>> {
    if environment.stopped() {
        return Err(Error::interrupted());
    }
    let runs = methods.iter().map(|method| method.run(scene, environment));
    runs.collect()
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
    let steady = |method: usize| by_pattern.iter().map(|runs| &runs[method].steady).collect();
    let throughputs = Throughput::beside(&(0..methods).map(steady).collect::<Vec<_>>());
    throughputs
        .into_iter()
        .enumerate()
        .map(|(method, throughput)| {
            let rates = figure(method, &Figures::picking_rate);
            let differences: Vec<f64> = rates.iter().zip(&first).map(|(a, b)| a - b).collect();
            let picking_rate = stats::mean(&rates);
            let runs: Vec<Figures> = by_pattern.iter().map(|runs| runs[method].figures).collect();
            let shares = picked_shares(&runs);
            let contents = by_pattern.iter().map(|runs| runs[method].contents.as_ref());
            let contents: Option<Vec<_>> = contents.collect();
            let classes = by_pattern
                .iter()
                .map(|runs| runs[method].classes.as_slice());
            MethodResult {
                classes: class_results(classes, None),
                runs: by_pattern.iter().map(|runs| runs[method].clone()).collect(),
                picked_share: stats::mean(&shares),
                picked_share_interval: stats::share_mean_interval(&shares),
                end: stats::mean(&figure(method, &|f| f.end)),
                throughput,
                picking_rate,
                picking_rate_interval: stats::rate_mean_interval(&rates),
                weighted_rate: stats::mean(&figure(method, &Figures::weighted_rate)),
                difference: stats::mean_interval(&differences),
                // A line that picks nothing at all has no rate to compare with.
                benefit: if mean_of_first > 0.0 {
                    picking_rate / mean_of_first - 1.0
                } else {
                    0.0
                },
                purity: contents.and_then(|contents| PurityByBin::of(&contents)),
            }
        })
        .collect()
}
