//! From text to tracks: the lines of a MOTChallenge file, the broken ones set aside.

use super::options::Options;
use super::report::{DroppedLine, LISTED};
use crate::error::{Error, Result, shown};
use std::collections::HashMap;

/// Pixels past this are no image; the bound keeps every later product finite.
const LARGEST_PX: f64 = 1e6;
/// A frame number past this is years of film.
const LAST_FRAME: f64 = 1e9;
/// Whole numbers up to this are exact in the f64 that ids are read as.
const LARGEST_ID: f64 = 9e15;
/// `frame,id,left,top,width,height,conf`; whatever follows is passed over.
const USED_FIELDS: usize = 7;

/// One box of one track.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sighting {
    /// Frame, from 1.
    pub frame: u32,
    /// Line of the file, from 1.
    pub line: usize,
    /// Centre of the box along the travel, growing with it [px].
    pub along: f64,
    /// Centre of the box across the travel, as the image counts it [px].
    pub across: f64,
    /// Area of the box [px^2]; none for a point.
    pub area: Option<f64>,
    /// What the file gives as confidence, whatever its range.
    pub confidence: Option<f64>,
}

/// The boxes under one id, by frame, never empty, no frame twice.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Track {
    pub name: String,
    pub sightings: Vec<Sighting>,
}

/// What a file holds.
#[derive(Debug)]
pub(super) struct Reading {
    /// Lines that are not blank.
    pub lines: usize,
    /// In the order in which their ids first appear.
    pub tracks: Vec<Track>,
    pub malformed: usize,
    pub repeated: usize,
    pub cut_off: Option<usize>,
    /// The first [`LISTED`] of all dropped lines.
    pub dropped: Vec<DroppedLine>,
}

/// Reads `text`; `name` is how messages call it.
///
/// # Errors
/// A file without a line, or with more broken lines than good ones.
pub(super) fn read(text: &str, name: &str, options: &Options) -> Result<Reading> {
    // Without the blank end, the last line that `lines` gives is the last one written.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).trim_end();
    let mut reading = Reading {
        lines: 0,
        tracks: Vec::new(),
        malformed: 0,
        repeated: 0,
        cut_off: None,
        dropped: Vec::new(),
    };
    let mut first_malformed = None;
    let mut place_of: HashMap<i64, usize> = HashMap::new();
    let mut usual_fields = 0;
    let mut lines = text.lines().enumerate().peekable();
    while let Some((index, line)) = lines.next() {
        if line.trim().is_empty() {
            continue;
        }
        let number = index + 1;
        let is_last = lines.peek().is_none();
        reading.lines += 1;
        let (filled, fields) = split_fields(line);
        let reason = match read_box(&fields, number, options) {
            // A line of fewer fields than the one before it is how a write that was
            // broken off looks, even when the stump can be read.
            Ok(_) if is_last && filled < usual_fields => {
                format!("{filled} fields where the line before has {usual_fields}")
            }
            Ok((id, sighting)) => {
                usual_fields = filled;
                let place = *place_of.entry(id).or_insert_with(|| {
                    reading.tracks.push(Track {
                        name: id.to_string(),
                        sightings: Vec::new(),
                    });
                    reading.tracks.len() - 1
                });
                reading.tracks[place].sightings.push(sighting);
                continue;
            }
            Err(reason) => reason,
        };
        let reason = if is_last {
            reading.cut_off = Some(number);
            format!("last line, cut off: {reason}")
        } else {
            reading.malformed += 1;
            reason
        };
        first_malformed.get_or_insert_with(|| (number, reason.clone()));
        if reading.dropped.len() < LISTED {
            reading.dropped.push(DroppedLine {
                line: number,
                reason,
            });
        }
    }
    if reading.lines == 0 {
        return Err(Error::input(
            name,
            "the file has no line",
            "give a tracker's file with lines `frame,id,left,top,width,height,conf`",
        ));
    }
    if let Some((line, reason)) = first_malformed
        && (reading.tracks.is_empty() || reading.malformed > reading.lines / 2)
    {
        let broken = reading.malformed + usize::from(reading.cut_off.is_some());
        return Err(Error::input(
            format!("{name}:{line}"),
            format!(
                "{broken} of {} lines are not a tracker's; here: {reason}",
                reading.lines
            ),
            "give lines `frame,id,left,top,width,height,conf` with frames from 1 and a track's \
             id (a detector's file, where every id is -1, needs a tracker first)",
        ));
    }
    drop_repeated(&mut reading);
    Ok(reading)
}

