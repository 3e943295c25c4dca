//! The pattern file: CSV with a header, one item a line.

use super::item::{Item, Pattern};
use crate::error::{Error, Result, known_names, shown};
use std::path::Path;

const REQUIRED: [&str; 3] = ["id", "x", "y"];
const COLUMNS: [&str; 8] = [
    "id",
    "x",
    "y",
    "area_cm2",
    "p_detection",
    "p_grasp",
    "weight",
    "class",
];

/// Reads a pattern file.
///
/// # Errors
/// A file that cannot be read, or whatever [`parse`] finds.
pub fn load(path: &Path) -> Result<Pattern> {
    parse(&crate::files::read_text(path)?, &path.display().to_string())
}

/// Parses a pattern file; `name` is how messages call it. Line ends may be Unix's or
/// Windows', a byte order mark is passed over.
///
/// # Errors
/// Whatever is wrong, with its line and column, the value found and the cure.
pub fn parse(text: &str, name: &str) -> Result<Pattern> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut records = Records::new(text, name);
    let mut header = csv::StringRecord::new();
    let line = records.next(&mut header)?.unwrap_or(1);
    let columns = read_header(&header, name, line)?;
    let mut items = Vec::new();
    let mut lines = Vec::new();
    let mut record = csv::StringRecord::new();
    while let Some(line) = records.next(&mut record)? {
        if record.len() != header.len() {
            let fields: Vec<&str> = record.iter().collect();
            return Err(Error::input(
                format!("{name}:{line}"),
                format!(
                    "{} fields where the header has {}: `{}`",
                    record.len(),
                    header.len(),
                    shown(&fields.join(","))
                ),
                "give every line one field per column of the header",
            ));
        }
        items.push(read_item(&record, &columns, name, line)?);
        lines.push(line);
    }
    Pattern::checked(items, name, &|i| format!("{name}:{}", lines[i]))
}

/// The records of a file, each with the line it stands on. The csv crate knows a line
/// only up to blank lines and Windows' line ends before it.
struct Records<'a> {
    reader: csv::Reader<&'a [u8]>,
    name: &'a str,
    bytes: &'a [u8],
    /// First byte that is not counted into `line` yet.
    counted: usize,
    line: usize,
}

impl<'a> Records<'a> {
    fn new(text: &'a str, name: &'a str) -> Self {
        Self {
            reader: csv::ReaderBuilder::new()
                .has_headers(false)
                .flexible(true)
                .from_reader(text.as_bytes()),
            name,
            bytes: text.as_bytes(),
            counted: 0,
            line: 1,
        }
    }

    /// Reads the next record, trimmed, and returns its line; none at the end.
    fn next(&mut self, record: &mut csv::StringRecord) -> Result<Option<usize>> {
        let more = self.reader.read_record(record).map_err(|error| {
            Error::input(
                format!("{}:{}", self.name, self.line),
                format!("not valid CSV: {error}"),
                "give every line one field per column of the header",
            )
        })?;
        if !more {
            return Ok(None);
        }
        let start = record.position().map_or(0, csv::Position::byte);
        let line = self.line_at(start as usize);
        // Else a quote that is never closed would swallow all items after it.
        if let Some(field) = record.iter().find(|field| field.contains(['\n', '\r'])) {
            return Err(Error::input(
                format!("{}:{line}", self.name),
                format!("the field `{}` goes on past the line's end", shown(field)),
                "close its quote: an item stands on one line",
            ));
        }
        record.trim();
        Ok(Some(line))
    }

    /// The line of the record that is read from byte `start` on.
    fn line_at(&mut self, start: usize) -> usize {
        while let Some(&byte) = self.bytes.get(self.counted) {
            let ends_line = byte == b'\n' || byte == b'\r';
            if self.counted >= start && !ends_line {
                break;
            }
            // Windows' two characters end one line.
            let in_pair = byte == b'\r' && self.bytes.get(self.counted + 1) == Some(&b'\n');
            self.line += usize::from(ends_line && !in_pair);
            self.counted += 1;
        }
        self.line
    }
}

/// For each known column, its place in this file.
type Columns = [Option<usize>; COLUMNS.len()];

