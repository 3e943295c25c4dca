//! The import: read, split, drop, merge, drop, place.

use super::formats::{Format, Recording};
use super::link::{link, other_way};
use super::median::{centre, median_of};
use super::motion::{Motion, measure, way};
use super::object::{Object, merge, split};
use super::options::{Boxes, ImageAxis, ImportOptions};
use super::pace::pace;
use super::place::{BACKWARDS, Found, ODD_SHARE, STILL, not_riding, place};
use super::read::read;
use super::report::{ImportReport, Merged, Split, count, named};
use super::track::stride;
use crate::error::{Error, Result, rounded};
use crate::pattern::{Item, Pattern};

/// Limit for the median over all items, which is more certain than the speed of a single item.
const MEDIAN_SHARE: f64 = 0.05;

/// A pattern from a tracker's file, with a report on how it was made.
#[derive(Debug, Clone)]
pub struct Import {
    /// One item per object, with the id of its track.
    pub pattern: Pattern,
    /// What was dropped, split, merged and measured.
    pub report: ImportReport,
}

/// Errors: the median over all items is wrong if it is off by more than this share; the pattern is
/// wrong if more than this share of its items are off by more than [`ODD_SHARE`].
const WRONG_SHARE: f64 = 0.15;
const WRONG_ITEMS: f64 = 1.0 / 3.0;
/// Start of the reason for dropping a track that was seen too rarely.
const FEWER: &str = "fewer than";
/// Positions off by this much [m] give a warning, and by the second value an error.
const OFF_M: f64 = 0.005;
const WRONG_M: f64 = 0.05;
/// Speeds that agree this well are never wrong, whatever the deviation over a long pattern; the
/// second value is for errors.
const AGREEING_SHARE: f64 = 0.005;
const CLOSE_SHARE: f64 = 0.01;
/// Common frame rates of cameras [1/s].
const USUAL_FPS: [f64; 12] = [
    10.0, 15.0, 20.0, 23.976, 24.0, 25.0, 29.97, 30.0, 50.0, 60.0, 100.0, 120.0,
];

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
    let mut misled = None;
    let linked = tracks.is_empty();
    if linked {
        let boxes = std::mem::take(&mut reading.loose);
        let count = boxes.len();
        misled = other_way(&boxes, options);
        if let Some((problem, cure)) = misled.clone().filter(|_| !options.accept_mismatch) {
            return Err(Error::input(
                name,
                format!("the pattern would be wrong: {problem}"),
                format!("{cure}; 'accept_mismatch' creates the pattern anyway"),
            ));
        }
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
    let boxes = reading.boxes;
    let mut report = ImportReport::new(name, options, reading, &tracks);
    report.warnings = misled
        .map(|(problem, cure)| format!("{problem}: {cure}"))
        .into_iter()
        .collect();
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
            Some(format!("{FEWER} {} frames", options.min_frames))
        } else if found.is_absurd(options) {
            Some("impossibly far away or large".to_owned())
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
    report.motion = measure(
        riding.map(|(object, _)| &object.track),
        pace.as_ref(),
        options,
    );
    let speed = speed_off(&found, turn(&report), options);
    let seen = Seen {
        boxes,
        speed,
        linked,
    };
    warn(&mut report, &found, &twins, &seen, options);
    let items = place(found, &mut report, options);
    contradictions(&report, &items, &seen, options)?;
    let pattern = Pattern::checked(items, name, &|_| name.to_owned())?;
    report.items = pattern.len();
    Ok(Import { pattern, report })
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

/// What the tracks are compared with, other than the options.
struct Seen {
    /// How the four numbers of the boxes were interpreted.
    boxes: Boxes,
    speed: Option<SpeedOff>,
    /// Whether the tracks were linked by this program.
    linked: bool,
}

/// Deviation of the items' speed from that of the belt.
struct SpeedOff {
    /// Median speed of the items [m/s].
    speed: f64,
    /// The deviation as a share of the belt speed.
    share: f64,
    /// The resulting position error between the first item seen and the last [m]; 0 if it may be
    /// chance.
    off_m: f64,
}

/// Ratio of the speed along the travel to the speed along the given direction. The effect of a
/// rotated camera must not be blamed on other options.
fn turn(report: &ImportReport) -> f64 {
    let turned = report.motion.as_ref().filter(|motion| is_turned(motion));
    turned.map_or(1.0, |motion| {
        1.0 / motion.angle_deg.to_radians().cos().max(0.01)
    })
}

fn speed_off(found: &[Found], turn: f64, options: &ImportOptions) -> Option<SpeedOff> {
    let belt = options.belt_speed;
    let speeds: Vec<f64> = found.iter().filter_map(|f| Some(f.speed? * turn)).collect();
    let (speed, error) = centre(&speeds)?;
    let times = found.iter().map(|f| f.time);
    let (first, last) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| {
        (l.min(t), h.max(t))
    });
    let difference = (speed - belt).abs();
    let is_chance = difference < 3.0 * error;
    Some(SpeedOff {
        speed,
        share: difference / belt,
        off_m: if is_chance {
            0.0
        } else {
            difference * (last - first)
        },
    })
}

