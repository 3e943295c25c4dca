//! Tables for other programs of the process, by Arrow's C stream interface
//! (<https://arrow.apache.org/docs/format/CDataInterface/PyCapsuleInterface.html>).

use arrow_array::ffi_stream::FFI_ArrowArrayStream;
use arrow_array::{
    ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, RecordBatchIterator,
    StringArray, UInt64Array,
};
use numpy::PyReadonlyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict};
use std::sync::Arc;

/// A capsule with the table of these columns, for ``__arrow_c_stream__``. Its reader has the memory.
#[pyfunction]
pub(crate) fn arrow_stream<'py>(
    py: Python<'py>,
    columns: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyCapsule>> {
    let read = |(name, values): (Bound<'py, PyAny>, Bound<'py, PyAny>)| {
        Ok((name.extract::<String>()?, column(&values)?))
    };
    let columns: Vec<(String, ArrayRef)> = columns.iter().map(read).collect::<PyResult<_>>()?;
    let batch = RecordBatch::try_from_iter(columns)
        .map_err(|error| PyValueError::new_err(format!("columns: {error}")))?;
    let schema = batch.schema();
    let reader = RecordBatchIterator::new([Ok(batch)], schema);
    let stream = FFI_ArrowArrayStream::new(Box::new(reader));
    PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
}

/// The values of a column: an array of numbers or flags, or of texts.
fn column(values: &Bound<'_, PyAny>) -> PyResult<ArrayRef> {
    if let Ok(numbers) = values.extract::<PyReadonlyArray1<'_, f64>>() {
        return Ok(Arc::new(Float64Array::from_iter_values(
            numbers.as_array().iter().copied(),
        )));
    }
    if let Ok(counts) = values.extract::<PyReadonlyArray1<'_, i64>>() {
        return Ok(Arc::new(Int64Array::from_iter_values(
            counts.as_array().iter().copied(),
        )));
    }
    if let Ok(counts) = values.extract::<PyReadonlyArray1<'_, u64>>() {
        return Ok(Arc::new(UInt64Array::from_iter_values(
            counts.as_array().iter().copied(),
        )));
    }
    if let Ok(flags) = values.extract::<PyReadonlyArray1<'_, bool>>() {
        return Ok(Arc::new(
            flags
                .as_array()
                .iter()
                .map(|flag| Some(*flag))
                .collect::<BooleanArray>(),
        ));
    }
    let texts = values.try_iter()?.map(|text| text?.extract::<String>());
    let texts = texts.collect::<PyResult<Vec<_>>>()?;
    Ok(Arc::new(StringArray::from_iter_values(texts)))
}
