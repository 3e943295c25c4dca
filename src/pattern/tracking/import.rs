//! The import: read, split, drop, merge, drop, place.

use super::formats::Recording;
use super::link::{link, other_way};
use super::median::median_of;
use super::mismatch::{Seen, contradictions, turn_over, warn};
use super::motion::{measure, way};
use super::object::{Object, merge, split};
use super::options::{ImageAxis, ImportOptions};
use super::pace::pace;
use super::place::{BACKWARDS, FEWER, Found, STILL, not_riding, place};
use super::read::{TrackFile, read};
use super::report::{ImportReport, Merged, Split, count};
use super::track::{Track, stride};
use crate::error::{Error, Result};
use crate::pattern::Pattern;

/// A pattern from a tracker's file, with a report on how it was made.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Import {
    /// One item per object, with the id of its track.
    pub pattern: Pattern,
    /// What was dropped, split, merged and measured.
    pub report: ImportReport,
}

/// Turns a recording into a pattern, as described at the top of the module; messages call the file
/// `name`.
///
/// An item's `x0` [m] and `y` [m] are the medians over its boxes, `area_cm2` is the median area of
/// the boxes that have one, and `p_detection` is the mean of the confidences within 0 to 1. A box
/// of size -1 x -1 (or 0 x 0) is a point at left, top.
///
/// # Errors
/// If an option is not possible for a camera or belt; if a file has more broken lines than valid
/// ones, or numbers of uncertain meaning; if no item remains; or if the tracks contradict the
/// options so much that the pattern would be wrong. Never panics, whatever the text.
pub fn import(recording: &Recording, name: &str, options: &ImportOptions) -> Result<Import> {
    options.check()?;
    let mut reading = read(recording, name, options)?;
    let mut tracks = std::mem::take(&mut reading.tracks);
    let linked = tracks.is_empty();
    let mut misled = None;
    if linked {
        (tracks, misled) = link_boxes(&mut reading, name, options)?;
    }
    let sightings = tracks.iter().flat_map(|track| &track.sightings);
    let first_line = sightings.map(|sighting| sighting.line).min();
    let boxes = reading.boxes;
    let mut report = ImportReport::new(name, options, reading, &tracks);
    report.warnings.extend(misled);
    let mut pieces = split_reused_ids(tracks, &mut report, options);
    let way = way(&pieces);
    // Includes tracks that stand still for a while: the belt may have stopped.
    let pace = pace(&pieces);
    // First remove what clearly does not ride on the belt: its x0 is meaningless and must not merge
    // with the track of a passing item. A fragment too short to decide stays for now.
    pieces.retain(|track| {
        let speed = track.speed(options);
        let lag = speed.map_or(0.0, |v| (options.belt_speed - v) * track.duration(options));
        let reason = not_riding(speed, options).filter(|_| lag > options.merge_distance_m);
        report.note_drop(track, speed, reason)
    });
    let objects = merge(pieces, options);
    let kept = keep_riding(&objects, &mut report, options);
    let rides: Vec<bool> = kept.iter().map(Option::is_some).collect();
    let twins = twins(&objects, &kept);
    let found: Vec<Found> = kept.into_iter().flatten().collect();
    let item_speeds = || found.iter().filter_map(|f| f.speed);
    report.measured_speed_items = median_of(item_speeds());
    let lost = report.dropped.iter().filter_map(|d| d.speed);
    report.measured_speed = median_of(lost.chain(item_speeds()));
    if found.is_empty() {
        return Err(nothing_remains(&report, first_line, way, options));
    }
    let riding = objects.iter().zip(&rides).filter(|(_, rides)| **rides);
    report.motion = measure(
        riding.map(|(object, _)| &object.track),
        pace.as_ref(),
        options,
    );
    let seen = Seen::new(&found, &report, boxes, linked, options);
    warn(&mut report, &found, &twins, &seen, options);
    let items = place(found, &mut report, options);
    contradictions(&report, &items, &seen, options)?;
    let pattern = Pattern::checked(items, name, &|_| name.to_owned())?;
    report.items = pattern.len();
    Ok(Import { pattern, report })
}