/// The first fields of a line, and how many of all its fields are filled. Commas
/// separate where there are any, blanks and tabs elsewhere.
fn split_fields(line: &str) -> (usize, [&str; USED_FIELDS]) {
    let mut fields = [""; USED_FIELDS];
    let mut filled = 0;
    if line.contains(',') {
        for (place, field) in line.split(',').map(str::trim).enumerate() {
            filled += usize::from(!field.is_empty());
            if let Some(slot) = fields.get_mut(place) {
                *slot = field;
            }
        }
    } else {
        for (place, field) in line.split_whitespace().enumerate() {
            filled += 1;
            if let Some(slot) = fields.get_mut(place) {
                *slot = field;
            }
        }
    }
    (filled, fields)
}

/// The box of one line, or what is wrong with the line.
fn read_box(
    fields: &[&str; USED_FIELDS],
    line: usize,
    options: &Options,
) -> std::result::Result<(i64, Sighting), String> {
    let number = |place: usize, what: &str| match fields[place].parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ if fields[place].is_empty() => Err(format!("the {what} is missing")),
        _ => Err(format!("{what} `{}` is not a number", shown(fields[place]))),
    };
    let pixel = |place: usize, what: &str| match number(place, what)? {
        value if value.abs() <= LARGEST_PX => Ok(value),
        value => Err(format!("{what} {value:?} is not a pixel")),
    };
    // Some trackers print every column as a float, so `3.0` is frame 3.
    let frame = number(0, "frame")?;
    if frame.fract() != 0.0 || !(1.0..=LAST_FRAME).contains(&frame) {
        return Err(format!(
            "{frame:?} is not a frame: frames are counted from 1"
        ));
    }
    let id = number(1, "id")?;
    if id.fract() != 0.0 || !(0.0..=LARGEST_ID).contains(&id) {
        return Err(match id == -1.0 {
            true => "id -1: a detection without a track".to_owned(),
            false => format!("{id:?} is not a track's id"),
        });
    }
    let (left, top) = (pixel(2, "left")?, pixel(3, "top")?);
    let (width, height) = (pixel(4, "width")?, pixel(5, "height")?);
    let sized = width > 0.0 && height > 0.0;
    let point = (width == -1.0 && height == -1.0) || (width == 0.0 && height == 0.0);
    if !sized && !point {
        return Err(format!("a box of {width:?} x {height:?} pixels"));
    }
    if point && width == -1.0 && left == -1.0 && top == -1.0 {
        // The 3D challenge fills the image columns so.
        return Err("neither box nor point: all four are -1".to_owned());
    }
    let confidence = match fields[6] {
        "" => None,
        _ => Some(number(6, "confidence")?),
    };
    let (width, height) = if sized { (width, height) } else { (0.0, 0.0) };
    let (along, across) = options.turned(left + width / 2.0, top + height / 2.0);
    let sighting = Sighting {
        // In range and whole, so exact.
        frame: frame as u32,
        line,
        along,
        across,
        area: sized.then_some(width * height),
        confidence,
    };
    Ok((id as i64, sighting))
}

