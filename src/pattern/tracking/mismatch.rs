//! Compares the tracks with the options: warnings, and errors where the pattern would be wrong.

use super::formats::Format;
use super::listing::named;
use super::median::centre;
use super::motion::Motion;
use super::options::{Boxes, ImportOptions};
use super::place::{BACKWARDS, FEWER, Found, ODD_SHARE, STILL};
use super::report::{ImportReport, count};
use crate::error::{Error, Result, rounded};
use crate::pattern::Item;

/// Limit for the median over all items, which is more certain than the speed of a single item.
const MEDIAN_SHARE: f64 = 0.05;
/// Errors: the median over all items is wrong if it is off by more than this share; the pattern is
/// wrong if more than this share of its items are off by more than [`ODD_SHARE`].
const WRONG_SHARE: f64 = 0.15;
const WRONG_ITEMS: f64 = 1.0 / 3.0;
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

/// What the tracks are compared with, other than the options.
pub(super) struct Seen {
    /// How the four numbers of the boxes were interpreted.
    boxes: Boxes,
    speed: Option<SpeedOff>,
    /// Whether the tracks were linked by this program.
    linked: bool,
}

impl Seen {
    pub(super) fn new(
        found: &[Found],
        report: &ImportReport,
        boxes: Boxes,
        linked: bool,
        options: &ImportOptions,
    ) -> Self {
        Self {
            boxes,
            speed: speed_off(found, turn(report), options),
            linked,
        }
    }
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

/// Adds warnings to the report where the tracks contradict the options; `twins` are pairs of items
/// at the same place.
pub(super) fn warn(
    report: &mut ImportReport,
    found: &[Found],
    twins: &[String],
    seen: &Seen,
    options: &ImportOptions,
) {
    let odd = odd_items(found, turn(report), options);
    report.odd_items = odd.len();
    let mut warnings = speed_warnings(report, odd, seen, options);
    warnings.extend(motion_warnings(report, seen.boxes, options));
    warnings.extend(dropped_warnings(report, found.len(), seen.linked));
    if !twins.is_empty() {
        warnings.push(format!(
            "{} at the same place at the same time, perhaps one item tracked twice: {}",
            count(twins.len(), "pair"),
            named(twins.iter().map(String::as_str))
        ));
    }
    report.warnings.append(&mut warnings);
}

/// The items whose speed is clearly not that of the belt.
fn odd_items<'a>(found: &'a [Found], turn: f64, options: &ImportOptions) -> Vec<&'a str> {
    let belt = options.belt_speed;
    let off = |speed: f64| (speed * turn - belt).abs() > ODD_SHARE * belt;
    found
        .iter()
        .filter(|f| f.speed.is_some_and(off))
        .map(|f| f.item.id.as_str())
        .collect()
}

fn speed_warnings(
    report: &ImportReport,
    odd: Vec<&str>,
    seen: &Seen,
    options: &ImportOptions,
) -> Vec<String> {
    let mut warnings = Vec::new();
    let unsteady = is_unsteady(report, OFF_M);
    if !odd.is_empty() {
        let cause = match unsteady {
            true => "",
            false => "; scale, fps or belt speed may be wrong",
        };
        warnings.push(format!(
            "{} more than 25 % off the belt's speed{cause}: {}",
            count(odd.len(), "item"),
            named(odd)
        ));
    }
    if let Some(speed) = seen.speed.as_ref().filter(|s| s.is_odd() && !unsteady) {
        warnings.push(format!(
            "{}: {}",
            speed.text(options),
            agreeing(speed.speed, options)
        ));
    }
    warnings
}

fn motion_warnings(report: &ImportReport, boxes: Boxes, options: &ImportOptions) -> Vec<String> {
    let Some(motion) = &report.motion else {
        return Vec::new();
    };
    let mut warnings = Vec::new();
    if is_unsteady(report, OFF_M) {
        warnings.push(format!("{}: {STEADY}", unsteadily(motion)));
    }
    if looks_like_corners(motion, boxes) {
        warnings.push(format!(
            "the boxes grow as they travel: if they are corners, {}",
            corners(report.format)
        ));
    }
    if motion.angle_off_m > OFF_M && is_turned(motion) {
        warnings.push(format!(
            "{}: {}",
            turned(motion, options),
            turning(motion, options)
        ));
    }
    if motion.bent_off_m > OFF_M {
        warnings.push(format!("{}: {STRAIGHTEN}", bent(motion)));
    }
    warnings
}

