//! A chart as data, without pixels and colours.

use super::draw;
use crate::provenance::Provenance;
use pickline::error::{Error, Result, known_names, shown};

/// A kind of chart for a report `R`; the first of a report's kinds is its main chart.
#[derive(Debug)]
pub struct ChartKind<R> {
    /// The name after `--chart`.
    pub name: &'static str,
    /// Makes the chart; `None` if the report lacks the data.
    pub(crate) chart: fn(&R) -> Option<Chart>,
    /// What the report needs for this chart, in words.
    pub needs: &'static str,
}

impl<R> ChartKind<R> {
    /// The kind with this name; the first if there is none.
    ///
    /// # Errors
    /// The name is unknown; the message suggests the nearest known one.
    pub fn named<'a>(kinds: &'a [Self], name: Option<&str>) -> Result<&'a Self> {
        let wanted = name.unwrap_or(kinds[0].name);
        let found = kinds.iter().find(|kind| kind.name == wanted);
        found.ok_or_else(|| {
            let names: Vec<&str> = kinds.iter().map(|kind| kind.name).collect();
            Error::input(
                "--chart",
                format!("this report has no chart `{}`", shown(wanted)),
                known_names(wanted, &names),
            )
        })
    }

    /// The error for a report that lacks the data for this chart.
    pub fn missing(&self) -> Error {
        Error::input(
            "--chart",
            format!("there is no data for the chart `{}`", self.name),
            format!("it needs {}", self.needs),
        )
    }

    /// The chart of `report` as an SVG file for a paper.
    ///
    /// # Errors
    /// The report lacks the data for this chart.
    pub fn svg(&self, report: &R, made: &Provenance) -> Result<String> {
        let chart = (self.chart)(report).ok_or_else(|| self.missing())?;
        Ok(draw::for_paper(&chart, made))
    }
}

/// A chart.
#[derive(Debug)]
pub(crate) struct Chart {
    /// A short title.
    pub title: String,
    /// What a reader must know to understand the chart.
    pub caption: String,
    /// The horizontal axis.
    pub x: Scale,
    /// The vertical axis, upwards; for names, downwards.
    pub y: Scale,
    /// What is drawn, in this order.
    pub layers: Vec<Layer>,
    /// Lines across the whole chart.
    pub marks: Vec<Mark>,
    /// The meaning of the inks and shapes.
    pub legend: Vec<Entry>,
}

/// An axis.
#[derive(Debug)]
pub(crate) enum Scale {
    /// Numbers from `low` to `high`.
    Numbers {
        /// The measured quantity, with its unit in brackets.
        title: String,
        low: f64,
        high: f64,
        /// Distance between two ticks.
        step: f64,
    },
    /// Names; the first is at 0, the next at 1.
    Names(Vec<String>),
}

impl Scale {
    /// An axis with round ends that includes all `values`, and 0 if `from_zero`. Values that
    /// are not finite are ignored.
    pub fn around(
        title: impl Into<String>,
        values: impl IntoIterator<Item = f64>,
        from_zero: bool,
    ) -> Self {
        let start = if from_zero {
            (0.0, 0.0)
        } else {
            (f64::INFINITY, f64::NEG_INFINITY)
        };
        let finite = values.into_iter().filter(|value| value.is_finite());
        let (low, high) = finite.fold(start, |(low, high), v| (v.min(low), v.max(high)));
        // No values, or a single one, still need an axis around them.
        let (low, high) = match (low < high, low.is_finite()) {
            (true, _) => (low, high),
            (false, true) => {
                let room = if low == 0.0 { 1.0 } else { 0.1 * low.abs() };
                (low - room, low + room)
            }
            (false, false) => (0.0, 1.0),
        };
        let step = round_step((high - low) / 6.0);
        Self::Numbers {
            title: title.into(),
            low: (low / step + 1e-9).floor() * step,
            high: (high / step - 1e-9).ceil() * step,
            step,
        }
    }

    /// An axis of whole numbers from `first` to `last`, such as robots or places. Its ticks are
    /// whole numbers as well, none below `first`.
    pub fn counted(title: impl Into<String>, first: f64, last: f64) -> Self {
        let step = round_step(((last - first) / 15.0).max(1.0));
        Self::Numbers {
            title: title.into(),
            low: first - 0.5,
            high: last + 0.5,
            step,
        }
    }

    /// Whether the axis does not include 0, so that lengths along it cannot be compared. Such
    /// an axis is drawn with a break.
    pub fn is_cut(&self) -> bool {
        match self {
            Self::Numbers { low, high, .. } => *low > 0.0 || *high < 0.0,
            Self::Names(_) => false,
        }
    }

    /// The same axis, ending at `end` at most.
    pub fn up_to(mut self, end: f64) -> Self {
        if let Self::Numbers { high, .. } = &mut self {
            *high = high.min(end);
        }
        self
    }
}

