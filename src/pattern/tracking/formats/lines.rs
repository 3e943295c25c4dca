//! What every format is converted to: lines with their boxes.

use super::format::Format;
use crate::pattern::tracking::options::Boxes;

/// A box as given in the file.
#[derive(Debug, Clone, PartialEq)]
pub(in super::super) struct FileRow {
    /// Frame number, in the counting of the file.
    pub frame: u32,
    /// Id of the track; `None` for a detection.
    pub id: Option<i64>,
    /// Left, top, width and height [px]; no size for a point.
    pub left: f64,
    pub top: f64,
    pub size: Option<(f64, f64)>,
    /// Confidence, possibly outside 0 to 1.
    pub confidence: Option<f64>,
    pub class: Option<String>,
}

/// A line of a file.
#[derive(Debug)]
pub(in super::super) struct FileLine {
    /// Name of the file within a folder; `None` for a single file.
    pub file: Option<String>,
    /// Line number, from 1.
    pub number: usize,
    /// Number of fields that are filled.
    pub filled: usize,
    /// The box, or what is wrong with the line.
    pub row: std::result::Result<FileRow, String>,
}

/// The lines of a file, and how they were interpreted.
#[derive(Debug)]
pub(in super::super) struct FileLines {
    pub format: Format,
    /// How the four numbers of the boxes were interpreted.
    pub boxes: Boxes,
    pub lines: Vec<FileLine>,
    /// Notes on how the lines were interpreted, for the report.
    pub remarks: Vec<String>,
    /// The cure for a file with hardly any valid line.
    pub cure: &'static str,
}
