//! Tables of a page. Every figure names its field of the JSON report and carries its exact
//! value, so that a test or a reader's script can compare the two.

use super::html::escape;
use crate::columns::TableColumns;
use crate::table::fixed;
use crate::throughput::ThroughputReport;
use pickline::stats::Interval;
use std::fmt::Write as _;

/// What stands in a row of a table under one header.
#[derive(Debug, Clone)]
pub(crate) enum Cell {
    /// Words, left-aligned.
    Words(String),
    /// A figure, right-aligned.
    Figure(PageFigure),
    /// An interval, right-aligned.
    Interval(PageFigure, PageFigure),
    /// Text, right-aligned.
    Text(String),
}

/// A figure of the JSON report.
#[derive(Debug, Clone)]
pub(crate) struct PageFigure {
    /// Its path in the report, such as `cases.0.items`.
    path: String,
    value: f64,
    shown: String,
}

impl PageFigure {
    /// The figure at `path` with `digits` decimals.
    pub(crate) fn new(path: impl Into<String>, value: f64, digits: usize) -> Self {
        Self {
            path: path.into(),
            value,
            shown: fixed(value, digits),
        }
    }

    /// A share, shown as a percentage.
    pub(crate) fn percent(path: impl Into<String>, share: f64) -> Self {
        Self {
            shown: fixed(100.0 * share, 1),
            ..Self::new(path, share, 0)
        }
    }

    /// A figure shown with all its digits.
    pub(crate) fn exact(path: impl Into<String>, value: f64) -> Self {
        Self {
            shown: value.to_string(),
            ..Self::new(path, value, 0)
        }
    }

    /// The figure as an HTML element.
    pub(crate) fn html(&self) -> String {
        format!(
            "<data data-name=\"{}\" value=\"{}\">{}</data>",
            escape(&self.path),
            self.value,
            self.shown
        )
    }
}

impl From<PageFigure> for Cell {
    fn from(figure: PageFigure) -> Self {
        Self::Figure(figure)
    }
}

impl Cell {
    /// An empty cell.
    pub(crate) fn empty() -> Self {
        Self::Text(String::new())
    }

    /// The figure, or an empty cell.
    pub(crate) fn or_empty(figure: Option<PageFigure>) -> Self {
        figure.map_or_else(Self::empty, Self::Figure)
    }

    /// A figure, or a dash.
    pub(crate) fn or_dash(figure: Option<PageFigure>) -> Self {
        figure.map_or_else(|| Self::Text("\u{2013}".into()), Self::Figure)
    }

    /// The interval of the figures named `low` and `high`, or a dash for `None`; `figure` makes
    /// a figure from a name and a value.
    pub(crate) fn interval(
        (low, high): (&str, &str),
        interval: Option<Interval>,
        figure: impl Fn(&str, f64) -> PageFigure,
    ) -> Self {
        match interval {
            Some(ends) => Self::Interval(figure(low, ends.low), figure(high, ends.high)),
            None => Self::or_dash(None),
        }
    }

    fn html(&self) -> String {
        match self {
            Self::Words(words) => format!("<td class=\"words\">{}</td>", escape(words)),
            Self::Text(text) => format!("<td>{}</td>", escape(text)),
            // A share of nothing has no value, and is null in the report.
            Self::Figure(figure) if figure.value.is_nan() => "<td>\u{2013}</td>".into(),
            Self::Figure(figure) => format!("<td>{}</td>", figure.html()),
            Self::Interval(low, high) => format!("<td>{} to {}</td>", low.html(), high.html()),
        }
    }
}

/// A table of a page, as data.
#[derive(Debug)]
pub(crate) struct PageTable {
    /// The headers; those that begin with `<` are left-aligned.
    header: Vec<String>,
    /// The rows; `true` marks the beginning of a group.
    rows: Vec<(bool, Vec<Cell>)>,
}

impl<'c, R: 'c> TableColumns<'c, R, Cell> {
    /// The same with throughput, its interval and the flow if `steady`; `of` gives the throughput
    /// of a row and `path` the path of its figures.
    pub(crate) fn with_throughput(
        self,
        steady: bool,
        of: fn(&R) -> &ThroughputReport,
        path: fn(&R, &str) -> String,
    ) -> Self {
        let figure = move |row: &R, field: &str, value| PageFigure::new(path(row, field), value, 1);
        self.with_if(steady, "throughput [1/min]", move |row| {
            let throughput = of(row).throughput_per_min;
            Cell::or_dash(throughput.map(|value| figure(row, "throughput_per_min", value)))
        })
        .with_if(steady, "95 %", move |row| {
            let names = ("throughput_low", "throughput_high");
            Cell::interval(names, of(row).interval, |field, value| {
                figure(row, field, value)
            })
        })
        .with_if(steady, "flow [1/min]", move |row| {
            let flow = of(row).flow_per_min;
            Cell::or_dash(flow.map(|value| figure(row, "flow_per_min", value)))
        })
    }
}

impl PageTable {
    /// The table of `rows`; `true` marks the beginning of a group.
    pub(crate) fn of<R>(
        columns: &TableColumns<R, Cell>,
        rows: impl IntoIterator<Item = (bool, R)>,
    ) -> Self {
        let rows = rows.into_iter();
        Self {
            header: columns.headers(),
            rows: rows
                .map(|(first, row)| (first, columns.cells(&row)))
                .collect(),
        }
    }

    /// As an HTML element that scrolls if it is too wide.
    pub(crate) fn html(&self) -> String {
        let mut text = "<div class=\"scroll\"><table>\n<thead><tr>".to_owned();
        for name in &self.header {
            // Writing to a string cannot fail.
            let _ = match name.strip_prefix('<') {
                Some(name) => write!(text, "<th class=\"words\">{}</th>", escape(name)),
                None => write!(text, "<th>{}</th>", escape(name)),
            };
        }
        text += "</tr></thead>\n<tbody>\n";
        for (first, row) in &self.rows {
            text += if *first {
                "<tr class=\"group\">"
            } else {
                "<tr>"
            };
            text.extend(row.iter().map(Cell::html));
            text += "</tr>\n";
        }
        text + "</tbody>\n</table></div>\n"
    }
}
