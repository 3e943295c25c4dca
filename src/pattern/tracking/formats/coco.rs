//! COCO's JSON: the list of detections that evaluations take, `image_id`, `category_id`,
//! `bbox` [left, top, width, height] and `score`, or a data set with `images`,
//! `annotations` and `categories` (Lin et al., "Microsoft COCO: Common Objects in Context",
//! 2014, arXiv:1405.0312).

use super::{Format, Line, Lines, Row, boxed, frame};
use crate::error::{Error, Result};
use crate::pattern::tracking::options::{Boxes, Options};
use serde_json::Value;
use std::collections::HashMap;

pub(super) fn read(text: &str, name: &str, options: &Options) -> Result<Lines> {
    let data: Value = serde_json::from_str(text).map_err(|error| {
        Error::input(
            format!("{name}:{}", error.line()),
            format!("not valid JSON: {error}"),
            "give COCO's list of detections, [{\"image_id\": 1, \"category_id\": 0, \
             \"bbox\": [left, top, width, height], \"score\": 0.9}, ...]",
        )
    })?;
    let listed = |key: &str| data.get(key).and_then(Value::as_array);
    let Some(boxes) = data.as_array().or_else(|| listed("annotations")) else {
        return Err(Error::input(
            name,
            "JSON, but no list of detections and no data set with `annotations`",
            "give COCO's list of detections, or its data set",
        ));
    };
    let names: HashMap<i64, &str> = listed("categories")
        .into_iter()
        .flatten()
        .filter_map(|entry| Some((entry.get("id")?.as_i64()?, entry.get("name")?.as_str()?)))
        .collect();
    // A data set of films says which frame an image is.
    let frames: HashMap<i64, f64> = listed("images")
        .into_iter()
        .flatten()
        .filter_map(|entry| {
            let frame = entry.get("frame_id").or_else(|| entry.get("frame_index"))?;
            Some((entry.get("id")?.as_i64()?, frame.as_f64()?))
        })
        .collect();
    // COCO's are sizes, but programs write corners as well.
    let kind = options.boxes.unwrap_or_default();
    let read = |entry: &Value| -> std::result::Result<Row, String> {
        let image = entry.get("image_id").and_then(Value::as_i64);
        let image = image.ok_or("the image_id is no whole number: the frames are missing")?;
        let figures = entry.get("bbox").and_then(Value::as_array);
        let figures: Option<Vec<f64>> =
            figures.and_then(|list| list.iter().map(Value::as_f64).collect());
        let Some([left, top, width, height]) = figures.as_deref() else {
            return Err("the bbox is not four numbers".to_owned());
        };
        let id = ["track_id", "instance_id", "tracker_id"]
            .iter()
            .find_map(|key| entry.get(*key));
        let frame = frame(frames.get(&image).copied().unwrap_or(image as f64))?;
        let id = id.and_then(Value::as_i64).filter(|id| *id >= 0);
        let mut row = boxed(frame, id, [*left, *top, *width, *height], kind)?;
        row.confidence = entry.get("score").and_then(Value::as_f64);
        row.class = entry.get("category_id").and_then(Value::as_i64).map(|id| {
            names
                .get(&id)
                .map_or_else(|| id.to_string(), |name| (*name).trim().to_owned())
        });
        Ok(row)
    };
    let line = |(index, entry): (usize, &Value)| Line {
        file: None,
        number: index + 1,
        filled: 1,
        row: read(entry),
    };
    let mut remarks = vec!["classes from category_id".to_owned()];
    if frames.is_empty() {
        remarks.push("frames from image_id".to_owned());
    }
    Ok(Lines {
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
                "give every detection an image_id that is its frame, and a bbox as --boxes says, \
                 or leave out --boxes if it is [left, top, width, height]"
            }
        },
    })
}
