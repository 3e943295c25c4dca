//! Reads CSV as written by spreadsheets, notebooks and other programs. Every error names the line.
//!
//! Fields are separated by commas, semicolons or tabs, whichever occurs most often in the header. A
//! number may have a decimal comma unless commas separate fields. The reader skips a byte order
//! mark, a first line `sep=;`, lines that start with `#`, rows without text and separators at the
//! end of a line. Windows line endings are accepted.

use crate::error::{Error, Result, shown};
use std::fmt;
use std::num::ParseFloatError;

/// Why a field is not a number: the error beneath that of its row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum NumberError {
    /// It is written in another form.
    Form(ParseFloatError),
    /// It has a comma where commas separate fields, or both marks, or another mark than the numbers
    /// before it.
    Mark,
    /// It is larger than any floating-point number.
    TooLarge,
}

impl fmt::Display for NumberError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Form(error) => error.fmt(f),
            Self::Mark => f.write_str("the decimal mark does not fit the file"),
            Self::TooLarge => f.write_str("the number is too large"),
        }
    }
}

impl std::error::Error for NumberError {}

impl From<ParseFloatError> for NumberError {
    fn from(error: ParseFloatError) -> Self {
        Self::Form(error)
    }
}

/// The decimal mark of a number. A file that uses both is ambiguous and is rejected.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mark {
    Point,
    Comma,
}

/// The rows of a file, each with its line number.
pub(crate) struct CsvFile<'a> {
    reader: csv::Reader<&'a [u8]>,
    name: &'a str,
    bytes: &'a [u8],
    separator: char,
    mark: Option<Mark>,
    /// First byte that is not yet counted in `line`. The csv crate's own line numbers are off after
    /// blank lines and Windows line endings.
    counted: usize,
    line: usize,
    /// Number of columns in the header, once it has been read.
    columns: Option<usize>,
}

impl<'a> CsvFile<'a> {
    /// A reader of `text`; messages call the file `name`.
    pub(crate) fn new(text: &'a str, name: &'a str) -> Self {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut lines = text.split_inclusive(['\n', '\r']);
        let first = lines
            .clone()
            .find(|line| !line.trim().is_empty() && !line.starts_with('#'))
            .unwrap_or_default();
        // Spreadsheets declare the separator this way.
        let said = first
            .trim()
            .strip_prefix("sep=")
            .and_then(|rest| rest.chars().next())
            .filter(|c| SEPARATORS.contains(c));
        let mut skipped = 0;
        if said.is_some() {
            for line in lines.by_ref() {
                skipped += line.len();
                if line.trim() == first.trim() {
                    break;
                }
            }
        }
        let separator = said.unwrap_or_else(|| separator_of(first));
        let reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(separator as u8)
            .comment(Some(b'#'))
            .from_reader(&text.as_bytes()[skipped..]);
        let mut file = Self {
            reader,
            name,
            bytes: text.as_bytes(),
            separator,
            mark: None,
            counted: 0,
            line: 1,
            columns: None,
        };
        file.line_at(skipped);
        file.bytes = &file.bytes[skipped..];
        file.counted -= skipped;
        file
    }

    /// The column names in lower case, and the line of the header; no names if the file has no
    /// rows.
    ///
    /// # Errors
    /// If a row is not valid CSV or a column has no name.
    pub(crate) fn header(&mut self) -> Result<(csv::StringRecord, usize)> {
        let mut record = csv::StringRecord::new();
        let mut line = 1;
        while let Some(next) = self.next_row(&mut record)? {
            line = next;
            if !record.iter().all(str::is_empty) {
                break;
            }
        }
        trim_end(&mut record, 0);
        if let Some(place) = record.iter().position(str::is_empty) {
            return Err(Error::input(
                format!("{}:{line}: column {}", self.name, place + 1),
                "the column has no name",
                "name it, or remove it",
            ));
        }
        self.columns = Some(record.len());
        let names = record.iter().map(str::to_lowercase).collect();
        Ok((names, line))
    }

    /// Reads the next row that contains text, trimmed and as long as the header, and returns its
    /// line; `None` at the end.
    ///
    /// # Errors
    /// If a row is not valid CSV, or has more or fewer fields than the header.
    pub(crate) fn next(&mut self, record: &mut csv::StringRecord) -> Result<Option<usize>> {
        let columns = self.columns.unwrap_or_default();
        while let Some(line) = self.next_row(record)? {
            if record.iter().all(str::is_empty) {
                continue;
            }
            trim_end(record, columns);
            if record.len() == columns {
                return Ok(Some(line));
            }
            let separator = self.separator.to_string();
            let fields: Vec<&str> = record.iter().collect();
            return Err(Error::input(
                format!("{}:{line}", self.name),
                format!(
                    "expected {columns} fields as in the header, found {}: `{}`",
                    record.len(),
                    shown(&fields.join(&separator))
                ),
                "give every row one field per column",
            ));
        }
        Ok(None)
    }

