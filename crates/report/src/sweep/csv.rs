//! A sweep as CSV.

use super::report::SweepReport;
use crate::csv_rows::{CsvRows, Displayed, OptionalNumber, high, low};
use crate::purity::{PurityByBinReport, PurityColumns, PurityReport};
use crate::table::column;
use serde::Serialize;

#[derive(Default, Serialize)]
struct SweptMethod<'r> {
    /// Named after the varied quantity.
    value: Displayed,
    method: &'r str,
}

#[derive(Default, Serialize)]
struct PointFigures {
    /// Only in a sweep of the number of robots.
    added_per_robot_per_min: OptionalNumber,
    picked_share: Displayed,
    picked_share_low: OptionalNumber,
    picked_share_high: OptionalNumber,
    picking_rate_per_min: Displayed,
    picking_rate_low_per_min: OptionalNumber,
    picking_rate_high_per_min: OptionalNumber,
    complete_share: Displayed,
    nearly_complete_share: Displayed,
    certified_percent: OptionalNumber,
    picked_share_upper_bound: OptionalNumber,
    picking_rate_upper_bound_per_min: OptionalNumber,
    /// Only where items have attributes.
    weighted_rate_per_min: OptionalNumber,
    /// Only where detections may be wrong, as those below.
    purity: OptionalNumber,
    purity_low: OptionalNumber,
    purity_high: OptionalNumber,
    recovery: OptionalNumber,
    recovery_low: OptionalNumber,
    recovery_high: OptionalNumber,
}

#[derive(Default, Serialize)]
struct ChosenThresholdRow<'r> {
    method: &'r str,
    wanted_purity: Displayed,
    min_detection: OptionalNumber,
    /// `training` or `fresh`.
    patterns: &'static str,
}

impl SweepReport {
    /// Every point; columns without figures are left out.
    pub(super) fn points_csv(&self) -> CsvRows {
        let methods = self.limits.len();
        let rows = self.points.iter().enumerate().map(|(i, point)| {
            let bound = self.bounds.as_ref().map(|b| &b.points[i / methods]);
            let of = SweptMethod {
                value: Displayed(point.value),
                method: point.method.as_str(),
            };
            let rate = bound.and_then(|bound| bound.picking_rate_per_min);
            let purity = point.sorting.as_ref().map(|purity| &purity.total);
            let content = purity.map(|purity| &purity.content);
            let purity_ends = purity.and_then(|purity| purity.purity_interval);
            let recovery_ends = purity.and_then(|purity| purity.recovery_interval);
            let figures = PointFigures {
                added_per_robot_per_min: point.added_per_robot_per_min.map(Displayed),
                picked_share: Displayed(point.picked_share),
                picked_share_low: low(point.picked_share_interval),
                picked_share_high: high(point.picked_share_interval),
                picking_rate_per_min: Displayed(point.picking_rate_per_min),
                picking_rate_low_per_min: low(point.picking_rate_interval),
                picking_rate_high_per_min: high(point.picking_rate_interval),
                complete_share: Displayed(point.complete_share),
                nearly_complete_share: Displayed(point.nearly_complete_share),
                certified_percent: point.certified_percent.map(Displayed),
                picked_share_upper_bound: bound.map(|bound| Displayed(bound.picked_share)),
                picking_rate_upper_bound_per_min: rate.map(Displayed),
                weighted_rate_per_min: self
                    .weighs
                    .then_some(Displayed(point.weighted_rate_per_min)),
                purity: content.and_then(|content| content.purity.map(Displayed)),
                purity_low: low(purity_ends),
                purity_high: high(purity_ends),
                recovery: content.and_then(|content| content.recovery.map(Displayed)),
                recovery_low: low(recovery_ends),
                recovery_high: high(recovery_ends),
            };
            (of, point.throughput.columns(), figures)
        });
        CsvRows::of(rows)
            .without_empty()
            .renamed(|name| self.column_name(name))
    }

    /// Purity and recovery of the bins at every point, if detections may be wrong.
    pub(super) fn purity_csv(&self) -> Option<CsvRows> {
        let rows = self.points.iter().flat_map(|point| {
            let parts = point.sorting.iter().flat_map(PurityByBinReport::parts);
            parts.map(|(bin, purity, _)| {
                let of = SweptMethod {
                    value: Displayed(point.value),
                    method: point.method.as_str(),
                };
                (of, PurityColumns::new(bin, purity))
            })
        });
        let rows = CsvRows::of(rows).renamed(|name| self.column_name(name));
        self.has_purity().then_some(rows)
    }

    /// The thresholds, with what each gives on the training patterns and on fresh ones.
    pub(super) fn thresholds_csv(&self) -> Option<CsvRows> {
        let thresholds = self.thresholds.as_ref()?;
        let rows = thresholds.methods.iter().flat_map(|method| {
            let of = |patterns: &'static str, purity: Option<PurityReport>| {
                let row = ChosenThresholdRow {
                    method: &method.method,
                    wanted_purity: Displayed(thresholds.purity),
                    min_detection: method.threshold.map(Displayed),
                    patterns,
                };
                let columns = purity.map(|purity| PurityColumns::new(None, &purity));
                (row, columns.unwrap_or_default())
            };
            [of("training", method.trained), of("fresh", method.fresh)]
        });
        Some(CsvRows::of(rows).without(&["bin"]))
    }

    /// What each method picks of each class, if there are classes.
    pub(super) fn classes_csv(&self) -> Option<CsvRows> {
        self.classes().next()?;
        let points = self.points.iter();
        let classes =
            points.flat_map(|point| point.classes.iter().map(move |class| (point, class)));
        let rows = classes.map(|(point, class)| {
            let of = SweptMethod {
                value: Displayed(point.value),
                method: point.method.as_str(),
            };
            (of, class.csv_columns())
        });
        let rows = CsvRows::of(rows).renamed(|name| self.column_name(name));
        Some(rows)
    }

    /// The name of a column: that of the value is the varied quantity with its unit.
    fn column_name(&self, name: &str) -> String {
        match (name, self.sweep) {
            ("value", "speed") => column("belt_speed", self.unit),
            ("value", other) => column(&other.replace('-', "_"), self.unit),
            _ => name.to_owned(),
        }
    }
}
