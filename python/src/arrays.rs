//! Columns of numbers from Python and for Python.

use numpy::{
    IntoPyArray, PyArray1, PyArrayDescrMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// The numbers of the argument `name`: an array of integers or floats with one dimension, or what numpy
/// makes one of.
pub(crate) fn numbers(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let numpy = given.py().import("numpy")?;
    let masked = numpy.getattr("ma")?;
    if masked.call_method1("is_masked", (given,))?.is_truthy()? {
        return Err(PyValueError::new_err(format!(
            "{name}: some values are masked\n  cure: leave these items out, or give their values"
        )));
    }
    let array = numpy.call_method1("asarray", (given,)).map_err(|error| {
        PyValueError::new_err(format!(
            "{name}: {}\n  cure: give an array with one dimension, with a number for every item",
            error.value(given.py())
        ))
    })?;
    let untyped = array.cast::<PyUntypedArray>()?;
    let dtype = untyped.dtype();
    if !matches!(dtype.kind(), b'i' | b'u' | b'f') {
        return Err(PyTypeError::new_err(format!(
            "{name}: an array of dtype {dtype}\n  cure: give an array of float64, or numbers"
        )));
    }
    if untyped.ndim() != 1 {
        return Err(PyValueError::new_err(format!(
            "{name}: an array of shape {:?}\n  cure: give an array with one dimension, with a \
             number for every item",
            untyped.shape()
        )));
    }
    let floats = array.call_method1("astype", ("float64",))?;
    let floats: PyReadonlyArrayDyn<f64> = floats.extract()?;
    Ok(floats.as_array().iter().copied().collect())
}

/// Like [`numbers`] for an argument that may be missing, and in which `None` is a missing value.
pub(crate) fn optional_numbers(
    name: &str,
    given: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Vec<Option<f64>>>> {
    let Some(given) = given else {
        return Ok(None);
    };
    if let Ok(list) = given.cast::<pyo3::types::PyList>() {
        let read = |value: Bound<'_, PyAny>| value.extract::<Option<f64>>();
        let values: PyResult<Vec<_>> = list.iter().map(read).collect();
        return values.map(Some).map_err(|error| {
            let problem = error.value(given.py()).to_string();
            PyTypeError::new_err(format!(
                "{name}: {problem}\n  cure: give numbers, and None for unknown ones"
            ))
        });
    }
    let values = numbers(name, given)?;
    Ok(Some(values.into_iter().map(Some).collect()))
}

/// The names of the argument `name`, in which `None` is a missing value.
pub(crate) fn optional_names(
    name: &str,
    given: Option<&Bound<'_, PyAny>>,
) -> PyResult<Option<Vec<Option<String>>>> {
    let Some(given) = given else {
        return Ok(None);
    };
    let wrong = |problem: String| {
        PyTypeError::new_err(format!(
            "{name}: {problem}\n  cure: give a list of texts, and None for unknown ones"
        ))
    };
    if given.is_instance_of::<pyo3::types::PyString>() {
        return Err(wrong("a single text".into()));
    }
    let values = given.try_iter().map_err(|_| wrong("not a list".into()))?;
    values
        .map(|value| {
            let value = value?;
            value
                .extract::<Option<String>>()
                .map_err(|_| wrong(format!("{value} is not a text")))
        })
        .collect::<PyResult<Vec<_>>>()
        .map(Some)
}

/// Values as an array for Python.
pub(crate) fn array<'py, T: numpy::Element>(
    py: Python<'py>,
    values: impl Iterator<Item = T>,
) -> Bound<'py, PyArray1<T>> {
    values.collect::<Vec<_>>().into_pyarray(py)
}