/// The tracks of a file with boxes only, and a warning if the boxes travel in another direction
/// than the options say.
///
/// # Errors
/// That direction, unless the options accept it.
fn link_boxes(
    reading: &mut TrackFile,
    name: &str,
    options: &ImportOptions,
) -> Result<(Vec<Track>, Option<String>)> {
    let boxes = std::mem::take(&mut reading.loose);
    let count = boxes.len();
    let misled = other_way(&boxes, options);
    if let Some((problem, cure)) = misled.as_ref().filter(|_| !options.accept_mismatch) {
        return Err(Error::input(
            name,
            format!("the pattern would be wrong: {problem}"),
            format!("{cure}; 'accept_mismatch' creates the pattern anyway"),
        ));
    }
    let tracks = link(boxes, options);
    reading.remarks.push(format!(
        "no track ids: {count} boxes linked to {} tracks by the belt's motion",
        tracks.len()
    ));
    let warning = misled.map(|(problem, cure)| format!("{problem}: {cure}"));
    Ok((tracks, warning))
}

/// Splits the tracks that consist of several objects.
fn split_reused_ids(
    tracks: Vec<Track>,
    report: &mut ImportReport,
    options: &ImportOptions,
) -> Vec<Track> {
    let stride = stride(&tracks);
    let mut pieces = Vec::with_capacity(tracks.len());
    for track in tracks {
        let mut parts = split(track, stride, options);
        if let [first, _, ..] = &parts[..] {
            report.split.push(Split {
                track: first.name.clone(),
                pieces: parts.len(),
            });
        }
        pieces.append(&mut parts);
    }
    pieces
}

/// What is known about each object; `None` if it is dropped.
fn keep_riding(
    objects: &[Object],
    report: &mut ImportReport,
    options: &ImportOptions,
) -> Vec<Option<Found>> {
    let mut kept: Vec<Option<Found>> = Vec::with_capacity(objects.len());
    for object in objects {
        if object.parts.len() > 1 {
            report.merged.push(Merged {
                track: object.track.name.clone(),
                parts: object.parts.clone(),
            });
        }
        let speed = object.track.speed(options);
        let found = Found::new(object, speed, options);
        let reason = if object.track.sightings.len() < options.min_frames {
            Some(format!("{FEWER} {} frames", options.min_frames))
        } else if found.is_absurd(options) {
            Some("impossibly far away or large".to_owned())
        } else {
            not_riding(speed, options).map(str::to_owned)
        };
        let stays = report.note_drop(&object.track, speed, reason.as_deref());
        kept.push(stays.then_some(found));
    }
    kept
}

/// Pairs of items, by name, that were at the same position at the same time.
fn twins(objects: &[Object], kept: &[Option<Found>]) -> Vec<String> {
    let name = |index: usize| kept[index].as_ref().map(|found| &found.item.id);
    let pair = |(index, object): (usize, &Object)| {
        let (one, other) = (name(object.twin?)?, name(index)?);
        Some(format!("{one} and {other}"))
    };
    objects.iter().enumerate().filter_map(pair).collect()
}

/// Like [`import`], for a text.
#[cfg(test)]
pub(super) fn import_text(text: &str, name: &str, options: &ImportOptions) -> Result<Import> {
    import(&Recording::Text(text.to_owned()), name, options)
}

fn nothing_remains(
    report: &ImportReport,
    first_line: Option<usize>,
    way: Option<(f64, f64)>,
    options: &ImportOptions,
) -> Error {
    let groups = report.dropped_by_reason();
    let each = |(reason, names): &(&str, Vec<&str>)| format!("{} {reason}", names.len());
    let reasons: Vec<String> = groups.iter().map(each).collect();
    let most = groups.iter().max_by_key(|(_, names)| names.len());
    let speeds = format!(
        "the median speed of the tracks is {:.4} m/s, the given belt speed is {} m/s",
        report.measured_speed.unwrap_or_default(),
        options.belt_speed
    );
    let aside = way.filter(|(along, across)| across.abs() > 2.0 * along.abs());
    let cure = match most.map_or("", |(reason, _)| reason) {
        STILL | BACKWARDS if aside.is_some() => {
            let across = aside.map_or(0.0, |(_, across)| across);
            let axis = match options.axis {
                ImageAxis::X => "y",
                ImageAxis::Y => "x",
            };
            let reverse = if across < 0.0 { " 'reverse'" } else { "" };
            format!("give 'axis' {axis}{reverse}, the direction of the tracks: {speeds}")
        }
        BACKWARDS => format!("{}: {speeds}", turn_over(options)),
        STILL => format!("check 'scale_m_per_px', 'fps', 'belt_speed' and 'axis': {speeds}"),
        reason if reason.starts_with(FEWER) => {
            "lower 'min_frames', or configure the tracker to keep its ids longer".to_owned()
        }
        _ => "check 'scale_m_per_px' and 'fps'".to_owned(),
    };
    Error::input(
        format!("{}:{}", report.file, first_line.unwrap_or(1)),
        format!(
            "no item remains of {}: {}",
            count(report.tracks, "track"),
            reasons.join(", ")
        ),
        cure,
    )
}

