//! The values that a sweep runs: those asked for, or about thirty around the limits of the
//! line.

use crate::error::{Error, Result, counted};
use crate::experiment::{Axis, Range, Setting, ValueLimit, find_limits, round_step, step_between};
use crate::optimize::Environment;
use crate::pattern::Pattern;
use crate::sim::{Conditions, Scene};
use crate::station::Station;
use crate::throughput::enough_items;
use std::sync::Arc;

/// Resolution of belt speed limits, as a share of the station's own speed.
const RESOLUTION: f64 = 1.0 / 50.0;
/// Speed limits are searched up to this multiple of the station's own speed.
const FURTHEST: f64 = 4.0;
/// A limit of fewer steps than this is searched again with finer steps.
const FEWEST_STEPS: f64 = 10.0;
/// Number of patterns examined to find how long they must be.
const FEW: usize = 100;
/// Maximum number of robots in a sweep.
const MOST_ROBOTS: f64 = 100.0;

/// The line of a number of robots.
type OfRobots = Arc<dyn Fn(usize) -> Result<Station> + Send + Sync>;

/// Which values are run.
#[derive(Clone)]
pub(super) struct ValueOptions {
    /// The quantity that is varied.
    pub axis: Axis,
    /// First value, in the unit of the quantity.
    pub from: Option<f64>,
    /// Last value, in the unit of the quantity.
    pub to: Option<f64>,
    /// Step between values, in the unit of the quantity.
    pub step: Option<f64>,
    /// The line of a number of robots.
    pub of_robots: Option<OfRobots>,
}

impl Default for ValueOptions {
    fn default() -> Self {
        Self {
            axis: Axis::Speed,
            from: None,
            to: None,
            step: None,
            of_robots: None,
        }
    }
}

/// The line at one value.
pub(super) struct LineAt {
    /// The varied quantity, in the unit of its axis.
    pub value: f64,
    /// The station at this value.
    pub station: Station,
    /// The lowest `p_detection` of items that are picked, if that is varied.
    pub min_detection: Option<f64>,
}

/// The thresholds of detections: as requested, otherwise about thirty over the `p_detection` of the
/// items of `patterns`, the first of which leaves none on the belt.
///
/// # Errors
/// An invalid range, or no item with a `p_detection`.
pub(super) fn thresholds(
    options: &ValueOptions,
    station: &Station,
    patterns: &[Pattern],
) -> Result<Vec<LineAt>> {
    let items = patterns.iter().flat_map(Pattern::items);
    let given = items.filter_map(|item| item.p_detection);
    let (low, high) = given.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    if low > high {
        return Err(Error::usage(
            "'sweep_axis' min-detection",
            "no item has a p_detection, so a threshold leaves none on the belt",
            "give 'p_detection' DIST for generated patterns, such as 'p_detection' beta:8,2, or \
             patterns with this column",
        ));
    }
    let step = step_between(low, high);
    let usual = Range {
        from: multiple_below(low, step),
        to: multiple_below(high, step),
        step,
    };
    lines_over(options, station, usual)
}

/// The greatest multiple of `step` that is at most `value`, whatever the rounding.
fn multiple_below(value: f64, step: f64) -> f64 {
    let multiple = (value / step + 1e-9).floor() * step;
    (multiple * 1e9).round() / 1e9
}

/// The lines at the requested values; missing ones default to values around the station's.
///
/// # Errors
/// An invalid range, or a value for which there is no valid line.
pub(super) fn lines(options: &ValueOptions, station: &Station) -> Result<Vec<LineAt>> {
    lines_over(options, station, usual_range(options.axis, station))
}

/// The values that are run if none are asked for.
fn usual_range(axis: Axis, station: &Station) -> Range {
    let robots = station.robots();
    let around = |value: f64| Range::around(0.4 * value, 1.6 * value);
    match axis {
        Axis::Speed => below_arms(station, around(station.belt().speed)),
        Axis::Robots => Range {
            from: 1.0,
            to: ((robots.len() + 2) as f64).clamp(6.0, MOST_ROBOTS),
            step: 1.0,
        },
        // Until it is known which values the patterns have.
        Axis::MinDetection => Range {
            from: 0.0,
            to: 1.0,
            step: 0.05,
        },
        Axis::Spacing => match robots {
            [first, second, ..] => around(second.base.x - first.base.x),
            _ => Range::around(1.0, 3.0),
        },
        Axis::Reach => around(robots[0].reach),
    }
}

/// The lines at the requested values; missing ones default to those of `usual`.
fn lines_over(options: &ValueOptions, station: &Station, usual: Range) -> Result<Vec<LineAt>> {
    let range = range(options, usual);
    let values = match options.axis {
        Axis::MinDetection => range.probabilities()?,
        _ => range.values()?,
    };
    values
        .into_iter()
        .map(|value| line_at(options, station, value))
        .collect()
}

/// `usual`, overridden by the options.
fn range(options: &ValueOptions, usual: Range) -> Range {
    let from = options.from.unwrap_or(usual.from);
    let to = options.to.unwrap_or(usual.to);
    let step = match (options.step, options.axis) {
        (Some(step), _) => step,
        (None, Axis::Robots) => step_between(from, to).ceil().max(1.0),
        (None, _) if (from, to) == (usual.from, usual.to) => usual.step,
        // Invalid ends are refused later, with the range.
        (None, _) if !(from < to && to.is_finite()) => usual.step,
        (None, _) => step_between(from, to),
    };
    Range { from, to, step }
}

/// `station`, if it has this number of robots.
fn with_robots(station: Station, robots: usize) -> Result<Station> {
    match station.robots().len() {
        found if found == robots => Ok(station),
        found => Err(Error::usage(
            "'robots'",
            format!("gives {} for {robots}", counted(found, "robot")),
            "make the line of the number of robots that is asked for",
        )),
    }
}

