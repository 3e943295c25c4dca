//! The charts of a comparison.

use super::report::{CaseReport, ComparisonReport, ResultReport};
use crate::bound::{CaseBoundReport, rounded_up};
use crate::charts::{
    Chart, ChartAxis, ChartBar, ChartKind, ChartMark, ChartPoint, Ink, Layer, LegendLine,
    PointStyle, Swatch, beside,
};
use crate::table::{fixed, interval as shown_interval};

/// The charts of a comparison, the main one first.
pub const COMPARISON_CHARTS: &[ChartKind<ComparisonReport>] = &[
    ChartKind {
        name: "rate",
        chart: rate,
        needs: "nothing",
    },
    ChartKind {
        name: "difference",
        chart: difference,
        needs: "a second method: greedy GT (game theory) or a --strategy",
    },
    ChartKind {
        name: "throughput",
        chart: throughput,
        needs: "patterns that are long enough for a steady state",
    },
    ChartKind {
        name: "picked",
        chart: picked,
        needs: "nothing",
    },
];

fn rate(report: &ComparisonReport) -> Option<Chart> {
    let value = |result: &ResultReport| BarFigure {
        value: result.picking_rate_per_min,
        interval: result.picking_rate_low.zip(result.picking_rate_high),
    };
    let printed = |result: &ResultReport| {
        let paper = result.paper.filter(|_| report.with_paper);
        paper.map(|paper| paper.picking_rate_per_min)
    };
    Some(bars(
        report,
        "Picking rate",
        ("picking rate [1/min]", "/min", 2),
        value,
        printed,
        |bound| bound.picking_rate_per_min,
    ))
}

fn throughput(report: &ComparisonReport) -> Option<Chart> {
    let value = |result: &ResultReport| BarFigure {
        value: result.throughput.throughput_per_min.unwrap_or_default(),
        interval: result.throughput.ends(),
    };
    let mut chart = bars(
        report,
        "Throughput",
        ("throughput [1/min]", "/min", 1),
        value,
        |_| None,
        |_| None,
    );
    chart.caption += " Picks per minute in the steady state; no bar: there is none.";
    report.is_steady().then_some(chart)
}

fn picked(report: &ComparisonReport) -> Option<Chart> {
    let value = |result: &ResultReport| {
        let ends = result.picked_share_low.zip(result.picked_share_high);
        BarFigure {
            value: 100.0 * result.picked_share,
            // An interval of a mean may pass 100 %, items cannot.
            interval: ends.map(|(low, high)| (100.0 * low, (100.0 * high).min(100.0))),
        }
    };
    let printed = |result: &ResultReport| {
        let paper = result.paper.filter(|_| report.with_paper);
        paper.map(|paper| paper.picked_percent)
    };
    Some(bars(
        report,
        "Items picked",
        ("picked share [%]", " %", 1),
        value,
        printed,
        |bound| Some(100.0 * bound.picked_share),
    ))
}

struct BarFigure {
    value: f64,
    interval: Option<(f64, f64)>,
}

/// One bar per method for every case, with intervals, the paper's figures and the bound for
/// every strategy.
fn bars(
    report: &ComparisonReport,
    title: &str,
    (axis, unit, digits): (&str, &str, usize),
    figure: impl Fn(&ResultReport) -> BarFigure,
    printed: impl Fn(&ResultReport) -> Option<f64>,
    most: impl Fn(&CaseBoundReport) -> Option<f64>,
) -> Chart {
    let methods = report.methods.len();
    let mut groups = Vec::new();
    let mut intervals = Vec::new();
    let mut papers = Vec::new();
    let mut bounds = Vec::new();
    for (i, case) in report.cases.iter().enumerate() {
        if let Some(x) = case.bound.as_ref().and_then(&most) {
            let (first, last) = (beside(0, methods), beside(methods - 1, methods));
            let half = 0.5 / methods as f64;
            bounds.push(ChartPoint {
                x,
                y: i as f64,
                along: Some((i as f64 + first - half, i as f64 + last + half)),
                tip: format!(
                    "{}: no strategy is above {}{unit}",
                    case.name,
                    rounded_up(x, digits)
                ),
                ..ChartPoint::default()
            });
        }
        let mut group = Vec::new();
        for (j, result) in case.results.iter().enumerate() {
            let BarFigure {
                value,
                interval: ends,
            } = figure(result);
            let y = i as f64 + beside(j, methods);
            let mut tip = format!(
                "{}, {}: {}{unit}",
                case.name,
                report.methods[j].title,
                fixed(value, digits)
            );
            if let Some((low, high)) = ends.filter(|(low, high)| low < high) {
                tip += &format!(
                    ", 95 % interval {} to {}",
                    fixed(low, digits),
                    fixed(high, digits)
                );
                intervals.push(interval(value, y, Some((low, high))));
            }
            if let Some(paper) = printed(result) {
                papers.push(ChartPoint {
                    x: paper,
                    y,
                    tip: format!(
                        "{}, {}: the paper prints {paper}",
                        case.name, case.results[j].method
                    ),
                    ..ChartPoint::default()
                });
            }
            group.push(ChartBar {
                value,
                words: fixed(value, digits),
                ink: Ink::Series(j),
                tip,
            });
        }
        groups.push(group);
    }
    let ends = groups.iter().flatten().map(|bar| bar.value);
    let ends = ends
        .chain(
            intervals
                .iter()
                .filter_map(|point| point.across)
                .map(|(_, high)| high),
        )
        .chain(papers.iter().chain(&bounds).map(|point| point.x));
    let x = ChartAxis::around(axis, ends.collect::<Vec<_>>(), true);
    let mut caption = "Means over the patterns of each case.".to_owned();
    let mut legend: Vec<LegendLine> = methods_legend(report, 0, Swatch::Bar);
    let mut layers = vec![Layer::Bars(groups)];
    if !intervals.is_empty() {
        caption += " Lines: 95 % intervals of the means, where a case has several patterns.";
        layers.push(Layer::Points {
            ink: Ink::Text,
            style: PointStyle::Intervals,
            points: intervals,
        });
    }
    if !papers.is_empty() {
        caption += " Crosses: the figures that the paper prints.";
        layers.push(Layer::Points {
            ink: Ink::Text,
            style: PointStyle::Dots,
            points: papers,
        });
        legend.push(LegendLine {
            label: "the paper's figure".into(),
            ink: Ink::Text,
            swatch: Swatch::Dot,
        });
    }
    if !bounds.is_empty() {
        caption += " Upright lines: the certified bound, which no strategy can pass.";
        layers.push(Layer::Points {
            ink: Ink::Text,
            style: PointStyle::Intervals,
            points: bounds,
        });
        legend.push(LegendLine {
            label: "bound: no strategy is above".into(),
            ink: Ink::Text,
            swatch: Swatch::Bare,
        });
    }
    Chart {
        title: title.into(),
        caption,
        x,
        y: names(report),
        layers,
        marks: Vec::new(),
        legend,
    }
}

