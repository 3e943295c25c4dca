//! The JSON Schema of the protocol, made from the types.

use super::VERSION;
use super::incoming::Incoming;
use super::outgoing::Outgoing;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Value, json};

/// JSON Schema (draft 2020-12) of every message: `$defs/Incoming` and `$defs/Outgoing`.
/// Ranges of values are in `docs/protocol.md`.
pub fn schema() -> Value {
    let mut generator = SchemaGenerator::default();
    let mut both = Vec::new();
    for mut schema in [
        Incoming::json_schema(&mut generator).to_value(),
        Outgoing::json_schema(&mut generator).to_value(),
    ] {
        // `v` stands outside the types: it says how to read them.
        let kinds = schema.get_mut("oneOf").and_then(Value::as_array_mut);
        for kind in kinds.into_iter().flatten() {
            if let Some(properties) = kind.get_mut("properties").and_then(Value::as_object_mut) {
                let about = "Version of the protocol.";
                properties.insert("v".into(), json!({"const": VERSION, "description": about}));
            }
        }
        both.push(schema);
    }
    let mut defs = generator.take_definitions(true);
    let outgoing = both.pop();
    let incoming = both.pop();
    defs.insert("Incoming".into(), incoming.unwrap_or_default());
    defs.insert("Outgoing".into(), outgoing.unwrap_or_default());
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "pickline live protocol",
        "description": "One JSON object a line; lengths in m, times in s, belt frame.",
        "anyOf": [{"$ref": "#/$defs/Incoming"}, {"$ref": "#/$defs/Outgoing"}],
        "$defs": defs,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_and_field_is_in_it() {
        let text = schema().to_string();
        for kind in Incoming::KINDS
            .iter()
            .chain(&["task", "cancel", "status", "due"])
        {
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
