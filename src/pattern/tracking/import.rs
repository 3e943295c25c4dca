//! The import itself: read, split, drop, merge, drop, place.

use super::formats::Recording;
use super::link::link;
use super::motion::{Motion, measure, way};
use super::options::{Axis, Boxes, Options};
use super::place::{BACKWARDS, Found, ODD_SHARE, STILL, not_riding, place};
use super::read::read;
use super::report::{Merged, Report, Split, count, named};
use super::track::{Object, median_of, merge, split, stride};
use crate::error::{Error, Result};
use crate::pattern::{Item, Pattern};

/// The median over all items is surer than one item's speed, so it may be off by less.
const MEDIAN_SHARE: f64 = 0.05;

/// A pattern from a tracker's file, and how it came about.
#[derive(Debug, Clone)]
pub struct Import {
    /// One item per object, named by its track.
    pub pattern: Pattern,
    /// What was dropped, split, merged and measured.
    pub report: Report,
}

/// The median over all items is plainly wrong when it is off by more, the pattern when so
/// large a share of the items is [`ODD_SHARE`] off.
const WRONG_SHARE: f64 = 0.15;
const WRONG_ITEMS: f64 = 1.0 / 3.0;
/// Places that are off by this much [m] are worth a warning, by that much an error.
const OFF_M: f64 = 0.005;
const WRONG_M: f64 = 0.05;
/// Frame rates that cameras have [1/s].
const USUAL_FPS: [f64; 8] = [24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 100.0, 120.0];

/// Turns a recording into a pattern, as the module's head tells;
/// `name` is how messages call the file.
///
/// An item's `x0` [m] and `y` [m] are medians over its boxes, `area_cm2` is the median
/// area of the boxes that have one, `p_detection` the mean of the confidences that lie
/// in 0 to 1. A box of size -1 x -1 (or 0 x 0) is a point at left, top.
///
/// # Errors
/// An option that no camera or belt has, a file with more broken lines than good
/// ones or of numbers without a certain meaning, a file of which no item remains or whose
/// tracks contradict the options so much that the pattern would be wrong. Never panics,
/// whatever the text.
pub fn import(recording: &Recording, name: &str, options: &Options) -> Result<Import> {
    options.check()?;
    let mut reading = read(recording, name, options)?;
    let mut tracks = std::mem::take(&mut reading.tracks);
    if tracks.is_empty() {
        let boxes = std::mem::take(&mut reading.loose);
        let count = boxes.len();
        tracks = link(boxes, options);
        reading.remarks.push(format!(
            "no track ids: {count} boxes linked to {} tracks by the belt's motion",
            tracks.len()
        ));
    }
    let first_line = tracks
        .iter()
        .flat_map(|t| &t.sightings)
        .map(|s| s.line)
        .min();
    let mut report = Report::new(name, options, reading, &tracks);
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
    let way = way(&pieces);
    // What plainly does not ride goes first: its x0 means nothing, and must not draw a
    // passing item's track into a merger. A stump too short to tell stays for now.
    pieces.retain(|track| {
        let speed = track.speed(options);
        let lag = speed.map_or(0.0, |v| (options.belt_speed - v) * track.duration(options));
        let reason = not_riding(speed, options).filter(|_| lag > options.merge_distance_m);
        report.note_drop(track, speed, reason)
    });
    let objects = merge(pieces, options);
    let mut kept: Vec<Option<Found>> = Vec::with_capacity(objects.len());
    for object in &objects {
        if object.parts.len() > 1 {
            report.merged.push(Merged {
                track: object.track.name.clone(),
                parts: object.parts.clone(),
            });
        }
        let speed = object.track.speed(options);
        let found = Found::new(object, speed, options);
        let reason = if object.track.sightings.len() < options.min_frames {
            Some(format!("fewer than {} frames", options.min_frames))
        } else if found.is_absurd(options) {
            Some("absurdly far away or large".to_owned())
        } else {
            not_riding(speed, options).map(str::to_owned)
        };
        let stays = report.note_drop(&object.track, speed, reason.as_deref());
        kept.push(stays.then_some(found));
    }
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
    report.motion = measure(riding.map(|(object, _)| &object.track), options);
    warn(&mut report, &found, &twins, options);
    let items = place(found, &mut report, options);
    contradictions(&report, &items, options)?;
    let pattern = Pattern::checked(items, name, &|_| name.to_owned())?;
    report.items = pattern.len();
    Ok(Import { pattern, report })
}

/// Pairs of items, by name, that were at one place at one time.
fn twins(objects: &[Object], kept: &[Option<Found>]) -> Vec<String> {
    let name = |index: usize| kept[index].as_ref().map(|found| &found.item.id);
    let pair = |(index, object): (usize, &Object)| {
        let (one, other) = (name(object.twin?)?, name(index)?);
        Some(format!("{one} and {other}"))
    };
    objects.iter().enumerate().filter_map(pair).collect()
}

/// As [`import`], of a text.
#[cfg(test)]
pub(super) fn import_text(text: &str, name: &str, options: &Options) -> Result<Import> {
    import(&Recording::Text(text.to_owned()), name, options)
}

