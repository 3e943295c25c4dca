//! Episodes of strategies as data for learning offline.

use crate::arrays::array;
use crate::conditions::ConditionArguments;
use crate::errors::exception;
use crate::pattern::Pattern;
use crate::scalars;
use crate::simulate::figures_by_name;
use crate::station::Station;
use crate::strategy::{Callables, strategy_of};
use numpy::{PyArray1, PyArrayMethods};
use pickline::decision::observation::{Layout, View};
use pickline::rl::{Demonstration, Reward};
use pickline::study::{self, DemonstrateOptions};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// The full name of a strategy, and its episode on each pattern.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "keyword arguments of `to_minari`"
)]
pub(crate) fn demonstrate<'py>(
    py: Python<'py>,
    station: &Station,
    patterns: Vec<PyRef<'_, Pattern>>,
    strategy: &Bound<'_, PyAny>,
    #[pyo3(from_py_with = ConditionArguments::read)] conditions: ConditionArguments,
    observation: &str,
    #[pyo3(from_py_with = scalars::count::slots)] slots: usize,
    wait: bool,
    reward: (f64, f64),
    #[pyo3(from_py_with = scalars::seed)] seed: u64,
    progress: Option<Bound<'_, PyAny>>,
) -> PyResult<(String, Vec<Bound<'py, PyDict>>)> {
    let view: View = observation.parse().map_err(exception)?;
    let layout = Layout::new(view, slots, wait).map_err(exception)?;
    let (pick, rate) = reward;
    // The environment's own seed of what goes wrong.
    let options = DemonstrateOptions::default()
        .with_seed(seed)
        .with_conditions(conditions.resolve(0)?)
        .with_layout(layout)
        .with_reward(Reward { pick, rate });
    let patterns: Vec<&pickline::Pattern> = patterns.iter().map(|p| &*p.inner).collect();
    let line = &*station.inner;
    let callables = Callables::default();
    let strategy = strategy_of(strategy, &callables)?;
    let worked = callables.long(py, progress.as_ref(), |environment| {
        study::demonstrate(line, &patterns, &strategy, &options, environment)
    })?;
    if worked.interrupted {
        return Err(PyKeyboardInterrupt::new_err(()));
    }
    let found = worked.value;
    let shown = found
        .episodes
        .iter()
        .map(|episode| shown(py, layout, episode));
    Ok((found.strategy, shown.collect::<PyResult<_>>()?))
}

/// The arrays and figures of an episode, by name.
fn shown<'py>(
    py: Python<'py>,
    layout: Layout,
    episode: &Demonstration,
) -> PyResult<Bound<'py, PyDict>> {
    let rows = episode.actions.len() + 1;
    let parts = PyDict::new(py);
    let observations = PyArray1::from_slice(py, &episode.observations);
    let observations = observations.reshape([rows, layout.observation()])?;
    parts.set_item("observations", observations)?;
    let masks = PyArray1::from_slice(py, &episode.masks);
    parts.set_item("masks", masks.reshape([rows, layout.actions()])?)?;
    let actions = episode.actions.iter().map(|action| *action as i64);
    parts.set_item("actions", array(py, actions))?;
    parts.set_item("rewards", array(py, episode.rewards.iter().copied()))?;
    parts.set_item("left_out", episode.left_out)?;
    parts.set_item("figures", figures_by_name(py, &episode.figures)?)?;
    Ok(parts)
}
