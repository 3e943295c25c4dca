//! COCO JSON: the list of detections that evaluations take, with `image_id`, `category_id`, `bbox`
//! [left, top, width, height] and `score`, or a data set with `images`, `annotations` and
//! `categories` (Lin et al., "Microsoft COCO: Common Objects in Context", 2014, arXiv:1405.0312).

use super::fields::{boxed, frame};
use super::format::Format;
use super::labels::frames_of;
use super::lines::{FileLine, FileLines, FileRow};
use super::table;
use crate::error::{Error, Result};
use crate::pattern::tracking::options::{Boxes, ImportOptions};
use serde_json::Value;
use std::collections::{HashMap, HashSet};

pub(super) fn read(text: &str, name: &str, options: &ImportOptions) -> Result<FileLines> {
    let data: Value = serde_json::from_str(text).map_err(|error| {
        Error::input(
            format!("{name}:{}", error.line()),
            format!("not valid JSON: {error}"),
            "give COCO's list of detections, [{\"image_id\": 1, \"category_id\": 0, \
             \"bbox\": [left, top, width, height], \"score\": 0.9}, ...]",
        )
        .caused_by(error)
    })?;
    if is_sink(&data) {
        return read_sink(&data, name, options);
    }
    let listed = |key: &str| data.get(key).and_then(Value::as_array);
    let Some(boxes) = data.as_array().or_else(|| listed("annotations")) else {
        return Err(Error::input(
            name,
            "JSON, but neither a list of detections nor a data set with `annotations`",
            "give COCO's list of detections, or its data set",
        ));
    };
    let mut remarks = vec!["classes from category_id".to_owned()];
    let (frames, order) = frames_of_images(listed("images"));
    remarks.extend(order.map(str::to_owned));
    // COCO boxes are sizes, but some programs write corners.
    let kind = options.boxes.unwrap_or_default();
    let detections = Detections {
        names: class_names(listed("categories")),
        frames,
        kind,
    };
    let line = |(index, entry): (usize, &Value)| FileLine {
        file: None,
        number: index + 1,
        filled: 1,
        row: detections.row(entry),
    };
    Ok(FileLines {
        format: Format::Coco,
        boxes: kind,
        lines: boxes.iter().enumerate().map(line).collect(),
        remarks,
        cure: match kind {
            Boxes::Sizes => {
                "give every detection an image_id that is its frame, and a bbox \
                 [left, top, width, height]"
            }
            _ => {
                "give every detection an image_id that is its frame, and a bbox as given with \
                 'boxes', or omit 'boxes' if it is [left, top, width, height]"
            }
        },
    })
}

/// What is needed to read a detection.
struct Detections<'a> {
    /// Names of the categories, by their ids.
    names: HashMap<i64, &'a str>,
    /// Frames of the images, by their ids; the others' frames are their ids.
    frames: HashMap<i64, f64>,
    kind: Boxes,
}

impl Detections<'_> {
    fn row(&self, entry: &Value) -> std::result::Result<FileRow, String> {
        let image = entry.get("image_id").and_then(Value::as_i64);
        let image = image.ok_or("the image_id is not a whole number, so the frames are missing")?;
        let figures = entry.get("bbox").and_then(Value::as_array);
        let figures: Option<Vec<f64>> =
            figures.and_then(|list| list.iter().map(Value::as_f64).collect());
        let Some([left, top, width, height]) = figures.as_deref() else {
            return Err("the bbox is not a list of four numbers".to_owned());
        };
        let id = ["track_id", "instance_id", "tracker_id"]
            .iter()
            .find_map(|key| entry.get(*key));
        let frame = frame(self.frames.get(&image).copied().unwrap_or(image as f64))?;
        let id = id.and_then(Value::as_i64).filter(|id| *id >= 0);
        let mut row = boxed(frame, id, [*left, *top, *width, *height], self.kind)?;
        row.confidence = entry.get("score").and_then(Value::as_f64);
        row.class = entry.get("category_id").and_then(Value::as_i64).map(|id| {
            self.names
                .get(&id)
                .map_or_else(|| id.to_string(), |name| (*name).trim().to_owned())
        });
        Ok(row)
    }
}