fn warn(report: &mut Report, found: &[Found], twins: &[String], options: &Options) {
    let belt = options.belt_speed;
    let off = |speed: f64, share: f64| (speed - belt).abs() > share * belt;
    let odd: Vec<&str> = found
        .iter()
        .filter(|f| f.speed.is_some_and(|v| off(v, ODD_SHARE)))
        .map(|f| f.item.id.as_str())
        .collect();
    report.odd_items = odd.len();
    if !odd.is_empty() {
        report.warnings.push(format!(
            "{} more than 25 % off the belt's speed, scale, fps or belt speed may be wrong: {}",
            count(odd.len(), "item"),
            named(odd)
        ));
    }
    if let Some(speed) = report
        .measured_speed_items
        .filter(|&v| off(v, MEDIAN_SHARE))
    {
        report.warnings.push(format!(
            "the items move at {speed:.4} m/s (median), the belt's speed was given as {belt} \
             m/s: {}",
            agreeing(speed, options)
        ));
    }
    if let Some(motion) = &report.motion {
        let mut found = Vec::new();
        if looks_like_corners(motion, options) {
            found.push(
                "the boxes grow with their travel: if they are corners, give --boxes corners"
                    .to_owned(),
            );
        }
        if motion.angle_off_m > OFF_M && is_turned(motion) {
            found.push(format!("{}: {}", turned(motion), turning(motion, options)));
        }
        if motion.bent_off_m > OFF_M {
            found.push(format!("{}: {STRAIGHTEN}", bent(motion)));
        }
        report.warnings.extend(found);
    }
    let lost = report.dropped.iter();
    let lost = lost
        .filter(|d| d.reason == STILL || d.reason == BACKWARDS)
        .count();
    if lost > found.len() {
        report.warnings.push(format!(
            "{} do not ride on the belt, more than do: --scale, --fps, --belt-speed, --axis or \
             --reverse may be wrong",
            count(lost, "track")
        ));
    }
    if !twins.is_empty() {
        report.warnings.push(format!(
            "{} at one place at one time, perhaps one item tracked twice: {}",
            count(twins.len(), "pair"),
            named(twins.iter().map(String::as_str))
        ));
    }
}

/// Refuses figures that the tracks contradict so much that the pattern would be wrong.
fn contradictions(report: &Report, items: &[Item], options: &Options) -> Result<()> {
    let belt = options.belt_speed;
    let odd = report.odd_items;
    let mut problems = Vec::new();
    let mut cures = Vec::new();
    let speed = report.measured_speed_items.unwrap_or(belt);
    let corners = report
        .motion
        .as_ref()
        .is_some_and(|m| looks_like_corners(m, options));
    if odd as f64 > WRONG_ITEMS * items.len() as f64 || (speed / belt - 1.0).abs() > WRONG_SHARE {
        let share = match odd {
            0 => String::new(),
            _ => format!(
                "{odd} of {} are more than 25 % off the belt's speed; ",
                count(items.len(), "item")
            ),
        };
        problems.push(format!(
            "{share}the items move at {speed:.4} m/s (median), the belt's speed was given as \
             {belt} m/s"
        ));
        if !corners {
            cures.push(agreeing(speed, options));
        }
    }
    if let Some(motion) = &report.motion {
        if corners {
            problems.push("the boxes grow with their travel, as corners taken for sizes do".into());
            cures.push("give --boxes corners".to_owned());
        }
        if motion.angle_off_m > WRONG_M && is_turned(motion) && !corners {
            problems.push(turned(motion));
            cures.push(turning(motion, options));
        }
        if motion.bent_off_m > WRONG_M && !corners {
            problems.push(bent(motion));
            cures.push(STRAIGHTEN.to_owned());
        }
    }
    if problems.is_empty() || options.accept_mismatch {
        return Ok(());
    }
    Err(Error::input(
        &report.file,
        format!("the pattern would be wrong: {}", problems.join("; ")),
        format!(
            "{}; --accept-mismatch makes the pattern all the same",
            cures.join("; ")
        ),
    ))
}

/// Whether the lower right corner was taken for the size: then the centre moves one and a
/// half times as fast as the box, and the size as fast as the box.
fn looks_like_corners(motion: &Motion, options: &Options) -> bool {
    options.boxes == Boxes::Sizes && (0.55..0.8).contains(&motion.growth)
}

/// The figures that would agree with items at `speed` [m/s].
fn agreeing(speed: f64, options: &Options) -> String {
    let ratio = options.belt_speed / speed;
    let fps = options.fps * ratio;
    let usual = USUAL_FPS
        .iter()
        .find(|usual| (fps / **usual - 1.0).abs() < 0.03);
    let fps = match usual {
        Some(usual) => format!("--fps {usual}"),
        None => format!("--fps {fps:.2}"),
    };
    format!(
        "--scale {:.6}, {fps} or --belt-speed {speed:.4} would agree with the tracks",
        options.scale_m_per_px * ratio
    )
}

