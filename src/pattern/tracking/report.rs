//! What the import did to a file, in text and machine-readable form.

use super::formats::Format;
use super::listing::named;
use super::motion::Motion;
use super::options::ImportOptions;
use super::read::{DroppedLine, TrackFile};
use super::track::Track;

/// An object that did not become an item.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct Dropped {
    /// Id of the object, as in the file.
    pub track: String,
    /// Why the object is not an item of the pattern.
    pub reason: String,
    /// Number of frames in which it was seen.
    pub frames: usize,
    /// Measured speed along the travel [m/s]; `None` if it was seen in a single frame.
    pub speed: Option<f64>,
}

/// A track that consisted of several objects with the same id.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[non_exhaustive]
pub struct Split {
    /// Id of the track in the file, before it was split.
    pub track: String,
    /// Number of tracks that it became: `ID`, `ID.2`, ...
    pub pieces: usize,
}

/// An object whose id changed.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[non_exhaustive]
pub struct Merged {
    /// The id that was kept, which is the first one.
    pub track: String,
    /// All of its ids, in order of time.
    pub parts: Vec<String>,
}

/// What was read, dropped, split, merged and measured.
#[derive(Debug, Clone, serde::Serialize)]
#[non_exhaustive]
pub struct ImportReport {
    /// Name of the file in messages.
    pub file: String,
    /// The file format that was given or recognised.
    pub format: Format,
    /// Notes on how the file was interpreted.
    pub remarks: Vec<String>,
    /// Number of lines that are not blank.
    pub lines: usize,
    /// Number of ids in the file, or of tracks that were linked from its boxes.
    pub tracks: usize,
    /// Number of items in the pattern.
    pub items: usize,
    /// Number of lines that could not be read, without an incomplete last line.
    pub malformed_lines: usize,
    /// Number of lines with a repeated frame and id.
    pub repeated_lines: usize,
    /// Number of the last line if it was incomplete.
    pub cut_off_line: Option<usize>,
    /// The first dropped lines of all three kinds.
    pub dropped_lines: Vec<DroppedLine>,
    /// Total number of dropped lines.
    pub dropped_lines_total: usize,
    /// Objects that did not become items.
    pub dropped: Vec<Dropped>,
    /// Tracks that were several objects.
    pub split: Vec<Split>,
    /// Objects that had several ids.
    pub merged: Vec<Merged>,
    /// Number of boxes without a size, treated as points; they have no area.
    pub points: usize,
    /// Number of boxes whose confidence is missing or outside 0 to 1; they are ignored for
    /// `p_detection`.
    pub no_confidence: usize,
    /// Number of boxes with confidence 0, which are kept.
    pub zero_confidence: usize,
    /// Possible problems that did not prevent the import.
    pub warnings: Vec<String>,
    /// Pixel of the belt's centre line [px].
    pub centre_px: f64,
    /// Whether the centre line was given; otherwise it is the middle between the outermost items.
    pub centre_given: bool,
    /// Distance added to every x0 so that the largest is 0 [m].
    pub shift_m: f64,
    /// Given angle of the travel from the axis [degrees].
    pub angle_deg: f64,
    /// Given belt speed [m/s].
    pub belt_speed: f64,
    /// Median of the objects' measured speeds [m/s], including dropped objects; `None` if all were
    /// seen only once.
    pub measured_speed: Option<f64>,
    /// Median of the items' measured speeds [m/s], to be used for calibration.
    pub measured_speed_items: Option<f64>,
    /// Number of items whose speed differs from the belt speed by more than 25 %.
    pub odd_items: usize,
    /// The belt as seen in the items' tracks; `None` if they are too short.
    pub motion: Option<Motion>,
}

/// A count with its noun: "1 line", "2 lines".
pub(super) fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

impl ImportReport {
    /// The report with what is known after reading.
    pub(super) fn new(
        name: &str,
        options: &ImportOptions,
        reading: TrackFile,
        tracks: &[Track],
    ) -> Self {
        let cut_off = usize::from(reading.cut_off.is_some());
        let mut report = Self {
            file: name.to_owned(),
            format: reading.format,
            remarks: reading.remarks,
            lines: reading.lines,
            tracks: tracks.len(),
            items: 0,
            malformed_lines: reading.malformed,
            repeated_lines: reading.repeated,
            cut_off_line: reading.cut_off,
            dropped_lines: reading.dropped,
            dropped_lines_total: reading.malformed + reading.repeated + cut_off,
            dropped: Vec::new(),
            split: Vec::new(),
            merged: Vec::new(),
            points: 0,
            no_confidence: 0,
            zero_confidence: 0,
            warnings: Vec::new(),
            centre_px: 0.0,
            centre_given: options.centre_px.is_some(),
            shift_m: 0.0,
            angle_deg: options.angle_deg,
            belt_speed: options.belt_speed,
            measured_speed: None,
            measured_speed_items: None,
            odd_items: 0,
            motion: None,
        };
        for sighting in tracks.iter().flat_map(|track| &track.sightings) {
            report.points += usize::from(sighting.size.is_none());
            match sighting.confidence {
                Some(0.0) => report.zero_confidence += 1,
                Some(p) if (0.0..=1.0).contains(&p) => {}
                _ => report.no_confidence += 1,
            }
        }
        report
    }

