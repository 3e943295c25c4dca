//! The Python module `pickline._pickline`: the library's types and calls as Python sees them. It
//! converts arguments, results and errors, and decides nothing.

mod arrays;
mod arrow;
mod batch;
mod bound;
mod check;
mod compare;
mod conditions;
mod crew;
mod curves;
#[cfg(debug_assertions)]
mod defect;
mod demonstrate;
mod errors;
mod frame;
mod optimize;
mod pattern;
mod portion;
mod program;
mod progress;
mod report;
mod robots_down;
mod run;
mod scalars;
mod scored;
mod simulate;
mod station;
mod strategy;
mod sweep;
mod tracks;
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
    module.add_function(wrap_pyfunction!(pattern::trials, module)?)?;
    module.add_function(wrap_pyfunction!(curves::learning_curves, module)?)?;
    module.add_class::<report::Report>()?;
    module.add_function(wrap_pyfunction!(simulate::simulate, module)?)?;
    module.add_function(wrap_pyfunction!(arrow::arrow_stream, module)?)?;
    module.add_function(wrap_pyfunction!(compare::compare, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(robots_down::robots_down, module)?)?;
    module.add_function(wrap_pyfunction!(optimize::optimize, module)?)?;
    module.add_function(wrap_pyfunction!(bound::bound, module)?)?;
    module.add_function(wrap_pyfunction!(check::check, module)?)?;
    module.add_function(wrap_pyfunction!(demonstrate::demonstrate, module)?)?;
    module.add_function(wrap_pyfunction!(tracks::import_mot, module)?)?;
    #[cfg(debug_assertions)]
    module.add_function(wrap_pyfunction!(defect::_panic, module)?)?;
    module.add_function(wrap_pyfunction!(program::make_shard, module)?)?;
    module.add_function(wrap_pyfunction!(program::program, module)?)
}
