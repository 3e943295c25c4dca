//! Upper bounds for every strategy on the patterns of a comparison.

use super::class_result::{ClassBound, class_bounds, class_results};
use super::comparison::{CaseBound, CaseResult, Comparison};
use super::draws::Draws;
use crate::error::Result;
use crate::optimize::{Environment, bound_beside};
use crate::planning::bound::{Bound, certified_percent};
use crate::station::Station;
use crate::stats;
use rayon::prelude::*;

/// The bound of a pattern, and those of its classes.
type PatternBound = (Bound, Vec<ClassBound>);

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
        let bounds: Result<Vec<PatternBound>> = drawn
            .par_iter()
            .enumerate()
            .map(|(place, (seed, pattern))| {
                let picked = result.methods.iter();
                let picked = picked.map(|method| method.runs[place].figures.picked).max();
                let scene = draws.scene(*seed, pattern, station)?;
                let bound = bound_beside(&scene, picked.unwrap_or_default(), environment)?;
                let classes = result.methods.iter();
                let classes = classes.map(|method| method.runs[place].classes.as_slice());
                let classes: Vec<_> = classes.collect();
                let classes = class_bounds(&scene, &classes, environment)?;
                progress.advance(1);
                Ok((bound, classes))
            })
            .collect();
        let bounds = match bounds {
            Err(error) if error.is_interrupted() => break,
            bounds => bounds?,
        };
        let (bounds, of_classes): (Vec<Bound>, Vec<_>) = bounds.into_iter().unzip();
        result.bound = Some(summarise(result, &bounds));
        for method in &mut result.methods {
            let classes = method.runs.iter().map(|run| run.classes.as_slice());
            method.classes = class_results(classes, Some(&of_classes));
        }
    }
    progress.end();
    Ok(())
}

fn summarise(result: &CaseResult, bounds: &[Bound]) -> CaseBound {
    let first = &result.methods[0];
    let picks: Vec<usize> = bounds.iter().map(|bound| bound.value as usize).collect();
    let most: usize = picks.iter().sum();
    let shares = bounds.iter().zip(&first.runs);
    let shares: Vec<f64> = shares
        .map(|(bound, run)| run.figures.share_of(bound.value))
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
