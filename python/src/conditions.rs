//! The conditions of a run, from keyword arguments.

use crate::errors::exception;
use pickline::sim::{Conditions, Disturbances};
use pyo3::prelude::*;

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
}

impl ConditionArguments {
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
        conditions.check().map_err(exception)?;
        Ok(conditions)
    }
}
