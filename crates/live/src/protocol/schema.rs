//! The JSON Schema of the protocol, generated from the types.

use super::VERSION;
use super::incoming::Incoming;
use super::outgoing::Outgoing;
use super::session::{FromNode, ToNode};
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Value, json};

/// JSON Schema (draft 2020-12) of every message: `$defs/Incoming` and `$defs/Outgoing`.
/// Ranges of values are in `docs/protocol.md`. The names in `$defs` are part of the format: a type
/// that is renamed keeps its name there by `schemars(rename)`.
pub fn schema() -> Value {
    let mut generator = SchemaGenerator::default();
    let mut incoming = kinds::<Incoming>(&mut generator);
    let mut outgoing = kinds::<Outgoing>(&mut generator);
    // Hellos are separate from the line's messages: the controller does not see them.
    add(&mut incoming, &kinds::<ToNode>(&mut generator));
    add(&mut outgoing, &kinds::<FromNode>(&mut generator));
    let mut defs = generator.take_definitions(true);
    defs.insert("Incoming".into(), incoming);
    defs.insert("Outgoing".into(), outgoing);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "pickline live protocol",
        "description": "One JSON object per line; lengths in m, times in s, belt frame.",
        "anyOf": [{"$ref": "#/$defs/Incoming"}, {"$ref": "#/$defs/Outgoing"}],
        "$defs": defs,
    })
}

/// Adds the message kinds of `other` to those of `schema`.
fn add(schema: &mut Value, other: &Value) {
    if let (Some(Value::Array(ours)), Some(Value::Array(theirs))) =
        (schema.get_mut("oneOf"), other.get("oneOf"))
    {
        ours.extend(theirs.iter().cloned());
    }
}

/// The schema of messages that are distinguished by `kind`, with `v`.
pub(super) fn kinds<M: JsonSchema>(generator: &mut SchemaGenerator) -> Value {
    let mut schema = M::json_schema(generator).to_value();
    // `v` is not part of the types: it defines how to read them.
    for kind in schema
        .get_mut("oneOf")
        .and_then(Value::as_array_mut)
        .into_iter()
        .flatten()
    {
        if let Some(properties) = kind.get_mut("properties").and_then(Value::as_object_mut) {
            let about = "Version of the protocol.";
            let version = json!({"type": "integer", "const": VERSION, "description": about});
            properties.insert("v".into(), version);
        }
    }
    schema
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_and_field_is_in_it() {
        let text = schema().to_string();
        let kinds = Incoming::KINDS.iter().chain(&Outgoing::KINDS);
        for kind in kinds.chain(&["hello"]) {
            assert!(text.contains(&format!("\"const\":\"{kind}\"")), "{kind}");
        }
        for word in [
            "latest_start",
            "available_at",
            "GRASP_FAIL",
            "covariance",
            "\"v\"",
        ] {
            assert!(text.contains(word), "{word}");
        }
    }
}
