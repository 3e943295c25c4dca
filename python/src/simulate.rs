//! Simulating one run.

use crate::arrays::array;
use crate::conditions::ConditionArguments;
use crate::pattern::Pattern;
use crate::report::{Report, shown};
use crate::run::Run;
use crate::scalars;
use crate::station::Station;
use crate::strategy::{Callables, strategy_of};
use pickline::decision::{Figures, Pick};
use pickline::study::{SimulateOptions, simulate_and_check};
use pickline_report::Provenance;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// The columns of `picks`, by name.
pub(crate) fn pick_columns<'py>(py: Python<'py>, picks: &[Pick]) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let picks = || picks.iter();
    columns.set_item("robot", array(py, picks().map(|pick| pick.robot as i64)))?;
    columns.set_item("item", array(py, picks().map(|pick| i64::from(pick.item))))?;
    columns.set_item("bin", array(py, picks().map(|pick| i64::from(pick.bin))))?;
    columns.set_item("decide", array(py, picks().map(|pick| pick.decide)))?;
    columns.set_item("grasp", array(py, picks().map(|pick| pick.grasp)))?;
    columns.set_item("release", array(py, picks().map(|pick| pick.release)))?;
    columns.set_item("x", array(py, picks().map(|pick| pick.meet.x)))?;
    columns.set_item("y", array(py, picks().map(|pick| pick.meet.y)))?;
    Ok(columns)
}

/// The figures of a run, by name.
pub(crate) fn figures_by_name<'py>(
    py: Python<'py>,
    figures: &Figures,
) -> PyResult<Bound<'py, PyDict>> {
    let named = PyDict::new(py);
    named.set_item("items", figures.items)?;
    named.set_item("picked", figures.picked)?;
    named.set_item("weight", figures.weight)?;
    named.set_item("end", figures.end)?;
    named.set_item("picking_rate", figures.picking_rate())?;
    named.set_item("weighted_rate", figures.weighted_rate())?;
    Ok(named)
}

/// The parts of a :class:`pickline.Simulation`.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "the options of the program")]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    station: &Station,
    pattern: &Pattern,
    strategy: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = ConditionArguments::read)] conditions: ConditionArguments,
    #[pyo3(from_py_with = scalars::seed)] seed: u64,
    bound: bool,
    progress: Option<Bound<'_, PyAny>>,
    call: &str,
) -> PyResult<Bound<'py, PyDict>> {
    let conditions = conditions.resolve(seed)?;
    let options = SimulateOptions::default()
        .with_seed(seed)
        .with_conditions(conditions.clone())
        .with_check(true)
        .with_bound(bound);
    let (on, of) = (&*station.inner, &*pattern.inner);
    let callables = Callables::default();
    let strategy = strategy_of(strategy, &callables)?;
    let worked = callables.long(py, progress.as_ref(), |environment| {
        simulate_and_check(on, of, &strategy, &options, environment)
    })?;
    if worked.interrupted {
        return Err(PyKeyboardInterrupt::new_err(()));
    }
    let run = worked.value;
    let outcome = &run.outcome;
    let parts = PyDict::new(py);
    parts.set_item("strategy", &run.strategy)?;
    parts.set_item("figures", figures_by_name(py, &outcome.figures)?)?;
    parts.set_item("picks", pick_columns(py, &outcome.picks)?)?;
    let failed: Vec<Pick> = outcome.failures.iter().map(|f| f.attempt).collect();
    parts.set_item("failures", pick_columns(py, &failed)?)?;
    let causes = outcome.failures.iter().map(|failure| failure.cause.name());
    parts.set_item("causes", causes.collect::<Vec<_>>())?;
    let missed = outcome.missed.iter();
    parts.set_item("missed", array(py, missed.map(|miss| i64::from(miss.item))))?;
    let reasons = outcome.missed.iter().map(|miss| miss.reason.name());
    parts.set_item("reasons", reasons.collect::<Vec<_>>())?;
    let left = outcome.left.iter();
    parts.set_item("left", array(py, left.map(|left| i64::from(left.item))))?;
    let robots = || outcome.robots.iter();
    parts.set_item("robot_picked", array(py, robots().map(|r| r.picked as i64)))?;
    parts.set_item("robot_failed", array(py, robots().map(|r| r.failed as i64)))?;
    parts.set_item("robot_weight", array(py, robots().map(|r| r.weight)))?;
    parts.set_item("robot_busy", array(py, robots().map(|r| r.busy)))?;
    parts.set_item("notes", shown().notes(&run.notes))?;
    let bound = run.bound.as_ref();
    parts.set_item("bound_picked", bound.map(|bound| bound.value))?;
    parts.set_item("bound_rate", bound.and_then(|bound| bound.rate))?;
    let made = Provenance::new(call, &station.name, on, &pattern.in_words(), seed);
    let run = Run {
        station: Arc::clone(&station.inner),
        pattern: Arc::clone(&pattern.inner),
        name: station.name.clone(),
        conditions: conditions.with_seed(seed),
        strategy: run.strategy,
        outcome: run.outcome,
        bound: run.bound,
        class_bounds: run.class_bounds,
        made: made.under(&conditions),
    };
    parts.set_item("run", Py::new(py, Report::whole(run))?)?;
    Ok(parts)
}
