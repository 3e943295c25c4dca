//! The file formats in which programs write boxes and tracks, each converted to the same rows.

mod coco;
mod labels;
mod mot;
mod table;

use super::options::{Boxes, Options};
use crate::error::{Error, Result, known_names, rounded, shown};
use std::fmt;
use std::path::Path;
use std::str::FromStr;

/// Maximum pixel coordinate. No image is larger, and the bound keeps all later products finite.
const LARGEST_PX: f64 = 1e6;
/// Maximum frame number, which corresponds to years of video.
const LAST_FRAME: f64 = 1e9;
/// Whole numbers up to this limit are exact in f64, the type in which ids are parsed.
const LARGEST_ID: f64 = 9e15;

/// A file format.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// `frame,id,left,top,width,height,conf,...` (MOTChallenge).
    Mot,
    /// CSV with a header: supervision's sink, or MOT columns with their names.
    Table,
    /// Ultralytics labels: a folder of `class xc yc w h [conf] [id]`, one file per frame.
    Ultralytics,
    /// `frame class x1 y1 x2 y2 xc yc`, as fractions of the image size.
    Yolo,
    /// COCO JSON: a list of detections, or a data set with annotations.
    Coco,
}

/// Every format with its value for `--as` and its name in messages.
pub const FORMATS: [(Format, &str, &str); 5] = [
    (Format::Mot, "mot", "MOTChallenge text"),
    (Format::Table, "supervision", "CSV with a header"),
    (Format::Ultralytics, "ultralytics", "Ultralytics labels"),
    (Format::Yolo, "yolo", "a YOLO tracker's text"),
    (Format::Coco, "coco", "COCO JSON"),
];

impl FromStr for Format {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let found = FORMATS.iter().find(|(_, name, _)| *name == text);
        found.map(|(format, ..)| *format).ok_or_else(|| {
            let names = FORMATS.map(|(_, name, _)| name);
            let problem = format!("`{}` is not a known file format", shown(text));
            Error::input("--as", problem, known_names(text, &names))
        })
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let found = FORMATS.iter().find(|(format, ..)| format == self);
        f.write_str(found.map_or("", |(.., words)| words))
    }
}

/// A file, or a folder with one file per frame, as read from disk.
#[derive(Debug)]
pub enum Recording {
    /// The text of a file.
    Text(String),
    /// Frame number, file name and text of every file in a folder, in order of frames.
    Folder(Vec<(u32, String, String)>),
}

impl Recording {
    /// Reads a file or a folder of Ultralytics labels.
    ///
    /// # Errors
    /// If something cannot be read, or a folder contains no text file or no frame numbers in the
    /// file names.
    pub fn load(path: &Path) -> Result<Self> {
        if path.is_dir() {
            return labels::load(path).map(Self::Folder);
        }
        crate::files::read_text(path).map(Self::Text)
    }
}

/// A box as given in the file.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Row {
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
pub(super) struct Line {
    /// Name of the file within a folder; `None` for a single file.
    pub file: Option<String>,
    /// Line number, from 1.
    pub number: usize,
    /// Number of fields that are filled.
    pub filled: usize,
    /// The box, or what is wrong with the line.
    pub row: std::result::Result<Row, String>,
}

/// The lines of a file, and how they were interpreted.
#[derive(Debug)]
pub(super) struct Lines {
    pub format: Format,
    /// How the four numbers of the boxes were interpreted.
    pub boxes: Boxes,
    pub lines: Vec<Line>,
    /// Notes on how the lines were interpreted, for the report.
    pub remarks: Vec<String>,
    /// The cure for a file with hardly any valid line.
    pub cure: &'static str,
}

/// Reads the lines of `recording`; messages call it `name`.
///
/// # Errors
/// If the meaning of the numbers is uncertain; the error says why.
pub(super) fn read(recording: &Recording, name: &str, options: &Options) -> Result<Lines> {
    let text = match recording {
        Recording::Folder(files) => return labels::read(files, name, options),
        Recording::Text(text) => text.strip_prefix('\u{feff}').unwrap_or(text),
    };
    let mut lines = match options.format.unwrap_or_else(|| recognise(text)) {
        Format::Mot => {
            if let Some((form, cure)) = unread(text) {
                let problem = format!("the file contains {form}, which is not supported");
                return Err(Error::input(name, problem, cure));
            }
            mot::read(text, name, options)?
        }
        Format::Table => table::read(text, name, options)?,
        Format::Yolo => return labels::read_yolo(text, name, options),
        Format::Coco => coco::read(text, name, options)?,
        Format::Ultralytics => return Err(labels::without_frames(name)),
    };
    scale_shares(&mut lines, name, options)?;
    Ok(lines)
}

