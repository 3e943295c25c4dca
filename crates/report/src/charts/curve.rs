//! The learning curve of a training run.

use super::chart::{Chart, ChartPoint, Ink, Layer, LegendLine, PointStyle, Swatch};
use super::curves::learning_chart;
use super::draw::for_paper;
use crate::provenance::Provenance;
use crate::table::fixed;
use pickline::rl::Curve;

/// `curve` as an SVG file.
pub(crate) fn curve_chart(curve: &Curve, made: &Provenance) -> String {
    for_paper(chart(curve), Some(made))
}

fn chart(curve: &Curve) -> Chart {
    let mut layers = Vec::new();
    let mut legend = Vec::new();
    let mut all = Vec::new();
    for (j, station) in curve.stations.iter().enumerate() {
        let point = |point: &pickline::rl::CurvePoint| {
            let y = 100.0 * point.shares[j];
            all.push(y);
            ChartPoint {
                x: point.decisions as f64 / 1000.0,
                y,
                tip: format!(
                    "{station} after {} decisions: {} %",
                    point.decisions,
                    fixed(y, 1)
                ),
                ..ChartPoint::default()
            }
        };
        layers.push(Layer::Points {
            ink: Ink::Series(j),
            style: PointStyle::Line,
            points: curve.points.iter().map(point).collect(),
        });
        legend.push(LegendLine {
            label: format!(
                "{station} ([SPT; FIFO]: {} %)",
                fixed(100.0 * curve.robust[j], 1)
            ),
            ink: Ink::Series(j),
            swatch: Swatch::Line,
        });
    }
    let learned = curve.points.iter().map(|point| point.decisions as f64);
    let title = "Learning curve";
    let caption = "Mean picking rate on the built-in cases of each station, as a share of \
                   that of the best rules for every single pattern (greedy GT, game theory), under \
                   seeds that no training sees.";
    learning_chart(title, caption, learned, all, layers, legend)
}
