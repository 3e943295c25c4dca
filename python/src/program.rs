//! The program `pickline`.

use crate::errors::{exception, panicked};
use pyo3::prelude::*;
use std::ffi::OsString;
use std::panic::catch_unwind;

/// Run the program with these words, of which the first is its name; returns its exit code.
#[pyfunction]
pub(crate) fn program(py: Python<'_>, words: Vec<OsString>) -> PyResult<u8> {
    let done = py.detach(|| catch_unwind(|| pickline_cli::call_hosted(&words)));
    done.map_err(|panic| panicked(&*panic))
}

/// Make one shard of a call, in a process that has other work too; raises what the program would print.
#[pyfunction]
pub(crate) fn make_shard(py: Python<'_>, words: Vec<OsString>) -> PyResult<()> {
    let done = py.detach(|| catch_unwind(|| pickline_cli::make_shard(&words)));
    done.map_err(|panic| panicked(&*panic))?.map_err(exception)
}
