//! Compares methods on cases, with paired differences.

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
        let (seeds, patterns): (Vec<_>, Vec<_>) = drawn.into_iter().unzip();
        let run = |(seed, pattern): (&Option<u64>, &Pattern)| -> Result<Vec<MethodRun>> {
            if environment.stopped() {
                return Err(Error::interrupted());
            }
            let scene = draws.scene(*seed, pattern, station);
            let scene = scene.map_err(|error| error.inside(&case.name))?;
            let runs = methods.iter().map(|method| method.run(&scene, environment));
            let runs = runs.collect();
            environment.progress.advance(1);
            runs
        };
        let by_pattern: Result<Vec<Vec<MethodRun>>> =
            seeds.par_iter().zip(&patterns).map(run).collect();
        let by_pattern = match by_pattern {
            Err(error) if error.is_interrupted() && !results.is_empty() => break,
            by_pattern => by_pattern?,
        };
        results.push(CaseResult {
            case: case.clone(),
            seeds,
            methods: summarise(&by_pattern, methods.len()),
            bound: None,
            weighs: patterns.iter().any(|pattern| pattern.weighs_on(station)),
        });
    }
    environment.progress.end();
    Ok(Comparison {
        methods,
        cases: results,
        planned: cases.len(),
        first_seed: draws.first_seed,
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
