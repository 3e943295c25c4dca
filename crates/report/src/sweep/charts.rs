//! The charts of a sweep.

use super::chart_parts::{MOST_BARS, heights, legend, mark, marks_entry, method_words};
use super::purity_chart::purity_chart;
use super::report::{BoundPoint, LimitReport, PointReport, SweepReport};
use crate::bound::rounded_up;
use crate::charts::{
    Chart, ChartAxis, ChartKind, ChartMark, ChartPoint, Ink, Layer, LegendLine, PointStyle, Swatch,
    percent,
};
use crate::table::{fixed, interval};
use pickline::stats::{self, Interval};

/// The charts of a sweep, the main one first.
pub(super) const CHARTS: &[ChartKind<SweepReport>] = &[
    ChartKind {
        name: "picked",
        chart: picked,
        needs: "nothing",
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
    ChartKind {
        name: "limits",
        chart: limits,
        needs: "several patterns, and a sweep of what makes picking harder: speed or spacing",
    },
    ChartKind {
        name: "purity",
        chart: purity_chart,
        needs: "a sweep of the threshold of detections ('sweep_axis' min-detection)",
    },
];

/// With more methods than this, their shades would merge.
const MOST_SHADES: usize = 4;
/// Share of the distance to the next value over which the methods' intervals are spread, so
/// that each is visible.
const SPREAD: f64 = 0.12;

fn picked(report: &SweepReport) -> Option<Chart> {
    let figure = |point: &PointReport| {
        Some((
            100.0 * point.picked_share,
            point.picked_share_interval.map(percent),
        ))
    };
    let bound = |bound: &BoundPoint| Some(100.0 * bound.picked_share);
    let mut chart = lines(report, "picked share [%]", " %", figure, bound);
    chart.title = "Items picked".into();
    chart.y = chart.y.up_to(100.0);
    if report.is_of_thresholds() {
        chart.caption += " Items below the threshold do not count.";
    }
    let mut marked = false;
    let limits = report.limits.iter().filter(|_| !report.is_of_thresholds());
    let shaded = report.limits.len() <= MOST_SHADES && !report.helps;
    for (j, limit) in limits.enumerate() {
        let (at, to) = match report.helps {
            true => (limit.lowest, None),
            false => (limit.highest, limit.first_miss.filter(|_| shaded)),
        };
        if let Some(at) = at {
            marked = true;
            chart
                .marks
                .push(mark(at, to, Ink::Series(j), at.to_string()));
        }
    }
    let words = match (report.helps, shaded) {
        (true, _) => "everything picked from here on",
        (false, true) => "everything picked up to here; shaded up to the first miss",
        (false, false) => "everything picked up to here",
    };
    if marked {
        chart.caption += &format!(" Dashed upright lines: {words}.");
        chart.legend.push(marks_entry(Ink::Text, words));
    }
    if let Some(paper) = &report.paper {
        for (name, at) in [("robust GT", paper.robust_gt), ("RL", paper.rl)] {
            let label = format!("paper, {name}: {at}");
            chart.marks.push(mark(at, None, Ink::Faint, label));
        }
        chart.caption += " Grey: the limits that the paper states.";
        chart
            .legend
            .push(marks_entry(Ink::Faint, "limits that the paper states"));
    }
    Some(chart)
}

fn rate(report: &SweepReport) -> Option<Chart> {
    let figure =
        |point: &PointReport| Some((point.picking_rate_per_min, point.picking_rate_interval));
    let bound = |bound: &BoundPoint| bound.picking_rate_per_min;
    let mut chart = lines(report, "picking rate [1/min]", "/min", figure, bound);
    chart.title = "Picking rate".into();
    Some(chart)
}

fn throughput(report: &SweepReport) -> Option<Chart> {
    let figure = |point: &PointReport| {
        let throughput = point.throughput.throughput_per_min?;
        Some((throughput, point.throughput.interval))
    };
    let mut chart = lines(report, "throughput [1/min]", "/min", figure, |_| None);
    chart.title = "Throughput".into();
    chart.caption = format!("Picks per minute in the steady state. {}", chart.caption);
    if report.patterns == 1 {
        chart.caption = "Picks per minute in the steady state of one pattern, with 95 % intervals \
                         by batch means."
            .into();
    }
    for (j, limit) in report.limits.iter().enumerate() {
        let chosen = limit.recommended;
        let chosen = chosen.map(|at| mark(at, None, Ink::Series(j), at.to_string()));
        chart.marks.extend(chosen);
    }
    if !chart.marks.is_empty() {
        chart.caption += " Dashed upright lines: the recommended values.";
        chart.legend.push(marks_entry(Ink::Text, "recommended"));
    }
    report.is_steady().then_some(chart)
}

/// A figure and its 95 % interval.
type Measured = (f64, Option<Interval>);

/// One line per method for a figure with its interval, and one for its bound.
fn lines(
    report: &SweepReport,
    axis: &str,
    unit: &str,
    figure: impl Fn(&PointReport) -> Option<Measured>,
    bound: impl Fn(&BoundPoint) -> Option<f64>,
) -> Chart {
    let (x, style) = across(report);
    let aside = aside(report, style);
    let methods = report.limits.len();
    let layer = |j: usize| {
        let of_method = report.points.iter().skip(j).step_by(methods);
        let points = of_method.filter_map(|point| {
            // A share of nothing is no point.
            let (y, ends) = figure(point).filter(|(y, _)| y.is_finite())?;
            Some(method_point(report, point, (y, ends), unit).moved(aside(j)))
        });
        Layer::Points {
            ink: Ink::Series(j),
            style,
            points: points.collect(),
        }
    };
    let mut layers: Vec<Layer> = (0..methods).map(layer).collect();
    let mut caption = match (report.patterns, style) {
        (1, _) => "One pattern, so there are no intervals.".into(),
        (n, PointStyle::Area) => format!("Means over {n} patterns; areas: their 95 % intervals."),
        (n, _) => format!(
            "Means over {n} patterns with their 95 % intervals, slightly offset if \
             there are several methods."
        ),
    };
    let mut legend = legend(report);
    let bounds = bound_points(report, unit, bound);
    if !bounds.is_empty() {
        layers.push(Layer::Points {
            ink: Ink::Text,
            style: PointStyle::Bare,
            points: bounds,
        });
        legend.push(LegendLine {
            label: "bound: no strategy is above".into(),
            ink: Ink::Text,
            swatch: Swatch::Bare,
        });
        caption += " The line without points: the certified bound of what any strategy can do.";
    }
    let all: Vec<f64> = layers.iter().flat_map(heights).collect();
    Chart {
        title: String::new(),
        caption,
        x,
        y: ChartAxis::around(axis, all, false),
        layers,
        marks: Vec::new(),
        legend,
    }
}

/// A figure of a method at a value.
fn method_point(
    report: &SweepReport,
    point: &PointReport,
    (y, ends): Measured,
    unit: &str,
) -> ChartPoint {
    let ends = ends.filter(Interval::is_wide);
    let words = ends.map_or(String::new(), |ends| {
        format!(", 95 % interval {}", interval(Some(ends), 2))
    });
    ChartPoint {
        x: point.value,
        y,
        along: ends,
        tip: format!(
            "{}, {} at {}: {}{unit}{words}",
            point.title,
            report.sweep,
            point.value,
            fixed(y, 2)
        ),
        ..ChartPoint::default()
    }
}

/// The bounds of a figure, if they are known.
fn bound_points(
    report: &SweepReport,
    unit: &str,
    bound: impl Fn(&BoundPoint) -> Option<f64>,
) -> Vec<ChartPoint> {
    let bounds = report.bounds.iter().flat_map(|bounds| &bounds.points);
    let point = |point: &BoundPoint| {
        let y = bound(point).filter(|y| y.is_finite())?;
        Some(ChartPoint {
            x: point.value,
            y,
            tip: format!(
                "no strategy is above {}{unit} at {}",
                rounded_up(y, 2),
                point.value
            ),
            ..ChartPoint::default()
        })
    };
    bounds.filter_map(point).collect()
}

/// The axis of the swept values, and how points over it are drawn.
fn across(report: &SweepReport) -> (ChartAxis, PointStyle) {
    let values = || report.points.iter().map(|point| point.value);
    let counts = report.sweep == "robots";
    let mut x = if counts {
        // Robots come in whole numbers.
        let first = values().fold(f64::INFINITY, f64::min);
        ChartAxis::counted(axis_title(report), first, values().fold(first, f64::max))
    } else {
        ChartAxis::around(axis_title(report), values(), false)
    };
    let count = report.points.len() / report.limits.len().max(1);
    let style = if count > MOST_BARS {
        PointStyle::Area
    } else {
        PointStyle::Line
    };
    if let ChartAxis::Numbers {
        low, high, step, ..
    } = &mut x
        && style == PointStyle::Line
        && !counts
    {
        // So that no interval is drawn on the axis.
        (*low, *high) = (*low - 0.3 * *step, *high + 0.3 * *step);
    }
    (x, style)
}

/// How far each method's points are moved aside.
fn aside(report: &SweepReport, style: PointStyle) -> impl Fn(usize) -> f64 + use<> {
    let methods = report.limits.len();
    let next = report.points.get(methods).map(|point| point.value);
    let step = next.map_or(0.0, |next| next - report.points[0].value);
    let spread = match style {
        PointStyle::Line if report.patterns > 1 => SPREAD * step,
        _ => 0.0,
    };
    move |method| spread * ((method as f64 + 0.5) / methods as f64 - 0.5)
}

fn axis_title(report: &SweepReport) -> String {
    match (report.sweep, report.unit) {
        ("min-detection", _) => "lowest p_detection that is picked".into(),
        (name, "1") => format!("number of {name}"),
        ("speed", unit) => format!("belt speed [{unit}]"),
        ("spacing", unit) => format!("distance between neighbouring bases [{unit}]"),
        (name, unit) => format!("{name} [{unit}]"),
    }
}

/// How many of the patterns are picked completely, up to each value.
fn limits(report: &SweepReport) -> Option<Chart> {
    if report.helps || report.patterns < 2 {
        return None;
    }
    let (x, style) = across(report);
    let aside = aside(report, style);
    let mut values: Vec<f64> = report.points.iter().map(|point| point.value).collect();
    values.dedup();
    let layer = |j: usize| {
        let limit = &report.limits[j];
        let point = |&value: &f64| limit_point(report, limit, value).moved(aside(j));
        Layer::Points {
            ink: Ink::Series(j),
            style,
            points: values.iter().map(point).collect(),
        }
    };
    let mut legend = legend(report);
    legend.push(marks_entry(Ink::Faint, "95 % of the patterns"));
    Some(Chart {
        title: "Limits of single patterns".into(),
        caption: format!(
            "Share of the {} patterns of which everything is picked at every value up to this \
             one, with 95 % intervals: how the patterns' own limits are distributed.",
            report.patterns
        ),
        x,
        y: ChartAxis::around("patterns picked completely [%]", [0.0, 100.0], true),
        layers: (0..report.limits.len()).map(layer).collect(),
        marks: vec![ChartMark {
            at: 95.0,
            upright: false,
            ink: Ink::Faint,
            shade_to: None,
            label: String::new(),
        }],
        legend,
    })
}

/// How many of the patterns a method picks completely up to `value`.
fn limit_point(report: &SweepReport, limit: &LimitReport, value: f64) -> ChartPoint {
    let count = limit.all_of_patterns.len();
    let below = limit.all_of_patterns.partition_point(|own| *own < value);
    let complete = count - below;
    let percent = |share: f64| 100.0 * share;
    let y = percent(complete as f64 / count as f64);
    let interval = stats::share_interval(complete, count);
    let (low, high) = (percent(interval.low), percent(interval.high));
    ChartPoint {
        x: value,
        y,
        along: Some(Interval { low, high }),
        tip: format!(
            "{}: {complete} of {count} patterns picked completely up to {value} {}, {} %, \
             95 % interval {} to {} %",
            method_words(&limit.method),
            report.unit,
            fixed(y, 1),
            fixed(low, 1),
            fixed(high, 1)
        ),
        ..ChartPoint::default()
    }
}
