//! The columns of a CSV file that a reader knows: in any order, with units in their names.

use crate::csv_file::CsvFile;
use crate::error::{Error, Result, known_names, nearest, shown};
use csv::StringRecord;

/// What a reader knows about the columns of its files.
pub(crate) struct KnownColumns<'k> {
    /// Their names; the required ones come first.
    pub names: &'k [&'k str],
    /// Number of required columns.
    pub required: usize,
    /// The index of the known column with this name in lower case, and the factor from its unit to
    /// that of the reader.
    pub find: fn(&str) -> Option<(usize, f64)>,
    /// Whether a column that is not known was probably meant to be.
    pub is_misspelt: fn(&str) -> bool,
    /// How an empty file should begin: the cure.
    pub beginning: &'k str,
    /// What the header needs: the cure for a missing column.
    pub needs: &'k str,
}

/// The columns of one file.
#[derive(Debug)]
pub(crate) struct Columns<'k> {
    names: &'k [&'k str],
    /// For each known column, its index in this file and the factor to our unit.
    places: Vec<Option<(usize, f64)>>,
    /// Names of the columns that were ignored.
    pub ignored: Vec<String>,
}

impl<'k> Columns<'k> {
    /// Reads the header of `file`.
    ///
    /// # Errors
    /// An empty file, a header that is not valid CSV, a column that is missing or given twice, or
    /// one whose name is similar to a known one.
    pub(crate) fn of(file: &mut CsvFile, known: &KnownColumns<'k>) -> Result<Self> {
        let (header, line) = file.header()?;
        let name = file.name();
        if header.is_empty() {
            return Err(Error::input(name, "the file is empty", known.beginning));
        }
        let wrong = |place: usize, problem: String, cure: String| {
            Error::input(
                format!("{name}:{line}: column {}", place + 1),
                problem,
                cure,
            )
        };
        let mut places = vec![None; known.names.len()];
        let mut ignored = Vec::new();
        for (place, column) in header.iter().enumerate() {
            let Some((index, factor)) = (known.find)(column) else {
                if (known.is_misspelt)(column) {
                    let problem = format!("unknown column `{}`", shown(column));
                    return Err(wrong(place, problem, known_names(column, known.names)));
                }
                ignored.push((place, shown(column)));
                continue;
            };
            if places[index].replace((place, factor)).is_some() {
                return Err(wrong(
                    place,
                    format!("duplicate column `{}`", known.names[index]),
                    "keep one of them".into(),
                ));
            }
        }
        for (index, column) in known.names[..known.required].iter().enumerate() {
            if places[index].is_none() {
                // If the file is something else, its first column name is the most telling.
                return Err(match ignored.first() {
                    Some((place, other)) if places.iter().all(Option::is_none) => wrong(
                        *place,
                        format!("unknown column `{other}`"),
                        format!("{}; known: {}", known.needs, known.names.join(", ")),
                    ),
                    _ => Error::input(
                        format!("{name}:{line}"),
                        format!("the column `{column}` is missing"),
                        known.needs,
                    ),
                });
            }
        }
        Ok(Self {
            names: known.names,
            places,
            ignored: ignored.into_iter().map(|(_, name)| name).collect(),
        })
    }

    /// Index in the file of a known column, if the file has it.
    pub(crate) fn place(&self, column: usize) -> Option<usize> {
        self.places[column].map(|(place, _)| place)
    }

    /// The text of a known column in this row; empty if the file does not have it.
    pub(crate) fn text<'r>(&self, record: &'r StringRecord, column: usize) -> &'r str {
        let place = self.place(column);
        place.and_then(|place| record.get(place)).unwrap_or("")
    }

    /// The number in a known column of the row that was read last, in the reader's unit; `None` if
    /// the field is empty.
    ///
    /// # Errors
    /// A text that is not a number.
    pub(crate) fn number(
        &self,
        file: &mut CsvFile,
        record: &StringRecord,
        column: usize,
    ) -> Result<Option<f64>> {
        let text = self.text(record, column);
        if text.is_empty() {
            return Ok(None);
        }
        match file.number(text) {
            // Skip the multiplication by 1, so that what is in our unit stays exactly as written.
            Ok(number) => Ok(Some(match self.places[column] {
                Some((_, factor)) if factor != 1.0 => number * factor,
                _ => number,
            })),
            Err(cause) => Err(Error::input(
                self.place_of(file, column),
                format!("`{}` is not a number", shown(text)),
                file.number_cure(),
            )
            .caused_by(cause)),
        }
    }

    /// The field of a known column in the row that was read last, as messages name it.
    pub(crate) fn place_of(&self, file: &CsvFile, column: usize) -> String {
        format!("{}:{}: {}", file.name(), file.line(), self.names[column])
    }
}

/// Whether `column` is similar to one of `names`.
pub(crate) fn resembles(column: &str, names: &[&str]) -> bool {
    // A single letter is always similar to `x` and `y`.
    column.chars().count() > 1 && nearest(column, names.iter().copied()).is_some()
}

/// The factor from this unit of length to metres.
pub(crate) fn metres(unit: &str) -> Option<f64> {
    match unit {
        "m" => Some(1.0),
        "cm" => Some(0.01),
        "mm" => Some(0.001),
        _ => None,
    }
}

/// The factor from this unit of time to seconds.
pub(crate) fn seconds(unit: &str) -> Option<f64> {
    match unit {
        "s" => Some(1.0),
        "ms" => Some(1e-3),
        "us" | "µs" => Some(1e-6),
        _ => None,
    }
}

/// The factor of the unit in a column's name that begins with `quantity`, by `unit`: for `grasp_ms`,
/// `grasp [ms]` or `grasp (ms)`, that of `ms`. 1 for the quantity alone.
pub(crate) fn unit_factor(
    column: &str,
    quantity: &str,
    unit: fn(&str) -> Option<f64>,
) -> Option<f64> {
    let rest = column.strip_prefix(quantity)?;
    if rest.is_empty() {
        return Some(1.0);
    }
    let stated = rest.strip_prefix(['_', ' ', '[', '('])?;
    unit(stated.trim_matches([' ', '[', ']', '(', ')']))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_may_have_units() {
        for (column, factor) in [
            ("grasp", Some(1.0)),
            ("grasp_s", Some(1.0)),
            ("grasp [ms]", Some(1e-3)),
            ("grasp_ms", Some(1e-3)),
            ("grasp(us)", Some(1e-6)),
            ("grasp_mm", None),
            ("grasping", None),
            ("release", None),
        ] {
            assert_eq!(unit_factor(column, "grasp", seconds), factor, "{column}");
        }
        assert_eq!(unit_factor("meet_x_mm", "meet_x", metres), Some(0.001));
    }
}
