//! Converts a line to a message, or to a one-line explanation of what is wrong with it.

use super::VERSION;
use super::check::{check_hello, check_values};
use super::fields::Fields;
use super::incoming::Incoming;
use super::outgoing::Outgoing;
use super::rejection::{LONGEST_LINE, Rejected, Rejection};
use super::session::{Hello, HelloAnswer};
use pickline::error::{known_names, shown};
use pickline::names::LONGEST_NAME;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

/// Decodes a line, given without its line ending, as a message to the node.
///
/// # Errors
/// The line is not a message of this version, or a value is out of its range.
pub fn decode(line: &[u8]) -> Result<Incoming, Rejected> {
    let (kind, fields) = open(line, &Incoming::KINDS)?;
    message(&kind, fields)
}

/// A line from a peer to the node.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PeerMessage {
    /// Its hello.
    Hello(Hello),
    /// A message for the line.
    Message(Incoming),
}

/// Decodes a line, given without its line ending, as a peer's hello or its message to the node.
///
/// # Errors
/// As for [`decode`].
pub(crate) fn decode_said(line: &[u8]) -> Result<PeerMessage, Rejected> {
    const KINDS: [&str; Incoming::KINDS.len() + 1] = {
        let mut kinds = [Hello::KIND; Incoming::KINDS.len() + 1];
        let mut i = 0;
        while i < Incoming::KINDS.len() {
            kinds[i] = Incoming::KINDS[i];
            i += 1;
        }
        kinds
    };
    let opened = open(line, &KINDS).map_err(|rejected| rejected.of_kind(&kind_of(line)));
    let (kind, fields) = opened?;
    if kind != Hello::KIND {
        return message(&kind, fields).map(PeerMessage::Message);
    }
    let hello = hello(fields).map_err(|rejected| rejected.of_kind(&kind))?;
    Ok(PeerMessage::Hello(hello))
}

fn hello(mut fields: Map<String, Value>) -> Result<Hello, Rejected> {
    fields.remove("kind");
    let hello = typed(Hello::KIND, fields)?;
    check_hello(&hello)?;
    Ok(hello)
}

/// The kind that an otherwise invalid line gives itself; empty if it gives none.
fn kind_of(line: &[u8]) -> String {
    let fields = (line.len() <= LONGEST_LINE).then(|| serde_json::from_slice::<Fields>(line).ok());
    let kind = fields
        .flatten()
        .and_then(|mut fields| fields.values.remove("kind"));
    kind.and_then(|kind| kind.as_str().map(str::to_owned))
        .unwrap_or_default()
}

fn message(kind: &str, fields: Map<String, Value>) -> Result<Incoming, Rejected> {
    let message = typed(kind, fields)?;
    check_values(&message)?;
    Ok(message)
}

/// Decodes a line, given without its line ending, as a message from the node. Unlike [`decode`] it
/// ignores unknown fields, because a newer node may send more.
///
/// # Errors
/// The line is not a message of this version.
pub fn decode_outgoing(line: &[u8]) -> Result<Outgoing, Rejected> {
    let (kind, fields) = open(line, &Outgoing::KINDS)?;
    typed(&kind, fields)
}

/// Decodes a line, given without its line ending, as the node's answer to a hello; none if it is
/// something else.
pub fn decode_answer(line: &[u8]) -> Option<HelloAnswer> {
    let (kind, mut fields) = open(line, &[Hello::KIND]).ok()?;
    fields.remove("kind");
    typed(&kind, fields).ok()
}

/// Parses a line into its kind of message, one of `kinds`, and its fields.
fn open(line: &[u8], kinds: &[&str]) -> Result<(String, Map<String, Value>), Rejected> {
    if line.len() > LONGEST_LINE {
        return Err(Rejected::too_long());
    }
    let text = std::str::from_utf8(line).map_err(|error| {
        let at = error.valid_up_to() + 1;
        Rejected::new(
            Rejection::Syntax,
            format!("byte {at} is not UTF-8; expected one JSON object per line, in UTF-8"),
        )
    })?;
    let fields: Fields = serde_json::from_str(text).map_err(|error| {
        Rejected::new(
            Rejection::Syntax,
            format!(
                "{}; expected one JSON object per line",
                one_line(&error.to_string())
            ),
        )
    })?;
    if let Some(key) = fields.twice {
        let problem = format!("`{}` is repeated; expected each field once", shown(&key));
        return Err(Rejected::new(Rejection::Field, problem));
    }
    let mut fields = fields.values;
    match fields.remove("v") {
        None => {}
        Some(version) if version.as_u64() == Some(VERSION) => {}
        Some(version) => {
            let version = shown(&version.to_string());
            let problem = format!("v = {version}; expected version {VERSION}");
            return Err(Rejected::new(Rejection::Version, problem));
        }
    }
    let kind = match fields.get("kind") {
        Some(Value::String(kind)) if kinds.contains(&kind.as_str()) => kind.clone(),
        Some(Value::String(kind)) => {
            let cure = known_names(&shown(kind), kinds);
            let problem = format!("there is no kind `{}`; {cure}", shown(kind));
            return Err(Rejected::new(Rejection::Kind, problem));
        }
        other => {
            let problem = if other.is_some() {
                "is not a string"
            } else {
                "is missing"
            };
            let known = kinds.join(", ");
            let problem = format!("`kind` {problem}; expected one of {known}");
            return Err(Rejected::new(Rejection::Kind, problem));
        }
    };
    Ok((kind, fields))
}

fn typed<M: DeserializeOwned>(kind: &str, fields: Map<String, Value>) -> Result<M, Rejected> {
    serde_json::from_value(Value::Object(fields)).map_err(|error| {
        let problem = format!("{kind}: {}", one_line(&error.to_string()));
        Rejected::new(Rejection::Field, problem)
    })
}

