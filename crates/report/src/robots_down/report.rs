//! The figures of a line with one of its robots halted.

use crate::provenance::Provenance;
use crate::throughput::ThroughputReport;
use pickline::experiment::{HaltedPoint, ROBOTS_DOWN, RobotsDown};
use pickline::stats::Interval;
use serde::Serialize;

/// A sweep over halted robots as printed and written; the JSON field names are the product's format.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RobotsDownReport {
    /// Name of the sweep, `robots-down`.
    pub sweep: &'static str,
    /// Number of patterns.
    pub patterns: usize,
    /// All points: with no robot halted, then with each, upstream first; by method in each.
    pub points: Vec<HaltedPointReport>,
    /// Remarks on how the figures are to be read.
    pub notes: Vec<String>,
    /// Where the result comes from.
    pub made: Provenance,
    /// Number of methods.
    #[serde(skip)]
    pub(super) methods: usize,
    #[serde(skip)]
    pub(super) weighs: bool,
}

/// One method with one robot halted, or with none.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct HaltedPointReport {
    /// Name of the robot that is down for the whole run; `None` if all work.
    pub robot_down: Option<String>,
    /// The method's name in files.
    pub method: String,
    /// Its name in tables.
    pub title: String,
    /// Picks per minute in the steady state.
    #[serde(flatten)]
    pub throughput: ThroughputReport,
    /// Mean share of the items picked.
    pub picked_share: f64,
    /// 95 % interval of that share; `None` for a single pattern, as for the others.
    #[serde(flatten, serialize_with = "crate::ends::picked_share")]
    pub picked_share_interval: Option<Interval>,
    /// Mean picks per minute.
    pub picking_rate_per_min: f64,
    /// 95 % interval of that rate [1/min].
    #[serde(flatten, serialize_with = "crate::ends::picking_rate")]
    pub picking_rate_interval: Option<Interval>,
    /// Mean reward-weighted picks per minute.
    pub weighted_rate_per_min: f64,
    /// How many fewer items are picked than if all robots work [%]; `None` if all work.
    pub loss_percent: Option<f64>,
    /// 95 % interval of that loss, paired over patterns [%].
    #[serde(flatten, serialize_with = "crate::ends::loss_percent")]
    pub loss_interval: Option<Interval>,
}

impl HaltedPointReport {
    fn new(robot: Option<&str>, point: &HaltedPoint) -> Self {
        Self {
            robot_down: robot.map(str::to_owned),
            method: point.method.clone(),
            title: point.title.clone(),
            throughput: ThroughputReport::new(&point.throughput),
            picked_share: point.picked_share,
            picked_share_interval: point.picked_share_interval,
            picking_rate_per_min: point.picking_rate,
            picking_rate_interval: point.picking_rate_interval,
            weighted_rate_per_min: point.weighted_rate,
            loss_percent: point.loss.map(|loss| 100.0 * loss),
            loss_interval: point.loss_interval.map(|ends| ends.times(100.0)),
        }
    }

    /// Which robot is down, in words.
    pub(super) fn halted(&self) -> &str {
        self.robot_down.as_deref().unwrap_or("none")
    }
}

impl RobotsDownReport {
    /// The report of `found`; `notes` are remarks on how the figures are to be read.
    pub fn new(found: &RobotsDown, notes: Vec<String>, made: Provenance) -> Self {
        let points = found.halted.iter().flat_map(|entry| {
            let methods = entry.methods.iter();
            methods.map(|point| HaltedPointReport::new(entry.robot.as_deref(), point))
        });
        let points: Vec<HaltedPointReport> = points.collect();
        let mut notes = notes;
        notes.extend(ThroughputReport::note(points.iter().map(|p| &p.throughput)));
        Self {
            sweep: ROBOTS_DOWN,
            patterns: found.patterns,
            methods: found.halted.first().map_or(0, |entry| entry.methods.len()),
            points,
            notes,
            made,
            weighs: found.weighs,
        }
    }

    /// Whether there is a throughput at some point.
    pub(super) fn is_steady(&self) -> bool {
        let mut points = self.points.iter();
        points.any(|point| point.throughput.throughput_per_min.is_some())
    }

    /// For each method, the place of the point with the halted robot that costs most, if any costs
    /// something.
    pub(super) fn worst(&self) -> Vec<Option<usize>> {
        let of_method = |j: usize| {
            let points = self.points.iter().enumerate().skip(j).step_by(self.methods);
            let losses = points.filter_map(|(place, point)| Some((place, point.loss_percent?)));
            let worst = losses.filter(|(_, loss)| *loss > 0.0);
            // Of equal losses, that of the first robot.
            worst.fold(None, |worst: Option<(usize, f64)>, this| match worst {
                Some(worst) if worst.1 >= this.1 => Some(worst),
                _ => Some(this),
            })
        };
        let all = (0..self.methods).map(of_method);
        all.map(|worst| worst.map(|(place, _)| place)).collect()
    }
}