impl SpeedOff {
    fn is_odd(&self) -> bool {
        self.share > MEDIAN_SHARE || (self.share > AGREEING_SHARE && self.off_m > OFF_M)
    }

    fn is_wrong(&self) -> bool {
        self.share > WRONG_SHARE || (self.share > CLOSE_SHARE && self.off_m > WRONG_M)
    }

    fn text(&self, options: &ImportOptions) -> String {
        let off = match self.off_m > OFF_M {
            true => format!(", which puts items up to {:.3} m off", self.off_m),
            false => String::new(),
        };
        format!(
            "the items move at {:.4} m/s (median), but the given belt speed is {} m/s{off}",
            self.speed, options.belt_speed
        )
    }
}

/// Whether the belt speed changes so much that positions are off by more than `limit` [m]. There is
/// then no single speed to compare with the given one.
fn is_unsteady(report: &ImportReport, limit: f64) -> bool {
    let motion = report.motion.as_ref();
    motion.is_some_and(|motion| motion.unsteady_off_m > limit)
}

fn warn(
    report: &mut ImportReport,
    found: &[Found],
    twins: &[String],
    seen: &Seen,
    options: &ImportOptions,
) {
    let belt = options.belt_speed;
    let turn = turn(report);
    let off = |speed: f64, share: f64| (speed * turn - belt).abs() > share * belt;
    let odd: Vec<&str> = found
        .iter()
        .filter(|f| f.speed.is_some_and(|v| off(v, ODD_SHARE)))
        .map(|f| f.item.id.as_str())
        .collect();
    report.odd_items = odd.len();
    let unsteady = is_unsteady(report, OFF_M);
    if !odd.is_empty() {
        let cause = match unsteady {
            true => "",
            false => "; scale, fps or belt speed may be wrong",
        };
        report.warnings.push(format!(
            "{} more than 25 % off the belt's speed{cause}: {}",
            count(odd.len(), "item"),
            named(odd)
        ));
    }
    if let Some(speed) = seen.speed.as_ref().filter(|s| s.is_odd() && !unsteady) {
        report.warnings.push(format!(
            "{}: {}",
            speed.text(options),
            agreeing(speed.speed, options)
        ));
    }
    if let Some(motion) = &report.motion {
        let mut found = Vec::new();
        if unsteady {
            found.push(format!("{}: {STEADY}", unsteadily(motion)));
        }
        if looks_like_corners(motion, seen.boxes) {
            found.push(format!(
                "the boxes grow as they travel: if they are corners, {}",
                corners(report.format)
            ));
        }
        if motion.angle_off_m > OFF_M && is_turned(motion) {
            found.push(format!(
                "{}: {}",
                turned(motion, options),
                turning(motion, options)
            ));
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
            "{} do not ride on the belt, more than do: 'scale', 'fps', 'belt_speed', 'axis' or \
             'reverse' may be wrong",
            count(lost, "track")
        ));
    }
    let short = report.dropped.iter();
    let short = short.filter(|d| d.reason.starts_with(FEWER)).count();
    if seen.linked && short > found.len() {
        report.warnings.push(format!(
            "{} linked from the boxes are too short, more than there are items: 'scale', 'fps' \
             or 'belt_speed' may be wrong, or the detector has false positives",
            count(short, "track")
        ));
    }
    if !twins.is_empty() {
        report.warnings.push(format!(
            "{} at the same place at the same time, perhaps one item tracked twice: {}",
            count(twins.len(), "pair"),
            named(twins.iter().map(String::as_str))
        ));
    }
}

