//! Single fields: from text to a value of the message, and back.

use super::table::{Field, FieldKind};
use serde_json::{Map, Number, Value};

/// Timestamps are written modulo this [ms], about 11.6 days, to fit into 32 bits.
pub(super) const TURN: f64 = 1e9;

/// `text` as a field can hold it: ASCII without separators, at most `most` characters.
pub(super) fn plain(text: &str, most: usize) -> String {
    let plain = |c: char| match c {
        ',' | ';' | '*' => '_',
        ' '..='~' => c,
        _ => '_',
    };
    let text: String = text.chars().take(most).map(plain).collect();
    text.trim().to_owned()
}

/// The timestamp [s] nearest to `near` [s] that is written as `ms` in a line.
pub(super) fn unwrapped(ms: f64, near: f64) -> f64 {
    let turns = ((1e3 * near - ms) / TURN).round().max(0.0);
    (turns * TURN + ms) / 1e3
}

/// Parses a field's text into a value of the message whose line has the timestamp `stamp` [s].
///
/// # Errors
/// The text is invalid; the error is what was expected.
pub(super) fn read(field: &Field, text: &str, stamp: f64) -> Result<Value, String> {
    match field.kind {
        FieldKind::Stamp | FieldKind::After => {
            let ms = number(text).ok_or("a time [ms]")?;
            match field.kind {
                FieldKind::Stamp if !(0.0..TURN).contains(&ms) => {
                    Err("a time from 0 to 999999999 [ms]".to_owned())
                }
                FieldKind::Stamp => Ok(json(unwrapped(ms, stamp))),
                _ => Ok(json(stamp + ms / 1e3)),
            }
        }
        FieldKind::Milli => Ok(json(number(text).ok_or("a number [mm, mm/s]")? / 1e3)),
        FieldKind::Degrees => Ok(json(number(text).ok_or("an angle [deg]")?.to_radians())),
        FieldKind::Number => Ok(json(number(text).ok_or("a number")?)),
        FieldKind::Count => text
            .parse::<u64>()
            .map(Value::from)
            .map_err(|_| "a whole number".to_owned()),
        FieldKind::Text(most) if text.len() > most => Err(format!("at most {most} characters")),
        FieldKind::Text(_) => Ok(Value::from(text)),
        FieldKind::Choice(choices) => {
            let found = choices.iter().find(|(letter, _)| *letter == text);
            found.map(|(_, name)| Value::from(*name)).ok_or_else(|| {
                let letters: Vec<&str> = choices.iter().map(|(letter, _)| *letter).collect();
                format!("one of {}", letters.join(", "))
            })
        }
        FieldKind::Flag => match text {
            "0" => Ok(Value::from(false)),
            "1" => Ok(Value::from(true)),
            _ => Err("0 or 1".to_owned()),
        },
        FieldKind::Texts => Ok(text
            .split(';')
            .map(|part| Value::from(part.trim()))
            .collect()),
        FieldKind::Sum => Err("nothing".to_owned()),
    }
}

/// Parses a decimal number. Other forms that Rust accepts but no controller writes are refused.
fn number(text: &str) -> Option<f64> {
    let is_plain = text.bytes().all(|byte| b"0123456789+-.eE".contains(&byte));
    let number: f64 = text.parse().ok()?;
    (is_plain && number.is_finite()).then_some(number)
}

fn json(number: f64) -> Value {
    Number::from_f64(number).map_or(Value::Null, Value::Number)
}

/// A field's text for a value of the message whose line has the timestamp `stamp` [s]; empty if
/// there is no value.
pub(super) fn write(field: &Field, value: Option<&Value>, stamp: f64) -> String {
    let Some(value) = value.filter(|value| !value.is_null()) else {
        return String::new();
    };
    let number = value.as_f64().unwrap_or_default();
    match field.kind {
        FieldKind::Stamp => decimal((1e3 * number).round().rem_euclid(TURN), 0),
        FieldKind::After => decimal(1e3 * (number - stamp), 0),
        FieldKind::Milli => decimal(1e3 * number, 1),
        FieldKind::Degrees => decimal(number.to_degrees(), 1),
        FieldKind::Number => decimal(number, 3),
        FieldKind::Count => value.to_string(),
        FieldKind::Text(most) => plain(value.as_str().unwrap_or_default(), most),
        FieldKind::Choice(choices) => {
            let found = choices.iter().find(|(_, name)| value == name);
            found.map_or(String::new(), |(letter, _)| (*letter).to_owned())
        }
        FieldKind::Flag => u8::from(value == &Value::Bool(true)).to_string(),
        FieldKind::Texts => {
            let texts = value.as_array().into_iter().flatten();
            let texts = texts.filter_map(|text| Some(plain(text.as_str()?, 8)));
            texts.collect::<Vec<_>>().join(";")
        }
        FieldKind::Sum => {
            let counts = value.as_object().into_iter().flat_map(Map::values);
            counts.filter_map(Value::as_u64).sum::<u64>().to_string()
        }
    }
}

/// A number with at most `decimals` decimals, without trailing zeros.
fn decimal(number: f64, decimals: usize) -> String {
    let text = format!("{number:.decimals$}");
    let short = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    match short {
        "-0" => "0".to_owned(),
        short => short.to_owned(),
    }
}
