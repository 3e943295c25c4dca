//! Reads values from a TOML file. Every error names the line, the key, the value and the cure.

use crate::error::{Error, Result, known_names, shown};
use nalgebra::Point2;
use std::cell::RefCell;
use std::collections::HashMap;
use std::num::ParseIntError;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// The file being read: its name, its text, and the line of each key, for messages.
pub(crate) struct File<'a> {
    pub name: &'a str,
    text: &'a str,
    /// Where the user can find an example, for cures.
    example: &'a str,
    lines: RefCell<HashMap<String, usize>>,
    aliases: RefCell<HashMap<String, String>>,
}

impl<'a> File<'a> {
    /// A file with the content `text`. Messages call it `name` and refer to `example` for an
    /// example.
    pub(crate) fn new(name: &'a str, text: &'a str, example: &'a str) -> Self {
        Self {
            name,
            text: text.strip_prefix('\u{feff}').unwrap_or(text),
            example,
            lines: RefCell::default(),
            aliases: RefCell::default(),
        }
    }

    /// Passes the file's top-level table to `read`.
    pub(crate) fn read<T>(&self, read: impl FnOnce(&Section) -> Result<T>) -> Result<T> {
        if self.text.trim().is_empty() {
            return Err(Error::input(
                self.name,
                "the file is empty",
                format!("start from {}", self.example),
            ));
        }
        let root = DeTable::parse(self.text).map_err(|error| {
            let line = error.span().map_or(1, |span| self.line(span.start));
            let cure = match error.message().contains("duplicate key") {
                true => self.duplicate_cure(line),
                false => {
                    "fix the line; strings need quotes, and numbers a digit before the decimal \
                          point"
                        .to_owned()
                }
            };
            Error::input(
                format!("{}:{line}", self.name),
                format!(
                    "not valid TOML: {}",
                    error.message().trim().replace('\n', "; ")
                ),
                cure,
            )
            .caused_by(error)
        })?;
        read(&Section {
            file: self,
            path: String::new(),
            table: root.get_ref(),
            line: 1,
        })
    }

    /// The cure for a key that is there twice, the second time on this line.
    fn duplicate_cure(&self, line: usize) -> String {
        let text = self.text.lines().nth(line - 1).unwrap_or_default().trim();
        match text.starts_with('[') {
            true => format!(
                "`{}` is a key that already has a value; keep one of the two",
                shown(text)
            ),
            false => "give every key once".to_owned(),
        }
    }

    pub(crate) fn line(&self, offset: usize) -> usize {
        let offset = offset.min(self.text.len());
        1 + self.text.as_bytes()[..offset]
            .iter()
            .filter(|&&byte| byte == b'\n')
            .count()
    }

    pub(crate) fn remember<T>(&self, key: &str, value: &Spanned<T>) -> usize {
        let line = self.line(value.span().start);
        self.lines.borrow_mut().insert(key.to_owned(), line);
        line
    }

    /// Messages about `key`, which is derived from `other`, name `other` instead.
    pub(crate) fn alias(&self, key: &str, other: &str) {
        let mut aliases = self.aliases.borrow_mut();
        aliases.insert(key.to_owned(), other.to_owned());
    }

    /// `file:line: key`; the line is that of the key or of the nearest enclosing table.
    pub(crate) fn place(&self, key: &str) -> String {
        let (lines, aliases) = (self.lines.borrow(), self.aliases.borrow());
        let mut key = key;
        while let Some(other) = aliases.get(key) {
            key = other;
        }
        let mut known = key;
        loop {
            if let Some(line) = lines.get(known) {
                return format!("{}:{line}: {key}", self.name);
            }
            match known.rfind('.') {
                Some(dot) => known = &known[..dot],
                None => return format!("{}: {key}", self.name),
            }
        }
    }
}

/// One table of the file, with its path as messages show it.
pub(crate) struct Section<'a> {
    pub file: &'a File<'a>,
    pub path: String,
    pub table: &'a DeTable<'a>,
    pub line: usize,
}

