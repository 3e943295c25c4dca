//! The conditions of a run, from keyword arguments.

use crate::errors::exception;
use pickline::sim::{Conditions, Disturbances, RandomOutages};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Random outages: their mean times [s], or both as text.
#[derive(FromPyObject)]
enum OutageTimes {
    #[pyo3(transparent)]
    Text(String),
    #[pyo3(transparent)]
    Means((f64, f64)),
}

impl OutageTimes {
    fn resolve(&self) -> pickline::Result<RandomOutages> {
        match self {
            Self::Text(text) => text.parse(),
            Self::Means((mtbf, mttr)) => Ok(RandomOutages::new(*mtbf, *mttr)),
        }
    }
}

/// The keyword arguments that conditions are made of.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct ConditionArguments {
    update_hz: f64,
    camera_x: Option<f64>,
    min_detection: f64,
    grasp_success: Option<f64>,
    position_noise: f64,
    misdetections: bool,
    outage: Vec<String>,
    outages: Option<OutageTimes>,
}

impl ConditionArguments {
    /// Reads them from the dictionary that the Python side makes of keyword arguments.
    pub(crate) fn read(given: &Bound<'_, PyAny>) -> PyResult<Self> {
        let wrong = |problem: String| {
            PyTypeError::new_err(format!(
                "conditions: {problem}\n  cure: give them as keyword arguments, with numbers; see \
                 pickline.Conditions"
            ))
        };
        let dictionary = given
            .cast::<PyDict>()
            .map_err(|error| wrong(error.to_string()))?;
        dictionary.extract::<Self>().map_err(|error| {
            let problem = error.value(given.py()).to_string();
            let field = problem.rsplit_once('.').map(|(_, field)| field);
            let value = field.and_then(|field| dictionary.get_item(field).ok().flatten());
            match field.zip(value) {
                Some((field, value)) => PyTypeError::new_err(format!(
                    "{field}: {value:?} has the wrong type\n  cure: see pickline.Conditions for what it takes"
                )),
                None => wrong(problem),
            }
        })
    }

    /// `conditions` with the outages, checked.
    fn with_outages(&self, conditions: Conditions) -> pickline::Result<Conditions> {
        let random = self
            .outages
            .as_ref()
            .map(OutageTimes::resolve)
            .transpose()?;
        let mut given = self.outage.iter();
        let conditions = given.try_fold(conditions.with_outages(random), |conditions, text| {
            Ok::<_, pickline::Error>(conditions.with_outage(text.parse()?))
        })?;
        conditions.check()?;
        Ok(conditions)
    }

    /// The conditions, with random events from `seed`.
    pub(crate) fn resolve(&self, seed: u64) -> PyResult<Conditions> {
        let disturbances = Disturbances::default()
            .with_grasp_failures(self.grasp_success.is_some())
            .with_default_p_grasp(self.grasp_success.unwrap_or(1.0))
            .with_position_noise(self.position_noise)
            .with_misdetections(self.misdetections)
            .with_seed(seed);
        let conditions = Conditions::at_update_hz(self.update_hz)
            .with_camera_x(self.camera_x)
            .with_min_detection(self.min_detection)
            .with_disturbances(disturbances);
        self.with_outages(conditions).map_err(exception)
    }
}
