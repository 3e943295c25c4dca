//! Sweeps of a quantity of the line.

use crate::conditions::ConditionArguments;
use crate::errors::exception;
use crate::report::{Report, shown};
use crate::scalars;
use crate::scored::{FeedArguments, GivenPatterns, patterns_of};
use crate::station::Station;
use crate::strategy::strategies;
use pickline::experiment::Axis;
use pickline::study::{SweepOptions, SweepStudy};
use pickline_report::{Provenance, SweepReport};
use pyo3::prelude::*;

/// The report of a :class:`pickline.Sweep`; ``call`` is how it says who made it.
#[pyfunction]
#[pyo3(signature = (station, sweep, *, strategy, patterns, items, feed, from_, to, step, purity,
    robust, train_patterns, train_items, greedy, tune, bound, area, p_detection, p_grasp, classes, seed,
    conditions, progress, call))]
#[expect(clippy::too_many_arguments, reason = "the options of the program")]
pub(crate) fn sweep(
    py: Python<'_>,
    station: &Station,
    sweep: &str,
    strategy: Vec<Bound<'_, PyAny>>,
    #[pyo3(from_py_with = GivenPatterns::read)] patterns: GivenPatterns,
    #[pyo3(from_py_with = scalars::optional_count::items)] items: Option<usize>,
    #[pyo3(from_py_with = FeedArguments::read)] feed: FeedArguments,
    from_: Option<f64>,
    to: Option<f64>,
    step: Option<f64>,
    purity: Option<f64>,
    robust: Option<&str>,
    train_patterns: Option<&str>,
    #[pyo3(from_py_with = scalars::optional_count::train_items)] train_items: Option<usize>,
    greedy: bool,
    tune: bool,
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
    let mut conditions = conditions.resolve(seed)?;
    let axis = Axis::named(sweep).map_err(exception)?;
    // As the library does, for the provenance.
    conditions.disturbances.misdetections |= axis == Axis::MinDetection;
    let (strategies, callables) = strategies(&strategy)?;
    let line = &*station.inner;
    let worked = callables.long(py, progress.as_ref(), |environment| {
        let attributes = [area, p_detection, p_grasp, classes];
        let patterns = patterns_of(&patterns, items, &feed, attributes)?;
        let source = station.source.clone();
        let mut options = SweepOptions::default()
            .with_axis(axis)
            .with_robots(move |robots| source.station(Some(robots)))
            .with_patterns(patterns)
            .with_seed(seed)
            .with_conditions(conditions.clone())
            .with_greedy(greedy)
            .with_tune(tune)
            .with_bound(bound);
        if let Some(purity) = purity {
            options = options.with_purity(purity);
        }
        options = options.with_named_training(robust, train_patterns, train_items, (line, seed))?;
        if let Some(from) = from_ {
            options = options.with_from(from);
        }
        if let Some(to) = to {
            options = options.with_to(to);
        }
        if let Some(step) = step {
            options = options.with_step(step);
        }
        let options = strategies
            .into_iter()
            .fold(options, SweepOptions::with_strategy);
        let study = SweepStudy::new(line, &options)?;
        let swept = study.run(environment)?;
        let scored = &study.set().description;
        let made = Provenance::new(call, &station.name, line, scored, seed).under(&conditions);
        Ok(SweepReport::of_study(
            &swept,
            axis,
            study.is_papers_case(),
            shown(),
            made,
        ))
    })?;
    Ok(Report::of(worked))
}