/// Warnings if more tracks were dropped for one reason than there are items.
fn dropped_warnings(report: &ImportReport, items: usize, linked: bool) -> Vec<String> {
    let mut warnings = Vec::new();
    let lost = report.dropped.iter();
    let lost = lost
        .filter(|d| d.reason == STILL || d.reason == BACKWARDS)
        .count();
    if lost > items {
        warnings.push(format!(
            "{} do not ride on the belt, more than do: 'scale_m_per_px', 'fps', 'belt_speed', 'axis' or \
             'reverse' may be wrong",
            count(lost, "track")
        ));
    }
    let short = report.dropped.iter();
    let short = short.filter(|d| d.reason.starts_with(FEWER)).count();
    if linked && short > items {
        warnings.push(format!(
            "{} linked from the boxes are too short, more than there are items: 'scale_m_per_px', 'fps' \
             or 'belt_speed' may be wrong, or the detector has false positives",
            count(short, "track")
        ));
    }
    warnings
}

/// Rejects options that the tracks contradict so much that the pattern would be wrong.
pub(super) fn contradictions(
    report: &ImportReport,
    items: &[Item],
    seen: &Seen,
    options: &ImportOptions,
) -> Result<()> {
    let mut found = Contradictions {
        report,
        items: items.len(),
        is_corners: report
            .motion
            .as_ref()
            .is_some_and(|motion| looks_like_corners(motion, seen.boxes)),
        options,
        problems: Vec::new(),
        cures: Vec::new(),
    };
    found.check_direction();
    found.check_speed(seen.speed.as_ref());
    if let Some(motion) = &report.motion {
        found.check_motion(motion);
    }
    if found.problems.is_empty() || options.accept_mismatch {
        return Ok(());
    }
    Err(Error::input(
        &report.file,
        format!("the pattern would be wrong: {}", found.problems.join("; ")),
        format!(
            "{}; 'accept_mismatch' creates the pattern anyway",
            found.cures.join("; ")
        ),
    ))
}

/// Contradictions between the tracks and the options, with their cures.
struct Contradictions<'a> {
    report: &'a ImportReport,
    /// Number of items that remain.
    items: usize,
    /// Whether the boxes look like corners, which also explains wrong speeds and angles.
    is_corners: bool,
    options: &'a ImportOptions,
    problems: Vec<String>,
    cures: Vec<String>,
}

impl Contradictions<'_> {
    fn check_direction(&mut self) {
        let dropped = self.report.dropped.iter();
        let backwards = dropped.filter(|d| d.reason == BACKWARDS).count();
        if backwards > self.items {
            self.problems.push(format!(
                "{} backwards, but only {} forwards",
                match backwards {
                    1 => "1 track travels".to_owned(),
                    more => format!("{more} tracks travel"),
                },
                count(self.items, "item")
            ));
            self.cures.push(turn_over(self.options));
        }
    }

    /// A belt that changes its speed has no single speed to compare with.
    fn check_speed(&mut self, speed: Option<&SpeedOff>) {
        let motion = self.report.motion.as_ref();
        if let Some(motion) = motion.filter(|_| is_unsteady(self.report, WRONG_M)) {
            self.problems.push(unsteadily(motion));
            self.cures.push(STEADY.to_owned());
            return;
        }
        let (odd, items) = (self.report.odd_items, self.items);
        let many_odd = odd as f64 > WRONG_ITEMS * items as f64;
        let Some(speed) = speed.filter(|s| many_odd || s.is_wrong()) else {
            return;
        };
        let share = match odd {
            0 => String::new(),
            _ => format!(
                "{odd} of {} {} more than 25 % off the belt's speed; ",
                count(items, "item"),
                if odd == 1 { "is" } else { "are" }
            ),
        };
        self.problems
            .push(format!("{share}{}", speed.text(self.options)));
        if !self.is_corners {
            self.cures.push(agreeing(speed.speed, self.options));
        }
    }

    fn check_motion(&mut self, motion: &Motion) {
        if self.is_corners {
            let problem = "the boxes grow as they travel, as if corners were read as sizes";
            self.problems.push(problem.into());
            self.cures.push(corners(self.report.format).to_owned());
            return;
        }
        if motion.angle_off_m > WRONG_M && is_turned(motion) {
            self.problems.push(turned(motion, self.options));
            self.cures.push(turning(motion, self.options));
        }
        // If the pattern is rejected anyway, the lens may be the cause.
        let is_rejected = !self.problems.is_empty();
        let bent_limit = if is_rejected { OFF_M } else { WRONG_M };
        if motion.bent_off_m > bent_limit {
            self.problems.push(bent(motion));
            self.cures.push(STRAIGHTEN.to_owned());
        }
    }
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
pub(super) fn turn_over(options: &ImportOptions) -> String {
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
        "'scale_m_per_px' {}, 'fps' {} or 'belt_speed' {} would agree with the tracks",
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
        angle => format!(", not at {} as given by 'angle_deg'", rounded(angle, 9)),
    };
    format!(
        "the belt travels {:.2} degrees off 'axis' in the image{given}, which puts items up to \
         {:.3} m off",
        options.angle_deg + motion.angle_deg,
        motion.angle_off_m
    )
}

fn turning(motion: &Motion, options: &ImportOptions) -> String {
    format!(
        "give 'angle_deg' {:.2}",
        options.angle_deg + motion.angle_deg
    )
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
