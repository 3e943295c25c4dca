//! Turns lines into tracks, and separates broken lines and boxes without a track.

use super::class_naming::name_classes;
use super::formats::{self, FileLine, FileLines, Format, Recording};
use super::options::{Boxes, ImportOptions};
use super::track::{BoxSighting, Track};
use crate::error::{Error, Result};
use std::collections::HashMap;

/// Maximum number of dropped lines listed; the counts cover all of them.
const LISTED: usize = 20;

/// A line of the file that was ignored.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[non_exhaustive]
pub struct DroppedLine {
    /// Name of the file within a folder; `None` for a single file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Line number, from 1.
    pub line: usize,
    /// What is wrong with it.
    pub reason: String,
}

/// The content of a file.
#[derive(Debug)]
pub(super) struct TrackFile {
    pub format: Format,
    /// How the four numbers of the boxes were interpreted.
    pub boxes: Boxes,
    /// Notes on how the file was interpreted.
    pub remarks: Vec<String>,
    /// Number of lines that are not blank.
    pub lines: usize,
    /// Tracks in the order in which their ids first appear.
    pub tracks: Vec<Track>,
    /// Boxes without a track, from a file without any tracks.
    pub loose: Vec<BoxSighting>,
    pub malformed: usize,
    pub repeated: usize,
    pub cut_off: Option<usize>,
    /// The dropped lines, at most the first [`LISTED`].
    pub dropped: Vec<DroppedLine>,
}

/// Reads `recording`; messages call it `name`.
///
/// # Errors
/// If a file has no lines, numbers of uncertain meaning, or more broken lines than valid ones.
pub(super) fn read(
    recording: &Recording,
    name: &str,
    options: &ImportOptions,
) -> Result<TrackFile> {
    let mut source = formats::read(recording, name, options)?;
    if let Some(names) = &options.class_names {
        name_classes(names, &mut source, name)?;
    }
    let cure = source.cure;
    let mut sorted = SortedLines::of(source, options);
    if sorted.file.lines == 0 {
        return Err(Error::input(
            name,
            "the file has no lines",
            "give a tracker's file with lines `frame,id,left,top,width,height,conf`",
        ));
    }
    sorted.place_loose();
    sorted.file.check_share(name, cure)?;
    let first = u32::from(count_from_one(&mut sorted.file));
    let SortedLines {
        file: mut reading,
        file_of,
        ..
    } = sorted;
    reading.dropped.truncate(LISTED);
    drop_repeated(&mut reading, |frame| file_of.get(&(frame - first)).cloned());
    Ok(reading)
}

/// The lines of a file, sorted into tracks, boxes without a track and dropped lines.
struct SortedLines {
    /// All dropped lines are in its list, in the order of the file.
    file: TrackFile,
    /// The boxes without a track, with the names of their files.
    loose: Vec<(Option<String>, BoxSighting)>,
    /// The place of each track, by its id.
    place_of: HashMap<i64, usize>,
    /// The file of each frame: in a folder, every frame has its own.
    file_of: HashMap<u32, String>,
}

impl SortedLines {
    fn of(source: FileLines, options: &ImportOptions) -> Self {
        let mut sorted = Self {
            file: TrackFile {
                format: source.format,
                boxes: source.boxes,
                remarks: source.remarks,
                lines: source.lines.len(),
                tracks: Vec::new(),
                loose: Vec::new(),
                malformed: 0,
                repeated: 0,
                cut_off: None,
                dropped: Vec::new(),
            },
            loose: Vec::new(),
            place_of: HashMap::new(),
            file_of: HashMap::new(),
        };
        let mut usual_fields = 0;
        let mut lines = source.lines.into_iter().peekable();
        while let Some(line) = lines.next() {
            let is_last = lines.peek().is_none();
            let FileLine {
                file,
                number,
                filled,
                row,
            } = line;
            match row {
                // A line with fewer fields than the previous one indicates an interrupted write,
                // even if the rest can be parsed.
                Ok(_) if is_last && filled < usual_fields => {
                    let reason =
                        format!("{filled} fields, but the previous line has {usual_fields}");
                    sorted.drop_line(file, number, is_last, reason);
                }
                Ok(row) => {
                    usual_fields = filled;
                    let id = row.id;
                    sorted.keep(file, id, BoxSighting::new(row, number, options));
                }
                Err(reason) => sorted.drop_line(file, number, is_last, reason),
            }
        }
        sorted
    }

    fn keep(&mut self, file: Option<String>, id: Option<i64>, sighting: BoxSighting) {
        if let Some(file) = &file {
            self.file_of
                .entry(sighting.frame)
                .or_insert_with(|| file.clone());
        }
        let Some(id) = id else {
            self.loose.push((file, sighting));
            return;
        };
        let tracks = &mut self.file.tracks;
        let place = *self.place_of.entry(id).or_insert_with(|| {
            tracks.push(Track {
                name: id.to_string(),
                sightings: Vec::new(),
            });
            tracks.len() - 1
        });
        tracks[place].sightings.push(sighting);
    }

    fn drop_line(&mut self, file: Option<String>, line: usize, is_last: bool, reason: String) {
        let reason = if is_last {
            self.file.cut_off = Some(line);
            format!("last line, incomplete: {reason}")
        } else {
            self.file.malformed += 1;
            reason
        };
        self.file.dropped.push(DroppedLine { file, line, reason });
    }

