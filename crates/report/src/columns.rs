//! Tables by column: a header and how its cells follow from a row stand in one place.

use crate::table::Table;

/// The columns of a table with rows `R` and cells `C`, from left to right.
pub(crate) struct TableColumns<'c, R, C> {
    columns: Vec<TableColumn<'c, R, C>>,
}

struct TableColumn<'c, R, C> {
    header: String,
    cell: Box<dyn Fn(&R) -> C + 'c>,
}

impl<'c, R, C> TableColumns<'c, R, C> {
    /// A table without columns yet.
    pub(crate) fn new() -> Self {
        Self {
            columns: Vec::new(),
        }
    }

    /// The same with one more column. If its header begins with `<`, it is left-aligned.
    pub(crate) fn with(mut self, header: impl Into<String>, cell: impl Fn(&R) -> C + 'c) -> Self {
        self.columns.push(TableColumn {
            header: header.into(),
            cell: Box::new(cell),
        });
        self
    }

    /// The same with one more column if `wanted`.
    pub(crate) fn with_if(
        self,
        wanted: bool,
        header: impl Into<String>,
        cell: impl Fn(&R) -> C + 'c,
    ) -> Self {
        match wanted {
            true => self.with(header, cell),
            false => self,
        }
    }

    /// The header of each column, from left to right.
    pub(crate) fn headers(&self) -> Vec<String> {
        let columns = self.columns.iter();
        columns.map(|column| column.header.clone()).collect()
    }

    /// The cells of a row.
    pub(crate) fn cells(&self, row: &R) -> Vec<C> {
        self.columns
            .iter()
            .map(|column| (column.cell)(row))
            .collect()
    }
}

impl<R> TableColumns<'_, R, String> {
    /// The table of `rows` for the terminal.
    pub(crate) fn table(&self, rows: impl IntoIterator<Item = R>) -> String {
        let headers = self.headers();
        let mut table = Table::new(&headers.iter().map(String::as_str).collect::<Vec<_>>());
        for row in rows {
            table.row(self.cells(&row));
        }
        table.render()
    }
}