/// Converts relative image coordinates to pixels in formats that usually contain pixels. Boxes that
/// all lie within one pixel cannot be pixel coordinates.
fn scale_shares(lines: &mut Lines, name: &str, options: &Options) -> Result<()> {
    /// How far a box may extend beyond the image, as a fraction of the image size.
    const PAST: f64 = 0.1;
    let rows = || lines.lines.iter().filter_map(|line| line.row.as_ref().ok());
    let inside = |row: &Row| {
        let (width, height) = row.size.unwrap_or_default();
        let ends = [row.left, row.top, row.left + width, row.top + height];
        let share = -PAST..=1.0 + PAST;
        ends.iter().all(|value| share.contains(value))
    };
    let broken = |row: &Row| row.left.fract() != 0.0 || row.top.fract() != 0.0;
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

/// Recognises known but unsupported formats; returns the name and the cure.
fn unread(text: &str) -> Option<(&'static str, &'static str)> {
    const XML: &str = "export MOT 1.1, COCO 1.0 or YOLO labels instead";
    if text.trim_start().starts_with('<') {
        return Some(match text {
            _ if text.contains("<annotations") => ("CVAT's XML", XML),
            _ if text.contains("<annotation>") => ("Pascal VOC's XML", XML),
            _ => ("XML", XML),
        });
    }
    let line = text.lines().find(|line| !line.trim().is_empty())?;
    let fields: Vec<&str> = line.split_whitespace().collect();
    let numbers = |range: std::ops::Range<usize>| {
        let mut range = range;
        range.all(|place| fields[place].parse::<f64>().is_ok())
    };
    let is_name = |place: usize| fields[place].starts_with(char::is_alphabetic);
    match fields.len() {
        17 | 18 if numbers(0..2) && is_name(2) && numbers(3..17) => Some((
            "KITTI's tracking labels",
            "write lines `frame,id,left,top,width,height,conf`: columns 1 and 2, the corners in \
             columns 7 to 10 (or give the corners and --boxes corners) and column 18",
        )),
        15 | 16 if is_name(0) && numbers(1..15) => Some((
            "KITTI's object labels",
            "they contain no frame; write lines `frame,id,left,top,width,height,conf` with id -1",
        )),
        _ => None,
    }
}

/// The format of `text`; MOT if nothing suggests another one.
fn recognise(text: &str) -> Format {
    /// Number of lines to examine.
    const SAMPLE: usize = 200;
    if text.trim_start().starts_with(['[', '{']) {
        return Format::Coco;
    }
    let mut lines = text
        .lines()
        .filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    if lines.clone().next().is_some_and(is_header) {
        return Format::Table;
    }
    let sample: Vec<Vec<&str>> = lines
        .by_ref()
        .take(SAMPLE)
        .map(|line| line.split_whitespace().collect())
        .collect();
    let shares = |from: usize, to: usize, least: usize, most: usize| {
        let share = |field: &&str| {
            field
                .parse::<f64>()
                .is_ok_and(|value| (0.0..=1.0).contains(&value))
        };
        let fits = |fields: &&Vec<&str>| {
            (least..=most).contains(&fields.len()) && fields[from..to].iter().all(share)
        };
        let count = sample.iter().filter(fits).count();
        // The last line may be incomplete.
        count > 0 && count + 1 >= sample.len()
    };
    if shares(2, 8, 8, 8) {
        Format::Yolo
    } else if shares(1, 5, 5, 7) {
        Format::Ultralytics
    } else {
        Format::Mot
    }
}

/// Whether a line contains names instead of numbers. It takes two of them, so that a single broken
/// number is not mistaken for a header.
fn is_header(line: &str) -> bool {
    let fields = line.split([',', ';', '\t']);
    let is_name = |field: &&str| {
        let field = field.trim().trim_matches('"');
        field.starts_with(|c: char| c.is_alphabetic()) && field.parse::<f64>().is_err()
    };
    fields.filter(is_name).count() > 1
}

/// What `text`, which is not a pattern, seems to be a recording of; `None` if this is uncertain.
pub fn recognised(text: &str) -> Option<String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let format = recognise(text);
    let found = match format {
        Format::Coco => text.contains("\"bbox\""),
        Format::Table => {
            let header = text.lines().next().unwrap_or_default().to_lowercase();
            ["bb_left", "x_min", "xmin", "tracker_id", "track_id"]
                .iter()
                .any(|name| header.contains(name))
        }
        Format::Mot => {
            let first = text.lines().next().unwrap_or_default();
            let fields: Vec<&str> = match first.contains(';') {
                true => first.split(';').collect(),
                false => first.split([',', ' ', '\t']).collect(),
            };
            let number = |field: &&str| field.trim().replace(',', ".").parse().ok();
            let numbers: Option<Vec<f64>> = fields.iter().map(number).collect();
            numbers.is_some_and(|numbers| (6..=10).contains(&numbers.len()))
        }
        Format::Ultralytics | Format::Yolo => true,
    };
    found.then(|| format.to_string())
}