    /// Keeps the boxes without a track if the file has no tracks at all, and drops them otherwise.
    fn place_loose(&mut self) {
        let loose = std::mem::take(&mut self.loose);
        let file = &mut self.file;
        if file.tracks.is_empty() {
            file.loose = loose.into_iter().map(|(_, sighting)| sighting).collect();
            return;
        }
        file.malformed += loose.len();
        let dropped = loose.into_iter().map(|(name, sighting)| DroppedLine {
            file: name,
            line: sighting.line,
            reason: "a detection without a track".to_owned(),
        });
        file.dropped.extend(dropped);
        // Also orders the lines of a folder, whose files are sorted, by frame.
        file.dropped
            .sort_by(|a, b| (&a.file, a.line).cmp(&(&b.file, b.line)));
    }
}

impl TrackFile {
    /// Rejects a file with more broken lines than valid ones, or without any valid line.
    fn check_share(&self, name: &str, cure: &str) -> Result<()> {
        let nothing = self.tracks.is_empty() && self.loose.is_empty();
        let Some(first) = self.dropped.first() else {
            return Ok(());
        };
        if !nothing && self.malformed <= self.lines / 2 {
            return Ok(());
        }
        let place = match &first.file {
            Some(file) => format!("{name}/{file}:{}", first.line),
            None => format!("{name}:{}", first.line),
        };
        Err(Error::input(
            place,
            format!(
                "{} of {} lines are not in a tracker's format; the first: {}",
                self.dropped.len(),
                self.lines,
                first.reason
            ),
            cure,
        ))
    }
}

/// Converts a file that counts frames from 0 so that the first frame is 1; returns whether it did.
fn count_from_one(reading: &mut TrackFile) -> bool {
    let tracked = reading.tracks.iter_mut().flat_map(|t| &mut t.sightings);
    let mut all: Vec<&mut BoxSighting> = tracked.chain(&mut reading.loose).collect();
    let from_zero = all.iter().any(|sighting| sighting.frame == 0);
    if from_zero {
        all.iter_mut().for_each(|sighting| sighting.frame += 1);
        reading.remarks.push("frames counted from 0".to_owned());
    }
    from_zero
}

/// Sorts every track by frame and keeps the first line of each frame. For a folder, `file_of` is
/// the file of a frame.
fn drop_repeated(reading: &mut TrackFile, file_of: impl Fn(u32) -> Option<String>) {
    let mut repeated: Vec<(usize, u32, &str)> = Vec::new();
    for track in &mut reading.tracks {
        // Stable sorting keeps the earlier of two lines with the same frame first.
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
            file: file_of(frame),
            line,
            reason: format!("duplicate frame {frame} of track {name}"),
        }));
    let place = |dropped: &DroppedLine| (dropped.file.clone(), dropped.line);
    reading.dropped.sort_by_cached_key(place);
    reading.dropped.truncate(LISTED);
}

#[cfg(test)]
mod tests {
    use super::super::options::ImageAxis;
    use super::*;

    fn read(text: &str, name: &str, options: &ImportOptions) -> Result<TrackFile> {
        super::read(&Recording::Text(text.to_owned()), name, options)
    }

    fn options() -> ImportOptions {
        ImportOptions::new(10.0, 0.001, ImageAxis::X, 0.1)
    }

    fn track(name: &str, frames: &[u32]) -> (String, Vec<u32>) {
        (name.to_owned(), frames.to_vec())
    }

    fn frames(reading: &TrackFile) -> Vec<(String, Vec<u32>)> {
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
        assert_eq!((first.area(), first.confidence), (Some(24.0), Some(0.5)));
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
        assert_eq!((seen[0].area(), seen[1].area()), (None, None));
        assert_eq!((seen[1].along, seen[2].along), (20.0, 31.0));
        let confidences: Vec<_> = seen.iter().map(|s| s.confidence).collect();
        assert_eq!(confidences, [Some(-1.0), Some(3.5), None, None]);
    }

    #[test]
    fn broken_lines_are_dropped_and_named() {
        for (line, word) in [
            ("frame,id,left,top,width,height,conf", "`frame`"),
            ("-1,1,1,1,1,1,1", "counted from 0 or 1"),
            ("1.5,1,1,1,1,1,1", "not a valid frame number"),
            ("4000000000,1,1,1,1,1,1", "greater than the maximum"),
            ("9,-1,1,1,1,1,1", "without a track"),
            ("9,-3,1,1,1,1,1", "-3.0 is not a valid track id"),
            ("9,1e99,1,1,1,1,1", "not a valid track id"),
            ("9,1,nan,1,1,1,1", "left `nan`"),
            ("9,1,1,inf,1,1,1", "top `inf`"),
            ("9,1,1e9,1,1,1,1", "not a valid pixel"),
            ("9,1,1,1,-5,4,1", "-5 x 4"),
            ("9,1,1,1,5,0,1", "5 x 0"),
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
            assert!(reading.dropped[0].reason.contains("incomplete"), "{stump}");
        }
        // One valid line and one incomplete line: not more than half is broken.
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
            ("1,1,1", &["t:1", "1 of 1 lines", "incomplete"]),
            ("a\nb\n1,1,1,1,1,1,1\n", &["t:1", "2 of 3 lines", "`a`"]),
            (
                "1,-1,1,1,1,1,1\n1,-1,5,1,1,1,1\n1,2,1,1,1,1,1",
                &["t:1", "2 of 3 lines", "without a track"],
            ),
        ] {
            let message = read(text, "t", &options()).unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
    }
}
