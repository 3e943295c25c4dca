//! Patterns from data frames.

use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat, PyInt, PyList};

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

/// The names of the columns of `frame`: those of pandas and polars are in `columns`, Arrow's, which has its
/// values there, in `column_names`.
fn column_names<'py>(frame: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let unusable = |problem: String, cure: &str| {
        Err(PyTypeError::new_err(format!(
            "frame: {problem}\n  cure: {cure}"
        )))
    };
    if frame.hasattr("collect_schema")? && !frame.hasattr("to_dict")? {
        return unusable(
            format!("a {} has no values yet", frame.get_type()),
            "call its `collect` first",
        );
    }
    match frame
        .getattr("column_names")
        .or_else(|_| frame.getattr("columns"))
    {
        Ok(names) => Ok(names),
        Err(_) => unusable(
            format!("a {} has no columns", frame.get_type()),
            "give a data frame of pandas or polars, or a table of Arrow",
        ),
    }
}

/// The arguments of ``Pattern`` in the columns of `frame`, of pandas, polars or Arrow.
pub(crate) fn arguments<'py>(frame: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    let known = COLUMNS.map(|(column, _)| column).join(", ");
    let arguments = PyDict::new(frame.py());
    let names = column_names(frame)?.try_iter()?;
    let names = names.map(|name| Ok(name?.str()?.to_string()));
    let names: Vec<String> = names.collect::<PyResult<_>>()?;
    for (place, name) in names.iter().enumerate() {
        let Some((_, argument)) = COLUMNS.iter().find(|(column, _)| column == name) else {
            return Err(PyValueError::new_err(format!(
                "frame: a pattern has no column `{name}`\n  cure: leave it out, or give it the name of \
                 one of {known}"
            )));
        };
        if names[..place].contains(name) || names[place + 1..].contains(name) {
            return Err(PyValueError::new_err(format!(
                "frame: two columns are called `{name}`\n  cure: leave one of them out"
            )));
        }
        arguments.set_item(argument, values(&frame.get_item(name)?, argument)?)?;
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
    let to_list = match column.hasattr("to_list")? {
        true => "to_list",
        false => "to_pylist",
    };
    let values = column.call_method0(to_list)?;
    let value = |(row, value): (usize, PyResult<Bound<'py, PyAny>>)| {
        let value = value?;
        // pandas has NaN for a missing value of any kind, and pandas.NA, which is not even itself.
        let missing = value.is_none() || !is_itself(&value);
        // The pattern says of NaN what is wrong.
        let is_null = missing && !value.is_instance_of::<PyFloat>();
        if is_null && matches!(argument, "x" | "y") {
            return Err(PyValueError::new_err(format!(
                "frame: row {row} has no `{argument}`\n  cure: give every item a place, or drop the row"
            )));
        }
        Ok(match argument {
            _ if missing && !matches!(argument, "x" | "y") => py.None().into_bound(py),
            "id" if value.is_instance_of::<PyInt>() => value.str()?.into_any(),
            _ => value,
        })
    };
    let values = values.try_iter()?.enumerate().map(value);
    PyList::new(py, values.collect::<PyResult<Vec<_>>>()?)
}

/// Whether `value` equals itself, as all but missing values do.
fn is_itself(value: &Bound<'_, PyAny>) -> bool {
    value.eq(value).unwrap_or(false)
}