/// A parser's message in one line, safe to print.
fn one_line(text: &str) -> String {
    let mut line: String = text
        .chars()
        .take(LONGEST_NAME)
        .flat_map(|c| {
            if c.is_control() {
                c.escape_debug().collect()
            } else {
                vec![c]
            }
        })
        .collect();
    if text.chars().nth(LONGEST_NAME).is_some() {
        line.push_str("...");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::super::incoming::Detection;
    use super::super::outgoing::encode;
    use super::*;

    #[test]
    fn what_is_written_reads_back_to_the_bit() {
        for x in [0.1 + 0.2, -1.0 / 3.0, 5e-324, 123_456.789_012_345_67] {
            let message = Incoming::Detection(Detection {
                stamp: 1_795_000_000.123_456_7,
                id: Some("a\u{e9}\"b".into()),
                x,
                y: -x / 7.0,
                area_cm2: None,
                p_detection: Some(0.9),
                p_grasp: None,
                weight: None,
                class: Some("PET".into()),
                covariance: Some([1e-6, 0.0, 1e-6]),
                source: Some("top".into()),
                ..Detection::default()
            });
            let line = encode(&message);
            assert!(
                line.starts_with("{\"v\":1,\"kind\":\"detection\""),
                "{line}"
            );
            assert_eq!(decode(line.trim_end().as_bytes()).unwrap(), message);
        }
    }

    #[test]
    fn what_is_wrong_is_named_in_one_line() {
        let long = format!(
            r#"{{"kind":"robot","stamp":1,"name":"{}","state":"idle"}}"#,
            "x".repeat(50_000)
        );
        let huge = "x".repeat(LONGEST_LINE + 1);
        let cases: &[(&str, Rejection, &str)] = &[
            ("", Rejection::Syntax, "EOF"),
            (r#"{"kind":"tick","stamp":1"#, Rejection::Syntax, "EOF"),
            ("[1]", Rejection::Syntax, "one JSON object"),
            (
                r#"{"kind":"tick","stamp":NaN}"#,
                Rejection::Syntax,
                "expected",
            ),
            (
                r#"{"kind":"tick","stamp":1e999}"#,
                Rejection::Syntax,
                "out of range",
            ),
            (
                r#"{"v":2,"kind":"tick","stamp":1}"#,
                Rejection::Version,
                "version 1",
            ),
            (r#"{"stamp":1}"#, Rejection::Kind, "missing"),
            (r#"{"kind":7,"stamp":1}"#, Rejection::Kind, "not a string"),
            (
                r#"{"kind":"tock","stamp":1}"#,
                Rejection::Kind,
                "did you mean `tick`",
            ),
            (
                r#"{"kind":"tick"}"#,
                Rejection::Field,
                "missing field `stamp`",
            ),
            (
                r#"{"kind":"tick","stamp":"1"}"#,
                Rejection::Field,
                "expected f64",
            ),
            (
                r#"{"kind":"tick","stamp":null}"#,
                Rejection::Field,
                "expected f64",
            ),
            (
                r#"{"kind":"ack","stamp":1,"task":-1}"#,
                Rejection::Field,
                "expected u64",
            ),
            (
                r#"{"kind":"ack","stamp":1,"task":1,"task":1}"#,
                Rejection::Field,
                "`task` is repeated",
            ),
            (
                r#"{"kind":"tick","stamp":1,"x":1}"#,
                Rejection::Field,
                "unknown field `x`",
            ),
            (
                r#"{"kind":"ack","stamp":1,"task":1,"x":1}"#,
                Rejection::Field,
                "unknown field `x`",
            ),
            (
                r#"{"kind":"result","stamp":1,"task":1,"result":"OK"}"#,
                Rejection::Field,
                "GRASP_FAIL",
            ),
            (
                r#"{"kind":"tick","stamp":-1}"#,
                Rejection::Value,
                "stamp = -1",
            ),
            (
                r#"{"kind":"tick","stamp":1e300}"#,
                Rejection::Value,
                "stamp = 1e300",
            ),
            (
                r#"{"kind":"belt","stamp":1,"speed":1e9}"#,
                Rejection::Value,
                "speed",
            ),
            (
                r#"{"kind":"detection","stamp":1,"x":1e9,"y":0}"#,
                Rejection::Value,
                "x = ",
            ),
            (
                r#"{"kind":"detection","stamp":1,"x":0,"y":0,"p_grasp":2}"#,
                Rejection::Value,
                "probability",
            ),
            (
                r#"{"kind":"detection","stamp":1,"x":0,"y":0,"id":""}"#,
                Rejection::Value,
                "id",
            ),
            (
                r#"{"kind":"detection","stamp":1,"x":0,"y":0,"id":"a\nb"}"#,
                Rejection::Value,
                "control",
            ),
            (
                r#"{"kind":"detection","stamp":1,"x":0,"y":0,"covariance":[1,2,1]}"#,
                Rejection::Value,
                "xy^2",
            ),
            (&long, Rejection::Value, "at most 200"),
            (&huge, Rejection::TooLong, "longer than"),
        ];
        for (line, reason, word) in cases {
            let rejected = decode(line.as_bytes()).unwrap_err();
            assert_eq!(rejected.reason, *reason, "{rejected:?}");
            assert!(rejected.message.contains(word), "{rejected:?}");
            assert!(!rejected.message.contains('\n') && rejected.message.len() < 500);
        }
        assert_eq!(
            decode(b"{\"kind\":\"\xff\"}").unwrap_err().reason,
            Rejection::Syntax
        );
    }
}
