//! The charts of a comparison.

use super::report::{CaseReport, ComparisonReport, MethodResultReport, PrintedReport};
use crate::bound::{CaseBoundReport, rounded_up};
use crate::charts::{
    Chart, ChartAxis, ChartBar, ChartKind, ChartMark, ChartPoint, Ink, Layer, LegendLine,
    PointStyle, Swatch, beside, percent,
};
use crate::table::{fixed, interval as shown_interval};
use pickline::stats::Interval;

/// The charts of a comparison, the main one first.
pub(super) const CHARTS: &[ChartKind<ComparisonReport>] = &[
    ChartKind {
        name: "rate",
        chart: rate,
        needs: "nothing",
    },
    ChartKind {
        name: "difference",
        chart: difference,
        needs: "a second method: greedy GT (game theory) or a 'strategy'",
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
    let bars = BarFigure {
        title: "Picking rate",
        axis: "picking rate [1/min]",
        unit: "/min",
        digits: 2,
        value: |result| result.picking_rate_per_min,
        interval: |result| result.picking_rate_interval,
        printed: |paper| Some(paper.picking_rate_per_min),
        most: |bound| bound.picking_rate_per_min,
    };
    Some(bars.chart(report))
}

fn throughput(report: &ComparisonReport) -> Option<Chart> {
    let bars = BarFigure {
        title: "Throughput",
        axis: "throughput [1/min]",
        unit: "/min",
        digits: 1,
        value: |result| result.throughput.throughput_per_min.unwrap_or_default(),
        interval: |result| result.throughput.interval,
        printed: |_| None,
        most: |_| None,
    };
    let mut chart = bars.chart(report);
    chart.caption += " Picks per minute in the steady state; no bar: there is none.";
    report.is_steady().then_some(chart)
}

fn picked(report: &ComparisonReport) -> Option<Chart> {
    let bars = BarFigure {
        title: "Items picked",
        axis: "picked share [%]",
        unit: " %",
        digits: 1,
        value: |result| 100.0 * result.picked_share,
        interval: |result| result.picked_share_interval.map(percent),
        printed: |paper| Some(paper.picked_percent),
        most: |bound| Some(100.0 * bound.picked_share),
    };
    Some(bars.chart(report))
}

/// A figure shown as one bar per method for every case, with intervals, the paper's figures and
/// the bound for every strategy.
struct BarFigure {
    title: &'static str,
    axis: &'static str,
    /// Follows the number in words.
    unit: &'static str,
    /// Decimals in words.
    digits: usize,
    value: fn(&MethodResultReport) -> f64,
    interval: fn(&MethodResultReport) -> Option<Interval>,
    printed: fn(&PrintedReport) -> Option<f64>,
    most: fn(&CaseBoundReport) -> Option<f64>,
}

impl BarFigure {
    fn chart(&self, report: &ComparisonReport) -> Chart {
        let groups = self.groups(report);
        let intervals = self.intervals(report);
        let papers = self.papers(report);
        let bounds = self.bounds(report);
        let values = groups.iter().flatten().map(|bar| bar.value);
        let upper = intervals
            .iter()
            .filter_map(|point| Some(point.across?.high));
        let marks = papers.iter().chain(&bounds).map(|point| point.x);
        let ends: Vec<f64> = values.chain(upper).chain(marks).collect();
        let mut chart = Chart {
            title: self.title.into(),
            caption: "Means over the patterns of each case.".into(),
            x: ChartAxis::around(self.axis, ends, true),
            y: names(report),
            layers: vec![Layer::Bars(groups)],
            marks: Vec::new(),
            legend: methods_legend(report, 0, Swatch::Bar),
        };
        let mut add =
            |points: Vec<ChartPoint>, style, words: &str, label: Option<(&str, Swatch)>| {
                if points.is_empty() {
                    return;
                }
                chart.caption += words;
                chart.layers.push(Layer::Points {
                    ink: Ink::Text,
                    style,
                    points,
                });
                chart.legend.extend(label.map(|(label, swatch)| LegendLine {
                    label: label.into(),
                    ink: Ink::Text,
                    swatch,
                }));
            };
        add(
            intervals,
            PointStyle::Intervals,
            " Lines: 95 % intervals of the means, where a case has several patterns.",
            None,
        );
        add(
            papers,
            PointStyle::Dots,
            " Crosses: the figures that the paper prints.",
            Some(("the paper's figure", Swatch::Dot)),
        );
        add(
            bounds,
            PointStyle::Intervals,
            " Upright lines: the certified bound, which no strategy can pass.",
            Some(("bound: no strategy is above", Swatch::Bare)),
        );
        chart
    }

    /// The interval of a figure, if it has a length.
    fn wide(&self, result: &MethodResultReport) -> Option<Interval> {
        (self.interval)(result).filter(Interval::is_wide)
    }

    fn groups(&self, report: &ComparisonReport) -> Vec<Vec<ChartBar>> {
        let bar = |case: &CaseReport, j: usize| {
            let result = &case.results[j];
            let value = fixed((self.value)(result), self.digits);
            let words = self.wide(result).map_or(String::new(), |interval| {
                format!(
                    ", 95 % interval {}",
                    shown_interval(Some(interval), self.digits)
                )
            });
            ChartBar {
                value: (self.value)(result),
                ink: Ink::Series(j),
                tip: format!(
                    "{}, {}: {value}{}{words}",
                    case.name, report.methods[j].title, self.unit
                ),
                words: value,
            }
        };
        let group = |case: &CaseReport| (0..case.results.len()).map(|j| bar(case, j)).collect();
        report.cases.iter().map(group).collect()
    }

    fn intervals(&self, report: &ComparisonReport) -> Vec<ChartPoint> {
        let point = |(y, _, result): (f64, &CaseReport, &MethodResultReport)| {
            let interval = self.wide(result)?;
            Some(point_with((self.value)(result), y, Some(interval)))
        };
        results(report).filter_map(point).collect()
    }

    fn papers(&self, report: &ComparisonReport) -> Vec<ChartPoint> {
        let point = |(y, case, result): (f64, &CaseReport, &MethodResultReport)| {
            let paper = result.paper.filter(|_| report.with_paper)?;
            let x = (self.printed)(&paper)?;
            Some(ChartPoint {
                tip: format!("{}, {}: the paper prints {x}", case.name, result.method),
                ..point_with(x, y, None)
            })
        };
        results(report).filter_map(point).collect()
    }

    fn bounds(&self, report: &ComparisonReport) -> Vec<ChartPoint> {
        let methods = report.methods.len();
        let (first, last) = (beside(0, methods), beside(methods - 1, methods));
        let half = 0.5 / methods as f64;
        let point = |(i, case): (usize, &CaseReport)| {
            let x = case.bound.as_ref().and_then(self.most)?;
            Some(ChartPoint {
                along: Some(Interval {
                    low: i as f64 + first - half,
                    high: i as f64 + last + half,
                }),
                tip: format!(
                    "{}: no strategy is above {}{}",
                    case.name,
                    rounded_up(x, self.digits),
                    self.unit
                ),
                ..point_with(x, i as f64, None)
            })
        };
        report.cases.iter().enumerate().filter_map(point).collect()
    }
}

/// Every method on every case, with its place along the y axis.
fn results(
    report: &ComparisonReport,
) -> impl Iterator<Item = (f64, &CaseReport, &MethodResultReport)> {
    let methods = report.methods.len();
    report.cases.iter().enumerate().flat_map(move |(i, case)| {
        let results = case.results.iter().enumerate();
        results.map(move |(j, result)| (i as f64 + beside(j, methods), case, result))
    })
}

fn point_with(x: f64, y: f64, across: Option<Interval>) -> ChartPoint {
    ChartPoint {
        x,
        y,
        across,
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
            let ends = result.difference;
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
                ..point_with(x, i as f64 + beside(j - 1, others.len()), ends)
            }
        };
        Layer::Points {
            ink: Ink::Series(j),
            style: PointStyle::Dots,
            points: report.cases.iter().enumerate().map(point).collect(),
        }
    };
    let mut ends: Vec<f64> = report.cases.iter().flat_map(difference_ends).collect();
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

/// The ends of all differences of a case [1/min].
fn difference_ends(case: &CaseReport) -> Vec<f64> {
    let ends = |result: &MethodResultReport| {
        let x = difference_of(case, result);
        let Interval { low, high } = result.difference.unwrap_or(Interval::point(x));
        [low, high]
    };
    case.results[1..].iter().flat_map(ends).collect()
}

/// Excess over the first method's picking rate [1/min].
fn difference_of(case: &CaseReport, result: &MethodResultReport) -> f64 {
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