fn interval(x: f64, y: f64, ends: Option<(f64, f64)>) -> ChartPoint {
    ChartPoint {
        x,
        y,
        across: ends,
        ..ChartPoint::default()
    }
}

/// How much more each method picks than the first, case by case.
fn difference(report: &ComparisonReport) -> Option<Chart> {
    let (first, others) = report.methods.split_first()?;
    if others.is_empty() {
        return None;
    }
    let layer = |j: usize| {
        let point = |(i, case): (usize, &CaseReport)| {
            let result = &case.results[j];
            let x = difference_of(case, result);
            let ends = result.diff_low.zip(result.diff_high);
            let words = ends.map_or(String::new(), |ends| {
                format!(", 95 % interval {}", shown_interval(Some(ends), 2))
            });
            ChartPoint {
                tip: format!(
                    "{}, {} minus {}: {}/min{words}",
                    case.name,
                    report.methods[j].title,
                    first.title,
                    fixed(x, 2),
                ),
                ..interval(x, i as f64 + beside(j - 1, others.len()), ends)
            }
        };
        Layer::Points {
            ink: Ink::Series(j),
            style: PointStyle::Dots,
            points: report.cases.iter().enumerate().map(point).collect(),
        }
    };
    let ends_of = |case: &CaseReport, result: &ResultReport| {
        let x = difference_of(case, result);
        [result.diff_low.unwrap_or(x), result.diff_high.unwrap_or(x)]
    };
    let ends_of = |case: &CaseReport| -> Vec<f64> {
        let results = case.results[1..].iter();
        results.flat_map(|result| ends_of(case, result)).collect()
    };
    let mut ends: Vec<f64> = report.cases.iter().flat_map(ends_of).collect();
    ends.push(0.0);
    // The title names the first method; the name of a long line would not fit here.
    let axis = "picking rate minus that of the first method [1/min]".to_owned();
    Some(Chart {
        title: format!("Difference from {}", first.title),
        caption: "Difference of the picking rates on the same patterns, with the 95 % interval \
                  of its mean; to the right of 0, a method is better. A case of a single \
                  pattern has no interval."
            .into(),
        x: ChartAxis::around(axis, ends, false),
        y: names(report),
        layers: (1..report.methods.len()).map(layer).collect(),
        marks: vec![ChartMark {
            at: 0.0,
            upright: true,
            ink: Ink::Series(0),
            shade_to: None,
            label: String::new(),
        }],
        legend: methods_legend(report, 1, Swatch::Dot),
    })
}

/// Excess over the first method's picking rate [1/min].
fn difference_of(case: &CaseReport, result: &ResultReport) -> f64 {
    result.picking_rate_per_min - case.results[0].picking_rate_per_min
}

fn names(report: &ComparisonReport) -> ChartAxis {
    ChartAxis::Names(report.cases.iter().map(|case| case.name.clone()).collect())
}

fn methods_legend(report: &ComparisonReport, from: usize, swatch: Swatch) -> Vec<LegendLine> {
    let methods = report.methods.iter().enumerate().skip(from);
    methods
        .map(|(j, method)| LegendLine {
            label: method.title.clone(),
            ink: Ink::Series(j),
            swatch,
        })
        .collect()
}
