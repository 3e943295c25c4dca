//! Patterns from recordings of a tracker.

use crate::errors::spelling;
use crate::pattern::Pattern;
use crate::scalars;
use crate::work;
use pickline::error::spell_settings;
use pickline::pattern::tracking::{self, ImportOptions, Recording};
use pickline_report::json_text;
use pyo3::prelude::*;
use std::path::PathBuf;

/// The pattern, the report as JSON, its lines and its warnings.
type Parts = (Pattern, String, Vec<String>, Vec<String>);

/// The parts of a :class:`pickline.Import`: the pattern, the report as JSON, what was read, dropped and
/// measured in words, and warnings.
#[pyfunction]
#[pyo3(signature = (file, *, fps, scale, axis, belt_speed, form, boxes, image_size, reverse, angle,
    centre_px, min_frames, split_distance, merge_distance, class_names, accept_mismatch))]
#[expect(clippy::too_many_arguments, reason = "the options of the program")]
pub(crate) fn import_mot(
    py: Python<'_>,
    file: PathBuf,
    fps: f64,
    scale: f64,
    axis: &str,
    belt_speed: f64,
    form: Option<&str>,
    boxes: Option<&str>,
    image_size: Option<(f64, f64)>,
    reverse: bool,
    angle: f64,
    centre_px: Option<f64>,
    #[pyo3(from_py_with = scalars::count::min_frames)] min_frames: usize,
    split_distance: f64,
    merge_distance: f64,
    class_names: Option<&str>,
    accept_mismatch: bool,
) -> PyResult<Parts> {
    let (import, json) = work::parallel(py, || {
        let options = ImportOptions::new(fps, scale, axis.parse()?, belt_speed)
            .with_format(form.map(str::parse).transpose()?)
            .with_boxes(boxes.map(str::parse).transpose()?)
            .with_image_size(image_size)
            .with_reverse(reverse)
            .with_angle_deg(angle)
            .with_centre_px(centre_px)
            .with_min_frames(min_frames)
            .with_split_distance_m(split_distance)
            .with_merge_distance_m(merge_distance)
            .with_class_names(class_names.map(str::parse).transpose()?)
            .with_accept_mismatch(accept_mismatch);
        let recording = Recording::load(&file)?;
        let name = file.display().to_string();
        let mut import = tracking::import(&recording, &name, &options)?;
        for warning in &mut import.report.warnings {
            *warning = spell_settings(warning, spelling);
        }
        let json = json_text(&import.report)?;
        Ok((import, json))
    })?;
    let lines = import.report.lines().into_iter();
    let lines = lines.map(|line| spell_settings(&line, spelling)).collect();
    Ok((import.pattern.into(), json, lines, import.report.warnings))
}
