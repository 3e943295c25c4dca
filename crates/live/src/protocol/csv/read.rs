//! Converts a line of the dialect to the JSON of its message.

use super::super::rejection::{Rejected, Rejection};
use super::fields;
use super::frame::{Sequence, opened};
use super::table::{FieldKind, Form, TO_NODE};
use pickline::error::shown;
use serde_json::{Map, Value};

/// Reads the lines of one peer.
#[derive(Debug, Default)]
pub(crate) struct CsvReader {
    sequence: Sequence,
    /// Timestamp of the previous line [s].
    last: f64,
}

/// The content of a line.
#[derive(Debug, PartialEq)]
pub(crate) struct CsvLine {
    /// Set if lines are missing before this one.
    pub gap: Option<Rejected>,
    /// The JSON of its message, for the common decoder.
    pub message: Result<Vec<u8>, Rejected>,
}

impl CsvLine {
    /// A line with this message or refusal, without a gap.
    pub(crate) fn of(message: Result<Vec<u8>, Rejected>) -> Self {
        Self { gap: None, message }
    }
}

impl CsvReader {
    /// Reads a line, given without its line ending. `now` is the present time [s]. Without it,
    /// times are relative to the previous line and are required.
    pub(crate) fn read(&mut self, line: &[u8], now: Option<f64>) -> CsvLine {
        let mut gap = None;
        let message = opened(line).and_then(|fields| {
            let followed = self.sequence.follow(fields.get(1).unwrap_or(&""));
            let message = match followed {
                Err(rejected) if rejected.reason != Rejection::Sequence => Err(rejected),
                followed => {
                    gap = followed.err();
                    self.message(&fields, now)
                }
            };
            let form = TO_NODE
                .iter()
                .find(|form| Some(&form.letter) == fields.first());
            message.map_err(|rejected| rejected.of_kind(form.map_or("", |form| form.message)))
        });
        let message = message.map(|message| message.to_string().into_bytes());
        CsvLine { gap, message }
    }

    fn message(&mut self, texts: &[&str], now: Option<f64>) -> Result<Value, Rejected> {
        let letter = texts.first().copied().unwrap_or_default();
        let Some(form) = TO_NODE.iter().find(|form| form.letter == letter) else {
            let known: Vec<&str> = TO_NODE.iter().map(|form| form.letter).collect();
            let known = known.join(", ");
            let problem = format!(
                "there is no line `{}`; expected one of {known}",
                shown(letter)
            );
            return Err(Rejected::new(Rejection::Kind, problem));
        };
        // Fields at the end may be omitted.
        let texts = texts.get(2..).unwrap_or_default();
        if texts.len() > form.fields.len() {
            let problem = format!(
                "{}: {} fields; expected at most {} ({}): {}",
                form.message,
                texts.len() + 2,
                form.fields.len() + 2,
                form.about,
                names(form),
            );
            return Err(Rejected::new(Rejection::Field, problem));
        }
        let mut message = Map::new();
        message.insert("kind".into(), Value::from(form.message));
        let mut stamp = now.unwrap_or(self.last);
        let texts = texts.iter().chain(std::iter::repeat(&""));
        for (field, text) in form.fields.iter().zip(texts) {
            let value = match (field.kind, now) {
                // A sender without a clock reports events as they happen.
                (FieldKind::Stamp, Some(now)) if text.is_empty() => Value::from(now),
                _ if text.is_empty() => continue,
                _ => fields::read(field, text, stamp).map_err(|expected| {
                    let (kind, name, text) = (form.message, field.name, shown(text));
                    let problem = format!("{kind}: {name} is `{text}`; expected {expected}");
                    Rejected::new(Rejection::Field, problem)
                })?,
            };
            if let (FieldKind::Stamp, Some(found)) = (field.kind, value.as_f64()) {
                stamp = found;
                self.last = found;
            }
            match field.path.split_once('/') {
                None => drop(message.insert(field.path.into(), value)),
                Some((whole, part)) => {
                    let whole = message.entry(whole).or_insert_with(|| Map::new().into());
                    whole[part] = value;
                }
            }
        }
        Ok(Value::Object(message))
    }
}

/// The names of a line's fields, in order.
fn names(form: &Form) -> String {
    let names = form.fields.iter().map(|field| field.name);
    let names: Vec<&str> = [form.letter, "number"].into_iter().chain(names).collect();
    names.join(",")
}
