//! Boxes in relative image coordinates: Ultralytics labels, one file per frame, and the text of
//! YOLO trackers.

use super::fields::{LAST_FRAME, boxed, class, frame, number, track_id};
use super::format::Format;
use super::fractions::{image_size, share};
use super::lines::{FileLine, FileLines, FileRow};
use crate::error::{Error, Result};
use crate::pattern::tracking::options::{Boxes, ImportOptions};
use std::path::Path;

/// Reads every text file in a folder. The frame of a file is the number in its name that differs
/// between files, as in `film_12.txt`.
pub(super) fn load(folder: &Path) -> Result<Vec<(u32, String, String)>> {
    let name = folder.display().to_string();
    let mut stems = Vec::new();
    let mut texts = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(|error| Error::read(folder, error))? {
        let path = entry.map_err(|error| Error::read(folder, error))?.path();
        let is_text = path
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("txt"));
        let part = |part: Option<&std::ffi::OsStr>| {
            part.unwrap_or_default().to_string_lossy().into_owned()
        };
        let stem = part(path.file_stem());
        // The same folders contain lists of names and classes.
        if !is_text || ["classes", "labels"].contains(&stem.as_str()) {
            continue;
        }
        if !stem.contains(|c: char| c.is_ascii_digit()) {
            return Err(Error::input(
                path.display().to_string(),
                "the file name contains no number, so its frame is unknown",
                "include the frame number in each file name, as in film_12.txt",
            ));
        }
        stems.push(stem);
        texts.push((part(path.file_name()), crate::files::read_text(&path)?));
    }
    if texts.is_empty() {
        return Err(Error::input(
            name,
            "the folder contains no .txt file",
            "give a folder of labels with one file per frame, as `yolo track save_txt=True` \
             writes it, or give a single file",
        ));
    }
    let frames = frames_of(&stems).map_err(|(problem, cure)| Error::input(&name, problem, cure))?;
    let with_text = frames.into_iter().zip(texts);
    let mut files: Vec<(u32, String, String)> = with_text
        .map(|(frame, (file, text))| (frame, file, text))
        .collect();
    // The order within a folder depends on the file system; frames do not.
    files.sort();
    if let Some(pair) = files.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        return Err(Error::input(
            name,
            format!("{} and {} have the same frame", pair[0].1, pair[1].1),
            "use a separate folder for the labels of each video",
        ));
    }
    Ok(files)
}

/// The frame numbers in the image names of a video: the last number that differs in every name.
/// Numbers too large for frames are timestamps, and their common step is one frame. On failure, the
/// problem and its cure.
pub(super) fn frames_of(names: &[String]) -> std::result::Result<Vec<u32>, (String, &'static str)> {
    const CURE: &str = "include the frame number in each file name, as in film_12.txt";
    let numbers = |name: &String| -> Vec<u64> {
        let parts = name.split(|c: char| !c.is_ascii_digit());
        // A longer number is a hash.
        let parts = parts.filter(|part| !part.is_empty());
        parts.map(|part| part.parse().unwrap_or(u64::MAX)).collect()
    };
    let numbers: Vec<Vec<u64>> = names.iter().map(numbers).collect();
    let fewest = numbers.iter().map(Vec::len).min().unwrap_or_default();
    let most = numbers.iter().map(Vec::len).max().unwrap_or_default();
    if fewest == 0 {
        return Err((
            "a file name contains no number, so its frame is unknown".into(),
            CURE,
        ));
    }
    let from_start = |place: usize| -> Vec<u64> { numbers.iter().map(|n| n[place]).collect() };
    let from_end =
        |place: usize| -> Vec<u64> { numbers.iter().map(|n| n[n.len() - 1 - place]).collect() };
    let all_differ = |list: &Vec<u64>| {
        let distinct: std::collections::HashSet<&u64> = list.iter().collect();
        distinct.len() == list.len()
    };
    let ends = (0..fewest).map(from_end);
    let mut candidates: Box<dyn Iterator<Item = Vec<u64>>> = match fewest == most {
        true => Box::new(ends),
        // In some names, another part with digits follows the frame number.
        false => Box::new((0..fewest).map(from_start).chain(ends)),
    };
    let found = candidates.find(all_differ);
    let found = found.unwrap_or_else(|| from_end(0));
    if let Ok(frames) = found.iter().map(|&number| frame_number(number)).collect() {
        return Ok(frames);
    }
    frames_of_stamps(&found).ok_or_else(|| {
        let first = found.iter().min().copied().unwrap_or_default();
        let problem = format!(
            "the numbers in the file names, from {first}, are neither frame numbers nor evenly \
             spaced timestamps"
        );
        (problem, CURE)
    })
}

/// The frame numbers of timestamps whose common step is one frame; `None` if they have no such
/// step.
fn frames_of_stamps(stamps: &[u64]) -> Option<Vec<u32>> {
    let first = stamps.iter().min().copied().unwrap_or_default();
    let divisor = |mut a: u64, mut b: u64| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    let step = stamps
        .iter()
        .fold(0, |step, &stamp| divisor(step, stamp - first));
    let frames = stamps
        .iter()
        .map(|&stamp| frame_number((stamp - first) / step.max(1)).ok());
    let frames: Vec<u32> = frames.collect::<Option<_>>()?;
    // Without a common step the numbers are not frame counts.
    let last = frames.iter().max().copied()?;
    ((last as usize) < 100 * stamps.len()).then_some(frames)
}

fn frame_number(number: u64) -> std::result::Result<u32, ()> {
    match number {
        number if number as f64 <= LAST_FRAME => u32::try_from(number).map_err(|_| ()),
        _ => Err(()),
    }
}