/// Rejects options that the tracks contradict so much that the pattern would be wrong.
fn contradictions(
    report: &ImportReport,
    items: &[Item],
    seen: &Seen,
    options: &ImportOptions,
) -> Result<()> {
    let odd = report.odd_items;
    let mut problems = Vec::new();
    let mut cures = Vec::new();
    let motion = report.motion.as_ref();
    let is_corners = motion.is_some_and(|m| looks_like_corners(m, seen.boxes));
    let backwards = report.dropped.iter().filter(|d| d.reason == BACKWARDS);
    let backwards = backwards.count();
    if backwards > items.len() {
        problems.push(format!(
            "{} backwards, but only {} forwards",
            match backwards {
                1 => "1 track travels".to_owned(),
                more => format!("{more} tracks travel"),
            },
            count(items.len(), "item")
        ));
        cures.push(turn_over(options));
    }
    let unsteady = is_unsteady(report, WRONG_M);
    if let Some(motion) = motion.filter(|_| unsteady) {
        problems.push(unsteadily(motion));
        cures.push(STEADY.to_owned());
    }
    let many_odd = odd as f64 > WRONG_ITEMS * items.len() as f64;
    let speed = seen.speed.as_ref().filter(|s| many_odd || s.is_wrong());
    if let Some(speed) = speed.filter(|_| !unsteady) {
        let share = match odd {
            0 => String::new(),
            _ => format!(
                "{odd} of {} {} more than 25 % off the belt's speed; ",
                count(items.len(), "item"),
                if odd == 1 { "is" } else { "are" }
            ),
        };
        problems.push(format!("{share}{}", speed.text(options)));
        if !is_corners {
            cures.push(agreeing(speed.speed, options));
        }
    }
    if let Some(motion) = motion {
        if is_corners {
            problems.push("the boxes grow as they travel, as if corners were read as sizes".into());
            cures.push(corners(report.format).to_owned());
        }
        if motion.angle_off_m > WRONG_M && is_turned(motion) && !is_corners {
            problems.push(turned(motion, options));
            cures.push(turning(motion, options));
        }
        // If the pattern is rejected anyway, the lens may be the cause.
        let bent_limit = if problems.is_empty() { WRONG_M } else { OFF_M };
        if motion.bent_off_m > bent_limit && !is_corners {
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
            "{}; 'accept_mismatch' creates the pattern anyway",
            cures.join("; ")
        ),
    ))
}

/// Whether the lower right corner was read as the size. The size then moves as fast as the box, and
/// so does the upper left corner that was read as the centre. A centre computed from both moves one
/// and a half times as fast.
fn looks_like_corners(motion: &Motion, boxes: Boxes) -> bool {
    match boxes {
        Boxes::Sizes => (0.55..0.8).contains(&motion.growth),
        Boxes::Centres => (0.85..1.2).contains(&motion.growth),
        Boxes::Corners => false,
    }
}

