//! The charts of a sweep over halted robots.

use super::report::{HaltedPointReport, RobotsDownReport};
use crate::charts::{
    Chart, ChartAxis, ChartBar, ChartKind, ChartPoint, Ink, Layer, LegendLine, PointStyle, Swatch,
    beside, percent,
};
use crate::table::{fixed, interval};
use pickline::stats::Interval;

/// The charts of a sweep over halted robots, the main one first.
pub(super) const CHARTS: &[ChartKind<RobotsDownReport>] = &[
    ChartKind {
        name: "picked",
        chart: picked,
        needs: "nothing",
    },
    ChartKind {
        name: "loss",
        chart: loss,
        needs: "a robot that was halted",
    },
    ChartKind {
        name: "throughput",
        chart: throughput,
        needs: "patterns that are long enough for a steady state",
    },
    ChartKind {
        name: "rate",
        chart: rate,
        needs: "nothing",
    },
];

/// A figure and its 95 % interval.
type Measured = (f64, Option<Interval>);

fn picked(report: &RobotsDownReport) -> Option<Chart> {
    let mut chart = bars(report, "picked share [%]", " %", |point| {
        let interval = point.picked_share_interval.map(percent);
        Some((100.0 * point.picked_share, interval))
    });
    chart.title = "Items picked with one robot down".into();
    chart.x = chart.x.up_to(100.0);
    Some(chart)
}

fn loss(report: &RobotsDownReport) -> Option<Chart> {
    let mut chart = bars(report, "fewer picks [%]", " %", |point| {
        Some((point.loss_percent?, point.loss_interval))
    });
    chart.title = "Picks lost with one robot down".into();
    chart.caption += " Against the same patterns with all robots.";
    let mut points = report.points.iter();
    points
        .any(|point| point.loss_percent.is_some())
        .then_some(chart)
}

fn throughput(report: &RobotsDownReport) -> Option<Chart> {
    let mut chart = bars(report, "throughput [1/min]", "/min", |point| {
        let throughput = point.throughput.throughput_per_min?;
        Some((throughput, point.throughput.interval))
    });
    chart.title = "Throughput with one robot down".into();
    chart.caption += " Picks per minute in the steady state; no bar: there is none.";
    report.is_steady().then_some(chart)
}

fn rate(report: &RobotsDownReport) -> Option<Chart> {
    let mut chart = bars(report, "picking rate [1/min]", "/min", |point| {
        Some((point.picking_rate_per_min, point.picking_rate_interval))
    });
    chart.title = "Picking rate with one robot down".into();
    Some(chart)
}

/// One group of bars for every halted robot, one bar for every method.
fn bars(
    report: &RobotsDownReport,
    axis: &str,
    unit: &str,
    figure: impl Fn(&HaltedPointReport) -> Option<Measured>,
) -> Chart {
    let groups: Vec<&[HaltedPointReport]> = report.points.chunks(report.methods.max(1)).collect();
    // Those without the figure, such as the loss with all robots, have no group.
    let has_figure = |group: &&&[HaltedPointReport]| group.iter().any(|p| figure(p).is_some());
    let groups: Vec<&[HaltedPointReport]> = groups.iter().filter(has_figure).copied().collect();
    let names = groups.iter().map(|group| match &group[0].robot_down {
        Some(robot) => format!("{robot} down"),
        None => "all robots".to_owned(),
    });
    let bar = |(j, point): (usize, &HaltedPointReport)| {
        let (value, ends) = figure(point).unwrap_or_default();
        let words = fixed(value, 1);
        let ends = ends
            .filter(Interval::is_wide)
            .map_or(String::new(), |ends| {
                format!(", 95 % interval {}", interval(Some(ends), 1))
            });
        ChartBar {
            value,
            ink: Ink::Series(j),
            tip: format!(
                "{}, {} down: {words}{unit}{ends}",
                point.title,
                point.halted()
            ),
            words,
        }
    };
    let mut points = Vec::new();
    for (row, group) in groups.iter().enumerate() {
        for (j, point) in group.iter().enumerate() {
            let measured = figure(point);
            let wide = measured.and_then(|(x, ends)| Some((x, ends.filter(Interval::is_wide)?)));
            points.extend(wide.map(|(x, ends)| ChartPoint {
                x,
                y: row as f64 + beside(j, group.len()),
                across: Some(ends),
                ..ChartPoint::default()
            }));
        }
    }
    let ends: Vec<f64> = groups
        .iter()
        .flat_map(|group| group.iter())
        .filter_map(&figure)
        .flat_map(|(value, ends)| [value, ends.map_or(value, |ends| ends.high)])
        .collect();
    let legend = report.points.iter().take(report.methods).enumerate();
    Chart {
        title: String::new(),
        caption: match report.patterns {
            1 => "One pattern, so there are no intervals.".into(),
            n => format!("Means over {n} patterns. Lines: their 95 % intervals."),
        },
        x: ChartAxis::around(axis, ends, true),
        y: ChartAxis::Names(names.collect()),
        layers: vec![
            Layer::Bars(
                groups
                    .iter()
                    .map(|group| group.iter().enumerate().map(bar).collect())
                    .collect(),
            ),
            Layer::Points {
                ink: Ink::Text,
                style: PointStyle::Intervals,
                points,
            },
        ],
        marks: Vec::new(),
        legend: legend
            .map(|(j, point)| LegendLine {
                label: point.title.clone(),
                ink: Ink::Series(j),
                swatch: Swatch::Bar,
            })
            .collect(),
    }
}