impl<'a> Section<'a> {
    fn key(&self, key: &str) -> String {
        if self.path.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.path)
        }
    }

    pub(crate) fn wrong(&self, key: &str, problem: String, cure: String) -> Error {
        if let Some(value) = self.table.get(key) {
            self.file.remember(&self.key(key), value);
        }
        Error::input(self.file.place(&self.key(key)), problem, cure)
    }

    pub(crate) fn missing(&self, key: &str) -> Error {
        self.missing_or(key, "")
    }

    /// That `key` is missing, for which something else would do.
    pub(crate) fn missing_or(&self, key: &str, otherwise: &str) -> Error {
        Error::input(
            format!("{}:{}: {}", self.file.name, self.line, self.key(key)),
            "the key is missing",
            format!("add `{key} = ...`{otherwise}; see {}", self.file.example),
        )
    }

    pub(crate) fn only(&self, known: &[&str]) -> Result<()> {
        for (key, _) in self.table.iter() {
            let name: &str = key.get_ref();
            if !known.contains(&name) {
                let line = self.file.line(key.span().start);
                return Err(Error::input(
                    format!("{}:{line}: {}", self.file.name, self.key(&shown(name))),
                    "unknown key",
                    known_names(name, known),
                ));
            }
        }
        Ok(())
    }

    pub(crate) fn section(&self, key: &str) -> Result<Section<'a>> {
        let Some(value) = self.table.get(key) else {
            return Err(Error::input(
                self.file.name,
                format!("the file has no [{key}] table"),
                format!("add a [{key}] table; see {}", self.file.example),
            ));
        };
        let line = self.file.remember(&self.key(key), value);
        let DeValue::Table(table) = value.get_ref() else {
            return Err(self.wrong(
                key,
                format!("{} is not a table", describe(value.get_ref())),
                format!("write it as [{key}] with one key per line"),
            ));
        };
        Ok(Section {
            file: self.file,
            path: self.key(key),
            table,
            line,
        })
    }

    /// The tables of the list `key`, each under its own [[key]] header.
    pub(crate) fn tables(&self, key: &str) -> Result<Vec<Section<'a>>> {
        let Some(value) = self.table.get(key) else {
            return Ok(Vec::new());
        };
        let name = self.key(key);
        self.file.remember(&name, value);
        let header = format!(
            "write each table under its own [[{}]] header",
            without_indices(&name)
        );
        let DeValue::Array(list) = value.get_ref() else {
            let found = describe(value.get_ref());
            return Err(self.wrong(key, format!("{found} is not a list of tables"), header));
        };
        let table = |(i, value): (usize, &'a Spanned<DeValue<'a>>)| {
            let path = format!("{name}[{i}]");
            let line = self.file.remember(&path, value);
            match value.get_ref() {
                DeValue::Table(table) => Ok(Section {
                    file: self.file,
                    path,
                    table,
                    line,
                }),
                other => Err(Error::input(
                    self.file.place(&path),
                    format!("{} is not a table", describe(other)),
                    header.clone(),
                )),
            }
        };
        list.iter().enumerate().map(table).collect()
    }

    fn value(&self, key: &str) -> Option<&'a DeValue<'a>> {
        let value = self.table.get(key)?;
        self.file.remember(&self.key(key), value);
        Some(value.get_ref())
    }

    pub(crate) fn optional(&self, key: &str) -> Result<Option<f64>> {
        let Some(value) = self.value(key) else {
            return Ok(None);
        };
        as_number(value).map(Some).map_err(|cause| {
            let wrong = self.wrong(
                key,
                format!("{} is not a number", describe(value)),
                "give a number in SI units (m, s, m/s), without quotes".into(),
            );
            with_cause(wrong, cause)
        })
    }

    pub(crate) fn number(&self, key: &str) -> Result<f64> {
        self.optional(key)?.ok_or_else(|| self.missing(key))
    }

    pub(crate) fn optional_count(&self, key: &str) -> Result<Option<usize>> {
        let Some(value) = self.value(key) else {
            return Ok(None);
        };
        let count = match value {
            DeValue::Integer(n) => as_integer(n)
                .map_err(Some)
                .and_then(|n| usize::try_from(n).map_err(|_| None)),
            _ => Err(None),
        };
        count.map(Some).map_err(|cause| {
            let wrong = self.wrong(
                key,
                format!("{} is not a valid count", describe(value)),
                "give a whole number of at least 1".into(),
            );
            with_cause(wrong, cause)
        })
    }

    pub(crate) fn text(&self, key: &str) -> Result<String> {
        match self.value(key) {
            None => Err(self.missing(key)),
            Some(DeValue::String(text)) => Ok(text.to_string()),
            Some(other) => Err(self.wrong(
                key,
                format!("{} is not a string", describe(other)),
                format!("put it in quotes: {key} = \"...\""),
            )),
        }
    }

    pub(crate) fn optional_text(&self, key: &str) -> Result<Option<String>> {
        match self.table.contains_key(key) {
            true => self.text(key).map(Some),
            false => Ok(None),
        }
    }

    pub(crate) fn optional_bool(&self, key: &str) -> Result<Option<bool>> {
        match self.value(key) {
            None => Ok(None),
            Some(DeValue::Boolean(value)) => Ok(Some(*value)),
            Some(other) => Err(self.wrong(
                key,
                format!("{} is neither true nor false", describe(other)),
                format!("write {key} = true or {key} = false, without quotes"),
            )),
        }
    }

    /// A list of strings.
    pub(crate) fn optional_texts(&self, key: &str) -> Result<Option<Vec<String>>> {
        let Some(value) = self.value(key) else {
            return Ok(None);
        };
        let text = |value: &Spanned<DeValue>| match value.get_ref() {
            DeValue::String(text) => Some(text.to_string()),
            _ => None,
        };
        let texts = match value {
            DeValue::Array(list) => list.iter().map(text).collect::<Option<Vec<_>>>(),
            _ => None,
        };
        texts.map(Some).ok_or_else(|| {
            self.wrong(
                key,
                format!("{} is not a list of strings", describe(value)),
                format!("put each name in quotes: {key} = [\"pet\", \"hdpe\"]"),
            )
        })
    }

    /// A list of pairs of numbers.
    pub(crate) fn optional_pairs(&self, key: &str) -> Result<Option<Vec<(f64, f64)>>> {
        let Some(value) = self.value(key) else {
            return Ok(None);
        };
        let pair = |value: &Spanned<DeValue>| match value.get_ref() {
            DeValue::Array(pair) => match &pair[..] {
                [a, b] => Some((as_number(a.get_ref()).ok()?, as_number(b.get_ref()).ok()?)),
                _ => None,
            },
            _ => None,
        };
        let wrong = |problem: String| {
            let cure = format!(
                "give length in m and time in s of each: {key} = [[0.0, 0.08], [0.1, 0.15]]"
            );
            self.wrong(key, problem, cure)
        };
        let DeValue::Array(list) = value else {
            return Err(wrong(format!(
                "{} is not a list of points",
                describe(value)
            )));
        };
        let points = list.iter().zip(1..).map(|(point, number)| {
            let what = || describe(point.get_ref());
            pair(point).ok_or_else(|| wrong(format!("point {number}, {}, is no point", what())))
        });
        points.collect::<Result<_>>().map(Some)
    }

    /// Whether the value of `key` is a list of tables rather than of numbers.
    pub(crate) fn has_tables(&self, key: &str) -> bool {
        let first = match self.table.get(key).map(Spanned::get_ref) {
            Some(DeValue::Array(list)) => list.first(),
            _ => None,
        };
        first.is_some_and(|first| matches!(first.get_ref(), DeValue::Table(_)))
    }

    pub(crate) fn optional_point(&self, key: &str) -> Result<Option<Point2<f64>>> {
        match self.table.contains_key(key) {
            true => self.point(key).map(Some),
            false => Ok(None),
        }
    }

    pub(crate) fn point(&self, key: &str) -> Result<Point2<f64>> {
        let value = self.value(key).ok_or_else(|| self.missing(key))?;
        let coordinates: std::result::Result<Vec<f64>, _> = match value {
            DeValue::Array(list) => list.iter().map(|v| as_number(v.get_ref())).collect(),
            _ => Err(None),
        };
        let cause = match coordinates.as_deref() {
            Ok(&[x, y]) => return Ok(Point2::new(x, y)),
            Ok(_) => None,
            Err(cause) => cause.clone(),
        };
        let wrong = self.wrong(
            key,
            format!("{} is not a position", describe(value)),
            format!("give x and y in metres: {key} = [1.3, -0.625]"),
        );
        Err(with_cause(wrong, cause))
    }
}

