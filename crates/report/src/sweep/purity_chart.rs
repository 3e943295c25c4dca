//! The chart of a sweep of the threshold of detections: what each threshold gives and costs.

use super::chart_parts::{MOST_BARS, heights, legend, mark, marks_entry};
use super::report::{PointReport, SweepReport};
use crate::charts::{Chart, ChartAxis, ChartMark, ChartPoint, Ink, Layer, PointStyle, percent};
use pickline::stats::Interval;

/// Purity over recovery, one line per method through its thresholds.
pub(super) fn purity_chart(report: &SweepReport) -> Option<Chart> {
    if !report.is_of_thresholds() {
        return None;
    }
    let methods = report.limits.len();
    let few = report.points.len() / methods.max(1) <= MOST_BARS;
    let layer = |j: usize| {
        let of_method = report.points.iter().skip(j).step_by(methods);
        let points = of_method.filter_map(|point| purity_point(point, few));
        Layer::Points {
            ink: Ink::Series(j),
            style: PointStyle::Line,
            points: points.collect(),
        }
    };
    let layers: Vec<Layer> = (0..methods).map(layer).collect();
    let across = layers.iter().flat_map(|layer| match layer {
        Layer::Points { points, .. } => points.iter().map(|point| point.x).collect(),
        Layer::Bars(_) => Vec::new(),
    });
    let across: Vec<f64> = across.collect();
    let wanted = report.thresholds.as_ref().map(|chosen| chosen.purity);
    let wanted = wanted.map(|purity| 100.0 * purity);
    let up: Vec<f64> = layers.iter().flat_map(heights).chain(wanted).collect();
    let mut chart = Chart {
        title: "Purity and recovery".into(),
        caption: format!(
            "Each point is a threshold of detections; a line joins them in order, the lowest first. \
             All items of {} together{}.",
            match report.patterns {
                1 => "the pattern".to_owned(),
                patterns => format!("{patterns} patterns"),
            },
            match few && report.patterns > 1 {
                true => ", with 95 % intervals",
                false => "",
            }
        ),
        x: ChartAxis::around("recovery [%]", across, false).up_to(100.0),
        y: ChartAxis::around("purity [%]", up, false).up_to(100.0),
        layers,
        marks: Vec::new(),
        legend: legend(report),
    };
    add_chosen(report, &mut chart);
    Some(chart)
}

/// A threshold of a method; without its intervals if they would merge.
fn purity_point(point: &PointReport, with_intervals: bool) -> Option<ChartPoint> {
    let total = &point.sorting.as_ref()?.total;
    let (purity, recovery) = (total.content.purity?, total.content.recovery?);
    let ends = |ends: Option<Interval>| ends.filter(|_| with_intervals).map(percent);
    Some(ChartPoint {
        x: 100.0 * recovery,
        y: 100.0 * purity,
        across: ends(total.recovery_interval),
        along: ends(total.purity_interval),
        tip: format!("{} at {}: {}", point.title, point.value, total.words()),
    })
}

/// The wanted purity and the chosen thresholds.
fn add_chosen(report: &SweepReport, chart: &mut Chart) {
    let Some(thresholds) = &report.thresholds else {
        return;
    };
    chart.marks.push(ChartMark {
        at: 100.0 * thresholds.purity,
        upright: false,
        ink: Ink::Faint,
        shade_to: None,
        label: String::new(),
    });
    chart.legend.push(marks_entry(Ink::Faint, "wanted purity"));
    let mut is_chosen = false;
    for (j, method) in thresholds.methods.iter().enumerate() {
        let recovery = method.fresh.and_then(|fresh| fresh.content.recovery);
        if let Some((threshold, recovery)) = method.threshold.zip(recovery) {
            is_chosen = true;
            let at = 100.0 * recovery;
            let label = threshold.to_string();
            chart.marks.push(mark(at, None, Ink::Series(j), label));
        }
    }
    if is_chosen {
        chart.caption += " Dashed upright lines: the thresholds that are chosen on other patterns.";
        chart
            .legend
            .push(marks_entry(Ink::Text, "chosen threshold"));
    }
}
