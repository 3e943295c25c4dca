//! A simulated run, kept for the forms in which the program shows it.

use crate::report::{Unpickled, kept, shown};
use crate::work;
use pickline::clearance;
use pickline::decision::Outcome;
use pickline::experiment::ClassBound;
use pickline::planning::bound::Bound;
use pickline::sim::{Conditions, Scene};
use pickline_report::{
    CertifiedReport, ClearanceReport, Provenance, RunReport, VerbReport, check_replay, json_text,
    replay_page,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// A run, in every form in which the program prints and writes it.
#[pyclass(frozen, module = "pickline._pickline")]
pub(crate) struct Run {
    pub station: Arc<pickline::Station>,
    pub pattern: Arc<pickline::Pattern>,
    /// What the user calls the station.
    pub name: String,
    /// With the seed of the run.
    pub conditions: Conditions,
    pub strategy: String,
    pub outcome: Outcome,
    pub bound: Option<Bound>,
    pub class_bounds: Vec<ClassBound>,
    pub made: Provenance,
}

impl Run {
    /// Calls `with` with the scene and the report.
    fn shown<T>(
        &self,
        with: impl FnOnce(&Scene, &RunReport) -> pickline::Result<T>,
    ) -> pickline::Result<T> {
        let scene = Scene::under(&self.station, &self.pattern, self.conditions.clone())?;
        let made = self.made.clone();
        let mut report = RunReport::new(self.strategy.clone(), &scene, &self.outcome, made);
        report.checked = Some(true);
        let bound = self.bound.as_ref();
        report.bound = bound.map(|bound| CertifiedReport::new(&self.outcome.figures, bound));
        report.certify_classes(&self.class_bounds);
        with(&scene, &report)
    }
}

#[pymethods]
impl Run {
    /// The text that the program prints.
    fn text(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || self.shown(|_, report| Ok(report.to_table(shown()))))
    }

    /// The attempts as CSV.
    fn csv(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || self.shown(|_, report| Ok(report.to_csv())))
    }

    /// The whole report as JSON.
    fn json(&self, py: Python<'_>) -> PyResult<String> {
        work::quick(py, || self.shown(|_, report| json_text(report)))
    }

    /// The page that replays the run, if it has not more items than a page can show.
    fn page(&self, py: Python<'_>) -> PyResult<Option<String>> {
        work::parallel(py, || {
            if check_replay(&self.pattern).is_err() {
                return Ok(None);
            }
            self.shown(|scene, report| {
                let found = clearance::smallest(&self.station, &self.outcome);
                let found = found.map(|found| ClearanceReport::new(&self.station, &found));
                Ok(Some(replay_page(scene, &self.name, report, found.as_ref())))
            })
        })
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &pyo3::Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Unpickled<'py>> {
        let forms = (
            self.text(py)?,
            self.csv(py)?,
            self.json(py)?,
            self.page(py)?,
            PyDict::new(py),
            false,
        );
        Ok((kept(py)?, forms))
    }
}
