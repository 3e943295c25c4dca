//! A sweep as CSV.

use super::report::SweepReport;
use crate::table::{cell, column, without_empty_columns};
use crate::throughput::ThroughputReport;

impl SweepReport {
    /// Every point as CSV.
    pub fn to_csv(&self) -> String {
        let varied = match self.sweep {
            "speed" => "belt_speed",
            other => other,
        };
        let varied = column(varied, self.unit);
        let mut header = vec![varied.as_str(), "method"];
        header.extend(ThroughputReport::COLUMNS);
        let adds = self.adds();
        header.extend(adds.then_some("added_per_robot_per_min"));
        header.extend([
            "picked_share",
            "picked_share_low",
            "picked_share_high",
            "picking_rate_per_min",
            "picking_rate_low_per_min",
            "picking_rate_high_per_min",
            "complete_share",
            "nearly_complete_share",
            "certified_percent",
            "picked_share_upper_bound",
            "picking_rate_upper_bound_per_min",
        ]);
        header.extend(self.weighs.then_some("weighted_rate_per_min"));
        let header: Vec<String> = header.into_iter().map(str::to_owned).collect();
        let methods = self.limits.len();
        let rows = self.points.iter().enumerate().map(|(i, point)| {
            let bound = self.bounds.as_ref().map(|b| &b.points[i / methods]);
            let mut row = vec![point.value.to_string(), point.method.clone()];
            let figures = [
                Some(point.picked_share),
                point.picked_share_low,
                point.picked_share_high,
                Some(point.picking_rate_per_min),
                point.picking_rate_low,
                point.picking_rate_high,
                Some(point.complete_share),
                Some(point.nearly_complete_share),
                point.certified_percent,
                bound.map(|bound| bound.picked_share),
                bound.and_then(|bound| bound.picking_rate_per_min),
            ];
            row.extend(point.throughput.cells());
            row.extend(adds.then(|| cell(point.added_per_robot_per_min)));
            row.extend(figures.map(cell));
            row.extend(self.weighs.then(|| point.weighted_rate_per_min.to_string()));
            row
        });
        let rows = std::iter::once(header).chain(rows);
        self.made.csv(without_empty_columns(rows))
    }
}
