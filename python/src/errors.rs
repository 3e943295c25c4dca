//! Errors of the library as Python exceptions.

use pickline::{Error, ErrorKind};
use pyo3::PyErr;
use pyo3::exceptions::{PyKeyboardInterrupt, PyOSError, PyRuntimeError, PyValueError};
use std::any::Any;
use std::error::Error as _;
use std::io;

/// What a setting is called here: a keyword argument, with the name of the program's option, and without
/// one for what is left out.
pub(crate) fn spelling(setting: &str) -> String {
    let option = pickline_cli::flag(setting);
    let name = option.trim_start_matches('-').replace('-', "_");
    match name.strip_prefix("no_") {
        Some(name) => format!("`{name}=False`"),
        // A word of Python, so the argument has another name.
        None if name == "from" => "`from_`".into(),
        None => format!("`{name}`"),
    }
}

/// The exception for `error`, with its place, problem and cure as the message.
///
/// | kind | exception |
/// |---|---|
/// | `Usage`, `Input`, `IllegalAction` | `ValueError` |
/// | `Path`, `Io`, `Resources` | `OSError`, or its subclass for the code of the system (1) |
/// | `Interrupted` | `KeyboardInterrupt` |
/// | `Refuted`, `Internal` | `RuntimeError` |
///
/// (1) `ValueError`, as by Python's `open`, for a path with a NUL.
pub(crate) fn exception(error: Error) -> PyErr {
    let error = error.spell_settings(spelling);
    let message = error.to_string();
    match error.kind() {
        ErrorKind::Usage | ErrorKind::Input | ErrorKind::IllegalAction => {
            PyValueError::new_err(message)
        }
        ErrorKind::Path | ErrorKind::Io | ErrorKind::Resources => {
            let source = error.source().and_then(|s| s.downcast_ref::<io::Error>());
            if source.is_some_and(|source| source.kind() == io::ErrorKind::InvalidInput) {
                // Not the name of a file at all: it has a NUL.
                return PyValueError::new_err(message);
            }
            match source.and_then(io::Error::raw_os_error) {
                // Python makes a FileNotFoundError and the like of it.
                Some(code) => PyOSError::new_err((code, message)),
                None => PyOSError::new_err(message),
            }
        }
        ErrorKind::Interrupted => PyKeyboardInterrupt::new_err(message),
        _ => PyRuntimeError::new_err(message),
    }
}

/// The exception for a panic, which is a defect of the library.
pub(crate) fn panicked(panic: &(dyn Any + Send)) -> PyErr {
    let text = panic
        .downcast_ref::<&str>()
        .map(|text| (*text).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned());
    PyRuntimeError::new_err(format!(
        "pickline: a defect of the library: {}\n  cure: report it with the call that led to it",
        text.unwrap_or_else(|| "it has no message".into())
    ))
}
