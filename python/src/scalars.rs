//! Whole numbers from Python.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBool;

/// Reads the whole number of the argument `name`, 0 or more, of at most `most`; a bool is not one.
fn whole(name: &str, given: &Bound<'_, PyAny>, most: u64) -> PyResult<u64> {
    let is_whole = given.hasattr("__index__")? && !given.is_instance_of::<PyBool>();
    if !is_whole {
        return Err(PyTypeError::new_err(format!(
            "{name}: {} is not a whole number\n  cure: give an int",
            given.repr()?
        )));
    }
    given
        .extract::<u64>()
        .ok()
        .filter(|number| *number <= most)
        .ok_or_else(|| {
            PyValueError::new_err(format!(
                "{name}: {given} is out of range\n  cure: give a whole number from 0 to {most}"
            ))
        })
}

/// Readers of arguments, each with the name of the argument, for numbers of things.
macro_rules! counts {
    ($($name:ident),*) => {$(
        pub(crate) fn $name(given: &Bound<'_, PyAny>) -> PyResult<usize> {
            whole(stringify!($name), given, u64::from(u32::MAX)).map(|number| number as usize)
        }
    )*};
}

/// The same for numbers that may be left open.
macro_rules! optional_counts {
    ($($name:ident),*) => {$(
        pub(crate) fn $name(given: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
            match given.is_none() {
                true => Ok(None),
                false => super::count::$name(given).map(Some),
            }
        }
    )*};
}

pub(crate) mod count {
    use super::{Bound, PyAny, PyResult, whole};

    counts!(
        items,
        iterations,
        max_runs,
        min_frames,
        num_envs,
        replicates,
        robots,
        slots,
        starts,
        train_items,
        validate
    );
}

pub(crate) mod optional_count {
    use super::{Bound, PyAny, PyAnyMethods, PyResult};

    optional_counts!(items, max_runs, robots, train_items, validate);
}

/// The seed of random numbers.
pub(crate) fn seed(given: &Bound<'_, PyAny>) -> PyResult<u64> {
    whole("seed", given, u64::MAX)
}
