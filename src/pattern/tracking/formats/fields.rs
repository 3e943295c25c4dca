//! Reads the fields of a line. Errors describe what is wrong with the line.

use super::lines::FileRow;
use crate::error::{rounded, shown};
use crate::pattern::tracking::options::Boxes;

/// Maximum pixel coordinate. No image is larger, and the bound keeps all later products finite.
const LARGEST_PX: f64 = 1e6;
/// Maximum frame number, which corresponds to years of video.
pub(super) const LAST_FRAME: f64 = 1e9;
/// Whole numbers up to this limit are exact in f64, the type in which ids are parsed.
const LARGEST_ID: f64 = 9e15;

/// Parses the number in `text`; the error describes the problem.
pub(super) fn number(text: &str, what: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ if text.is_empty() => Err(format!("the {what} is missing")),
        _ => Err(format!("{what} `{}` is not a number", shown(text))),
    }
}

/// Checks a pixel coordinate.
pub(super) fn pixel(value: f64, what: &str) -> std::result::Result<f64, String> {
    match value {
        value if value.abs() <= LARGEST_PX => Ok(value),
        value => Err(format!("{what} {value:?} is not a valid pixel coordinate")),
    }
}

/// Parses a frame number. Some trackers print every column as a float, so `3.0` is frame 3.
pub(super) fn frame(value: f64) -> std::result::Result<u32, String> {
    if value > LAST_FRAME {
        return Err(format!(
            "frame {value:.0} is greater than the maximum of {LAST_FRAME:.0}"
        ));
    }
    if value.fract() != 0.0 || value < 0.0 {
        return Err(format!(
            "{value:?} is not a valid frame number; frames are counted from 0 or 1"
        ));
    }
    // In range and a whole number, so the conversion is exact.
    Ok(value as u32)
}

/// Parses a track id; -1 stands for a detection without a track.
pub(super) fn track_id(value: f64) -> std::result::Result<Option<i64>, String> {
    match value {
        -1.0 => Ok(None),
        id if id.fract() != 0.0 || !(0.0..=LARGEST_ID).contains(&id) => {
            Err(format!("{id:?} is not a valid track id"))
        }
        id => Ok(Some(id as i64)),
    }
}

/// A class in the form used in a pattern: whole numbers without a decimal point.
pub(super) fn class(text: &str) -> Option<String> {
    match text.parse::<f64>() {
        _ if text.is_empty() => None,
        Ok(number) if number.fract() == 0.0 && number.abs() < LARGEST_ID => {
            Some((number as i64).to_string())
        }
        _ => Some(text.to_owned()),
    }
}

/// Interprets the four numbers of a box [px] according to the option `boxes`. A width and height
/// of 0 or -1 mean a point.
pub(super) fn boxed(
    frame: u32,
    id: Option<i64>,
    [left, top, width, height]: [f64; 4],
    boxes: Boxes,
) -> std::result::Result<FileRow, String> {
    let row = |left: f64, top: f64, size: Option<(f64, f64)>| FileRow {
        frame,
        id,
        left,
        top,
        size,
        confidence: None,
        class: None,
    };
    let [left, top] = [pixel(left, "left")?, pixel(top, "top")?];
    let [width, height] = [pixel(width, "width")?, pixel(height, "height")?];
    let (width, height) = match boxes {
        Boxes::Corners => (width - left, height - top),
        _ => (width, height),
    };
    if width > 0.0 && height > 0.0 {
        let (left, top) = match boxes {
            Boxes::Centres => (left - width / 2.0, top - height / 2.0),
            _ => (left, top),
        };
        return Ok(row(left, top, Some((width, height))));
    }
    let sizes = boxes != Boxes::Corners;
    match (width, height) {
        (-1.0, -1.0) if sizes && left == -1.0 && top == -1.0 => {
            // The 3D challenge fills the image columns this way.
            Err("neither box nor point: all four are -1".to_owned())
        }
        (-1.0, -1.0) | (0.0, 0.0) if sizes => Ok(row(left, top, None)),
        _ => {
            let (width, height) = (rounded(width, 9), rounded(height, 9));
            let by = if sizes { "" } else { " by its corners" };
            Err(format!("a box of {width} x {height} pixels{by}"))
        }
    }
}
