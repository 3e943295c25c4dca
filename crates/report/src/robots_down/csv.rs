//! A sweep over halted robots as CSV.

use super::report::RobotsDownReport;
use crate::csv_rows::{CsvRows, Displayed, OptionalNumber, high, low};
use serde::Serialize;

#[derive(Default, Serialize)]
struct HaltedMethod<'r> {
    /// The robot's name; empty if all robots work.
    robot_down: &'r str,
    method: &'r str,
}

#[derive(Default, Serialize)]
struct HaltedFigures {
    picked_share: Displayed,
    picked_share_low: OptionalNumber,
    picked_share_high: OptionalNumber,
    picking_rate_per_min: Displayed,
    picking_rate_low_per_min: OptionalNumber,
    picking_rate_high_per_min: OptionalNumber,
    loss_percent: OptionalNumber,
    loss_low_percent: OptionalNumber,
    loss_high_percent: OptionalNumber,
    /// Only where items have attributes.
    weighted_rate_per_min: OptionalNumber,
}

impl RobotsDownReport {
    /// Every point; columns without figures are left out.
    pub(super) fn points_csv(&self) -> CsvRows {
        let rows = self.points.iter().map(|point| {
            let of = HaltedMethod {
                robot_down: point.robot_down.as_deref().unwrap_or_default(),
                method: &point.method,
            };
            let weighted = Displayed(point.weighted_rate_per_min);
            let figures = HaltedFigures {
                picked_share: Displayed(point.picked_share),
                picked_share_low: low(point.picked_share_interval),
                picked_share_high: high(point.picked_share_interval),
                picking_rate_per_min: Displayed(point.picking_rate_per_min),
                picking_rate_low_per_min: low(point.picking_rate_interval),
                picking_rate_high_per_min: high(point.picking_rate_interval),
                loss_percent: point.loss_percent.map(Displayed),
                loss_low_percent: low(point.loss_interval),
                loss_high_percent: high(point.loss_interval),
                weighted_rate_per_min: self.weighs.then_some(weighted),
            };
            (of, point.throughput.columns(), figures)
        });
        CsvRows::of(rows).without_empty()
    }
}
