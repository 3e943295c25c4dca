//! Converts a message to its lines in the dialect.

use super::LONGEST_CSV_LINE;
use super::fields;
use super::frame::{NUMBERS, framed};
use super::table::{FROM_NODE, FieldKind, Form};
use serde::Serialize;
use serde_json::Value;

/// The line with details about a task's item.
const ITEM: &str = "I";

/// The line with the items that are left on purpose, and the field without which it is not sent.
const LEFT: (&str, &str) = ("L", "unwanted");

/// Writes lines to one peer.
#[derive(Debug)]
pub(crate) struct CsvWriter {
    forms: &'static [Form],
    next: u16,
}

impl Default for CsvWriter {
    /// A writer of messages from the node.
    fn default() -> Self {
        let forms = FROM_NODE;
        Self { forms, next: 0 }
    }
}

impl CsvWriter {
    /// A writer of messages to the node.
    #[cfg(test)]
    pub(crate) fn to_node() -> Self {
        let forms = super::table::TO_NODE;
        Self { forms, next: 0 }
    }

    /// The lines of a message, with their line endings; empty for a message that the dialect lacks.
    ///
    /// # Errors
    /// The message does not fit into a line; the error describes it.
    pub(crate) fn write<M: Serialize>(&mut self, message: &M) -> Result<String, String> {
        let message = serde_json::to_value(message).unwrap_or_default();
        let kind = message.get("kind").and_then(Value::as_str);
        let mut lines = String::new();
        for form in self.forms.iter().filter(|form| Some(form.message) == kind) {
            if form.letter == LEFT.0 && message.get(LEFT.1).is_none() {
                continue;
            }
            let line = framed(&self.text(form, &message));
            if line.len() > LONGEST_CSV_LINE {
                if form.letter == ITEM {
                    // This line only supplements the next one.
                    continue;
                }
                let text = line.trim_end();
                return Err(format!(
                    "a {} does not fit into a line of the csv dialect and is not sent: {text}",
                    form.message
                ));
            }
            self.next = (self.next + 1) % NUMBERS;
            lines += &line;
        }
        Ok(lines)
    }

    fn text(&self, form: &Form, message: &Value) -> String {
        let at = |path: &str| message.pointer(&format!("/{path}"));
        let stamp = form
            .fields
            .iter()
            .find(|f| matches!(f.kind, FieldKind::Stamp));
        let stamp = stamp.and_then(|field| at(field.path)?.as_f64());
        // Later times are relative to the timestamp as it is written.
        let stamp = (1e3 * stamp.unwrap_or_default()).round() / 1e3;
        let mut text = format!("{},{}", form.letter, self.next);
        for field in form.fields {
            text.push(',');
            text += &fields::write(field, at(field.path), stamp);
        }
        text
    }
}
