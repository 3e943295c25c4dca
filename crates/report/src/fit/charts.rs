//! The charts of a fit.

use super::report::{ArmFitReport, FitReport, ResidualReport};
use crate::charts::{
    Chart, ChartAxis, ChartKind, ChartMark, ChartPoint, Ink, Layer, LegendLine, PointStyle, Swatch,
};
use pickline::error::counted;

/// The charts of a fit, the main one first.
pub(super) const CHARTS: &[ChartKind<FitReport>] = &[
    ChartKind {
        name: "residuals",
        chart: residuals,
        needs: "nothing",
    },
    ChartKind {
        name: "times",
        chart: times,
        needs: "nothing",
    },
];

fn residuals(report: &FitReport) -> Option<Chart> {
    let value = |residual: &ResidualReport| residual.residual_s.map(|r| 1e3 * r);
    let mut chart = scattered(report, "recorded - predicted [ms]", value);
    chart.title = "Residuals of the fitted laws".into();
    chart.marks.push(ChartMark {
        at: 0.0,
        upright: false,
        ink: Ink::Text,
        shade_to: None,
        label: String::new(),
    });
    chart.caption = "Each point is a recorded time, by the length of its way in the plane. A law \
                     that fits leaves no trend."
        .into();
    note_outliers(report, &mut chart);
    Some(chart)
}

fn times(report: &FitReport) -> Option<Chart> {
    let mut chart = scattered(report, "recorded time [s]", |r| Some(r.time_s));
    chart.title = "Recorded times".into();
    chart.caption =
        "Each point is a recorded time, by the length of its way in the plane; ways to \
                     the bin include grasp and release."
            .into();
    note_outliers(report, &mut chart);
    Some(chart)
}

/// Says how many outliers lie outside the chart.
fn note_outliers(report: &FitReport, chart: &mut Chart) {
    let outliers: usize = report.robots.iter().map(|robot| robot.outliers).sum();
    if outliers > 0 {
        chart.caption += &format!(" {} not shown.", counted(outliers, "outlier"));
    }
}

/// A chart of a value of each time that is no outlier, by its way; a series for each robot.
fn scattered(
    report: &FitReport,
    title: &str,
    value: impl Fn(&ResidualReport) -> Option<f64>,
) -> Chart {
    let points = |robot: &ArmFitReport| -> Vec<ChartPoint> {
        let kept = robot.residuals.iter().filter(|residual| !residual.outlier);
        let points = kept.filter_map(|residual| {
            Some(ChartPoint {
                x: residual.way_m,
                y: value(residual)?,
                ..ChartPoint::default()
            })
        });
        points.collect()
    };
    let series: Vec<Vec<ChartPoint>> = report.robots.iter().map(points).collect();
    let all = || series.iter().flatten();
    let legend = report
        .robots
        .iter()
        .enumerate()
        .map(|(i, robot)| LegendLine {
            label: robot.name.clone(),
            ink: Ink::Series(i),
            swatch: Swatch::Dot,
        });
    Chart {
        title: String::new(),
        caption: String::new(),
        x: ChartAxis::around("way in the plane [m]", all().map(|point| point.x), true),
        y: ChartAxis::around(title, all().map(|point| point.y), true),
        legend: legend.collect(),
        layers: series
            .into_iter()
            .enumerate()
            .map(|(i, points)| Layer::Points {
                ink: Ink::Series(i),
                style: PointStyle::Dots,
                points,
            })
            .collect(),
        marks: Vec::new(),
    }
}
