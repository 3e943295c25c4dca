//! Compares methods on cases, with paired differences.

use super::bounds::CaseBound;
use super::case::Case;
use super::method::{Method, MethodRun};
use crate::decision::Figures;
use crate::error::{Error, Result};
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::sim::{Conditions, Scene};
use crate::station::Station;
use crate::stats::{self, Interval};
use crate::throughput::Throughput;
use rayon::prelude::*;

/// One method on one case.
#[derive(Debug, Clone)]
pub struct MethodResult {
    /// Its run on each pattern.
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
}

/// All methods on one case.
#[derive(Debug, Clone)]
pub struct CaseResult {
    /// The case.
    pub case: Case,
    /// The seed of each pattern; `None` if the case is not random.
    pub seeds: Vec<Option<u64>>,
    /// The methods, in the order given.
    pub methods: Vec<MethodResult>,
    /// What no strategy can exceed, if the bound was requested.
    pub bound: Option<CaseBound>,
    /// Whether items have attributes, so that weight differs from the count.
    pub weighs: bool,
}

/// All methods on all cases.
#[derive(Debug, Clone)]
pub struct Comparison {
    /// The methods.
    pub methods: Vec<Method>,
    /// The completed cases; all of them unless the user stopped the comparison.
    pub cases: Vec<CaseResult>,
    /// Number of planned cases.
    pub planned: usize,
    /// The seed of the first pattern of each random case.
    pub first_seed: u64,
}

/// Runs `methods` on `cases`; random cases on `replicates` patterns with the seeds
/// `first_seed`, `first_seed + 1`, ... The other methods are compared with the first. If
/// failures are simulated, every case is random: run r draws its luck from seed
/// `first_seed + r`. The same input gives the same result on any number of threads. A stop
/// request takes effect after a whole case.
///
/// # Errors
/// A pattern that cannot be generated or read or that does not fit on the belt, an illegal
/// action, or [`Error::Interrupted`] before the first case is complete.
pub fn compare(
    station: &Station,
    methods: Vec<Method>,
    cases: &[Case],
    replicates: usize,
    first_seed: u64,
    conditions: &Conditions,
    environment: &Environment,
) -> Result<Comparison> {
    let draws = Draws {
        replicates,
        first_seed,
        conditions,
    };
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
                return Err(Error::Interrupted);
            }
            let scene = draws.scene(*seed, pattern, station);
            let scene = scene.map_err(|error| error.inside(&case.name))?;
            let runs = methods.iter().map(|method| method.run(&scene)).collect();
            environment.progress.advance(1);
            runs
        };
        let by_pattern: Result<Vec<Vec<MethodRun>>> =
            seeds.par_iter().zip(&patterns).map(run).collect();
        let by_pattern = match by_pattern {
            Err(Error::Interrupted) if !results.is_empty() => break,
            by_pattern => by_pattern?,
        };
        results.push(CaseResult {
            case: case.clone(),
            seeds,
            methods: summarise(&by_pattern, methods.len()),
            bound: None,
            weighs: patterns.iter().any(Pattern::has_attributes),
        });
    }
    environment.progress.end();
    Ok(Comparison {
        methods,
        cases: results,
        planned: cases.len(),
        first_seed,
    })
}

/// What a case is drawn from: its patterns, and the luck of each run.
#[derive(Clone, Copy)]
pub struct Draws<'a> {
    /// Number of patterns of each random case.
    pub replicates: usize,
    /// The seed of the first pattern; the others follow.
    pub first_seed: u64,
    /// What the camera sees and what goes wrong.
    pub conditions: &'a Conditions,
}

impl Draws<'_> {
    /// The patterns of `case`, each with its seed if it has one.
    pub(super) fn patterns(
        &self,
        case: &Case,
        station: &Station,
    ) -> Result<Vec<(Option<u64>, Pattern)>> {
        let patterns = case.patterns(station.belt(), self.replicates, self.first_seed)?;
        let random = patterns.iter().any(|(seed, _)| seed.is_some());
        if random || !self.conditions.disturbances.any() {
            return Ok(patterns);
        }
        let seeds = (0..self.replicates as u64).map(|r| Some(self.first_seed.wrapping_add(r)));
        let again = patterns.iter().map(|(_, pattern)| pattern).cycle();
        Ok(seeds.zip(again.cloned()).collect())
    }

    /// The scene for one of the patterns.
    pub(super) fn scene<'s>(
        &self,
        seed: Option<u64>,
        pattern: &'s Pattern,
        station: &'s Station,
    ) -> Result<Scene<'s>> {
        let luck = self.conditions.with_seed(seed.unwrap_or(self.first_seed));
        Scene::under(station, pattern, luck)
    }
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
            let shares = figure(method, &Figures::picked_share);
            MethodResult {
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
            }
        })
        .collect()
}
