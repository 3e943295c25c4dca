//! The Python module `pickline._pickline`: the library's types and calls as Python sees them. It
//! converts arguments, results and errors, and decides nothing.

mod arrays;
mod batch;
mod conditions;
mod errors;
mod pattern;
mod program;
mod scalars;
mod simulate;
mod station;
mod work;

use pyo3::prelude::*;

#[pymodule]
fn _pickline(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add(
        "OBSERVATION_VERSION",
        pickline::decision::observation::VERSION,
    )?;
    module.add_class::<station::Station>()?;
    module.add_class::<pattern::Pattern>()?;
    module.add_class::<batch::Batch>()?;
    module.add_function(wrap_pyfunction!(pattern::patterns, module)?)?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(program::program, module)?)
}
