//! Panics on purpose, in builds with debug assertions only: so that a test can hold the promise that
//! Python never sees one.

use crate::work;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use std::panic::panic_any;

/// Panics with a text, a formatted text, or something that is no text.
pub(crate) fn panic_with(message: &str) -> ! {
    match message {
        "" => panic_any(7u32),
        "fixed" => panic!("a fixed text"),
        text => panic!("{text}"),
    }
}

/// Panics with `message` in work of this kind: ``quick``, ``parallel``, ``scattered`` over the threads, or
/// ``long``.
#[pyfunction]
pub(crate) fn _panic(py: Python<'_>, kind: &str, message: &str) -> PyResult<()> {
    match kind {
        "quick" => work::quick(py, || panic_with(message)),
        "parallel" => work::parallel(py, || panic_with(message)),
        "scattered" => work::parallel(py, || {
            (0..1000).into_par_iter().for_each(|place| {
                if place == 777 {
                    panic_with(message);
                }
            });
            Ok(())
        }),
        "long" => work::long(py, None, |_| panic_with(message)).map(|worked| worked.value),
        _ => Err(PyValueError::new_err(
            "kind: give quick, parallel, scattered or long",
        )),
    }
}