/// The meaning of the sixth of six fields.
#[derive(Clone, Copy, PartialEq)]
enum Sixth {
    Confidence,
    Id,
    /// Neither: a whole number that several boxes of one frame share.
    Unknown,
}

/// Determines the meaning of the sixth of six fields: fractions are confidences and whole numbers
/// are ids, unless several boxes of one frame share them.
fn sixth(files: &[(u32, String, String)]) -> Option<(Sixth, &'static str)> {
    let (mut all, mut shared) = (0_usize, 0_usize);
    let mut in_unit = true;
    for (_, _, text) in files {
        let values = text.lines().filter_map(|line| {
            let fields: Vec<&str> = line.split_whitespace().collect();
            (fields.len() == 6).then(|| fields[5].parse::<f64>().ok())?
        });
        let mut values: Vec<f64> = values.collect();
        if values.iter().any(|value| value.fract() != 0.0) {
            return Some((Sixth::Confidence, "contains fractions: confidences"));
        }
        all += values.len();
        in_unit &= values.iter().all(|value| (0.0..=1.0).contains(value));
        values.retain(|value| *value >= 0.0);
        values.sort_by(f64::total_cmp);
        shared += values.windows(2).filter(|pair| pair[0] == pair[1]).count();
    }
    match all {
        0 => None,
        // A tracker repeats an id within a frame only by mistake.
        all if shared * 4 <= all => Some((Sixth::Id, "contains whole numbers: track ids")),
        _ if in_unit => Some((
            Sixth::Confidence,
            "contains only 0 and 1, shared by boxes of one frame: confidences",
        )),
        _ => Some((
            Sixth::Unknown,
            "is ignored: boxes of one frame share its whole numbers, so they are not track ids",
        )),
    }
}

pub(super) fn read(
    files: &[(u32, String, String)],
    name: &str,
    options: &ImportOptions,
) -> Result<FileLines> {
    let size = image_size(name, options)?;
    let kind = options.boxes_of(Boxes::Centres, "the Ultralytics format")?;
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
    let found = sixth(files);
    let sixth = found.map_or(Sixth::Unknown, |(sixth, _)| sixth);
    let mut lines = Vec::new();
    for (frame, file, text) in files {
        for (index, line) in text.lines().enumerate() {
            if line.trim().is_empty() {
                continue;
            }
            let fields: Vec<&str> = line.split_whitespace().collect();
            lines.push(FileLine {
                file: Some(file.clone()),
                number: index + 1,
                // Lines vary by design: the first boxes of a track have no id yet.
                filled: 5,
                row: read_label(*frame, &fields, sixth, size),
            });
        }
    }
    let mut remarks = vec!["classes from the first column".to_owned()];
    let named = |frame: &u32, file: &str| {
        file.split(|c: char| !c.is_ascii_digit())
            .any(|part| part.parse() == Ok(*frame))
    };
    if files
        .last()
        .is_some_and(|(frame, file, _)| !named(frame, file))
    {
        remarks.push("frames from the steps between the timestamps in the names".to_owned());
    }
    if let Some((_, words)) = found {
        remarks.push(format!("the sixth column {words}"));
    }
    Ok(FileLines {
        format: Format::Ultralytics,
        boxes: kind,
        lines,
        remarks,
        cure: "give lines `class xc yc w h [conf] [id]` as fractions of the image size",
    })
}

fn read_label(
    frame: u32,
    fields: &[&str],
    sixth: Sixth,
    size: (f64, f64),
) -> std::result::Result<FileRow, String> {
    let field = |place: usize| fields.get(place).copied().unwrap_or_default();
    let share = |place: usize, what: &str| share(field(place), what);
    let (x, y) = (share(1, "xc")? * size.0, share(2, "yc")? * size.1);
    let (width, height) = (share(3, "w")? * size.0, share(4, "h")? * size.1);
    let (confidence, id) = match fields.len() {
        7 => (Some(5), Some(6)),
        6 if sixth == Sixth::Id => (None, Some(5)),
        6 if sixth == Sixth::Confidence => (Some(5), None),
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

/// The error for labels of a whole video in one file, which do not show which lines belong to one
/// frame.
pub(super) fn without_frames(name: &str) -> Error {
    Error::input(
        name,
        "Ultralytics labels (class xc yc w h) of a whole video in one file: the frames are missing",
        "give the folder with one file per frame, as `yolo track save_txt=True` writes it",
    )
}

/// `frame class x1 y1 x2 y2 xc yc`.
pub(super) fn read_yolo(text: &str, name: &str, options: &ImportOptions) -> Result<FileLines> {
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
                    "a YOLO tracker's text (class x1 y1 x2 y2 xc yc as image fractions), \
                     but the first column goes back from {before} to {first}, so it counts the \
                     boxes or tracks and the frames are missing"
                ),
                "configure the tracker to write the frame first, or export MOT text \
                 (frame,id,left,top,width,height,conf) or one label file per frame",
            ));
        }
        before = first;
    }
    let size = image_size(name, options)?;
    let kind = options.boxes_of(Boxes::Corners, "the YOLO tracker format")?;
    let read = |fields: &[&str]| -> std::result::Result<FileRow, String> {
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
    let line = |(number, fields): &(usize, Vec<&str>)| FileLine {
        file: None,
        number: *number,
        filled: fields.len(),
        row: read(fields),
    };
    Ok(FileLines {
        format: Format::Yolo,
        boxes: kind,
        lines: rows.iter().map(line).collect(),
        remarks: vec!["classes from the second column".to_owned()],
        cure: "give lines `frame class x1 y1 x2 y2 xc yc` as fractions of the image size",
    })
}
