//! Boxes in shares of the picture: Ultralytics' labels, one file a frame, and the text of
//! YOLO trackers.

use super::{Format, Line, Lines, Row, boxed, class, frame, image_size, number, track_id};
use crate::error::{Error, Result};
use crate::pattern::tracking::options::{Boxes, Options};
use std::path::Path;

/// Reads every text file of a folder; its frame is the last number in its name, as in
/// `film_12.txt`.
pub(super) fn load(folder: &Path) -> Result<Vec<(u32, String, String)>> {
    let name = folder.display().to_string();
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|error| Error::read(folder, error))? {
        let path = entry.map_err(|error| Error::read(folder, error))?.path();
        let is_text = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("txt"));
        let stem = path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        // Lists of names and of classes lie in the same folders.
        if !is_text || ["classes", "labels"].contains(&stem.as_str()) {
            continue;
        }
        let digits = stem.len() - stem.trim_end_matches(|c: char| c.is_ascii_digit()).len();
        let Ok(frame) = stem[stem.len() - digits..].parse::<u32>() else {
            return Err(Error::input(
                path.display().to_string(),
                "the name of the file ends in no number, so its frame is not known",
                "name the files by their frames, as in film_12.txt",
            ));
        };
        let file = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        files.push((frame, file, crate::files::read_text(&path)?));
    }
    if files.is_empty() {
        return Err(Error::input(
            name,
            "the folder holds no .txt file",
            "give a folder of labels with one file a frame, as `yolo track save_txt=True` \
             writes it, or name one file",
        ));
    }
    // The order of a folder is the file system's; frames are everybody's.
    files.sort();
    if let Some(pair) = files.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(Error::input(
            name,
            format!("{} and {} are of one frame", pair[0].1, pair[1].1),
            "give one film's labels a folder of their own",
        ));
    }
    Ok(files)
}

/// What the sixth of six fields is.
#[derive(Clone, Copy, PartialEq)]
enum Sixth {
    Confidence,
    Id,
}

pub(super) fn read(
    files: &[(u32, String, String)],
    name: &str,
    options: &Options,
) -> Result<Lines> {
    let size = image_size(name, options)?;
    let kind = options.boxes_of(Boxes::Centres, "Ultralytics' form")?;
    let rows = || files.iter().flat_map(|(_, _, text)| text.lines());
    let fields = |line: &str| line.split_whitespace().count();
    if let Some((_, file, _)) = files
        .iter()
        .find(|(_, _, text)| text.lines().any(|l| fields(l) > 7))
    {
        return Err(Error::input(
            format!("{name}/{file}"),
            "more than 7 fields: outlines or key points, not boxes",
            "export boxes: run a detection model, whose labels are `class xc yc w h [conf] [id]`",
        ));
    }
    let sixths: Vec<f64> = rows()
        .filter(|line| fields(line) == 6)
        .filter_map(|line| line.split_whitespace().nth(5)?.parse().ok())
        .collect();
    let sixth = if sixths.iter().all(|value| value.fract() == 0.0) {
        Sixth::Id
    } else {
        Sixth::Confidence
    };
    let mut lines = Vec::new();
    for (frame, file, text) in files {
        for (index, line) in text.lines().enumerate() {
            if line.trim().is_empty() {
                continue;
            }
            let fields: Vec<&str> = line.split_whitespace().collect();
            lines.push(Line {
                file: Some(file.clone()),
                number: index + 1,
                // Lines differ by design: the first boxes of a track have no id yet.
                filled: 5,
                row: read_label(*frame, &fields, sixth, size),
            });
        }
    }
    let mut remarks = vec!["classes from the first column".to_owned()];
    if !sixths.is_empty() {
        remarks.push(match sixth {
            Sixth::Id => "the sixth column holds whole numbers: track ids".to_owned(),
            Sixth::Confidence => "the sixth column holds fractions: confidences".to_owned(),
        });
    }
    Ok(Lines {
        format: Format::Ultralytics,
        boxes: kind,
        lines,
        remarks,
        cure: "give lines `class xc yc w h [conf] [id]` in shares of the picture",
    })
}

