//! The pattern file: CSV with a header and one item per line.

use super::item::{Item, Pattern};
use crate::csv_columns::{Columns, KnownColumns, metres, resembles};
use crate::csv_file::CsvFile;
use crate::error::{Error, Result, shown};
use std::path::Path;

/// The columns of a pattern file.
const KNOWN: KnownColumns = KnownColumns {
    names: &[
        "id",
        "x",
        "y",
        "area_cm2",
        "p_detection",
        "p_grasp",
        "weight",
        "class",
        TRUE_CLASS,
    ],
    required: 3,
    find: known_column,
    is_misspelt,
    beginning: "start it with the header `id,x,y`; `pickline pattern generate` writes one",
    needs: "the header needs id, x [m] and y [m]",
};

/// The column with what an item truly is.
const TRUE_CLASS: &str = "true_class";
/// Index of the area in [`KNOWN`].
const AREA: usize = 3;

/// A pattern and the columns of its file that were ignored.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Loaded {
    /// The items of the file, sorted as a pattern is.
    pub pattern: Pattern,
    /// Names of the columns that were ignored.
    pub ignored: Vec<String>,
}

impl Loaded {
    /// Description for provenance: `hash 0123456789abcdef, column timestamp ignored`.
    pub fn describe(&self) -> String {
        let hash = crate::files::fingerprint(to_csv(&self.pattern));
        match self.ignored.as_slice() {
            [] => format!("hash {hash}"),
            [one] => format!("hash {hash}, column {one} ignored"),
            more => format!("hash {hash}, columns {} ignored", more.join(", ")),
        }
    }
}

/// Reads a pattern file.
///
/// # Errors
/// If the file cannot be read, or for any error of [`parse`].
pub fn load(path: &Path) -> Result<Loaded> {
    read(&crate::files::read_text(path)?, &path.display().to_string())
}

/// Parses `text` as [`read`] does and returns only the pattern.
///
/// # Errors
/// The first problem, with its line and column, the value found and the cure.
pub fn parse(text: &str, name: &str) -> Result<Pattern> {
    Ok(read(text, name)?.pattern)
}

/// Parses the text of a pattern file in any CSV variant that `CsvFile` accepts; messages call it
/// `name`. Column names are case-insensitive. `x`, `y` and `area` may include a unit: `x_mm`, `y
/// [cm]` or `area [mm^2]`. Columns with other names are ignored.
///
/// # Errors
/// The first problem, with its line and column, the value found and the cure. A column whose name
/// is similar to a known one is an error.
pub fn read(text: &str, name: &str) -> Result<Loaded> {
    let mut file = CsvFile::new(text, name);
    let columns = Columns::of(&mut file, &KNOWN);
    // A tracker's file may have columns with the names of pattern columns but other meanings.
    if let Some(form) = super::tracking::recognised(text) {
        return Err(Error::input(
            name,
            format!("not a pattern, but the recording of a tracker or detector ({form})"),
            "convert it to a pattern with `pickline pattern import tracks`",
        ));
    }
    let columns = columns?;
    let [x, y] = [1, 2].map(|column| columns.place(column).unwrap_or(0));
    let is_item = |file: &mut CsvFile, fields: &[&str]| {
        [x, y]
            .iter()
            .all(|&place| file.number(fields[place]).is_ok())
    };
    if let Some((line, row)) = file.commented_row(is_item) {
        return Err(Error::input(
            format!("{name}:{line}"),
            format!("`{}` is a comment that looks like an item", shown(row)),
            "put the id that starts with # into quotes, or remove the line",
        ));
    }
    let mut items = Vec::new();
    let mut lines = Vec::new();
    let mut record = csv::StringRecord::new();
    while let Some(line) = file.next(&mut record)? {
        items.push(read_item(&mut file, &record, &columns)?);
        lines.push(line);
    }
    let pattern = Pattern::checked(items, name, &|i| format!("{name}:{}", lines[i]))?;
    Ok(Loaded {
        pattern,
        ignored: columns.ignored,
    })
}