#[cfg(test)]
mod tests {
    use super::super::options::ImageAxis;
    use super::import_text as import;
    use super::*;
    use proptest::prelude::*;
    use std::fmt::Write;

    const MESSY: &str = include_str!("../../../tests/data/messy_mot.txt");

    /// 10 frames per second, 1 mm per pixel: the belt moves 10 px per frame.
    fn options() -> ImportOptions {
        ImportOptions::new(10.0, 0.001, ImageAxis::X, 0.1)
    }

    /// Lines of 40 x 20 boxes around (`along` at frame 0 + `step` per frame, `across`).
    fn track(id: u32, frames: std::ops::Range<u32>, along: f64, step: f64, across: f64) -> String {
        frames.fold(String::new(), |mut text, frame| {
            let left = along + step * f64::from(frame) - 20.0;
            let top = across - 10.0;
            let _ = writeln!(text, "{frame},{id},{left},{top},40,20,0.8,-1,-1,-1");
            text
        })
    }

    fn of(text: &str) -> Import {
        import(text, "t.txt", &options()).unwrap()
    }

    fn ids(import: &Import) -> Vec<&str> {
        let items = import.pattern.items();
        items.iter().map(|item| item.id.as_str()).collect()
    }

    fn reasons(import: &Import) -> Vec<(&str, &str)> {
        let dropped = import.report.dropped.iter();
        dropped.map(|d| (&*d.track, &*d.reason)).collect()
    }

    fn has(lines: &[String], words: &str) -> bool {
        lines.iter().any(|line| line.contains(words))
    }

    #[test]
    fn gaps_stay_and_reused_ids_are_split() {
        let text = track(4, 1..11, 0.0, 10.0, 50.0)
            + &track(4, 20..25, 0.0, 10.0, 50.0)
            + &track(4, 60..70, -600.0, 10.0, 50.0);
        let result = of(&text);
        assert_eq!(ids(&result), ["4", "4.2"]);
        assert!((result.pattern.items()[1].x0 + 0.6).abs() < 1e-12);
        assert_eq!(result.report.split[0].pieces, 2);
        assert!(has(&result.report.lines(), "id was reused: 4 into 2"));
    }

    #[test]
    fn changed_ids_are_merged_even_for_short_tracks() {
        let text = track(1, 1..11, 0.0, 10.0, 50.0)
            + &track(2, 11..12, 3.0, 10.0, 50.0)
            + &track(3, 12..20, -2.0, 10.0, 51.0);
        let result = of(&text);
        assert_eq!(ids(&result), ["1"]);
        assert_eq!(result.report.merged[0].parts, ["1", "2", "3"]);
        assert!(has(&result.report.lines(), "changed its id: 1 + 2 + 3"));
        // A one-frame glitch splits a track in three; its ends are merged.
        let glitch = track(1, 1..8, 0.0, 10.0, 50.0)
            + &track(1, 8..9, 400.0, 10.0, 50.0)
            + &track(1, 9..15, 0.0, 10.0, 50.0);
        let result = of(&glitch);
        assert_eq!(result.report.merged[0].parts, ["1", "1.3"]);
        assert_eq!(reasons(&result), [("1.2", "fewer than 2 frames")]);
    }

    #[test]
    fn what_does_not_ride_is_dropped() {
        let text = track(1, 1..11, 0.0, 10.0, 50.0)
            + &track(2, 1..60, 100.0, 0.01, 90.0)
            + &track(3, 1..60, 900.0, -9.0, 70.0)
            + &track(5, 1..60, 300.0, -0.02, 70.0)
            + &track(6, 7..8, 700.0, 10.0, 70.0)
            + &track(7, 1..3, 900.0, 1.0, 60.0);
        let result = of(&text);
        assert_eq!(ids(&result), ["1"]);
        let expected = [
            ("2", "stands still"),
            ("3", "moves backwards"),
            ("5", "stands still"),
            ("7", "stands still"),
            ("6", "fewer than 2 frames"),
        ];
        assert_eq!(reasons(&result), expected);
        assert_eq!(result.report.dropped[1].frames, 59);
        assert!((result.report.dropped[1].speed.unwrap() + 0.09).abs() < 1e-9);
        assert!(has(&result.report.lines(), "stands still: 2, 5, 7"));
        let mut once = options();
        once.min_frames = 1;
        let result = import(&text, "t", &once).unwrap();
        assert_eq!(ids(&result), ["6", "1"]);
        // A dirty speck must not swallow the item that passes through it.
        let speck = track(1, 30..40, 0.0, 10.0, 50.0) + &track(2, 1..29, 150.0, 0.0, 50.0);
        assert_eq!(ids(&of(&speck)), ["1"]);
        assert!(of(&speck).report.merged.is_empty());
    }

