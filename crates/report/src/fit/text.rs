//! A fit as text for the terminal.

use super::report::{ArmFitReport, FitReport, ParameterReport, TablePointReport};
use crate::columns::TableColumns;
use crate::presentation::Presentation;
use crate::table::fixed;
use pickline::error::{counted, rounded};
use pickline::fit::HalfOpen;

/// Significant digits of parameters.
const DIGITS: usize = 4;

pub(super) fn text(report: &FitReport, shown: &Presentation) -> String {
    let robots = TableColumns::new()
        .with("<robot", |robot: &&ArmFitReport| robot.name.clone())
        .with("<law", |robot| robot.law.to_owned())
        .with("moves", |robot| robot.moves.to_string())
        .with("times", |robot| robot.times.to_string())
        .with("error, median [ms]", |robot| {
            milliseconds(robot.error.median_s)
        })
        .with("95 % [ms]", |robot| milliseconds(robot.error.p95_s))
        .with("outliers [%]", |robot| {
            fixed(100.0 * robot.outlier_share, 1)
        })
        .with("95 % without [ms]", |robot| {
            milliseconds(robot.error_without_outliers.p95_s)
        })
        .table(&report.robots);
    let parameters = report.robots.iter().flat_map(|robot| {
        let parameters = robot.parameters.iter();
        parameters.map(move |parameter| (robot.name.as_str(), parameter))
    });
    let parameters: Vec<(&str, &ParameterReport)> = parameters.collect();
    let parameters = TableColumns::new()
        .with("<robot", |(robot, _): &&(&str, &ParameterReport)| {
            (*robot).to_owned()
        })
        .with("<parameter", |(_, p)| p.name.clone())
        .with("value", |(_, p)| {
            p.value.map_or("-".into(), |v| rounded(v, DIGITS))
        })
        .with("<95 % interval", |(_, p)| interval(p.interval))
        .with("<unit", |(_, p)| p.unit.to_owned())
        .with("<remark", |(_, p)| p.remark.clone())
        .table(&parameters);
    let tables: String = report.robots.iter().map(table_text).collect();
    let notes = report.robots.iter().flat_map(|robot| {
        let notes = robot.notes.iter();
        notes.map(move |note| format!("note      {}: {}\n", robot.name, shown.spelled(note)))
    });
    let notes: String = notes.collect();
    format!(
        "{robots}{parameters}{tables}error     of all times that are predicted, by fits that did not \
         use them: each fifth of the moves was held out once; outliers have no influence on fits\n\
         {notes}{}{}",
        source_lines(report),
        report.made.lines()
    )
}

fn milliseconds(seconds: f64) -> String {
    fixed(1e3 * seconds, 2)
}

/// An interval; `at least` if it is open.
fn interval(interval: Option<HalfOpen>) -> String {
    let digits = |value| rounded(value, DIGITS);
    match interval {
        None => "-".into(),
        Some(HalfOpen { low, high: None }) => format!("at least {}", digits(low)),
        Some(HalfOpen {
            low,
            high: Some(high),
        }) => format!("{} to {}", digits(low), digits(high)),
    }
}

fn table_text(robot: &ArmFitReport) -> String {
    if robot.table.is_empty() {
        return String::new();
    }
    TableColumns::new()
        .with("<robot", |_: &&TablePointReport| robot.name.clone())
        .with("path [m]", |point| fixed(point.length_m, 4))
        .with("time [s]", |point| fixed(point.time_s, 4))
        .with("<95 % interval", |point| interval(point.interval))
        .with("<remark", |point| point.remark().to_owned())
        .table(&robot.table)
}

/// What of the source was not used.
fn source_lines(report: &FitReport) -> String {
    let mut lines = String::new();
    if report.unused > 0 {
        lines += &format!(
            "unused    {} without what a move needs\n",
            counted(report.unused, "row")
        );
    }
    if !report.ignored_columns.is_empty() {
        lines += &format!("ignored   columns {}\n", report.ignored_columns.join(", "));
    }
    if !report.without_moves.is_empty() {
        lines += &format!(
            "unchanged {}: no moves, or too few\n",
            report.without_moves.join(", ")
        );
    }
    lines
}