    /// Records a drop if there is a reason for one; returns whether the track stays.
    pub(super) fn note_drop(
        &mut self,
        track: &Track,
        speed: Option<f64>,
        reason: Option<&str>,
    ) -> bool {
        let Some(reason) = reason else { return true };
        self.dropped.push(Dropped {
            track: track.name.clone(),
            reason: reason.to_owned(),
            frames: track.sightings.len(),
            speed,
        });
        false
    }

    /// The dropped objects grouped by reason, in order of first occurrence: (reason, names).
    pub(super) fn dropped_by_reason(&self) -> Vec<(&str, Vec<&str>)> {
        let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
        for dropped in &self.dropped {
            match groups
                .iter_mut()
                .find(|(reason, _)| *reason == dropped.reason)
            {
                Some((_, names)) => names.push(&dropped.track),
                None => groups.push((&dropped.reason, vec![&dropped.track])),
            }
        }
        groups
    }

    /// The report as text without its warnings, one finding per line.
    pub fn lines(&self) -> Vec<String> {
        let mut out = vec![format!(
            "{} ({}): {} and {} became {}",
            self.file,
            self.format,
            count(self.lines, "line"),
            count(self.tracks, "track"),
            count(self.items, "item")
        )];
        out.extend(self.remarks.iter().cloned());
        if let Some(items) = self.measured_speed_items.or(self.measured_speed) {
            let all = self.measured_speed.unwrap_or(items);
            out.push(format!(
                "median measured speed: {items:.4} m/s over the items, {all:.4} m/s over all \
                 tracks; the given belt speed is {} m/s",
                self.belt_speed
            ));
        }
        if let Some(motion) = &self.motion {
            // Adding 0 turns negative zero into zero.
            let angle = ((self.angle_deg + motion.angle_deg) * 100.0).round() / 100.0 + 0.0;
            out.push(format!(
                "the belt travels at {angle:.2} degrees from 'axis' in the image (+/- {:.2}), from \
                 {}",
                1.96 * motion.angle_error_deg,
                count(motion.tracks, "track")
            ));
        }
        let origin = match self.centre_given {
            true => "as given",
            false => "the middle between the outermost items",
        };
        out.push(format!(
            "centre line at pixel {:.2}, {origin}",
            self.centre_px
        ));
        out.push(format!(
            "shifted along x by {:.4} m, so that the first item is at x = 0",
            self.shift_m
        ));
        self.line_findings(&mut out);
        self.track_findings(&mut out);
        out
    }

    fn line_findings(&self, out: &mut Vec<String>) {
        if self.dropped_lines_total > 0 {
            out.push(format!(
                "dropped {}: {} malformed, {} repeated, {} incomplete",
                count(self.dropped_lines_total, "line"),
                self.malformed_lines,
                self.repeated_lines,
                usize::from(self.cut_off_line.is_some())
            ));
            let listed = self.dropped_lines.iter();
            out.extend(listed.map(|d| match &d.file {
                Some(file) => format!("  {file}, line {}: {}", d.line, d.reason),
                None => format!("  line {}: {}", d.line, d.reason),
            }));
            match self
                .dropped_lines_total
                .saturating_sub(self.dropped_lines.len())
            {
                0 => {}
                more => out.push(format!("  and {more} more")),
            }
        }
        for (number, meaning) in [
            (self.points, "without a size: points, no area"),
            (
                self.no_confidence,
                "without a confidence from 0 to 1: ignored for p_detection",
            ),
            (
                self.zero_confidence,
                "with confidence 0: kept (in MOTChallenge ground truth 0 means ignored)",
            ),
        ] {
            if number > 0 {
                let boxes = if number == 1 { "box" } else { "boxes" };
                out.push(format!("{number} {boxes} {meaning}"));
            }
        }
    }

    fn track_findings(&self, out: &mut Vec<String>) {
        if !self.split.is_empty() {
            let each = |s: &Split| format!("{} into {}", s.track, s.pieces);
            let all: Vec<String> = self.split.iter().map(each).collect();
            out.push(format!(
                "split {} whose id was reused: {}",
                count(all.len(), "track"),
                named(all.iter().map(String::as_str))
            ));
        }
        if !self.merged.is_empty() {
            let all: Vec<String> = self.merged.iter().map(|m| m.parts.join(" + ")).collect();
            out.push(format!(
                "merged {} that changed {} id: {}",
                count(all.len(), "object"),
                if all.len() == 1 { "its" } else { "their" },
                named(all.iter().map(String::as_str))
            ));
        }
        for (reason, names) in self.dropped_by_reason() {
            out.push(format!(
                "dropped {}, {reason}: {}",
                count(names.len(), "track"),
                named(names)
            ));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lists_are_cut_short() {
        assert_eq!(named(["a", "b"]), "a, b");
        assert!(named(["a"; 12]).ends_with("a and 2 more"));
        assert_eq!(count(1, "line"), "1 line");
        assert_eq!(count(0, "line"), "0 lines");
    }
}