fn class_names(categories: Option<&Vec<Value>>) -> HashMap<i64, &str> {
    categories
        .into_iter()
        .flatten()
        .filter_map(|entry| Some((entry.get("id")?.as_i64()?, entry.get("name")?.as_str()?)))
        .collect()
}

/// The frames of images, by their ids, and a remark on their source if the images do not state
/// them.
fn frames_of_images(images: Option<&Vec<Value>>) -> (HashMap<i64, f64>, Option<&'static str>) {
    // A video data set states which frame an image is.
    let stated: HashMap<i64, f64> = images
        .into_iter()
        .flatten()
        .filter_map(|entry| {
            let frame = entry.get("frame_id").or_else(|| entry.get("frame_index"))?;
            Some((entry.get("id")?.as_i64()?, frame.as_f64()?))
        })
        .collect();
    if !stated.is_empty() {
        return (stated, None);
    }
    match images.and_then(|images| frames_by_name(images)) {
        Some(named) => (
            named,
            Some("frames from the numbers in file_name, since the image ids are out of order"),
        ),
        None => (stated, Some("frames from image_id")),
    }
}

/// The frames of images whose ids are not in the order of the video, from the numbers in their
/// names. `None` if the ids are in order or the names do not give an order.
fn frames_by_name(images: &[Value]) -> Option<HashMap<i64, f64>> {
    let mut ids = Vec::new();
    let mut names = Vec::new();
    for image in images {
        ids.push(image.get("id")?.as_i64()?);
        let path = std::path::Path::new(image.get("file_name")?.as_str()?);
        names.push(path.file_stem()?.to_string_lossy().into_owned());
    }
    let frames = frames_of(&names).ok()?;
    let mut pairs: Vec<(i64, u32)> = ids.into_iter().zip(frames).collect();
    pairs.sort_unstable();
    if pairs.is_sorted_by_key(|pair| pair.1) {
        return None;
    }
    let distinct: HashSet<u32> = pairs.iter().map(|pair| pair.1).collect();
    let usable = distinct.len() == pairs.len();
    usable.then(|| {
        pairs
            .iter()
            .map(|&(id, frame)| (id, f64::from(frame)))
            .collect()
    })
}

/// Whether the list is from the JSON sink of supervision, which writes the rows of its CSV sink as
/// objects.
fn is_sink(data: &Value) -> bool {
    let first = data.as_array().and_then(|list| list.first());
    first.is_some_and(|first| {
        let columns = ["x_min", "x1", "bb_left"];
        first.get("bbox").is_none() && columns.iter().any(|key| first.get(*key).is_some())
    })
}

/// Reads a list of objects whose keys are the columns of a table.
fn read_sink(data: &Value, name: &str, options: &ImportOptions) -> Result<FileLines> {
    let objects = || data.as_array().into_iter().flatten();
    let mut keys: Vec<&str> = Vec::new();
    for key in objects()
        .filter_map(Value::as_object)
        .flat_map(|o| o.keys())
    {
        if !keys.contains(&key.as_str()) {
            keys.push(key);
        }
    }
    let text = |value: &Value| match value {
        Value::Null => String::new(),
        Value::String(text) => text.replace(['\n', '\r'], " "),
        other => other.to_string(),
    };
    let mut rows = csv::Writer::from_writer(Vec::new());
    // Writing to memory cannot fail.
    let _ = rows.write_record(&keys);
    for object in objects() {
        let fields = keys
            .iter()
            .map(|key| object.get(*key).map(text).unwrap_or_default());
        let _ = rows.write_record(fields);
    }
    let rows = rows.into_inner().unwrap_or_default();
    let mut lines = table::read(&String::from_utf8_lossy(&rows), name, options)?;
    // Objects are numbered like the entries of COCO lists.
    lines.lines.iter_mut().for_each(|line| line.number -= 1);
    Ok(lines)
}