    /// What messages call the file.
    pub(crate) fn name(&self) -> &'a str {
        self.name
    }

    /// The line reached so far: that of the last row or of its error.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    fn next_row(&mut self, record: &mut csv::StringRecord) -> Result<Option<usize>> {
        let more = self.reader.read_record(record).map_err(|error| {
            Error::input(
                format!("{}:{}", self.name, self.line),
                format!("not valid CSV: {error}"),
                "give every row one field per column",
            )
            .caused_by(error)
        })?;
        if !more {
            return Ok(None);
        }
        let start = record.position().map_or(0, csv::Position::byte);
        let line = self.line_at(start as usize);
        // Otherwise an unclosed quote would swallow all following rows.
        if let Some(field) = record.iter().find(|field| field.contains(['\n', '\r'])) {
            return Err(Error::input(
                format!("{}:{line}", self.name),
                format!("the field `{}` spans more than one line", shown(field)),
                "close the quote; each item must be on a single line",
            ));
        }
        record.trim();
        Ok(Some(line))
    }

    /// The line of the row that starts at byte `start`, with comments skipped.
    fn line_at(&mut self, start: usize) -> usize {
        let mut in_comment = false;
        let mut at_start = true;
        while let Some(&byte) = self.bytes.get(self.counted) {
            let ends_line = byte == b'\n' || byte == b'\r';
            in_comment |= at_start && byte == b'#';
            if self.counted >= start && !ends_line && !in_comment {
                break;
            }
            in_comment &= !ends_line;
            at_start = ends_line;
            // The two characters of a Windows line ending count once.
            let in_pair = byte == b'\r' && self.bytes.get(self.counted + 1) == Some(&b'\n');
            self.line += usize::from(ends_line && !in_pair);
            self.counted += 1;
        }
        self.line
    }

    /// The first comment below the header that looks like a row, with its line: it has as many
    /// fields as the header and satisfies `is_row`. It may be a row whose first field starts with
    /// `#`.
    pub(crate) fn commented_row(
        &mut self,
        is_row: impl Fn(&mut Self, &[&str]) -> bool,
    ) -> Option<(usize, &'a str)> {
        let text = std::str::from_utf8(self.bytes).unwrap_or_default();
        let mut line = self.line_at(0);
        let below = &text[self.counted..];
        if !below.contains("\n#") && !below.contains("\r#") {
            return None;
        }
        let mut rest = below;
        while let Some(end) = rest.find(['\n', '\r']) {
            rest = rest[end..].strip_prefix("\r\n").unwrap_or(&rest[end + 1..]);
            line += 1;
            if rest.starts_with('#') {
                let row = rest.split(['\n', '\r']).next().unwrap_or_default();
                let fields: Vec<&str> = row.split(self.separator).map(str::trim).collect();
                if Some(fields.len()) == self.columns && is_row(self, &fields) {
                    return Some((line, row));
                }
            }
        }
        None
    }

    /// Parses `field` as a number with a decimal point. A decimal comma is accepted if commas do
    /// not separate fields and no other number in the file has a point.
    ///
    /// # Errors
    /// Why it is not a number.
    pub(crate) fn number(&mut self, field: &str) -> std::result::Result<f64, NumberError> {
        let mark = match (field.contains('.'), field.contains(',')) {
            (true, false) => Some(Mark::Point),
            (false, true) if self.separator != ',' => Some(Mark::Comma),
            (_, true) => return Err(NumberError::Mark),
            (false, false) => None,
        };
        if let Some(mark) = mark
            && *self.mark.get_or_insert(mark) != mark
        {
            return Err(NumberError::Mark);
        }
        let number: f64 = match mark {
            Some(Mark::Comma) => field.replacen(',', ".", 1).parse()?,
            _ => field.parse()?,
        };
        // Callers reject `nan` and `inf`. 1e400 overflows to infinity, so it is rejected here.
        let fits = number.is_finite() || !field.contains(|c: char| c.is_ascii_digit());
        fits.then_some(number).ok_or(NumberError::TooLarge)
    }

    /// How to write a number: the cure for a field that is not one.
    pub(crate) fn number_cure(&self) -> &'static str {
        match (self.separator, self.mark) {
            (',', _) => {
                "write it with a decimal point and no unit, for example -0.15 (decimal commas \
                 need semicolons or tabs between the fields)"
            }
            (_, Some(Mark::Comma)) => {
                "write it with a decimal comma like the others, with no thousands separators \
                 and no unit, for example -0,15"
            }
            _ => "write it with a decimal point and no unit, for example -0.15",
        }
    }
}

