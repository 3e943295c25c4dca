//! Whole numbers from Python.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBool;

/// Reads a whole number, 0 or more, of at most `most`; a bool is not one.
fn whole(given: &Bound<'_, PyAny>, most: u64) -> PyResult<u64> {
    let is_whole = given.hasattr("__index__")? && !given.is_instance_of::<PyBool>();
    if !is_whole {
        return Err(PyTypeError::new_err(format!(
            "{} is not a whole number\n  cure: give an int",
            given.repr()?
        )));
    }
    given
        .extract::<u64>()
        .ok()
        .filter(|number| *number <= most)
        .ok_or_else(|| {
            PyValueError::new_err(format!(
                "{given} is out of range\n  cure: give a whole number from 0 to {most}"
            ))
        })
}

/// A number of things.
pub(crate) fn count(given: &Bound<'_, PyAny>) -> PyResult<usize> {
    whole(given, u64::from(u32::MAX)).map(|number| number as usize)
}

/// A number of things that may be left open.
pub(crate) fn optional_count(given: &Bound<'_, PyAny>) -> PyResult<Option<usize>> {
    match given.is_none() {
        true => Ok(None),
        false => count(given).map(Some),
    }
}

/// The seed of random numbers.
pub(crate) fn seed(given: &Bound<'_, PyAny>) -> PyResult<u64> {
    whole(given, u64::MAX)
}
