//! The list of instances: CSV with one line for each and what is known of it.

use crate::csv_columns::{Columns, KnownColumns, resembles};
use crate::csv_file::CsvFile;
use crate::error::{Error, Result, shown};
use crate::files::csv_text;
use csv::StringRecord;
use std::collections::HashSet;

/// The name of the list in the folder of a benchmark.
pub const MANIFEST: &str = "instances.csv";

const NAME: usize = 0;
const PICKED: usize = 3;
const RATE: usize = 4;
const PICKS_BOUND: usize = 5;
const RATE_BOUND: usize = 6;
const FOUND_BY: usize = 7;

const KNOWN: KnownColumns = KnownColumns {
    names: &[
        "name",
        "robots",
        "items",
        "picked",
        "rate_per_min",
        "picks_bound",
        "rate_bound_per_min",
        "found_by",
    ],
    required: 1,
    find: |column| {
        let place = KNOWN.names.iter().position(|&known| known == column);
        place.map(|place| (place, 1.0))
    },
    is_misspelt: |column| resembles(column, KNOWN.names),
    beginning: "start it with the header `name` and write one instance per line",
    needs: "the header needs name",
};

/// What is known of an instance.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Known {
    /// The most picks of any solution that is known.
    pub picked: Option<usize>,
    /// The picking rate of that solution [1/min].
    pub rate: Option<f64>,
    /// What no solution exceeds.
    pub picks_bound: Option<usize>,
    /// The picking rate that no solution exceeds [1/min].
    pub rate_bound: Option<f64>,
    /// How the best solution was found; empty if there is none.
    pub found_by: String,
}

/// A line of the list.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ManifestRow {
    pub name: String,
    pub known: Known,
}

/// Reads the list in `text`; messages call it `file`.
///
/// # Errors
/// The first line that cannot be read, a name that is not one of a file, or one that occurs twice.
pub(super) fn read(text: &str, file: &str) -> Result<Vec<ManifestRow>> {
    let mut csv = CsvFile::new(text, file);
    let columns = Columns::of(&mut csv, &KNOWN)?;
    let mut rows = Vec::new();
    let mut names = HashSet::new();
    let mut record = StringRecord::new();
    while csv.next(&mut record)?.is_some() {
        let name = columns.text(&record, NAME).to_owned();
        let place = || columns.place_of(&csv, NAME);
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
        if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
            return Err(Error::input(
                place(),
                format!("`{}` is not the name of an instance", shown(&name)),
                "use letters, digits, hyphens, underscores and dots",
            ));
        }
        if !names.insert(name.clone()) {
            return Err(Error::input(
                place(),
                format!("`{}` occurs twice", shown(&name)),
                "give every instance a name of its own",
            ));
        }
        let known = Known {
            picked: count(&columns, &mut csv, &record, PICKED)?,
            rate: number(&columns, &mut csv, &record, RATE)?,
            picks_bound: count(&columns, &mut csv, &record, PICKS_BOUND)?,
            rate_bound: number(&columns, &mut csv, &record, RATE_BOUND)?,
            found_by: columns.text(&record, FOUND_BY).to_owned(),
        };
        rows.push(ManifestRow { name, known });
    }
    if rows.is_empty() {
        return Err(Error::input(
            file,
            "lists no instance",
            "write the name of one per line",
        ));
    }
    Ok(rows)
}

/// A number of at least 0; `None` if the field is empty.
fn number(
    columns: &Columns,
    csv: &mut CsvFile,
    record: &StringRecord,
    column: usize,
) -> Result<Option<f64>> {
    let number = columns.number(csv, record, column)?;
    match number {
        Some(value) if !(value.is_finite() && value >= 0.0) => Err(Error::input(
            columns.place_of(csv, column),
            format!("{value} is out of range"),
            "give a number of at least 0, or leave the field empty",
        )),
        number => Ok(number),
    }
}

/// A whole number; `None` if the field is empty.
fn count(
    columns: &Columns,
    csv: &mut CsvFile,
    record: &StringRecord,
    column: usize,
) -> Result<Option<usize>> {
    let number = number(columns, csv, record, column)?;
    match number {
        Some(value) if value.fract() != 0.0 || value > 1e9 => Err(Error::input(
            columns.place_of(csv, column),
            format!("{value} is not a number of items"),
            "give a whole number, or leave the field empty",
        )),
        number => Ok(number.map(|value| value as usize)),
    }
}

/// The list of `rows`, each with its numbers of robots and items, as text.
pub(super) fn text(rows: &[(&ManifestRow, [usize; 2])]) -> String {
    let header = KNOWN.names.iter().map(|name| (*name).to_owned()).collect();
    let field = |value: Option<String>| value.unwrap_or_default();
    let row = |(row, [robots, items]): &(&ManifestRow, [usize; 2])| {
        let known = &row.known;
        vec![
            row.name.clone(),
            robots.to_string(),
            items.to_string(),
            field(known.picked.map(|n| n.to_string())),
            field(known.rate.map(|n| n.to_string())),
            field(known.picks_bound.map(|n| n.to_string())),
            field(known.rate_bound.map(|n| n.to_string())),
            known.found_by.clone(),
        ]
    };
    csv_text(std::iter::once(header).chain(rows.iter().map(row)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_read_as_it_was_written() {
        let known = Known {
            picked: Some(7),
            rate: Some(12.5),
            picks_bound: Some(8),
            rate_bound: None,
            found_by: "lookahead:budget=4,depth=1".into(),
        };
        let rows = [("a-1", known), ("b.2", Known::default())];
        let rows = rows.map(|(name, known)| ManifestRow {
            name: name.into(),
            known,
        });
        let written = text(&[(&rows[0], [2, 9]), (&rows[1], [3, 20])]);
        assert_eq!(
            written.lines().nth(1),
            Some("a-1,2,9,7,12.5,8,,\"lookahead:budget=4,depth=1\"")
        );
        assert_eq!(read(&written, "m").unwrap(), rows);
    }

    #[test]
    fn what_is_wrong_in_a_list_is_named() {
        for (text, words) in [
            ("", "m: the file is empty"),
            ("name\n", "m: lists no instance"),
            ("nmae\na\n", "unknown column `nmae`"),
            ("name\n../a\n", "m:2: name: `../a` is not the name"),
            ("name\n.a\n", "m:2: name: `.a` is not the name"),
            ("name\na\na\n", "m:3: name: `a` occurs twice"),
            (
                "name,picked\na,1.5\n",
                "m:2: picked: 1.5 is not a number of items",
            ),
            ("name,picked\na,x\n", "m:2: picked: `x` is not a number"),
            (
                "name,rate_per_min\na,-1\n",
                "m:2: rate_per_min: -1 is out of range",
            ),
            (
                "name,rate_bound_per_min\na,inf\n",
                "m:2: rate_bound_per_min: inf is out of range",
            ),
        ] {
            let message = read(text, "m").unwrap_err().to_string();
            assert!(message.contains(words), "{words} not in {message}");
        }
    }
}
