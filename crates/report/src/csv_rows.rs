//! Tables whose rows are structs: the names of the fields are the header. As CSV files, and column by
//! column.

use crate::cells::{Cell, cells};
use crate::provenance::Provenance;
use pickline::files::csv_text;
use pickline::stats::Interval;
use serde::{Serialize, Serializer};
use std::iter;

/// A number, or an empty field if there is none: a share of nothing has no value.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Displayed(pub f64);

impl Serialize for Displayed {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0.is_nan() {
            true => serializer.serialize_none(),
            false => serializer.serialize_f64(self.0),
        }
    }
}

/// A number, or an empty field.
pub(crate) type OptionalNumber = Option<Displayed>;

/// The lower end of an interval, or an empty field.
pub(crate) fn low(interval: Option<Interval>) -> OptionalNumber {
    interval.map(|interval| Displayed(interval.low))
}

/// The upper end of an interval, or an empty field.
pub(crate) fn high(interval: Option<Interval>) -> OptionalNumber {
    interval.map(|interval| Displayed(interval.high))
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Column {
    /// What it is called wherever the table occurs: `value` in every sweep.
    pub field: &'static str,
    /// Its name in the CSV file, which may say what is varied and in which unit:
    /// `belt_speed_m_per_s`.
    pub name: String,
    /// Its values, from top to bottom.
    pub values: ColumnValues,
}

/// The values of a column.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum ColumnValues {
    /// Yes or no.
    Flags(Vec<bool>),
    /// Numbers of things, and seeds.
    Counts(Vec<u64>),
    /// Numbers, NaN where the CSV file has an empty field.
    Numbers(Vec<f64>),
    /// Texts, empty where the CSV file has an empty field.
    Texts(Vec<String>),
}

impl ColumnValues {
    /// The values of `cells`; `usual` is that of a row without values.
    fn of(usual: &Cell, cells: &[&Cell]) -> Self {
        let is_empty = |cell: &&Cell| matches!(cell, Cell::Empty);
        let given = cells.iter().copied().find(|cell| !is_empty(cell));
        match if is_empty(&usual) { given } else { Some(usual) } {
            Some(Cell::Text(_)) => Self::Texts(cells.iter().map(ToString::to_string).collect()),
            Some(Cell::Flag(_)) => {
                let flag = |cell: &&Cell| matches!(cell, Cell::Flag(true));
                Self::Flags(cells.iter().map(flag).collect())
            }
            Some(Cell::Count(_)) if !cells.iter().any(is_empty) => {
                let count = |cell: &&Cell| match cell {
                    Cell::Count(count) => Some(*count),
                    _ => None,
                };
                Self::Counts(cells.iter().filter_map(count).collect())
            }
            _ => {
                let number = |cell: &&Cell| match cell {
                    Cell::Number(number) => *number,
                    Cell::Count(count) => *count as f64,
                    _ => f64::NAN,
                };
                Self::Numbers(cells.iter().map(number).collect())
            }
        }
    }
}

/// A table: what its columns are called, and its rows.
#[derive(Debug)]
pub(crate) struct CsvRows {
    /// Each column's field and name.
    header: Vec<(&'static str, String)>,
    rows: Vec<Vec<Cell>>,
    /// The cells of a row without values, which tell the kind of each column.
    template: Vec<Cell>,
}

impl CsvRows {
    /// A table of `rows`, which are structs or tuples of structs. It has its header even without
    /// any row.
    pub(crate) fn of<R: Serialize + Default>(rows: impl IntoIterator<Item = R>) -> Self {
        Self::like(&R::default(), rows)
    }

    /// The same for rows whose number of columns is not part of their type; `template` has as
    /// many as each of `rows`.
    pub(crate) fn like<R: Serialize>(template: &R, rows: impl IntoIterator<Item = R>) -> Self {
        let (fields, template): (Vec<_>, Vec<_>) = cells(template).into_iter().unzip();
        let values = |row| cells(&row).into_iter().map(|(_, cell)| cell).collect();
        Self {
            header: fields
                .iter()
                .map(|field| (*field, (*field).to_owned()))
                .collect(),
            rows: rows.into_iter().map(values).collect(),
            template,
        }
    }

    /// The same with other names of columns.
    pub(crate) fn renamed(mut self, mut name: impl FnMut(&str) -> String) -> Self {
        for (_, named) in &mut self.header {
            *named = name(named);
        }
        self
    }

    /// The same without the columns that `omitted` names.
    pub(crate) fn without(self, omitted: &[&str]) -> Self {
        let names = self.header.iter();
        let kept: Vec<bool> = names
            .map(|(_, name)| !omitted.contains(&name.as_str()))
            .collect();
        self.only(&kept)
    }

    /// The same without columns that are empty in every row, if there are rows.
    pub(crate) fn without_empty(self) -> Self {
        let is_empty = |cell: &Cell| match cell {
            Cell::Empty => true,
            Cell::Text(text) => text.is_empty(),
            _ => false,
        };
        let given = |column: usize| {
            let mut fields = self.rows.iter().filter_map(|row| row.get(column));
            self.rows.is_empty() || fields.any(|field| !is_empty(field))
        };
        let kept: Vec<bool> = (0..self.header.len()).map(given).collect();
        self.only(&kept)
    }

