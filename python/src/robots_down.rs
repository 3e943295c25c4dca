//! A line with each of its robots halted in turn.

use crate::conditions::ConditionArguments;
use crate::report::{Report, shown};
use crate::scalars;
use crate::scored::{FeedArguments, GivenPatterns, patterns_of};
use crate::station::Station;
use crate::strategy::strategies;
use pickline::study::{RobotsDownOptions, RobotsDownStudy, RobustTraining};
use pickline_report::{Provenance, RobotsDownReport};
use pyo3::prelude::*;

/// The report of a :class:`pickline.RobotsDown`; ``call`` is how it says who made it.
#[pyfunction]
#[pyo3(signature = (station, *, strategy, patterns, items, feed, robust, train_patterns, train_items,
    greedy, tune, area, p_detection, p_grasp, classes, seed, conditions, progress, call))]
#[expect(clippy::too_many_arguments, reason = "the options of the program")]
pub(crate) fn robots_down(
    py: Python<'_>,
    station: &Station,
    strategy: Vec<Bound<'_, PyAny>>,
    #[pyo3(from_py_with = GivenPatterns::read)] patterns: GivenPatterns,
    #[pyo3(from_py_with = scalars::optional_count::items)] items: Option<usize>,
    #[pyo3(from_py_with = FeedArguments::read)] feed: FeedArguments,
    robust: Option<&str>,
    train_patterns: Option<&str>,
    #[pyo3(from_py_with = scalars::optional_count::train_items)] train_items: Option<usize>,
    greedy: bool,
    tune: bool,
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
        let training =
            RobustTraining::named(robust, train_patterns, train_items, false, (line, seed))?;
        let options = RobotsDownOptions::default()
            .with_scored_patterns(patterns)
            .with_seed(seed)
            .with_conditions(conditions.clone())
            .with_training(training)
            .with_greedy(greedy)
            .with_tune(tune);
        let options = strategies
            .into_iter()
            .fold(options, RobotsDownOptions::with_strategy);
        let study = RobotsDownStudy::new(line, &options)?;
        let found = study.run(environment)?;
        let halted = &found.robots_down;
        let scored = &study.set().description;
        let made = Provenance::new(call, &station.name, line, scored, seed)
            .under(&conditions)
            .of_parts(halted.halted.len(), halted.planned, "robots");
        Ok(RobotsDownReport::new(
            halted,
            shown().notes(&found.notes),
            made,
        ))
    })?;
    Ok(Report::of(worked))
}
