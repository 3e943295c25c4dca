//! The search for the best assignment of rules.

use crate::conditions::ConditionArguments;
use crate::report::{Report, shown};
use crate::scalars;
use crate::scored::{FeedArguments, GivenPatterns, patterns_of};
use crate::station::Station;
use crate::strategy::strategies;
use pickline::optimize::{Grasp, Limits, Objective, Risk, SearchKind, SpeedScan};
use pickline::study::{OptimizeOptions, OptimizeStudy};
use pickline_report::{OptimumReport, Provenance};
use pyo3::prelude::*;

/// The report of a :class:`pickline.Optimum`; ``call`` is how it says who made it.
#[pyfunction]
#[pyo3(signature = (station, *, strategy, patterns, items, feed, objective, risk, search, starts, alpha,
    speed_step, max_runs, time_limit, validate, bound, area, p_detection, p_grasp, classes, seed,
    conditions, progress, call))]
#[expect(clippy::too_many_arguments, reason = "the options of the program")]
pub(crate) fn optimize(
    py: Python<'_>,
    station: &Station,
    strategy: Vec<Bound<'_, PyAny>>,
    #[pyo3(from_py_with = GivenPatterns::read)] patterns: GivenPatterns,
    #[pyo3(from_py_with = scalars::optional_count::items)] items: Option<usize>,
    #[pyo3(from_py_with = FeedArguments::read)] feed: FeedArguments,
    objective: &str,
    risk: &str,
    search: &str,
    #[pyo3(from_py_with = scalars::count::starts)] starts: usize,
    alpha: f64,
    speed_step: f64,
    #[pyo3(from_py_with = scalars::optional_count::max_runs)] max_runs: Option<usize>,
    time_limit: Option<f64>,
    #[pyo3(from_py_with = scalars::optional_count::validate)] validate: Option<usize>,
    bound: bool,
    area: Option<&str>,
    p_detection: Option<&str>,
    p_grasp: Option<&str>,
    classes: Option<&str>,
    #[pyo3(from_py_with = scalars::seed)] seed: u64,
    #[pyo3(from_py_with = ConditionArguments::read)] conditions: ConditionArguments,
    progress: Option<Bound<'_, PyAny>>,
    call: &str,
) -> PyResult<Report> {
    let conditions = conditions.resolve(seed)?;
    let (strategies, callables) = strategies(&strategy)?;
    let line = &*station.inner;
    let worked = callables.long(py, progress.as_ref(), |environment| {
        let attributes = [area, p_detection, p_grasp, classes];
        let patterns = patterns_of(&patterns, items, &feed, attributes)?;
        let scan = SpeedScan::new(speed_step, line)?;
        let objective = Objective::named(objective, scan)?;
        let grasp = Grasp::default()
            .with_starts(starts)
            .with_alpha(alpha)
            .with_seed(seed);
        let mut options = OptimizeOptions::default()
            .with_seed(seed)
            .with_patterns(patterns)
            .with_conditions(conditions.clone())
            .with_objective(objective)
            .with_scan(scan)
            .with_kind(SearchKind::named(search)?)
            .with_grasp(grasp)
            .with_risk(risk.parse::<Risk>()?)
            .with_limits(Limits::of(max_runs.map(|runs| runs as u64), time_limit)?)
            .with_bound(bound);
        if let Some(fresh) = validate {
            options = options.with_validation(fresh);
        }
        let options = strategies
            .into_iter()
            .fold(options, OptimizeOptions::with_strategy);
        let study = OptimizeStudy::new(line, &options)?;
        let optimized = study.run(environment)?;
        let set = study.set().scored();
        let made = Provenance::new(call, &station.name, line, &set.description, seed);
        let made = made.under(&conditions);
        Ok(OptimumReport::of_study(
            &optimized,
            objective,
            set,
            shown(),
            made,
        ))
    })?;
    Ok(Report::of(worked))
}
