//! What the charts of a sweep have in common.

use super::report::{PointReport, SweepReport};
use crate::charts::{ChartMark, ChartPoint, Ink, Layer, LegendLine, Swatch};
use pickline::experiment::policy_title;
use pickline::stats::Interval;
use pickline::strategies::POLICY;

/// With more points than this, intervals are drawn as an area.
pub(super) const MOST_BARS: usize = 12;

pub(super) fn mark(at: f64, shade_to: Option<f64>, ink: Ink, label: String) -> ChartMark {
    ChartMark {
        at,
        upright: true,
        ink,
        shade_to,
        label,
    }
}

pub(super) fn marks_entry(ink: Ink, words: &str) -> LegendLine {
    LegendLine {
        label: words.into(),
        ink,
        swatch: Swatch::Mark,
    }
}

/// Everything that the vertical axis must include.
pub(super) fn heights(layer: &Layer) -> Vec<f64> {
    let Layer::Points { points, .. } = layer else {
        return Vec::new();
    };
    let point = |point: &ChartPoint| {
        let ends = point.along.unwrap_or(Interval::point(point.y));
        [point.y, ends.low, ends.high]
    };
    points.iter().flat_map(point).collect()
}

pub(super) fn legend(report: &SweepReport) -> Vec<LegendLine> {
    let methods = report.limits.len();
    let entry = |(j, first): (usize, &PointReport)| {
        // If each value is a line of its own, the assignment may differ along it.
        let mut own = report.points.iter().skip(j).step_by(methods);
        let label = if own.all(|point| point.title == first.title) {
            first.title.clone()
        } else {
            method_words(&first.method)
        };
        LegendLine {
            label,
            ink: Ink::Series(j),
            swatch: Swatch::Line,
        }
    };
    report
        .points
        .iter()
        .take(methods)
        .enumerate()
        .map(entry)
        .collect()
}

/// A method's name in files in readable form.
pub(super) fn method_words(id: &str) -> String {
    match id {
        "robust_gt" => "robust GT".into(),
        "greedy_gt" => "greedy GT".into(),
        POLICY => policy_title(),
        other => other.into(),
    }
}
