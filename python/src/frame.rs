//! Patterns from data frames.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyInt, PyList};

/// The columns of a pattern file, each with the argument of ``Pattern`` that it is.
const COLUMNS: [(&str, &str); 9] = [
    ("id", "id"),
    ("x", "x"),
    ("y", "y"),
    ("area_cm2", "area_cm2"),
    ("p_detection", "p_detection"),
    ("p_grasp", "p_grasp"),
    ("weight", "weight"),
    ("class", "item_class"),
    ("true_class", "true_class"),
];

/// The arguments of ``Pattern`` in the columns of `frame`, of pandas or polars.
pub(crate) fn arguments<'py>(frame: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    let known = COLUMNS.map(|(column, _)| column).join(", ");
    let columns = frame.getattr("columns").map_err(|_| {
        PyTypeError::new_err(format!(
            "frame: a {} has no columns\n  cure: give a data frame of pandas or polars",
            frame.get_type()
        ))
    })?;
    let arguments = PyDict::new(frame.py());
    for name in columns.try_iter()? {
        let name = name?.str()?.to_string();
        let Some((_, argument)) = COLUMNS.iter().find(|(column, _)| *column == name) else {
            return Err(PyValueError::new_err(format!(
                "frame: a pattern has no column `{name}`\n  cure: leave it out, or give it the name of \
                 one of {known}"
            )));
        };
        arguments.set_item(argument, values(&frame.get_item(&name)?, argument)?)?;
    }
    for needed in ["x", "y"] {
        if !arguments.contains(needed)? {
            return Err(PyValueError::new_err(format!(
                "frame: there is no column `{needed}`\n  cure: add it; a pattern can have {known}"
            )));
        }
    }
    Ok(arguments)
}

/// The values of `column`, which is for `argument`, with None where there is none.
fn values<'py>(column: &Bound<'py, PyAny>, argument: &str) -> PyResult<Bound<'py, PyList>> {
    let py = column.py();
    let values = column.call_method0("to_list")?;
    let value = |value: PyResult<Bound<'py, PyAny>>| {
        let value = value?;
        // pandas has NaN for a missing value of any kind, and pandas.NA, which is not even itself.
        let missing = !matches!(argument, "x" | "y") && !is_itself(&value);
        Ok(match argument {
            _ if missing => py.None().into_bound(py),
            "id" if value.is_instance_of::<PyInt>() => value.str()?.into_any(),
            _ => value,
        })
    };
    let values = values.try_iter()?.map(value);
    PyList::new(py, values.collect::<PyResult<Vec<_>>>()?)
}

/// Whether `value` equals itself, as all but missing values do.
fn is_itself(value: &Bound<'_, PyAny>) -> bool {
    value.eq(value).unwrap_or(false)
}
