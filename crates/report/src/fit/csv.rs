//! A fit as CSV: one row for each parameter and each point of a table.

use super::report::FitReport;
use crate::csv_rows::{CsvRows, Displayed, OptionalNumber};
use serde::Serialize;

#[derive(Default, Serialize)]
struct ParameterRow<'r> {
    robot: &'r str,
    law: &'static str,
    parameter: &'r str,
    unit: &'static str,
    /// Length of the path of a point of a table [m].
    length_m: OptionalNumber,
    value: OptionalNumber,
    low: OptionalNumber,
    high: OptionalNumber,
    remark: &'r str,
}

pub(super) fn csv(report: &FitReport) -> String {
    let rows = report.robots.iter().flat_map(|robot| {
        let parameters = robot.parameters.iter().map(|parameter| ParameterRow {
            robot: &robot.name,
            law: robot.law,
            parameter: &parameter.name,
            unit: parameter.unit,
            length_m: None,
            value: parameter.value.map(Displayed),
            low: parameter.interval.map(|interval| Displayed(interval.low)),
            high: parameter
                .interval
                .and_then(|interval| interval.high.map(Displayed)),
            remark: &parameter.remark,
        });
        let table = robot.table.iter().map(|point| ParameterRow {
            robot: &robot.name,
            law: robot.law,
            parameter: "travel",
            unit: "s",
            length_m: Some(Displayed(point.length_m)),
            value: Some(Displayed(point.time_s)),
            low: point.interval.map(|interval| Displayed(interval.low)),
            high: point
                .interval
                .and_then(|interval| interval.high.map(Displayed)),
            remark: point.remark(),
        });
        parameters.chain(table)
    });
    CsvRows::of(rows).text(&report.made)
}