/// The smallest of 1, 2 and 5 times a power of ten that is at least `least`.
fn round_step(least: f64) -> f64 {
    let power = 10f64.powf(least.log10().floor());
    let factor = [1.0, 2.0, 5.0].into_iter();
    let steps = factor.map(|factor| factor * power);
    steps
        .into_iter()
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

/// Something drawn inside the axes.
#[derive(Debug)]
pub(crate) enum Layer {
    /// Horizontal bars, side by side within each name of the y axis.
    Bars(Vec<Vec<Bar>>),
    /// Points with their intervals.
    Points {
        ink: Ink,
        style: Style,
        points: Vec<Point>,
    },
}

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Style {
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

/// A bar.
#[derive(Debug)]
pub(crate) struct Bar {
    pub value: f64,
    /// The value as printed at the right end of the bar's row.
    pub words: String,
    pub ink: Ink,
    /// Shown when the pointer rests on it.
    pub tip: String,
}

/// A point.
#[derive(Debug, Default)]
pub(crate) struct Point {
    pub x: f64,
    pub y: f64,
    /// Its interval along x, if there is one.
    pub across: Option<(f64, f64)>,
    /// Its interval along y, if there is one.
    pub along: Option<(f64, f64)>,
    /// Shown when the pointer rests on it; nothing if empty.
    pub tip: String,
}

/// A line from edge to edge.
#[derive(Debug)]
pub(crate) struct Mark {
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
pub(crate) struct Entry {
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
    pub fn note(&self) -> String {
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
}

/// `text` cut to at most `most` characters.
pub(crate) fn short(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    let kept: String = text.chars().take(most - 1).collect();
    format!("{}\u{2026}", kept.trim_end())
}

/// Position of the `i`-th of `count` side-by-side series relative to a name of the y axis; the
/// first is uppermost.
pub(crate) fn beside(i: usize, count: usize) -> f64 {
    GROUP * ((i as f64 + 0.5) / count as f64 - 0.5)
}

/// Share of a name's space that its series occupy.
pub(crate) const GROUP: f64 = 0.78;

#[cfg(test)]
mod tests {
    use super::*;

    fn ends(values: &[f64], from_zero: bool) -> (f64, f64, f64) {
        match Scale::around("", values.iter().copied(), from_zero) {
            Scale::Numbers {
                low, high, step, ..
            } => (low, high, step),
            Scale::Names(_) => unreachable!(),
        }
    }

    #[test]
    fn axes_have_round_ends_around_their_values() {
        let near = |(low, high, step): (f64, f64, f64), expected: [f64; 3]| {
            for (a, b) in [low, high, step].into_iter().zip(expected) {
                assert!(
                    (a - b).abs() < 1e-9,
                    "{low} to {high} by {step}: {expected:?}"
                );
            }
        };
        near(ends(&[28.3, 31.1], true), [0.0, 40.0, 10.0]);
        near(ends(&[-0.2, 0.9], false), [-0.2, 1.0, 0.2]);
        near(ends(&[3.0], false), [2.7, 3.3, 0.1]);
        near(ends(&[0.0], false), [-1.0, 1.0, 0.5]);
        near(ends(&[], false), [0.0, 1.0, 0.2]);
        near(ends(&[1.0, f64::INFINITY, 2.0], false), [1.0, 2.0, 0.2]);
    }

    #[test]
    fn axes_of_counts_have_whole_ticks_from_the_first() {
        for (first, last, expected) in [
            (1.0, 3.0, 1.0),
            (1.0, 1.0, 1.0),
            (1.0, 14.0, 1.0),
            (2.0, 25.0, 2.0),
        ] {
            let axis = Scale::counted("", first, last);
            let Scale::Numbers { low, step, .. } = axis else {
                unreachable!()
            };
            assert_eq!(step, expected);
            // The tick below the first would be outside.
            assert!(low > first - 1.0 && low < first);
            assert!(Scale::counted("", 1.0, last).is_cut());
        }
        assert!(Scale::around("", [0.03, 0.05], false).is_cut());
        assert!(Scale::around("", [-3.0, -1.0], false).is_cut());
        assert!(!Scale::around("", [-1.0, 1.0], false).is_cut());
        assert!(!Scale::around("", [3.0], true).is_cut());
    }

    #[test]
    fn long_names_are_cut_between_characters() {
        assert_eq!(short("grid", 4), "grid");
        assert_eq!(short("gr\u{fc}n und blau", 6), "gr\u{fc}n\u{2026}");
    }

    #[test]
    fn unknown_charts_name_the_nearest() {
        let kinds = [ChartKind::<()> {
            name: "rate",
            chart: |()| None,
            needs: "nothing",
        }];
        assert_eq!(ChartKind::named(&kinds, None).unwrap().name, "rate");
        let message = ChartKind::named(&kinds, Some("rat"))
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("--chart") && message.contains("`rate`"),
            "{message}"
        );
    }
}