const STRAIGHTEN: &str = "take the lens distortion and the tilt out of the film before tracking, \
                          for example with OpenCV's undistort and warpPerspective";

/// Whether the angle is more than chance.
fn is_turned(motion: &Motion) -> bool {
    motion.angle_deg.abs() > 3.0 * motion.angle_error_deg
}

fn turned(motion: &Motion) -> String {
    format!(
        "the belt travels {:.2} degrees off --axis in the picture, which puts items up to \
         {:.3} m off",
        motion.angle_deg, motion.angle_off_m
    )
}

fn turning(motion: &Motion, options: &Options) -> String {
    format!("give --angle {:.2}", options.angle_deg + motion.angle_deg)
}

fn bent(motion: &Motion) -> String {
    let cause = match motion.bends {
        true => "as with a lens that distorts",
        false => "as with a camera that is tilted",
    };
    let range = |speeds: Option<[f64; 2]>, way: &str| {
        let speeds = speeds.map(|[slow, fast]| format!(", {slow:.4} to {fast:.4} m/s {way}"));
        speeds.unwrap_or_default()
    };
    format!(
        "the belt's motion differs over the picture{}{}, {cause}, which puts items that \
         are seen on a part of the way only up to {:.3} m off",
        range(motion.speeds_along, "along it"),
        range(motion.speeds_across, "across it"),
        motion.bent_off_m
    )
}

fn nothing_remains(
    report: &Report,
    first_line: Option<usize>,
    way: Option<(f64, f64)>,
    options: &Options,
) -> Error {
    let groups = report.dropped_by_reason();
    let each = |(reason, names): &(&str, Vec<&str>)| format!("{} {reason}", names.len());
    let reasons: Vec<String> = groups.iter().map(each).collect();
    let most = groups.iter().max_by_key(|(_, names)| names.len());
    let speeds = format!(
        "the tracks' median speed is {:.4} m/s, the belt's was given as {} m/s",
        report.measured_speed.unwrap_or_default(),
        options.belt_speed
    );
    let aside = way.filter(|(along, across)| across.abs() > 2.0 * along.abs());
    let cure = match most.map_or("", |(reason, _)| reason) {
        STILL | BACKWARDS if aside.is_some() => {
            let across = aside.map_or(0.0, |(_, across)| across);
            let axis = match options.axis {
                Axis::X => "y",
                Axis::Y => "x",
            };
            let reverse = if across < 0.0 { " --reverse" } else { "" };
            format!("give --axis {axis}{reverse}, which is how the tracks travel: {speeds}")
        }
        BACKWARDS => format!("turn --reverse over, or check --axis: {speeds}"),
        STILL => format!("check --scale, --fps, --belt-speed and --axis: {speeds}"),
        reason if reason.starts_with("fewer") => {
            "lower --min-frames, or have the tracker keep its ids for longer".to_owned()
        }
        _ => "check --scale and --fps".to_owned(),
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
    use super::super::options::Axis;
    use super::import_text as import;
    use super::*;
    use proptest::prelude::*;
    use std::fmt::Write;

    const MESSY: &str = include_str!("../../../tests/data/messy_mot.txt");

    /// 10 frames a second, 1 mm a pixel: the belt moves 10 px a frame.
    fn options() -> Options {
        Options::new(10.0, 0.001, Axis::X, 0.1)
    }

    /// Lines of boxes of 40 x 20 around (`along` at frame 0 + `step` a frame, `across`).
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
        assert!(has(&result.report.lines(), "id was used again: 4 into 2"));
    }

    #[test]
    fn changed_ids_are_merged_even_from_stumps() {
        let text = track(1, 1..11, 0.0, 10.0, 50.0)
            + &track(2, 11..12, 3.0, 10.0, 50.0)
            + &track(3, 12..20, -2.0, 10.0, 51.0);
        let result = of(&text);
        assert_eq!(ids(&result), ["1"]);
        assert_eq!(result.report.merged[0].parts, ["1", "2", "3"]);
        assert!(has(&result.report.lines(), "changed their id: 1 + 2 + 3"));
        // A glitch of one frame splits a track in three; its ends find each other.
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
        assert!(has(&report.lines(), "warning: the items move"));
    }

    #[test]
    fn when_nothing_remains_the_error_says_why() {
        for (text, words) in [
            (
                track(1, 1..9, 0.0, 0.0, 5.0),
                &["t.txt:1", "1 stands still", "--scale"][..],
            ),
            (
                track(1, 1..2, 0.0, 0.0, 5.0),
                &["fewer than 2 frames", "--min-frames"],
            ),
            (
                track(1, 1..9, 0.0, 1.0, 5.0),
                &["median speed is 0.0100 m/s", "given as 0.1"],
            ),
            (
                "999999999,1,1,1,1,1,1\n1000000000,1,11,1,1,1,1".into(),
                &["absurdly", "--fps"],
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
                .contains("--fps")
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
        // 60,000 tracks of one place at one time: every one is everybody's neighbour, so
        // comparing all pairs would take thousands of millions of steps.
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
            axis in prop::sample::select(vec![Axis::X, Axis::Y]),
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
