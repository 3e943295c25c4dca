//! The charts of a search.

use super::objective::bracketed;
use super::report::{OptimumReport, RankedReport};
use super::validation::ValidationReport;
use crate::charts::{
    Chart, ChartAxis, ChartKind, ChartMark, ChartPoint, Ink, Layer, LegendLine, PointStyle, Swatch,
};
use crate::table::{fixed, interval};
use pickline::stats::Interval;

/// The charts of a search, the main one first.
pub(super) const CHARTS: &[ChartKind<OptimumReport>] = &[
    ChartKind {
        name: "difference",
        chart: difference,
        needs: "nothing",
    },
    ChartKind {
        name: "spread",
        chart: spread,
        needs: "nothing",
    },
    ChartKind {
        name: "ranking",
        chart: ranking,
        needs: "nothing",
    },
];

/// Maximum number of lines of the ranking that a chart names.
const MOST_NAMES: usize = 20;

/// Maximum number of points of a line, and of points with markers.
const MOST_POINTS: usize = 600;
const MOST_MARKERS: usize = 120;

fn named(report: &OptimumReport) -> &[RankedReport] {
    &report.ranking[..report.ranking.len().min(MOST_NAMES)]
}

fn names(report: &OptimumReport) -> ChartAxis {
    let names = named(report).iter().map(|line| bracketed(&line.assignment));
    ChartAxis::Names(names.collect())
}

/// `what` with the objective's unit in brackets.
fn titled(report: &OptimumReport, what: &str) -> String {
    match report.unit {
        "1" => format!("{what} [1]"),
        unit => format!("{what} [{unit}]"),
    }
}

/// The objective under the chosen risk, in words.
fn value_words(report: &OptimumReport) -> String {
    format!("{} {}", report.risk, report.objective.replace('-', " "))
}

/// The assignments by how they stand to the best, and what the legend calls them.
const GROUPS: [(Ink, &str); 3] = [
    (Ink::Series(0), "the best"),
    (
        Ink::Series(1),
        "tied with the best: the interval contains 0",
    ),
    (Ink::Faint, "proven below the best: the interval excludes 0"),
];

/// The place in [`GROUPS`] of the `i`-th assignment of the ranking.
fn group_of(i: usize, line: &RankedReport) -> usize {
    match (i, line.tied) {
        (0, _) => 0,
        (_, true) => 1,
        (_, false) => 2,
    }
}

/// How far each assignment is proven to be below the best.
fn difference(report: &OptimumReport) -> Option<Chart> {
    let best = report.ranking.first()?;
    let digits = report.format().digits();
    let mut layers = Vec::new();
    let mut legend = Vec::new();
    let mut ends = vec![0.0];
    for (group, (ink, label)) in GROUPS.into_iter().enumerate() {
        let lines = named(report).iter().enumerate();
        let lines = lines.filter(|(i, line)| group_of(*i, line) == group);
        let points: Vec<ChartPoint> = lines
            .map(|(i, line)| {
                let x = best.value - line.value;
                let own = line.difference.unwrap_or(Interval::point(x));
                ends.extend([own.low, own.high]);
                below_best(line, i, x, digits)
            })
            .collect();
        if points.is_empty() {
            continue;
        }
        legend.push(LegendLine {
            label: label.into(),
            ink,
            swatch: Swatch::Dot,
        });
        layers.push(Layer::Points {
            ink,
            style: PointStyle::Dots,
            points,
        });
    }
    Some(Chart {
        title: format!("How far below {}", bracketed(&best.assignment)),
        caption: format!(
            "{} of the best minus that of each assignment on the same {} patterns, with 95 % \
             intervals ({}). {}",
            capital(&value_words(report)),
            report.patterns,
            report.intervals,
            shown(report)
        ),
        x: ChartAxis::around(
            titled(report, &format!("best minus this, {}", value_words(report))),
            ends,
            false,
        ),
        y: names(report),
        layers,
        marks: vec![ChartMark {
            at: 0.0,
            upright: true,
            ink: Ink::Series(0),
            shade_to: None,
            label: String::new(),
        }],
        legend,
    })
}

/// The `i`-th assignment of the ranking at its distance `x` from the best.
fn below_best(line: &RankedReport, i: usize, x: f64, digits: usize) -> ChartPoint {
    let own = line.difference;
    let words = own.map_or(String::new(), |own| {
        format!(", 95 % interval {}", interval(Some(own), digits))
    });
    ChartPoint {
        x,
        y: i as f64,
        across: own.filter(|_| i > 0),
        tip: format!(
            "{}: {} below the best{words}",
            bracketed(&line.assignment),
            fixed(x, digits),
        ),
        ..ChartPoint::default()
    }
}

