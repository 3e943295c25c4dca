//! What no strategy can exceed.

use crate::conditions::ConditionArguments;
use crate::pattern::Pattern;
use crate::report::{Report, shown};
use crate::scalars;
use crate::station::Station;
use crate::work;
use pickline::study::{BoundStudy, BoundStudyOptions};
use pickline_report::{BoundReport, Provenance};
use pyo3::prelude::*;

/// The report of a :class:`pickline.Bound`; ``call`` is how it says who made it.
#[pyfunction]
#[pyo3(signature = (station, pattern, *, weight, slot, iterations, seed, conditions, progress, call))]
#[expect(clippy::too_many_arguments, reason = "the options of the program")]
pub(crate) fn bound(
    py: Python<'_>,
    station: &Station,
    pattern: &Pattern,
    weight: bool,
    slot: Option<f64>,
    #[pyo3(from_py_with = scalars::count::iterations)] iterations: usize,
    #[pyo3(from_py_with = scalars::seed)] seed: u64,
    #[pyo3(from_py_with = ConditionArguments::read)] conditions: ConditionArguments,
    progress: Option<Bound<'_, PyAny>>,
    call: &str,
) -> PyResult<Report> {
    let conditions = conditions.resolve(seed)?;
    let (line, items) = (&*station.inner, &*pattern.inner);
    let worked = work::long(py, progress.as_ref(), |environment| {
        let mut options = BoundStudyOptions::default()
            .with_seed(seed)
            .with_conditions(conditions.clone())
            .with_weight(weight)
            .with_iterations(iterations);
        if let Some(slot) = slot {
            options = options.with_slot(slot);
        }
        let study = BoundStudy::new(line, items, &options)?;
        let mut found = study.run(environment)?;
        found.notes.splice(0..0, study.notes());
        let scored = pattern.in_words();
        let made = Provenance::new(call, &station.name, line, &scored, seed).under(&conditions);
        Ok(BoundReport::of_study(&found, study.scene(), shown(), made))
    })?;
    Ok(Report::of(worked))
}