    #[test]
    fn odd_speeds_and_twins_are_kept_with_a_warning() {
        let text = track(1, 1..11, 0.0, 10.0, 50.0)
            + &track(2, 1..11, 300.0, 14.0, 90.0)
            + &track(3, 2..11, 4.0, 10.0, 51.0);
        let result = of(&text);
        assert_eq!(result.report.items, 3);
        let warnings = &result.report.warnings;
        assert!(has(warnings, "1 item more than 25 % off"), "{warnings:?}");
        assert!(has(warnings, "tracked twice: 1 and 3"), "{warnings:?}");
        let slow = track(1, 1..11, 0.0, 9.0, 50.0);
        let report = of(&slow).report;
        assert!(has(&report.warnings, "move at 0.0900 m/s"));
        assert!(has(&report.warnings, "the items move"));
    }

    #[test]
    fn when_nothing_remains_the_error_says_why() {
        for (text, words) in [
            (
                track(1, 1..9, 0.0, 0.0, 5.0),
                &["t.txt:1", "1 stands still", "'scale_m_per_px'"][..],
            ),
            (
                track(1, 1..2, 0.0, 0.0, 5.0),
                &["fewer than 2 frames", "'min_frames'"],
            ),
            (
                track(1, 1..9, 0.0, 1.0, 5.0),
                &[
                    "median speed of the tracks is 0.0100 m/s",
                    "given belt speed is 0.1",
                ],
            ),
            (
                "999999999,1,1,1,1,1,1\n1000000000,1,11,1,1,1,1".into(),
                &["impossibly", "'fps'"],
            ),
            (String::new(), &["no line"]),
        ] {
            let message = import(&text, "t.txt", &options()).unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
        let mut bad = options();
        bad.fps = 0.0;
        assert!(
            import("", "t", &bad)
                .unwrap_err()
                .to_string()
                .contains("'fps'")
        );
    }

    #[test]
    fn the_messy_file_is_understood() {
        let result = of(MESSY);
        let report = &result.report;
        assert_eq!(ids(&result), ["1", "2", "3", "5", "3.2"], "{report:#?}");
        let xs: Vec<f64> = result.pattern.items().iter().map(|i| i.x0).collect();
        for (x, expected) in xs.iter().zip([0.0, -0.1, -0.2, -0.3, -1.2]) {
            assert!((x - expected).abs() < 0.003, "{xs:?}");
        }
        assert_eq!((report.malformed_lines, report.repeated_lines), (1, 1));
        assert!(report.cut_off_line.is_some());
        assert_eq!(report.merged[0].parts, ["2", "8"]);
        let expected = [
            ("6", "stands still"),
            ("7", "moves backwards"),
            ("9", "fewer than 2 frames"),
        ];
        assert_eq!(reasons(&result), expected);
        let json = serde_json::to_value(report).unwrap();
        assert_eq!(json["items"], 5);
    }

    #[test]
    fn a_long_and_degenerate_file_is_imported() {
        // 60,000 tracks at the same place and time: every track is a neighbour of all others, so
        // comparing all pairs would take billions of steps.
        let mut text = String::new();
        for id in 0..60_000 {
            let _ = writeln!(text, "1,{id},5,5,2,2,1\n2,{id},15,5,2,2,1");
        }
        assert_eq!(of(&text).report.items, 60_000);
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC*", fields in "([-0-9.,e \t\r\n]|nan|inf){0,400}") {
            let mut loose = options();
            loose.min_frames = 1;
            for text in [text, fields] {
                let _ = import(&text, "t", &options()).map(|i| i.report.lines());
                let _ = import(&text, "t", &loose).map(|i| i.report.lines());
            }
        }

        #[test]
        fn no_boxes_panic(
            boxes in prop::collection::vec((1u32..40, 0u32..6, -500i32..500, 0i32..200), 1..200),
            axis in prop::sample::select(vec![ImageAxis::X, ImageAxis::Y]),
            reverse: bool,
        ) {
            let mut text = String::new();
            for (frame, id, left, top) in boxes {
                let _ = writeln!(text, "{frame} {id} {left} {top} 8 8 1");
            }
            let mut options = options();
            (options.axis, options.reverse, options.min_frames) = (axis, reverse, 1);
            if let Ok(result) = import(&text, "t", &options) {
                prop_assert_eq!(result.pattern.items()[0].x0, 0.0);
                prop_assert_eq!(result.report.items, result.pattern.len());
            }
        }

    }
}
