//! CSV with a header whose names define the meaning of every column: the output of supervision's
//! CSV sink, and MOT files edited in a spreadsheet.

use super::fields::{boxed, class, frame, number as parse_number, pixel, track_id};
use super::format::Format;
use super::lines::{FileLine, FileLines, FileRow};
use crate::csv_file::CsvFile;
use crate::error::{Error, ErrorKind, Result};
use crate::pattern::tracking::options::{Boxes, ImportOptions};

/// Accepted column names.
const FRAME: &[&str] = &[
    "frame",
    "frame_id",
    "frame_number",
    "frame_index",
    "frame_idx",
];
const ID: &[&str] = &["tracker_id", "track_id", "id", "object_id"];
const LEFT: &[&str] = &["x_min", "xmin", "x1", "bb_left", "bbox_left", "left"];
const TOP: &[&str] = &["y_min", "ymin", "y1", "bb_top", "bbox_top", "top"];
const RIGHT: &[&str] = &["x_max", "xmax", "x2", "bb_right", "right"];
const BOTTOM: &[&str] = &["y_max", "ymax", "y2", "bb_bottom", "bottom"];
const WIDTH: &[&str] = &["bb_width", "bbox_width", "width", "w"];
const HEIGHT: &[&str] = &["bb_height", "bbox_height", "height", "h"];
const CONFIDENCE: &[&str] = &["confidence", "conf", "score"];
const CLASS_NAME: &[&str] = &["class_name", "class", "label"];
const CLASS_ID: &[&str] = &["class_id", "cls"];

pub(super) fn read(text: &str, name: &str, options: &ImportOptions) -> Result<FileLines> {
    let mut file = CsvFile::new(text, name);
    let (header, header_line) = file.header()?;
    let place = format!("{name}:{header_line}");
    let columns = TrackColumns::find(&header, &place, options)?;
    let mut lines = Vec::new();
    let mut record = csv::StringRecord::new();
    loop {
        let (number, row) = match file.next(&mut record) {
            Ok(Some(number)) => (number, columns.row(&record, &mut file)),
            Ok(None) => break,
            Err(error) if error.kind() == ErrorKind::Input => (file.line(), Err(error.problem())),
            Err(error) => return Err(error),
        };
        lines.push(FileLine {
            file: None,
            number,
            // Optional columns may be empty in any line, including the last.
            filled: header.len(),
            row,
        });
    }
    let source = columns.class_name.or(columns.class_id);
    let source = source.and_then(|place| header.get(place));
    Ok(FileLines {
        format: Format::Table,
        boxes: columns.kind,
        lines,
        remarks: source
            .map(|name| format!("classes from column {name}"))
            .into_iter()
            .collect(),
        cure: "give every row a frame, a track id and a box in the columns named by the header",
    })
}

/// The places of the columns.
struct TrackColumns {
    frame: usize,
    id: Option<usize>,
    /// Left, top, and two of the right edge and bottom or the width and height.
    figures: [usize; 4],
    confidence: Option<usize>,
    class_name: Option<usize>,
    class_id: Option<usize>,
    /// Which two these are.
    kind: Boxes,
}

impl TrackColumns {
    /// The columns named by `header`, which is at `line` of the file.
    fn find(header: &csv::StringRecord, line: &str, options: &ImportOptions) -> Result<Self> {
        let place = |names: &[&str]| {
            let find = |name: &&str| header.iter().position(|column| column == *name);
            names.iter().find_map(find)
        };
        let Some(frame) = place(FRAME) else {
            return Err(Error::input(
                line,
                "a recording with a header but without a column `frame`: the frames are missing",
                "write the frame in every row; with supervision's CSVSink: \
                 sink.append(detections, custom_data={\"frame\": index})",
            ));
        };
        let corners = place(RIGHT).zip(place(BOTTOM));
        let sizes = place(WIDTH).zip(place(HEIGHT));
        let (Some(left), Some(top), Some((first, second))) =
            (place(LEFT), place(TOP), corners.or(sizes))
        else {
            return Err(Error::input(
                line,
                "a recording with a header but without known columns for the boxes",
                "name them x_min,y_min,x_max,y_max or bb_left,bb_top,bb_width,bb_height",
            ));
        };
        // The column names determine the kind of boxes.
        let kind = match corners {
            Some(_) => Boxes::Corners,
            None => Boxes::Sizes,
        };
        Ok(Self {
            frame,
            id: place(ID),
            figures: [left, top, first, second],
            confidence: place(CONFIDENCE),
            class_name: place(CLASS_NAME),
            class_id: place(CLASS_ID),
            kind: options.boxes_of(kind, "the header")?,
        })
    }

    /// The box in `record`, a row of `file`.
    fn row(
        &self,
        record: &csv::StringRecord,
        file: &mut CsvFile,
    ) -> std::result::Result<FileRow, String> {
        let mut value = |place: usize, what: &str| {
            let text = record.get(place).unwrap_or_default();
            match file.number(text) {
                Ok(value) if value.is_finite() => Ok(value),
                _ => parse_number(text, what).and(Err(format!("{what} `{text}` is not a number"))),
            }
        };
        let frame = frame(value(self.frame, "frame")?)?;
        let given = |place: &usize| record.get(*place).is_some_and(|text| !text.is_empty());
        let id = match self.id.filter(given) {
            Some(place) => track_id(value(place, "id")?)?,
            None => None,
        };
        let [left, top, first, second] = self.figures;
        let figures = [
            pixel(value(left, "left")?, "left")?,
            pixel(value(top, "top")?, "top")?,
            pixel(value(first, "width")?, "width")?,
            pixel(value(second, "height")?, "height")?,
        ];
        let mut row = boxed(frame, id, figures, self.kind)?;
        if let Some(place) = self.confidence.filter(given) {
            row.confidence = Some(value(place, "confidence")?);
        }
        let class_place = self
            .class_name
            .filter(given)
            .or(self.class_id.filter(given));
        row.class = class_place.and_then(|place| class(record.get(place).unwrap_or_default()));
        Ok(row)
    }
}