/// The known column called `name`, and the factor from its unit to ours: metres, or cm^2 for an
/// area.
fn known_column(name: &str) -> Option<(usize, f64)> {
    if let Some(known) = KNOWN.names.iter().position(|&column| column == name) {
        return Some((known, 1.0));
    }
    let (column, unit) = name.split_once(['_', ' ', '[', '('])?;
    let unit = unit.trim_matches([' ', '[', ']', '(', ')']);
    match column.trim() {
        axis @ ("x" | "y") => {
            let column = if axis == "x" { 1 } else { 2 };
            metres(unit).map(|factor| (column, factor))
        }
        "area" => {
            let square = match unit.replace(['^', ' '], "").replace('²', "2").as_str() {
                "cm2" => 1.0,
                "mm2" => 0.01,
                "m2" => 1e4,
                _ => return None,
            };
            Some((AREA, square))
        }
        _ => None,
    }
}

/// Whether `column` is probably meant to be a known column. The long name `true_class` is similar to
/// too many others, such as `item_class`, for more than another separator to count.
fn is_misspelt(column: &str) -> bool {
    let others = KNOWN.names.iter().copied();
    let others: Vec<&str> = others.filter(|name| *name != TRUE_CLASS).collect();
    let letters = |name: &str| -> String { name.chars().filter(|c| c.is_alphanumeric()).collect() };
    resembles(column, &others) || letters(column).eq_ignore_ascii_case(&letters(TRUE_CLASS))
}

fn read_item(file: &mut CsvFile, record: &csv::StringRecord, columns: &Columns) -> Result<Item> {
    let mut optional = |column: usize| columns.number(file, record, column);
    let numbers = [
        optional(1)?,
        optional(2)?,
        optional(3)?,
        optional(4)?,
        optional(5)?,
        optional(6)?,
    ];
    let text = |column: usize| {
        let text = columns.text(record, column).to_owned();
        Some(text).filter(|text| !text.is_empty())
    };
    let required = |column: usize| {
        numbers[column - 1].ok_or_else(|| {
            Error::input(
                columns.place_of(file, column),
                "the field is empty",
                "give metres in the belt frame",
            )
        })
    };
    Ok(Item {
        id: columns.text(record, 0).to_owned(),
        x0: required(1)?,
        y: required(2)?,
        area_cm2: numbers[2],
        p_detection: numbers[3],
        p_grasp: numbers[4],
        weight: numbers[5],
        class: text(7),
        true_class: text(8),
    })
}