/// The line at `value`.
fn line_at(options: &ValueOptions, station: &Station, value: f64) -> Result<LineAt> {
    let line = match options.axis {
        Axis::Speed => station.with_belt_speed(value),
        Axis::Spacing => station.with_spacing(value),
        Axis::Reach => station.with_reach(value),
        Axis::MinDetection => Ok(station.clone()),
        Axis::Robots if value.fract() == 0.0 && value <= MOST_ROBOTS => match &options.of_robots {
            Some(of_robots) => with_robots(of_robots(value as usize)?, value as usize),
            None => Err(Error::usage(
                "'sweep_axis' robots",
                "where other robots would stand is not known",
                "give the option 'robots', which makes the line of a number of robots",
            )),
        },
        Axis::Robots => Err(Error::usage(
            "'sweep_axis' robots",
            format!("{value} is not a number of robots"),
            "give whole numbers for 'from', 'to' and 'step', up to 100",
        )),
    };
    // The value comes from the range.
    let place = format!("'sweep_axis' {} at {value}", options.axis.name());
    let station = line.map_err(|error| error.at(&place).into_usage())?;
    let is_threshold = options.axis == Axis::MinDetection;
    Ok(LineAt {
        value,
        station,
        min_detection: is_threshold.then_some(value),
    })
}

/// The settings of a sweep of the belt speed around the limits of the methods in `own`, which
/// is the station at its own speed. The limits are found first, so that the sweep neither
/// begins above them nor ends below. Each limit is a value of the sweep, and so is the next
/// value, at which something is missed.
///
/// # Errors
/// As for [`find_limits`] and [`lines`].
pub(super) fn speeds(
    options: &ValueOptions,
    own: &Setting,
    patterns: &[Pattern],
    conditions: &Conditions,
    environment: &Environment,
) -> Result<Vec<Setting>> {
    let (station, speed) = (&own.station, own.station.belt().speed);
    let setting = |value: f64| -> Result<Setting> {
        Ok(Setting {
            value,
            station: line_at(options, station, value)?.station,
            min_detection: None,
            methods: own.methods.clone(),
        })
    };
    if options.from.is_some() && options.to.is_some() {
        let lines = lines(options, station)?;
        return lines.iter().map(|line| setting(line.value)).collect();
    }
    let limits = speed_limits(own, setting, patterns, conditions, environment)?;
    let found: Vec<f64> = limits.iter().filter_map(|limit| limit.highest).collect();
    let low = found.iter().copied().fold(f64::INFINITY, f64::min);
    let high = found.iter().copied().fold(0.0, f64::max);
    let usual = match found.is_empty() {
        true => Range::around(0.4 * speed, 1.6 * speed),
        false => Range::around((0.5 * low).min(0.8 * speed), (1.5 * high).max(1.2 * speed)),
    };
    let usual = below_arms(station, usual);
    let mut values = range(options, usual).values()?;
    if options.step.is_none() {
        let (from, to) = (values[0], values[values.len() - 1]);
        let misses = limits.iter().filter(|limit| limit.highest.is_some());
        let misses = misses.filter_map(|limit| limit.first_miss);
        values.extend(
            found
                .into_iter()
                .chain(misses)
                .filter(|v| (from..=to).contains(v)),
        );
        values.sort_by(f64::total_cmp);
        values.dedup();
    }
    values.into_iter().map(setting).collect()
}

/// Up to which speed each method of `own` picks everything.
fn speed_limits(
    own: &Setting,
    setting: impl Fn(f64) -> Result<Setting>,
    patterns: &[Pattern],
    conditions: &Conditions,
    environment: &Environment,
) -> Result<Vec<ValueLimit>> {
    let (station, speed) = (&own.station, own.station.belt().speed);
    let mut step = round_step(RESOLUTION * speed);
    let mut limits: Vec<ValueLimit> = Vec::new();
    // If the limit is only a few of these steps, as on a line run far above it, they are too
    // coarse.
    for _ in 0..3 {
        let most = fastest(station, step, FURTHEST * speed);
        limits = find_limits(&setting, (step, most), patterns, conditions, environment)?;
        let highest = limits.iter().filter_map(|limit| limit.highest);
        if highest.fold(0.0, f64::max) >= FEWEST_STEPS * step {
            break;
        }
        step = round_step(step / 10.0);
    }
    Ok(limits)
}

/// `range`, cut where the belt becomes as fast as the slowest arm of `station`.
fn below_arms(station: &Station, range: Range) -> Range {
    Range {
        to: fastest(station, range.step, range.to),
        ..range
    }
}

/// The greatest multiple of `step`, up to `most`, at which every arm is faster than the belt.
fn fastest(station: &Station, step: f64, most: f64) -> f64 {
    let mut k = (most / step + 1e-9).floor().max(1.0);
    while k > 1.0 && !station.is_faster_than(k * step) {
        k = ((station.slowest_arm() / step).floor()).min(k - 1.0);
    }
    k * step
}

/// The number of items that a generated pattern with the density of `patterns` needs for a
/// steady state on all `lines`; `usual` if that is unknown.
///
/// # Errors
/// A pattern that does not lie on the belt.
pub(super) fn items(lines: &[LineAt], patterns: &[Pattern], usual: usize) -> Result<usize> {
    let mut most = usual;
    for line in lines {
        for pattern in patterns.iter().take(FEW) {
            let scene = Scene::new(&line.station, pattern)?;
            most = most.max(enough_items(&scene).unwrap_or(usual));
        }
    }
    Ok(most)
}