/// The cure for corners that were read as sizes.
fn corners(format: Format) -> &'static str {
    match format {
        Format::Table => "name their columns x_max and y_max",
        _ => "give 'boxes' corners",
    }
}

/// The cure for the opposite direction along the axis.
fn turn_over(options: &ImportOptions) -> String {
    let turned = match options.reverse {
        true => "omit 'reverse'",
        false => "give 'reverse'",
    };
    format!("{turned}, or check 'axis'")
}

/// The option values that would agree with items at `speed` [m/s].
fn agreeing(speed: f64, options: &ImportOptions) -> String {
    let ratio = options.belt_speed / speed;
    let fps = options.fps * ratio;
    let off = |usual: &f64| (fps / usual - 1.0).abs();
    let nearest = USUAL_FPS
        .iter()
        .min_by(|a, b| off(a).total_cmp(&off(b)))
        .filter(|usual| off(usual) < CLOSE_SHARE);
    // Enough digits that the suggested values also agree over a long pattern.
    let shown = |value: f64| rounded(value, 5);
    format!(
        "'scale' {}, 'fps' {} or 'belt_speed' {} would agree with the tracks",
        shown(options.scale_m_per_px * ratio),
        nearest.map_or_else(|| shown(fps), f64::to_string),
        shown(speed)
    )
}

const STEADY: &str = "cut a stretch at constant speed out of the video: belts that change \
                      their speed are not supported";

fn unsteadily(motion: &Motion) -> String {
    let speeds = motion
        .speeds_over_time
        .map_or(String::new(), |[slow, fast]| {
            // Adding 0 turns negative zero into zero.
            let slow = (slow * 1e4).round() / 1e4 + 0.0;
            format!(", {slow:.4} to {fast:.4} m/s")
        });
    format!(
        "the belt speed changes during the recording{speeds}, which puts items up to {:.3} m \
         off",
        motion.unsteady_off_m
    )
}

const STRAIGHTEN: &str = "remove the lens distortion and the tilt from the video before tracking, \
                          for example with OpenCV's undistort and warpPerspective";

/// Whether the angle is statistically significant.
fn is_turned(motion: &Motion) -> bool {
    motion.angle_deg.abs() > 3.0 * motion.angle_error_deg
}

fn turned(motion: &Motion, options: &ImportOptions) -> String {
    let given = match options.angle_deg {
        0.0 => String::new(),
        angle => format!(", not at {} as given by 'angle'", rounded(angle, 9)),
    };
    format!(
        "the belt travels {:.2} degrees off 'axis' in the image{given}, which puts items up to \
         {:.3} m off",
        options.angle_deg + motion.angle_deg,
        motion.angle_off_m
    )
}

fn turning(motion: &Motion, options: &ImportOptions) -> String {
    format!("give 'angle' {:.2}", options.angle_deg + motion.angle_deg)
}

fn bent(motion: &Motion) -> String {
    let cause = match motion.bends {
        true => "as with a distorting lens",
        false => "as with a tilted camera",
    };
    let range = |speeds: Option<[f64; 2]>, way: &str| {
        let speeds = speeds.map(|[slow, fast]| format!(", {slow:.4} to {fast:.4} m/s {way}"));
        speeds.unwrap_or_default()
    };
    format!(
        "the belt's motion varies over the image{}{}, {cause}, which puts items that \
         are seen only on a part of the way up to {:.3} m off",
        range(motion.speeds_along, "along it"),
        range(motion.speeds_across, "across it"),
        motion.bent_off_m
    )
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
        STILL => format!("check 'scale', 'fps', 'belt_speed' and 'axis': {speeds}"),
        reason if reason.starts_with(FEWER) => {
            "lower 'min_frames', or configure the tracker to keep its ids longer".to_owned()
        }
        _ => "check 'scale' and 'fps'".to_owned(),
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
    fn changed_ids_are_merged_even_from_stumps() {
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
                &["t.txt:1", "1 stands still", "'scale'"][..],
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