/// Sorts every track by frame and keeps the first line of each frame.
fn drop_repeated(reading: &mut Reading) {
    let mut repeated: Vec<(usize, u32, &str)> = Vec::new();
    for track in &mut reading.tracks {
        // Stable: of two lines of one frame the earlier one stays ahead.
        track.sightings.sort_by_key(|sighting| sighting.frame);
        let name = &track.name;
        track.sightings.dedup_by(|next, kept| {
            let same = next.frame == kept.frame;
            if same {
                repeated.push((next.line, next.frame, name));
            }
            same
        });
    }
    reading.repeated = repeated.len();
    repeated.sort_unstable();
    let listed = repeated.iter().take(LISTED);
    reading
        .dropped
        .extend(listed.map(|&(line, frame, name)| DroppedLine {
            line,
            reason: format!("frame {frame} of track {name} was there before"),
        }));
    reading.dropped.sort_by_key(|dropped| dropped.line);
    reading.dropped.truncate(LISTED);
}

#[cfg(test)]
mod tests {
    use super::super::options::Axis;
    use super::*;

    fn options() -> Options {
        Options::new(10.0, 0.001, Axis::X, 0.1)
    }

    fn track(name: &str, frames: &[u32]) -> (String, Vec<u32>) {
        (name.to_owned(), frames.to_vec())
    }

    fn frames(reading: &Reading) -> Vec<(String, Vec<u32>)> {
        let of = |t: &Track| t.sightings.iter().map(|s| s.frame).collect();
        reading
            .tracks
            .iter()
            .map(|t| (t.name.clone(), of(t)))
            .collect()
    }

    #[test]
    fn separators_marks_and_line_ends_do_not_matter() {
        let plain = read("1,7,10,20,4,6,0.5\n2,7,20,20,4,6,0.5\n", "t", &options()).unwrap();
        assert_eq!(frames(&plain), [track("7", &[1, 2])]);
        let first = &plain.tracks[0].sightings[0];
        assert_eq!((first.along, first.across), (12.0, 23.0));
        assert_eq!((first.area, first.confidence), (Some(24.0), Some(0.5)));
        for text in [
            "\u{feff}1,7,10,20,4,6,0.5\r\n2,7,20,20,4,6,0.5\r\n",
            "1, 7, 10, 20, 4, 6, 0.5\n2, 7, 20, 20, 4, 6, 0.5",
            "1 7 10 20 4 6 0.5\n2 7  20 20 4 6 0.5\n\n \n",
            "1\t7\t10\t20\t4\t6\t0.5\n2\t7\t20\t20\t4\t6\t0.5\t-1\t-1\t-1\n",
            "1.0,7.00e0,10,20,4,6,0.5,-1,-1,-1\n2,7,20,20,4,6,0.5,-1,-1,-1\n",
        ] {
            let other = read(text, "t", &options()).unwrap();
            assert_eq!(other.tracks, plain.tracks, "{text:?}");
            assert!(other.dropped.is_empty(), "{text:?}");
        }
    }

    #[test]
    fn points_and_missing_confidences_are_read() {
        let text = "1,1,10,20,-1,-1,-1,-1,-1,-1\n2,1,20,20,0,0,3.5,-1,-1,-1\n3,1,30,20,2,2\n4,1,1,1,1,1,,,";
        let reading = read(text, "t", &options()).unwrap();
        let seen = &reading.tracks[0].sightings;
        assert_eq!((seen[0].along, seen[0].across), (10.0, 20.0));
        assert_eq!((seen[0].area, seen[1].area), (None, None));
        assert_eq!((seen[1].along, seen[2].along), (20.0, 31.0));
        let confidences: Vec<_> = seen.iter().map(|s| s.confidence).collect();
        assert_eq!(confidences, [Some(-1.0), Some(3.5), None, None]);
    }

