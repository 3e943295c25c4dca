//! Tables of a page. Every figure says which field of the JSON report it is and carries
//! its exact value, so that a test, or a reader's script, can hold the two together.

use super::html::escape;
use crate::table::fixed;
use crate::throughput::ThroughputReport;
use std::fmt::Write as _;

/// A cell.
#[derive(Debug)]
pub(super) enum Cell {
    /// Words, flush left.
    Words(String),
    /// A figure, flush right.
    Figure(Figure),
    /// An interval, flush right.
    Interval(Figure, Figure),
    /// Text, flush right.
    Text(String),
}

/// A figure of the JSON report.
#[derive(Debug)]
pub(super) struct Figure {
    /// Where in the report it stands, as `cases.0.items`.
    path: String,
    value: f64,
    shown: String,
}

impl Figure {
    /// The figure at `path` with so many digits behind the point.
    pub fn new(path: impl Into<String>, value: f64, digits: usize) -> Self {
        Self {
            path: path.into(),
            value,
            shown: fixed(value, digits),
        }
    }

    /// A share, shown in percent.
    pub fn percent(path: impl Into<String>, share: f64) -> Self {
        Self {
            shown: fixed(100.0 * share, 1),
            ..Self::new(path, share, 0)
        }
    }

    /// A figure shown with all its digits.
    pub fn exact(path: impl Into<String>, value: f64) -> Self {
        Self {
            shown: value.to_string(),
            ..Self::new(path, value, 0)
        }
    }

    /// As an element.
    pub fn html(&self) -> String {
        format!(
            "<data data-name=\"{}\" value=\"{}\">{}</data>",
            escape(&self.path),
            self.value,
            self.shown
        )
    }
}

impl From<Figure> for Cell {
    fn from(figure: Figure) -> Self {
        Self::Figure(figure)
    }
}

impl Cell {
    /// An empty cell.
    pub fn empty() -> Self {
        Self::Text(String::new())
    }

    /// The figure, or an empty cell.
    pub fn or_empty(figure: Option<Figure>) -> Self {
        figure.map_or_else(Self::empty, Self::Figure)
    }

    /// The headers of [`Cell::throughput`].
    pub const THROUGHPUT: [&'static str; 3] = ["throughput [1/min]", "95 %", "flow [1/min]"];

    /// Throughput, its interval and the flow, at `path`; a dash for what there is not.
    pub fn throughput(of: &ThroughputReport, path: &dyn Fn(&str) -> String) -> Vec<Self> {
        let figure = |field: &str, value| Figure::new(path(field), value, 1);
        let or_dash = |field: &str, value: Option<f64>| match value {
            Some(value) => figure(field, value).into(),
            None => Self::Text("\u{2013}".into()),
        };
        vec![
            or_dash("throughput_per_min", of.throughput_per_min),
            Self::interval(("throughput_low", "throughput_high"), of.ends(), figure),
            or_dash("flow_per_min", of.flow_per_min),
        ]
    }

    /// The interval from figures that are named `low` and `high`, or a dash where there is
    /// none; `figure` makes a figure of a name and a value.
    pub fn interval(
        (low, high): (&str, &str),
        ends: Option<(f64, f64)>,
        figure: impl Fn(&str, f64) -> Figure,
    ) -> Self {
        match ends {
            Some(ends) => Self::Interval(figure(low, ends.0), figure(high, ends.1)),
            None => Self::Text("\u{2013}".into()),
        }
    }

    fn html(&self) -> String {
        match self {
            Self::Words(words) => format!("<td class=\"words\">{}</td>", escape(words)),
            Self::Text(text) => format!("<td>{}</td>", escape(text)),
            Self::Figure(figure) => format!("<td>{}</td>", figure.html()),
            Self::Interval(low, high) => format!("<td>{} to {}</td>", low.html(), high.html()),
        }
    }
}

/// A table.
#[derive(Debug)]
pub(super) struct PageTable {
    /// Those that begin with `<` stand flush left.
    pub header: Vec<String>,
    /// Its rows; `true` where a new group begins.
    pub rows: Vec<(bool, Vec<Cell>)>,
}

impl PageTable {
    /// As an element, which scrolls where it is too wide.
    pub fn html(&self) -> String {
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
