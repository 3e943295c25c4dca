//! CSV files whose rows are structs: the names of the fields are the header.

use crate::provenance::Provenance;
use pickline::files::csv_text;
use pickline::stats::Interval;
use serde::{Serialize, Serializer};
use std::fmt::Display;

/// A value written as `Display` shows it. Numbers have all their digits, but neither an exponent
/// nor a `.0`: `5`, `0.000001`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Displayed<T>(pub T);

impl<T: Display> Serialize for Displayed<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let text = self.0.to_string();
        // A share of nothing has no value.
        serializer.serialize_str(if text == "NaN" { "" } else { &text })
    }
}

/// A number, or an empty field.
pub(crate) type OptionalNumber = Option<Displayed<f64>>;

/// The lower end of an interval, or an empty field.
pub(crate) fn low(interval: Option<Interval>) -> OptionalNumber {
    interval.map(|interval| Displayed(interval.low))
}

/// The upper end of an interval, or an empty field.
pub(crate) fn high(interval: Option<Interval>) -> OptionalNumber {
    interval.map(|interval| Displayed(interval.high))
}

/// The rows of a CSV file, header first.
#[derive(Debug)]
pub(crate) struct CsvRows {
    records: Vec<csv::StringRecord>,
}

impl CsvRows {
    /// A file of `rows`, which are structs or tuples of structs. It has its header even without
    /// any row.
    pub(crate) fn of<R: Serialize + Default>(rows: impl IntoIterator<Item = R>) -> Self {
        Self::like(&R::default(), rows)
    }

    /// The same for rows whose number of columns is not part of their type; `template` has as
    /// many as each of `rows`.
    pub(crate) fn like<R: Serialize>(template: &R, rows: impl IntoIterator<Item = R>) -> Self {
        let mut writer = csv::Writer::from_writer(Vec::new());
        // Writing to memory cannot fail, and neither can these structs.
        let _ = writer.serialize(template);
        for row in rows {
            let _ = writer.serialize(row);
        }
        let text = writer.into_inner().unwrap_or_default();
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .from_reader(text.as_slice());
        let mut records: Vec<csv::StringRecord> = reader.records().flatten().collect();
        if records.len() > 1 {
            // The template.
            records.remove(1);
        }
        Self { records }
    }

    /// The same with other names of columns.
    pub(crate) fn renamed(mut self, mut name: impl FnMut(&str) -> String) -> Self {
        if let Some(header) = self.records.first_mut() {
            *header = header.iter().map(&mut name).collect();
        }
        self
    }

    /// The same without the columns that `omitted` names.
    pub(crate) fn without(self, omitted: &[&str]) -> Self {
        let header = self.records.first();
        let kept = header.map_or(Vec::new(), |header| {
            header.iter().map(|name| !omitted.contains(&name)).collect()
        });
        self.columns(&kept)
    }

    /// The same without columns that are empty in every row, if there are rows.
    pub(crate) fn without_empty(self) -> Self {
        let Some((header, rows)) = self.records.split_first() else {
            return self;
        };
        let given = |column: usize| {
            let mut fields = rows.iter().filter_map(|row| row.get(column));
            rows.is_empty() || fields.any(|field| !field.is_empty())
        };
        let kept: Vec<bool> = (0..header.len()).map(given).collect();
        self.columns(&kept)
    }

    fn columns(mut self, kept: &[bool]) -> Self {
        for record in &mut self.records {
            let fields = record.iter().zip(kept);
            *record = fields
                .filter(|(_, kept)| **kept)
                .map(|(field, _)| field)
                .collect();
        }
        self
    }

    /// The text, after comment lines about where the result comes from.
    pub(crate) fn text(self, made: &Provenance) -> String {
        made.csv_comment() + &self.plain_text()
    }

    /// The text without comments.
    pub(crate) fn plain_text(self) -> String {
        csv_text(self.records.iter())
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
        value: Displayed<f64>,
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
            rate: Displayed<f64>,
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
}
