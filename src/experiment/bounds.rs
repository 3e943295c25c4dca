//! Upper bounds for every strategy on the patterns of a comparison.

use super::case::Case;
use super::class_result::{ClassBound, class_bounds, class_results};
use super::comparison::{CaseBound, CaseResult, Comparison};
use super::draws::Draws;
use super::method::MethodRun;
use crate::error::Result;
use crate::optimize::{Environment, bound_beside};
use crate::planning::bound::certified_percent;
use crate::sim::Scene;
use crate::station::Station;
use crate::stats;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What no strategy can exceed on one pattern.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct PatternBound {
    /// The most items that can be picked.
    pub picks: f64,
    /// The highest rate [1/min]; `None` if no finite bound was found.
    pub rate: Option<f64>,
    /// The bounds of the classes.
    pub classes: Vec<ClassBound>,
}

impl PatternBound {
    /// The bound for `scene`, on which the methods made `runs`.
    ///
    /// # Errors
    /// As for [`bound_beside`].
    pub(super) fn beside(
        runs: &[&MethodRun],
        scene: &Scene,
        environment: &Environment,
    ) -> Result<Self> {
        let picked = runs.iter().map(|run| run.figures.picked).max();
        let bound = bound_beside(scene, picked.unwrap_or_default(), environment)?;
        let classes: Vec<_> = runs.iter().map(|run| run.classes.as_slice()).collect();
        Ok(Self {
            picks: bound.value,
            rate: bound.rate,
            classes: class_bounds(scene, &classes, environment)?,
        })
    }
}

/// The name of the bounds on the patterns of a case, among the units of work.
pub(super) fn bounds_of(case: &Case) -> String {
    format!("bounds of case {}", case.name)
}

/// Bounds every pattern of `comparison`, which was made on `station` from `draws`. A stop
/// request takes effect after a whole case; later cases have no bound.
///
/// # Errors
/// A pattern for which no bound can be computed.
pub fn add_bounds(
    comparison: &mut Comparison,
    station: &Station,
    draws: Draws,
    environment: &Environment,
) -> Result<()> {
    let total: usize = comparison.cases.iter().map(|case| case.seeds.len()).sum();
    let progress = environment.progress;
    progress.begin("bounding", total as u64, "patterns");
    for result in &mut comparison.cases {
        let drawn = draws.patterns(&result.case, station)?;
        let name = bounds_of(&result.case);
        let bounds: Result<Option<Vec<PatternBound>>> = drawn
            .par_iter()
            .enumerate()
            .map(|(place, (seed, pattern))| {
                let bound = environment.ledger.unit(&name, place, || {
                    let runs = result.methods.iter().map(|method| &method.runs[place]);
                    let scene = draws.scene(*seed, pattern, station)?;
                    PatternBound::beside(&runs.collect::<Vec<_>>(), &scene, environment)
                });
                progress.advance(1);
                bound.transpose()
            })
            .collect::<Option<Result<_>>>()
            .transpose();
        let bounds = match bounds {
            Err(error) if error.is_interrupted() => break,
            bounds => bounds?,
        };
        // Missing in a part of the shards.
        let Some(bounds) = bounds else { continue };
        result.bound = Some(summarise(result, &bounds));
        let of_classes: Vec<_> = bounds.into_iter().map(|bound| bound.classes).collect();
        for method in &mut result.methods {
            let classes = method.runs.iter().map(|run| run.classes.as_slice());
            method.classes = class_results(classes, Some(&of_classes));
        }
    }
    progress.end();
    Ok(())
}

fn summarise(result: &CaseResult, bounds: &[PatternBound]) -> CaseBound {
    let first = &result.methods[0];
    let picks: Vec<usize> = bounds.iter().map(|bound| bound.picks as usize).collect();
    let most: usize = picks.iter().sum();
    let shares = bounds.iter().zip(&first.runs);
    let shares: Vec<f64> = shares
        .map(|(bound, run)| run.figures.share_of(bound.picks))
        .collect();
    let rates: Option<Vec<f64>> = bounds.iter().map(|bound| bound.rate).collect();
    let mean = rates.as_deref().map(stats::mean);
    CaseBound {
        picked_share: stats::mean(&shares),
        picking_rate: mean,
        difference: rates.and_then(|rates| {
            let rates = rates.iter().zip(&first.runs);
            let differences: Vec<f64> = rates
                .map(|(rate, run)| rate - run.figures.picking_rate())
                .collect();
            stats::mean_interval(&differences)
        }),
        benefit: mean
            .filter(|_| first.picking_rate > 0.0)
            .map(|mean| mean / first.picking_rate - 1.0),
        certified: result
            .methods
            .iter()
            .map(|method| {
                let picked: usize = method.runs.iter().map(|run| run.figures.picked).sum();
                certified_percent(picked as f64, most as f64)
            })
            .collect(),
        certified_rate: result
            .methods
            .iter()
            .map(|method| mean.map(|mean| certified_percent(method.picking_rate, mean)))
            .collect(),
        picks,
    }
}
