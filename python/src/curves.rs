//! Learning curves as a picture.

use crate::arrays::numbers;
use crate::work;
use pickline_report::LearningCurve;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Draw learning curves of several trainings as an SVG file. Curves with the same name are drawn alike.
///
/// Args:
///     curves: The trainer's name, the numbers of decisions learned from, and the picking rates then as
///         shares of greedy GT's, for each training.
#[pyfunction]
pub(crate) fn learning_curves(
    py: Python<'_>,
    curves: Vec<(String, Bound<'_, PyAny>, Bound<'_, PyAny>)>,
) -> PyResult<String> {
    let read = |(name, steps, shares): (String, Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        let (steps, shares) = (numbers("steps", &steps)?, numbers("shares", &shares)?);
        if steps.len() != shares.len() {
            return Err(PyValueError::new_err(format!(
                "shares: {} numbers for {} of steps\n  cure: give as many",
                shares.len(),
                steps.len()
            )));
        }
        let points = steps.into_iter().zip(shares).collect();
        Ok(LearningCurve { name, points })
    };
    let curves: Vec<LearningCurve> = curves.into_iter().map(read).collect::<PyResult<_>>()?;
    work::quick(py, || pickline_report::learning_curves_svg(&curves))
}