fn read_header(header: &csv::StringRecord, name: &str, line: usize) -> Result<Columns> {
    let mut columns = Columns::default();
    if header.is_empty() {
        return Err(Error::input(
            name,
            "the file is empty",
            "start it with the header `id,x,y`; `pickline pattern generate` writes one",
        ));
    }
    for (place, column) in header.iter().enumerate() {
        let Some(known) = COLUMNS.iter().position(|&c| c == column) else {
            return Err(Error::input(
                format!("{name}:{line}: column {}", place + 1),
                format!("unknown column `{}`", shown(column)),
                known_names(column, &COLUMNS),
            ));
        };
        if columns[known].replace(place).is_some() {
            return Err(Error::input(
                format!("{name}:{line}: column {}", place + 1),
                format!("the column `{column}` is there twice"),
                "keep one of them",
            ));
        }
    }
    for (known, column) in REQUIRED.iter().enumerate() {
        if columns[known].is_none() {
            return Err(Error::input(
                format!("{name}:{line}"),
                format!("the column `{column}` is missing"),
                "the header needs id, x [m] and y [m]",
            ));
        }
    }
    Ok(columns)
}

fn read_item(
    record: &csv::StringRecord,
    columns: &Columns,
    name: &str,
    line: usize,
) -> Result<Item> {
    let field = |column: usize| {
        columns[column]
            .and_then(|place| record.get(place))
            .unwrap_or("")
    };
    let optional = |column: usize| -> Result<Option<f64>> {
        let text = field(column);
        if text.is_empty() {
            return Ok(None);
        }
        // `nan` and `inf` are numbers that the item refuses; 1e400 is neither infinite
        // nor a number that can be worked with.
        let fits = |n: &f64| n.is_finite() || !text.contains(|c: char| c.is_ascii_digit());
        match text.parse().ok().filter(fits) {
            Some(number) => Ok(Some(number)),
            None => Err(Error::input(
                format!("{name}:{line}: {}", COLUMNS[column]),
                format!("`{}` is not a number", shown(text)),
                "write it with a decimal point and no unit, for example -0.15",
            )),
        }
    };
    let number = |column: usize| -> Result<f64> {
        optional(column)?.ok_or_else(|| {
            Error::input(
                format!("{name}:{line}: {}", COLUMNS[column]),
                "the field is empty",
                "give metres in the belt frame",
            )
        })
    };
    Ok(Item {
        id: field(0).to_owned(),
        x0: number(1)?,
        y: number(2)?,
        area_cm2: optional(3)?,
        p_detection: optional(4)?,
        p_grasp: optional(5)?,
        weight: optional(6)?,
        class: Some(field(7))
            .filter(|text| !text.is_empty())
            .map(str::to_owned),
    })
}

/// The pattern as CSV, with the columns that some item uses; [`parse`] reads it
/// back to an equal pattern.
pub fn to_csv(pattern: &Pattern) -> String {
    type Column<'a> = (&'static str, Box<dyn Fn(&Item) -> String + 'a>);
    let number = |value: Option<f64>| value.map(|v| v.to_string()).unwrap_or_default();
    let mut columns: Vec<Column> = vec![
        ("id", Box::new(|item| item.id.clone())),
        ("x", Box::new(|item| item.x0.to_string())),
        ("y", Box::new(|item| item.y.to_string())),
    ];
    let optional: [Column; 5] = [
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
            ("id,x,y,x\na,0,0,1\n", &["t:1", "twice"]),
            ("id,x,y\na,0,zero\n", &["t:2: y", "`zero`"]),
            ("id,x,y\na,0,\n", &["t:2: y", "empty"]),
            ("id,x,y\na,0,nan\n", &["t:2", "y of item `a`", "NaN"]),
            ("id,x,y\na,0,0\nb,0.5,0\n", &["t:3", "0.5"]),
            ("id,x,y\na,0,0\na,-1,0\n", &["t:3: id", "t:2"]),
            ("id,x,y\na,0\n", &["t:2", "2 fields", "`a,0`"]),
            ("id,x,y\r\n\r\na,0,0\r\nb,zero,0\r\n", &["t:4: x", "`zero`"]),
            ("\n\nid,x,y\n\n\na,0,0\n\nb,zero,0\n", &["t:8: x", "`zero`"]),
            ("\nid,x\n", &["t:2", "`y` is missing"]),
            ("id,x,y\ra,0,0\rb,zero,0\r", &["t:3: x", "`zero`"]),
            ("id,x,y\na,1e400,0\n", &["t:2: x", "`1e400`"]),
            (
                "id,x,y,class\na,0,0,\"PET\nb,-1,0,glass\n",
                &["t:2", "past the line's end", "`PET\\nb,-1,0,glass"],
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
