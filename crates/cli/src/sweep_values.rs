//! The values that `pickline sweep` runs: those asked for, or about thirty around the limits
//! of the line.

use super::args::SweepArgs;
use pickline::error::{Error, Result};
use pickline::experiment::{
    Axis, Range, Setting, ValueLimit, find_limits, round_step, step_between,
};
use pickline::optimize::Environment;
use pickline::pattern::Pattern;
use pickline::sim::{Conditions, Scene};
use pickline::station::Station;
use pickline::throughput::enough_items;

/// Resolution of belt speed limits, as a share of the station's own speed.
const RESOLUTION: f64 = 1.0 / 50.0;
/// Speed limits are searched up to this multiple of the station's own speed.
const FURTHEST: f64 = 4.0;
/// A limit of fewer steps than this is searched again with finer steps.
const FEWEST_STEPS: f64 = 10.0;
/// Number of patterns examined to find how long they must be.
const FEW: usize = 100;

/// The values of a sweep and the line at each.
pub type Lines = Vec<(f64, Station)>;

/// The lines at the requested values; missing ones default to values around the station's.
///
/// # Errors
/// An invalid range, or a value for which there is no valid line.
pub fn lines(args: &SweepArgs, axis: Axis, station: &Station) -> Result<Lines> {
    let robots = station.robots();
    let around = |value: f64| Range::around(0.4 * value, 1.6 * value);
    let usual = match axis {
        Axis::Speed => below_arms(station, around(station.belt().speed)),
        Axis::Robots => Range {
            from: 1.0,
            to: (robots.len() + 2).clamp(6, 100) as f64,
            step: 1.0,
        },
        Axis::Spacing => match robots {
            [first, second, ..] => around(second.base.x - first.base.x),
            _ => Range::around(1.0, 3.0),
        },
        Axis::Reach => around(robots[0].reach),
    };
    at(args, axis, station, &range(args, axis, usual).values()?)
}

/// `usual`, overridden by the arguments.
fn range(args: &SweepArgs, axis: Axis, usual: Range) -> Range {
    let from = args.from.unwrap_or(usual.from);
    let to = args.to.unwrap_or(usual.to);
    let step = match (args.step, axis) {
        (Some(step), _) => step,
        (None, Axis::Robots) => step_between(from, to).ceil().max(1.0),
        (None, _) if (from, to) == (usual.from, usual.to) => usual.step,
        // Invalid ends are refused later, with the range.
        (None, _) if !(from < to && to.is_finite()) => usual.step,
        (None, _) => step_between(from, to),
    };
    Range { from, to, step }
}

/// The line at each of `values`.
fn at(args: &SweepArgs, axis: Axis, station: &Station, values: &[f64]) -> Result<Lines> {
    let line = |&value: &f64| {
        let line = match axis {
            Axis::Speed => station.with_belt_speed(value),
            Axis::Spacing => station.with_spacing(value),
            Axis::Reach => station.with_reach(value),
            Axis::Robots if value.fract() == 0.0 && value <= 100.0 => {
                let mut choice = args.station.clone();
                choice.robots = Some(value as usize);
                choice.resolve()
            }
            Axis::Robots => Err(Error::input(
                "--sweep robots",
                format!("{value} is not a number of robots"),
                "give whole numbers for --from, --to and --step, up to 100",
            )),
        };
        // The value comes from the range.
        let place = format!("--sweep {} at {value}", axis.name());
        line.map(|line| (value, line))
            .map_err(|error| error.at(&place))
    };
    values.iter().map(line).collect()
}

/// The settings of a sweep of the belt speed around the limits of the methods in `own`, which
/// is the station at its own speed. The limits are found first, so that the sweep neither
/// begins above them nor ends below. Each limit is a value of the sweep, and so is the next
/// value, at which something is missed.
///
/// # Errors
/// As for [`find_limits`] and [`lines`].
pub fn speeds(
    args: &SweepArgs,
    own: &Setting,
    patterns: &[Pattern],
    luck: &Conditions,
    environment: &Environment,
) -> Result<Vec<Setting>> {
    let (station, speed) = (&own.station, own.station.belt().speed);
    let setting = |value: f64| -> Result<Setting> {
        let line = at(args, Axis::Speed, station, &[value])?;
        Ok(Setting {
            value,
            station: line[0].1.clone(),
            methods: own.methods.clone(),
        })
    };
    if args.from.is_some() && args.to.is_some() {
        let lines = lines(args, Axis::Speed, station)?;
        return lines.iter().map(|line| setting(line.0)).collect();
    }
    let mut step = round_step(RESOLUTION * speed);
    let mut limits: Vec<ValueLimit> = Vec::new();
    // If the limit is only a few of these steps, as on a line run far above it, they are too
    // coarse.
    for _ in 0..3 {
        let most = fastest(station, step, FURTHEST * speed);
        limits = find_limits(setting, (step, most), patterns, luck, environment)?;
        let highest = limits.iter().filter_map(|limit| limit.highest);
        if highest.fold(0.0, f64::max) >= FEWEST_STEPS * step {
            break;
        }
        step = round_step(step / 10.0);
    }
    let found: Vec<f64> = limits.iter().filter_map(|limit| limit.highest).collect();
    let low = found.iter().copied().fold(f64::INFINITY, f64::min);
    let high = found.iter().copied().fold(0.0, f64::max);
    let usual = match found.is_empty() {
        true => Range::around(0.4 * speed, 1.6 * speed),
        false => Range::around((0.5 * low).min(0.8 * speed), (1.5 * high).max(1.2 * speed)),
    };
    let usual = below_arms(station, usual);
    let mut values = range(args, Axis::Speed, usual).values()?;
    if args.step.is_none() {
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
    while k > 1.0 && !station.outruns(k * step) {
        k = ((station.slowest_arm() / step).floor()).min(k - 1.0);
    }
    k * step
}

/// The number of items that a generated pattern with the density of `patterns` needs for a
/// steady state on all `lines`; `usual` if that is unknown.
///
/// # Errors
/// A pattern that does not lie on the belt.
pub fn items(lines: &Lines, patterns: &[Pattern], usual: usize) -> Result<usize> {
    let mut most = usual;
    for (_, station) in lines {
        for pattern in patterns.iter().take(FEW) {
            let scene = Scene::new(station, pattern)?;
            most = most.max(enough_items(&scene).unwrap_or(usual));
        }
    }
    Ok(most)
}