/// Parses the number in `text`; the error describes the problem.
fn number(text: &str, what: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ if text.is_empty() => Err(format!("the {what} is missing")),
        _ => Err(format!("{what} `{}` is not a number", shown(text))),
    }
}

fn pixel(value: f64, what: &str) -> std::result::Result<f64, String> {
    match value {
        value if value.abs() <= LARGEST_PX => Ok(value),
        value => Err(format!("{what} {value:?} is not a valid pixel coordinate")),
    }
}

/// Parses a frame number. Some trackers print every column as a float, so `3.0` is frame 3.
fn frame(value: f64) -> std::result::Result<u32, String> {
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
fn track_id(value: f64) -> std::result::Result<Option<i64>, String> {
    match value {
        -1.0 => Ok(None),
        id if id.fract() != 0.0 || !(0.0..=LARGEST_ID).contains(&id) => {
            Err(format!("{id:?} is not a valid track id"))
        }
        id => Ok(Some(id as i64)),
    }
}

/// A class in the form used in a pattern: whole numbers without a decimal point.
fn class(text: &str) -> Option<String> {
    match text.parse::<f64>() {
        _ if text.is_empty() => None,
        Ok(number) if number.fract() == 0.0 && number.abs() < LARGEST_ID => {
            Some((number as i64).to_string())
        }
        _ => Some(text.to_owned()),
    }
}

/// Interprets the four numbers of a box [px] according to `--boxes`. A width and height of 0 or -1
/// mean a point.
fn boxed(
    frame: u32,
    id: Option<i64>,
    [left, top, width, height]: [f64; 4],
    boxes: Boxes,
) -> std::result::Result<Row, String> {
    let row = |left: f64, top: f64, size: Option<(f64, f64)>| Row {
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

/// The size of the image [px], which relative coordinates need.
fn image_size(name: &str, options: &Options) -> Result<(f64, f64)> {
    options.image_size.ok_or_else(|| {
        Error::input(
            name,
            "the boxes are fractions of the image size, which the file does not contain",
            "give --image-size WIDTHxHEIGHT [px], for example --image-size 1280x720",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forms_are_recognised_by_what_is_in_them() {
        for (text, format) in [
            ("1,1,10,20,4,6,0.5\n", Format::Mot),
            ("1 7 10 20 4 6 0.5\n2 7 20 20 4 6 0.5", Format::Mot),
            ("0,1,1,1,1,1,1\n", Format::Mot),
            ("", Format::Mot),
            ("frame,id,bb_left,bb_top\n1,1,1,1\n", Format::Table),
            ("x_min;y_min;x_max\n1;1;1\n", Format::Table),
            (
                "0 0.21 0.77 0.02 0.1\n1 0.2 0.7 0.02 0.1\n",
                Format::Ultralytics,
            ),
            ("0 0.21 0.77 0.02 0.1 0.9 3\n0 0.2\n", Format::Ultralytics),
            ("1 0 0.2 0.7 0.23 0.8 0.21 0.77\n", Format::Yolo),
            (" [{\"image_id\": 1}]", Format::Coco),
        ] {
            assert_eq!(recognise(text), format, "{text}");
        }
        for (format, name, _) in FORMATS {
            assert_eq!(name.parse::<Format>().unwrap(), format);
        }
        assert!(
            "mott"
                .parse::<Format>()
                .unwrap_err()
                .to_string()
                .contains("`mot`")
        );
    }

    #[test]
    fn patterns_are_taken_for_no_recordings() {
        for text in ["id,x,y\na,0,0\n", "name,a\n", "1,2,3\n", "[belt]\n", ""] {
            assert_eq!(recognised(text), None, "{text}");
        }
        assert!(recognised("1,1,10,20,4,6,0.5,-1,-1,-1\n").is_some());
        assert!(recognised("frame,id,bb_left,x,y\n").is_some());
    }
}
