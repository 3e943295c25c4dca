//! A chart as data, without pixels and colours.

use super::axis::ChartAxis;
use crate::game_theory::spell_out;
use pickline::stats::Interval;

/// A chart as it will be drawn: axes, layers and legend.
#[derive(Debug)]
pub(crate) struct Chart {
    /// A short title.
    pub title: String,
    /// What a reader must know to understand the chart.
    pub caption: String,
    /// The horizontal axis.
    pub x: ChartAxis,
    /// The vertical axis, upwards; for names, downwards.
    pub y: ChartAxis,
    /// What is drawn, in this order.
    pub layers: Vec<Layer>,
    /// Lines across the whole chart.
    pub marks: Vec<ChartMark>,
    /// The meaning of the inks and shapes.
    pub legend: Vec<LegendLine>,
}

/// Something drawn inside the axes.
#[derive(Debug)]
pub(crate) enum Layer {
    /// Horizontal bars, side by side within each name of the y axis.
    Bars(Vec<Vec<ChartBar>>),
    /// Points with their intervals.
    Points {
        ink: Ink,
        style: PointStyle,
        points: Vec<ChartPoint>,
    },
}

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PointStyle {
    /// A marker and an interval for each point.
    Dots,
    /// Intervals only, for points that are already shown.
    Intervals,
    /// Markers and intervals, connected by a line.
    Line,
    /// The same with the intervals along y as one area.
    Area,
    /// A line only.
    Bare,
}

/// A horizontal bar as long as `value`.
#[derive(Debug)]
pub(crate) struct ChartBar {
    pub value: f64,
    /// The value as printed at the right end of the bar's row.
    pub words: String,
    pub ink: Ink,
    /// Shown when the pointer rests on it.
    pub tip: String,
}

/// A point of a series, with its intervals.
#[derive(Debug, Default)]
pub(crate) struct ChartPoint {
    pub x: f64,
    pub y: f64,
    /// Its interval along x, if there is one.
    pub across: Option<Interval>,
    /// Its interval along y, if there is one.
    pub along: Option<Interval>,
    /// Shown when the pointer rests on it; nothing if empty.
    pub tip: String,
}

impl ChartPoint {
    /// The same point, moved to the right.
    pub(crate) fn moved(self, by: f64) -> Self {
        Self {
            x: self.x + by,
            ..self
        }
    }
}

/// A line from edge to edge.
#[derive(Debug)]
pub(crate) struct ChartMark {
    /// Position on the x axis if upright, otherwise on the y axis.
    pub at: f64,
    pub upright: bool,
    pub ink: Ink,
    /// The area from the line to here is shaded.
    pub shade_to: Option<f64>,
    /// Printed above an upright line.
    pub label: String,
}

/// A line of the legend.
#[derive(Debug)]
pub(crate) struct LegendLine {
    pub label: String,
    pub ink: Ink,
    pub swatch: Swatch,
}

/// The sign before the words of a legend entry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Swatch {
    Bar,
    /// A marker with its interval.
    Dot,
    /// A line with its marker.
    Line,
    /// A line only.
    Bare,
    /// A dashed line from edge to edge.
    Mark,
}

/// What something is drawn with; the look defines its colour and shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ink {
    /// The n-th series.
    Series(usize),
    /// The colour of the text, for what is not a series.
    Text,
    /// Less prominent than the rest.
    Faint,
}

impl Chart {
    /// The caption, with remarks that the axes require.
    pub(crate) fn note(&self) -> String {
        let cut = [&self.x, &self.y]
            .iter()
            .filter(|scale| scale.is_cut())
            .count();
        let cut = match cut {
            0 => "",
            1 => " The axis with a break does not begin at 0.",
            _ => " Axes with a break do not begin at 0.",
        };
        format!("{}{cut}", self.caption)
    }

    /// Spells out "GT" at its first place in the order of reading.
    pub(crate) fn spell_out_gt(&mut self) {
        let axis = match &mut self.y {
            ChartAxis::Numbers { title, .. } => Some(title),
            ChartAxis::Names(_) => None,
        };
        let legend = self.legend.iter_mut().map(|line| &mut line.label);
        let mut texts = std::iter::once(&mut self.title).chain(axis).chain(legend);
        texts.any(spell_out);
    }
}

/// Position of the `i`-th of `count` side-by-side series relative to a name of the y axis; the
/// first is uppermost.
pub(crate) fn beside(i: usize, count: usize) -> f64 {
    GROUP * ((i as f64 + 0.5) / count as f64 - 0.5)
}

/// Share of a name's space that its series occupy.
pub(crate) const GROUP: f64 = 0.78;