/// The pattern as CSV with the columns that at least one item uses. [`parse`] reads it back as an
/// equal pattern.
pub fn to_csv(pattern: &Pattern) -> String {
    type Column<'a> = (&'static str, Box<dyn Fn(&Item) -> String + 'a>);
    let number = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
    let mut columns: Vec<Column> = vec![
        ("id", Box::new(|item| item.id.clone())),
        ("x", Box::new(|item| item.x0.to_string())),
        ("y", Box::new(|item| item.y.to_string())),
    ];
    let optional: [Column; 6] = [
        ("area_cm2", Box::new(move |item| number(item.area_cm2))),
        (
            "p_detection",
            Box::new(move |item| number(item.p_detection)),
        ),
        ("p_grasp", Box::new(move |item| number(item.p_grasp))),
        ("weight", Box::new(move |item| number(item.weight))),
        (
            "class",
            Box::new(|item| item.class.clone().unwrap_or_default()),
        ),
        (
            TRUE_CLASS,
            Box::new(|item| item.true_class.clone().unwrap_or_default()),
        ),
    ];
    for column in optional {
        if pattern
            .items()
            .iter()
            .any(|item| !column.1(item).is_empty())
        {
            columns.push(column);
        }
    }
    let names: Vec<String> = columns.iter().map(|c| c.0.to_owned()).collect();
    let rows = pattern
        .items()
        .iter()
        .map(|item| columns.iter().map(|c| c.1(item)).collect());
    crate::files::csv_text(std::iter::once(names).chain(rows))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_may_carry_their_unit() {
        for (column, area) in [
            ("area [cm^2]", 80.0),
            ("area_cm2", 80.0),
            ("area [mm^2]", 0.8),
            ("Area_mm2", 0.8),
            ("area (mm²)", 0.8),
            ("area [m2]", 8e5),
        ] {
            let loaded = read(&format!("id,x,y,{column}\na,0,0,80\n"), "t").unwrap();
            assert_eq!(loaded.pattern.items()[0].area_cm2, Some(area), "{column}");
            assert!(loaded.ignored.is_empty(), "{column}");
        }
        let plain = read("id,x,y,area\na,0,0,80\n", "t").unwrap();
        assert_eq!(plain.ignored, ["area"]);
    }

    #[test]
    fn reads_back_what_it_writes() {
        let text = "id,x,y,area_cm2,p_grasp,class\na,0,0.1,80,0.5,\"PET, clear\"\n\"b\"\"\",-0.15,-0.1,,,\n";
        let pattern = parse(text, "t").unwrap();
        assert_eq!(pattern.items()[0].class.as_deref(), Some("PET, clear"));
        assert_eq!(pattern.items()[1].id, "b\"");
        assert_eq!(parse(&to_csv(&pattern), "t").unwrap(), pattern);
    }

    #[test]
    fn marks_and_line_ends_are_passed_over() {
        let plain = parse("id,x,y\na,0,0\nb,-1,0\n", "t").unwrap();
        for text in [
            "\u{feff}id,x,y\r\na,0,0\r\nb,-1,0\r\n",
            "id, x, y\na, 0, 0\nb, -1, 0",
            "id,x,y\n\na,0,0\n\nb,-1,0\n",
            "\r\n\r\nid,x,y\r\n\r\na,0,0\r\n\r\nb,-1,0",
            "id,x,y\ra,0,0\rb,-1,0\r",
        ] {
            assert_eq!(parse(text, "t").unwrap(), plain, "{text:?}");
        }
    }

    #[test]
    fn messages_name_line_and_column() {
        for (text, words) in [
            ("", &["t: ", "empty"][..]),
            ("id,x,y\n", &["no item"]),
            ("id,x\na,0\n", &["t:1", "`y` is missing"]),
            (
                "id,x,y,wieght\na,0,0,1\n",
                &["t:1: column 4", "did you mean `weight`"],
            ),
            ("id,x,y,x\na,0,0,1\n", &["t:1", "duplicate column"]),
            ("id,x,y\na,0,zero\n", &["t:2: y", "`zero`"]),
            ("id,x,y\na,0,\n", &["t:2: y", "empty"]),
            ("id,x,y\na,0,nan\n", &["t:2", "y of item `a`", "NaN"]),
            ("id,x,y\na,0,0\nb,0.5,0\n", &["t:3", "0.5"]),
            ("id,x,y\na,0,0\na,-1,0\n", &["t:3: id", "t:2"]),
            ("id,x,y\na,0\n", &["t:2", "found 2: `a,0`"]),
            ("id,x,y\r\n\r\na,0,0\r\nb,zero,0\r\n", &["t:4: x", "`zero`"]),
            ("\n\nid,x,y\n\n\na,0,0\n\nb,zero,0\n", &["t:8: x", "`zero`"]),
            ("\nid,x\n", &["t:2", "`y` is missing"]),
            ("id,x,y\ra,0,0\rb,zero,0\r", &["t:3: x", "`zero`"]),
            ("id,x,y\na,1e400,0\n", &["t:2: x", "`1e400`"]),
            (
                "id,x,y,class\na,0,0,\"PET\nb,-1,0,glass\n",
                &["t:2", "spans more than one line", "`PET\\nb,-1,0,glass"],
            ),
            ("id,x,y,p_grasp\na,0,0,1.5\n", &["t:2: p_grasp", "1.5"]),
            ("id,x,y,area_cm2\na,0,0,-3\n", &["t:2: area_cm2", "-3"]),
        ] {
            let message = parse(text, "t").unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
    }
}
