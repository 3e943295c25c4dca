//! The list of file formats.

use crate::error::{Error, Result, known_names, shown};
use std::fmt;
use std::str::FromStr;

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

/// Every format with its name as a setting and its name in messages. By hand, because each has
/// two names that do not follow from the variant.
pub(super) const FORMATS: [(Format, &str, &str); 5] = [
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
            Error::usage("'format'", problem, known_names(text, &names))
        })
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let found = FORMATS.iter().find(|(format, ..)| format == self);
        f.write_str(found.map_or("", |(.., words)| words))
    }
}