fn read_label(
    frame: u32,
    fields: &[&str],
    sixth: Sixth,
    size: (f64, f64),
) -> std::result::Result<Row, String> {
    let field = |place: usize| fields.get(place).copied().unwrap_or_default();
    let share = |place: usize, what: &str| share(field(place), what);
    let (x, y) = (share(1, "xc")? * size.0, share(2, "yc")? * size.1);
    let (width, height) = (share(3, "w")? * size.0, share(4, "h")? * size.1);
    let (confidence, id) = match fields.len() {
        7 => (Some(5), Some(6)),
        6 if sixth == Sixth::Id => (None, Some(5)),
        6 => (Some(5), None),
        _ => (None, None),
    };
    let id = match id {
        Some(place) => track_id(number(field(place), "id")?)?,
        None => None,
    };
    let mut row = boxed(frame, id, [x, y, width, height], Boxes::Centres)?;
    row.class = class(field(0));
    if let Some(place) = confidence {
        row.confidence = Some(number(field(place), "confidence")?);
    }
    Ok(row)
}

/// A share of the picture, a little more for boxes that reach past its edge.
fn share(text: &str, what: &str) -> std::result::Result<f64, String> {
    match number(text, what)? {
        value if (-1.0..=2.0).contains(&value) => Ok(value),
        value => Err(format!("{what} {value:?} is not a share of the picture")),
    }
}

/// Labels of a whole film in one file: which lines are of one frame nobody can tell.
pub(super) fn without_frames(name: &str) -> Error {
    Error::input(
        name,
        "Ultralytics labels (class xc yc w h) of a whole film in one file: the frames are missing",
        "give the folder with one file a frame, as `yolo track save_txt=True` writes it",
    )
}

/// `frame class x1 y1 x2 y2 xc yc`.
pub(super) fn read_yolo(text: &str, name: &str, options: &Options) -> Result<Lines> {
    let rows: Vec<(usize, Vec<&str>)> = text
        .trim_end()
        .lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
        .map(|(index, line)| (index + 1, line.split_whitespace().collect()))
        .collect();
    let mut before = f64::NEG_INFINITY;
    for (line, fields) in &rows {
        let first = fields.first().and_then(|field| field.parse::<f64>().ok());
        let Some(first) = first else { continue };
        if first < before {
            return Err(Error::input(
                format!("{name}:{line}"),
                format!(
                    "a YOLO tracker's text (class x1 y1 x2 y2 xc yc in shares of the picture), \
                     but the first column goes back from {before} to {first}: it counts the \
                     boxes or tracks, and the frames are missing"
                ),
                "have the tracker write the frame first, or export MOT text \
                 (frame,id,left,top,width,height,conf) or one label file a frame",
            ));
        }
        before = first;
    }
    let size = image_size(name, options)?;
    let kind = options.boxes_of(Boxes::Corners, "the YOLO tracker's form")?;
    let read = |fields: &[&str]| -> std::result::Result<Row, String> {
        let field = |place: usize| fields.get(place).copied().unwrap_or_default();
        let frame = frame(number(field(0), "frame")?)?;
        let corners = [
            share(field(2), "x1")? * size.0,
            share(field(3), "y1")? * size.1,
            share(field(4), "x2")? * size.0,
            share(field(5), "y2")? * size.1,
        ];
        let mut row = boxed(frame, None, corners, kind)?;
        row.class = class(field(1));
        Ok(row)
    };
    let line = |(number, fields): &(usize, Vec<&str>)| Line {
        file: None,
        number: *number,
        filled: fields.len(),
        row: read(fields),
    };
    Ok(Lines {
        format: Format::Yolo,
        boxes: kind,
        lines: rows.iter().map(line).collect(),
        remarks: vec!["classes from the second column".to_owned()],
        cure: "give lines `frame class x1 y1 x2 y2 xc yc` in shares of the picture",
    })
}