/// Mean and worst pattern of each assignment, and the best one on fresh patterns.
fn spread(report: &OptimumReport) -> Option<Chart> {
    let lines = named(report);
    let mut all: Vec<f64> = lines
        .iter()
        .flat_map(|line| [line.mean, line.worst])
        .collect();
    let mut layers = vec![
        figure_layer(report, Ink::Series(0), "mean", |line| line.mean),
        figure_layer(report, Ink::Series(1), "worst pattern", |line| line.worst),
    ];
    let entry = |label: &str, ink| LegendLine {
        label: label.into(),
        ink,
        swatch: Swatch::Dot,
    };
    let mut legend = vec![
        entry("mean over the patterns", Ink::Series(0)),
        entry("on the worst pattern", Ink::Series(1)),
    ];
    if let Some(validation) = &report.validation {
        let ends = validation.mean_interval;
        all.push(validation.mean);
        all.extend(ends.iter().flat_map(|ends| [ends.low, ends.high]));
        layers.push(Layer::Points {
            ink: Ink::Text,
            style: PointStyle::Dots,
            points: vec![fresh_mean(report, validation)],
        });
        legend.push(entry("mean on fresh patterns, 95 %", Ink::Text));
    }
    Some(Chart {
        title: "Mean and worst pattern".into(),
        caption: format!(
            "The {} of each assignment on {} patterns. {}",
            report.objective.replace('-', " "),
            report.patterns,
            shown(report)
        ),
        x: ChartAxis::around(
            titled(report, &report.objective.replace('-', " ")),
            all,
            false,
        ),
        y: names(report),
        layers,
        marks: Vec::new(),
        legend,
    })
}

/// A figure of every assignment that is named.
fn figure_layer(
    report: &OptimumReport,
    ink: Ink,
    words: &str,
    of: fn(&RankedReport) -> f64,
) -> Layer {
    let digits = report.format().digits();
    let point = |(i, line): (usize, &RankedReport)| ChartPoint {
        x: of(line),
        y: i as f64,
        tip: format!(
            "{}: {words} {}",
            bracketed(&line.assignment),
            fixed(of(line), digits)
        ),
        ..ChartPoint::default()
    };
    Layer::Points {
        ink,
        style: PointStyle::Dots,
        points: named(report).iter().enumerate().map(point).collect(),
    }
}

/// The best assignment's mean on fresh patterns.
fn fresh_mean(report: &OptimumReport, validation: &ValidationReport) -> ChartPoint {
    let digits = report.format().digits();
    let ends = validation.mean_interval;
    let words = ends.map_or(String::new(), |ends| {
        format!(", 95 % interval {}", interval(Some(ends), digits))
    });
    ChartPoint {
        x: validation.mean,
        y: 0.0,
        across: ends,
        tip: format!(
            "{} on {} fresh patterns: mean {}{words}",
            bracketed(&report.best),
            validation.count,
            fixed(validation.mean, digits),
        ),
        ..ChartPoint::default()
    }
}

/// The figures of all assignments in order: how much the choice matters.
fn ranking(report: &OptimumReport) -> Option<Chart> {
    let mut values: Vec<(f64, &RankedReport)> = report
        .ranking
        .iter()
        .map(|line| (line.value, line))
        .collect();
    // Ordered by the figure itself: another figure may have broken ties.
    values.sort_by(|a, b| b.0.total_cmp(&a.0));
    // A picture has room for one point per pixel, so more would not show.
    let every = values.len().div_ceil(MOST_POINTS);
    let some = values.iter().enumerate().step_by(every);
    let points = some.map(|(i, (value, line))| ChartPoint {
        x: (i + 1) as f64,
        y: *value,
        tip: format!(
            "{}. {}: {}",
            i + 1,
            bracketed(&line.assignment),
            fixed(*value, report.format().digits())
        ),
        ..ChartPoint::default()
    });
    let x = ChartAxis::counted("place", 1.0, values.len() as f64);
    Some(Chart {
        title: "All assignments".into(),
        caption: format!(
            "{} of all {} assignments that were scored, the highest first: how much the choice \
             matters.",
            capital(&value_words(report)),
            values.len()
        ),
        x,
        y: ChartAxis::around(
            titled(report, &value_words(report)),
            values.iter().map(|(value, _)| *value),
            false,
        ),
        layers: vec![Layer::Points {
            ink: Ink::Series(0),
            style: match values.len() > MOST_MARKERS {
                true => PointStyle::Bare,
                false => PointStyle::Line,
            },
            points: points.collect(),
        }],
        marks: Vec::new(),
        legend: Vec::new(),
    })
}

/// How many of the assignments are named.
fn shown(report: &OptimumReport) -> String {
    match (named(report).len(), report.ranking.len()) {
        (shown, all) if shown < all => format!("The first {shown} of {all} assignments."),
        (_, all) => format!("All {all} assignments that were scored."),
    }
}

fn capital(text: &str) -> String {
    let mut characters = text.chars();
    match characters.next() {
        Some(first) => first.to_uppercase().chain(characters).collect(),
        None => String::new(),
    }
}
