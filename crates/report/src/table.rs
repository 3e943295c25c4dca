//! Tables for the terminal: plain characters, readable without colour.

use comfy_table::{Cell, CellAlignment, ContentArrangement};
use pickline::stats::Interval;

/// A table, built row by row.
#[derive(Debug)]
pub struct Table {
    table: comfy_table::Table,
}

impl Table {
    /// A table with this header. Columns whose header begins with `<` are left-aligned, all
    /// others right-aligned.
    pub fn new(header: &[&str]) -> Self {
        let mut table = comfy_table::Table::new();
        // Plain enough for any terminal, and still a table when pasted into Markdown.
        table.load_style(comfy_table::presets::ASCII_MARKDOWN);
        // One line per row whatever the terminal's width, so that equal runs give equal bytes.
        table.set_content_arrangement(ContentArrangement::Disabled);
        table.set_header(header.iter().map(|name| name.trim_start_matches('<')));
        for (i, name) in header.iter().enumerate() {
            if let Some(column) = table.column_mut(i) {
                column.set_cell_alignment(if name.starts_with('<') {
                    CellAlignment::Left
                } else {
                    CellAlignment::Right
                });
            }
        }
        Self { table }
    }

    /// Adds a row.
    pub fn row<T: Into<String>>(&mut self, cells: impl IntoIterator<Item = T>) {
        self.table
            .add_row(cells.into_iter().map(|cell| Cell::new(cell.into())));
    }

    /// The finished table, ending with a line break.
    pub fn render(&self) -> String {
        let text = self.table.to_string();
        let lines = text.lines().map(|line| format!("{}\n", line.trim_end()));
        lines.collect()
    }
}

/// A number with `digits` decimals, never `-0`; a dash for a share of nothing, which is not a number.
pub fn fixed(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "-".to_owned();
    }
    let text = format!("{value:.digits$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        _ => text,
    }
}

/// An interval with `digits` decimals; a dash for `None`.
pub(crate) fn interval(interval: Option<Interval>, digits: usize) -> String {
    interval.map_or("-".to_owned(), |Interval { low, high }| {
        format!("{} to {}", fixed(low, digits), fixed(high, digits))
    })
}

/// The name of a column of a CSV file: the figure in snake case, followed by its unit.
pub(crate) fn column(figure: &str, unit: &str) -> String {
    let suffix = match unit {
        "1/min" => "_per_min",
        "m/s" => "_m_per_s",
        "m" => "_m",
        "s" => "_s",
        _ => "",
    };
    format!("{figure}{suffix}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_negative_zero() {
        assert_eq!(fixed(-0.001, 2), "0.00");
        assert_eq!(fixed(-0.01, 2), "-0.01");
        assert_eq!(fixed(26.666, 1), "26.7");
    }

    #[test]
    fn columns_line_up() {
        let mut table = Table::new(&["<name", "n"]);
        table.row(["a", "1"]);
        table.row(["bc", "10"]);
        let text = table.render();
        assert_eq!(
            text,
            "| name |  n |\n|------|----|\n| a    |  1 |\n| bc   | 10 |\n"
        );
    }
}