/// The characters that may separate fields.
const SEPARATORS: [char; 3] = [',', ';', '\t'];

/// The separator of this line: the one that occurs most often outside quotes.
fn separator_of(line: &str) -> char {
    let mut counts = [0; SEPARATORS.len()];
    let mut quoted = false;
    for character in line.chars() {
        quoted ^= character == '"';
        if let Some(place) = SEPARATORS.iter().position(|&c| c == character)
            && !quoted
        {
            counts[place] += 1;
        }
    }
    // On a tie the first one, which is the comma.
    let most = counts.iter().copied().max().unwrap_or_default();
    let place = counts.iter().position(|&count| count == most);
    SEPARATORS[place.unwrap_or_default()]
}

/// Removes trailing empty fields of `record` while it has more than `least` fields.
fn trim_end(record: &mut csv::StringRecord, least: usize) {
    let empty = record.iter().rev().take_while(|field| field.is_empty());
    let kept = (record.len() - empty.count()).max(least.min(record.len()));
    record.truncate(kept);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(text: &str) -> Vec<(usize, Vec<String>)> {
        let mut file = CsvFile::new(text, "t");
        let (header, line) = file.header().unwrap();
        let owned = |record: &csv::StringRecord| record.iter().map(str::to_owned).collect();
        let mut rows = vec![(line, owned(&header))];
        let mut record = csv::StringRecord::new();
        while let Some(line) = file.next(&mut record).unwrap() {
            rows.push((line, owned(&record)));
        }
        rows
    }

    #[test]
    fn what_separates_is_found() {
        for text in [
            "id,x\na,1\n",
            "id;x\na;1\n",
            "ID\tX\na\t1\n",
            "\u{feff}id;x\r\na;1\r\n",
            "id,x,\na,1,\n",
            "id,x,,\na,1\n",
            "id,x\na,1,,\n",
            "\"id\";\"x\"\n\"a\";1\n",
        ] {
            let rows = rows(text);
            assert_eq!(rows[0], (1, vec!["id".into(), "x".into()]), "{text:?}");
            assert_eq!(rows[1], (2, vec!["a".into(), "1".into()]), "{text:?}");
        }
    }

    #[test]
    fn lines_are_counted_past_what_is_skipped() {
        for (text, header, row) in [
            ("# by pickline\nid,x\na,1\n", 2, 3),
            ("sep=;\r\nid;x\r\na;1\r\n", 2, 3),
            (
                "# one\r\n# two, with \"\r\n\r\nid,x\r\n# three\r\n;\r\n",
                4,
                0,
            ),
            ("  \nid,x\na,1\n", 2, 3),
            (",,\nid,x\na,1\n", 2, 3),
            ("id,x\n,\n# more\n\na,1\n", 1, 5),
            ("#\n#\n\n#\nid,x\n,\na,1", 5, 7),
        ] {
            let rows = match row {
                0 => continue,
                _ => rows(text),
            };
            assert_eq!((rows[0].0, rows[1].0), (header, row), "{text:?}");
        }
    }

    #[test]
    fn numbers_have_one_kind_of_decimal_mark() {
        let mut file = CsvFile::new("id;x\n", "t");
        assert_eq!(file.number("12"), Ok(12.0));
        assert_eq!(file.number("-0,15"), Ok(-0.15));
        assert_eq!(file.number("0.15"), Err(NumberError::Mark));
        assert_eq!(file.number("1.234,5"), Err(NumberError::Mark));
        assert!(matches!(file.number("1,234,5"), Err(NumberError::Form(_))));
        assert!(file.number_cure().contains("decimal comma"));
        let mut file = CsvFile::new("id;x\n", "t");
        assert_eq!(file.number("0.15"), Ok(0.15));
        assert_eq!(file.number("0,15"), Err(NumberError::Mark));
        let mut file = CsvFile::new("id,x\n", "t");
        assert_eq!(file.number("0,15"), Err(NumberError::Mark));
        assert_eq!(file.number("1e400"), Err(NumberError::TooLarge));
    }

    #[test]
    fn rows_of_another_length_are_named() {
        for (text, words) in [
            ("id,x\na\n", &["t:2", "found 1", "expected 2"][..]),
            ("id;x\na;1;2\n", &["t:2", "found 3", "`a;1;2`"]),
            ("id,,x\n", &["t:1: column 2", "no name"]),
            ("id,x\n\"a,1\nb,2\n", &["t:2", "spans more than one line"]),
        ] {
            let mut file = CsvFile::new(text, "t");
            let mut record = csv::StringRecord::new();
            let error = file.header().and_then(|_| file.next(&mut record));
            let message = error.unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{word} not in {message}");
            }
        }
    }
}