/// The path of a table as it is written in a header: `robot[0].bin` is `robot.bin`.
fn without_indices(path: &str) -> String {
    let mut parts = path
        .split('.')
        .map(|part| part.split('[').next().unwrap_or(part));
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |path, part| format!("{path}.{part}"))
}

/// `error` with the error beneath it, if there is one.
fn with_cause(error: Error, cause: Option<ParseIntError>) -> Error {
    match cause {
        Some(cause) => error.caused_by(cause),
        None => error,
    }
}

/// The value as a number; otherwise the error of parsing it, if it is an integer.
fn as_number(value: &DeValue) -> std::result::Result<f64, Option<ParseIntError>> {
    match value {
        DeValue::Float(number) => {
            let text = number.as_str();
            // TOML accepts `inf` and `nan`; the range checks reject them. 1e400 overflows to
            // infinity, so it is rejected here.
            let fits = |n: &f64| n.is_finite() || !text.contains(|c: char| c.is_ascii_digit());
            text.replace('_', "").parse().ok().filter(fits).ok_or(None)
        }
        DeValue::Integer(number) => as_integer(number).map(|n| n as f64).map_err(Some),
        _ => Err(None),
    }
}

fn as_integer(number: &DeInteger) -> std::result::Result<i64, ParseIntError> {
    i64::from_str_radix(&number.as_str().replace('_', ""), number.radix())
}

/// Describes a value for messages.
fn describe(value: &DeValue) -> String {
    // A list longer than a position would be unreadable.
    const MOST: usize = 4;
    match value {
        DeValue::String(text) => format!("the string \"{}\"", shown(text)),
        DeValue::Integer(number) => shown(&number.to_string()),
        DeValue::Float(number) => shown(number.as_str()),
        DeValue::Boolean(truth) => truth.to_string(),
        DeValue::Datetime(date) => date.to_string(),
        DeValue::Array(list) if list.len() <= MOST => {
            let each: Vec<_> = list.iter().map(|v| describe(v.get_ref())).collect();
            format!("the list [{}]", each.join(", "))
        }
        DeValue::Array(list) => format!("a list of {} values", list.len()),
        DeValue::Table(_) => "a table".into(),
    }
}