    #[test]
    fn broken_lines_are_dropped_and_named() {
        for (line, word) in [
            ("frame,id,left,top,width,height,conf", "`frame`"),
            ("0,1,1,1,1,1,1", "counted from 1"),
            ("1.5,1,1,1,1,1,1", "not a frame"),
            ("4000000000,1,1,1,1,1,1", "not a frame"),
            ("9,-1,1,1,1,1,1", "without a track"),
            ("9,-3,1,1,1,1,1", "-3.0 is not a track's id"),
            ("9,1e99,1,1,1,1,1", "not a track's id"),
            ("9,1,nan,1,1,1,1", "left `nan`"),
            ("9,1,1,inf,1,1,1", "top `inf`"),
            ("9,1,1e9,1,1,1,1", "not a pixel"),
            ("9,1,1,1,-5,4,1", "-5.0 x 4.0"),
            ("9,1,1,1,5,0,1", "5.0 x 0.0"),
            ("9,1,-1,-1,-1,-1,1", "all four are -1"),
            ("9,1,1,1,1,1,high", "confidence `high`"),
            ("9,1,1,1", "width is missing"),
            ("# a comment", "frame `#`"),
            ("9,1,,1,1,1,1", "left is missing"),
        ] {
            let text = format!("1,1,1,1,1,1,1\n2,1,1,1,1,1,1\n\n{line}\n3,1,1,1,1,1,1\n");
            let reading = read(&text, "t", &options()).unwrap();
            assert_eq!(frames(&reading), [track("1", &[1, 2, 3])], "{line}");
            assert_eq!((reading.malformed, reading.lines), (1, 4), "{line}");
            assert_eq!(reading.dropped[0].line, 4, "{line}");
            let reason = &reading.dropped[0].reason;
            assert!(reason.contains(word), "{word} not in {reason}");
        }
    }

    #[test]
    fn a_cut_off_last_line_is_dropped() {
        for stump in ["3,1,1,1", "3,1,1,1,1,1,", "3,1,1,1,1,1", "3", "3,1,1,-"] {
            let text = format!("1,1,1,1,1,1,1\n2,1,1,1,1,1,1\n{stump}");
            let reading = read(&text, "t", &options()).unwrap();
            assert_eq!(frames(&reading), [track("1", &[1, 2])], "{stump}");
            assert_eq!((reading.cut_off, reading.malformed), (Some(3), 0));
            assert!(reading.dropped[0].reason.contains("cut off"), "{stump}");
        }
        // One good line and a stump: not more than half is broken.
        assert!(read("1,1,1,1,1,1,1\n2,1", "t", &options()).is_ok());
    }

    #[test]
    fn of_repeated_lines_the_first_stays() {
        let text = "2,1,5,1,2,2,1\n1,1,0,1,2,2,1\n2,1,9,1,2,2,1\n2,3,9,1,2,2,1\n2,1,8,1,2,2,1\n";
        let reading = read(text, "t", &options()).unwrap();
        assert_eq!(frames(&reading), [track("1", &[1, 2]), track("3", &[2])]);
        assert_eq!(reading.tracks[0].sightings[1].along, 6.0);
        assert_eq!(reading.repeated, 2);
        let lines: Vec<_> = reading.dropped.iter().map(|d| d.line).collect();
        assert_eq!(lines, [3, 5]);
        assert!(reading.dropped[0].reason.contains("frame 2 of track 1"));
    }

    #[test]
    fn the_list_of_dropped_lines_is_capped() {
        let text = "1,1,1,1,1,1,1\n2,x\n".repeat(500) + "3,1,1,1,1,1,1\n";
        let reading = read(&text, "t", &options()).unwrap();
        assert_eq!((reading.malformed, reading.repeated), (500, 499));
        let lines: Vec<_> = reading.dropped.iter().map(|d| d.line).collect();
        assert_eq!(lines, (2..2 + LISTED).collect::<Vec<_>>());
    }

    #[test]
    fn a_file_of_something_else_is_an_error() {
        for (text, words) in [
            ("", &["t: ", "no line"][..]),
            ("\u{feff} \n\n", &["no line"]),
            ("1,1,1", &["t:1", "1 of 1 lines", "cut off"]),
            ("a\nb\n1,1,1,1,1,1,1\n", &["t:1", "2 of 3 lines", "`a`"]),
            (
                "1,-1,1,1,1,1,1\n1,-1,5,1,1,1,1\n1,2,1,1,1,1,1",
                &["without a track", "tracker first"],
            ),
        ] {
            let message = read(text, "t", &options()).unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
    }
}