    fn only(mut self, kept: &[bool]) -> Self {
        fn chosen<T>(values: Vec<T>, kept: &[bool]) -> Vec<T> {
            let values = values.into_iter().zip(kept);
            values
                .filter(|(_, kept)| **kept)
                .map(|(value, _)| value)
                .collect()
        }
        self.header = chosen(self.header, kept);
        self.template = chosen(self.template, kept);
        self.rows = self.rows.into_iter().map(|row| chosen(row, kept)).collect();
        self
    }

    /// The table column by column.
    pub(crate) fn columns(&self) -> Vec<Column> {
        let header = self.header.iter().zip(&self.template).enumerate();
        let column =
            |(place, ((field, name), usual)): (usize, (&(&'static str, String), &Cell))| {
                let cells = self.rows.iter().filter_map(|row| row.get(place));
                Column {
                    field,
                    name: name.clone(),
                    values: ColumnValues::of(usual, &cells.collect::<Vec<_>>()),
                }
            };
        header.map(column).collect()
    }

    /// The text, after comment lines about where the result comes from.
    pub(crate) fn text(&self, made: &Provenance) -> String {
        made.csv_comment() + &self.plain_text()
    }

    /// The text without comments.
    pub(crate) fn plain_text(&self) -> String {
        let names = self.header.iter().map(|(_, name)| name.clone());
        let rows = self.rows.iter();
        let rows = rows.map(|row| row.iter().map(ToString::to_string).collect());
        csv_text(iter::once(names.collect::<Vec<_>>()).chain(rows))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize, Default)]
    struct TestName<'r> {
        name: &'r str,
    }

    #[derive(Serialize, Default)]
    struct TestFigures {
        value: Displayed,
        low: OptionalNumber,
        count: Option<usize>,
    }

    fn rows() -> Vec<(TestName<'static>, TestFigures)> {
        let row = |name, value, low| {
            let (value, count) = (Displayed(value), None);
            (TestName { name }, TestFigures { value, low, count })
        };
        vec![
            row("a, b", 5.0, None),
            row("#c", 1e-7, Some(Displayed(1e21))),
        ]
    }

    #[test]
    fn numbers_have_all_digits_and_no_exponent() {
        assert_eq!(
            CsvRows::of(rows()).plain_text(),
            "name,value,low,count\n\"a, b\",5,,\n\"#c\",0.0000001,1000000000000000000000,\n"
        );
    }

    #[test]
    fn columns_are_renamed_and_left_out() {
        let upper = |name: &str| name.to_uppercase();
        let text = CsvRows::of(rows())
            .without_empty()
            .renamed(upper)
            .without(&["LOW"]);
        assert_eq!(
            text.plain_text(),
            "NAME,VALUE\n\"a, b\",5\n\"#c\",0.0000001\n"
        );
        // Without rows, nothing is known to be empty.
        let none = CsvRows::of(Vec::<(TestName, TestFigures)>::new()).without_empty();
        assert_eq!(none.plain_text(), "name,value,low,count\n");
    }

    #[test]
    fn columns_of_a_number_known_only_later_have_names() {
        #[derive(Serialize, Default)]
        struct TestRate {
            rate: Displayed,
        }
        let row = |rates: usize| {
            let rates: Vec<TestRate> = (0..rates).map(|_| TestRate::default()).collect();
            (TestName { name: "a" }, rates, TestFigures::default())
        };
        let mut number = 0;
        let rows = CsvRows::like(&row(2), [row(2)]).renamed(|name| {
            number += 1;
            format!("{name}{number}")
        });
        assert_eq!(
            rows.plain_text(),
            "name1,rate2,rate3,value4,low5,count6\na,0,0,0,,\n"
        );
    }

    #[test]
    fn columns_have_the_kind_of_their_fields() {
        #[derive(Serialize, Default)]
        struct TestRow {
            name: &'static str,
            tied: bool,
            seed: u64,
            count: Option<usize>,
            share: Displayed,
            low: OptionalNumber,
        }
        let row = |seed, count, share| TestRow {
            name: "a",
            tied: true,
            seed,
            count,
            share: Displayed(share),
            low: None,
        };
        let kinds = |rows: CsvRows| -> Vec<String> {
            let columns = rows.columns().into_iter();
            columns
                .map(|column| format!("{:?}", column.values))
                .collect()
        };
        let most = u64::MAX;
        let whole = CsvRows::of([row(1, Some(2), 0.5), row(most, Some(3), f64::NAN)]);
        assert_eq!(
            whole.plain_text(),
            format!("name,tied,seed,count,share,low\na,true,1,2,0.5,\na,true,{most},3,,\n")
        );
        assert_eq!(
            kinds(whole),
            [
                "Texts([\"a\", \"a\"])",
                "Flags([true, true])",
                &format!("Counts([1, {most}])"),
                "Counts([2, 3])",
                "Numbers([0.5, NaN])",
                "Numbers([NaN, NaN])",
            ]
        );
        assert_eq!(
            kinds(CsvRows::of([row(1, None, 1.0), row(2, Some(4), 1.0)]))[3],
            "Numbers([NaN, 4.0])"
        );
        let none = kinds(CsvRows::of(Vec::<TestRow>::new()));
        assert_eq!(
            none,
            [
                "Texts([])",
                "Flags([])",
                "Counts([])",
                "Numbers([])",
                "Numbers([])",
                "Numbers([])"
            ]
        );
    }
}
