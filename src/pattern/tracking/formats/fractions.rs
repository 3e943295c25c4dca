//! Boxes as fractions of the image size.

use super::fields::number;
use super::lines::{FileLines, FileRow};
use crate::error::{Error, Result};
use crate::pattern::tracking::options::ImportOptions;

/// Converts relative image coordinates to pixels in formats that usually contain pixels. Boxes that
/// all lie within one pixel cannot be pixel coordinates.
pub(super) fn scale_shares(
    lines: &mut FileLines,
    name: &str,
    options: &ImportOptions,
) -> Result<()> {
    /// How far a box may extend beyond the image, as a fraction of the image size.
    const PAST: f64 = 0.1;
    let rows = || lines.lines.iter().filter_map(|line| line.row.as_ref().ok());
    let inside = |row: &FileRow| {
        let (width, height) = row.size.unwrap_or_default();
        let ends = [row.left, row.top, row.left + width, row.top + height];
        let share = -PAST..=1.0 + PAST;
        ends.iter().all(|value| share.contains(value))
    };
    let broken = |row: &FileRow| row.left.fract() != 0.0 || row.top.fract() != 0.0;
    if !rows().any(broken) || !rows().all(inside) {
        return Ok(());
    }
    let (width, height) = image_size(name, options)?;
    for row in lines.lines.iter_mut().filter_map(|l| l.row.as_mut().ok()) {
        row.left *= width;
        row.top *= height;
        row.size = row.size.map(|(w, h)| (w * width, h * height));
    }
    lines.remarks.push(format!(
        "boxes as fractions of the image size of {width} x {height} pixels"
    ));
    Ok(())
}

/// The size of the image [px], which relative coordinates need.
pub(super) fn image_size(name: &str, options: &ImportOptions) -> Result<(f64, f64)> {
    options.image_size.ok_or_else(|| {
        Error::input(
            name,
            "the boxes are fractions of the image size, which the file does not contain",
            "give 'image_size' WIDTHxHEIGHT [px], for example 'image_size' 1280x720",
        )
    })
}

/// A fraction of the image size, with some margin for boxes that extend beyond the edge.
pub(super) fn share(text: &str, what: &str) -> std::result::Result<f64, String> {
    match number(text, what)? {
        value if (-1.0..=2.0).contains(&value) => Ok(value),
        value => Err(format!(
            "{what} {value:?} is not a fraction of the image size"
        )),
    }
}
