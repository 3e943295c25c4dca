//! The JSON Schema of single kinds of messages, in the simple form that recordings need.

use super::schema::kinds;
use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value, json};

/// The schema of each kind of message by itself, as an object of plain fields. Tools that read
/// recordings follow no references, support no alternatives, and fail if an object has no
/// `properties` or a field no `type`.
pub(crate) fn schemas_of<M: JsonSchema>() -> Vec<(String, Value)> {
    let mut generator = SchemaGenerator::default();
    let all = kinds::<M>(&mut generator);
    let defs = generator.take_definitions(true);
    let each = all.get("oneOf").and_then(Value::as_array);
    let each = each.into_iter().flatten().map(|kind| plain(kind, &defs));
    each.filter_map(|schema| {
        let kind = schema.pointer("/properties/kind/const")?.as_str()?;
        Some((kind.to_owned(), schema))
    })
    .collect()
}

/// `schema` with its references resolved, and optional fields without their null alternative: a
/// field without a value is omitted, never null.
fn plain(schema: &Value, defs: &Map<String, Value>) -> Value {
    let mut fields = match schema {
        Value::Object(fields) => fields.clone(),
        Value::Array(values) => return values.iter().map(|value| plain(value, defs)).collect(),
        other => return other.clone(),
    };
    let target = fields.remove("$ref");
    let target = target.as_ref().and_then(Value::as_str);
    let target = target.and_then(|name| defs.get(name.strip_prefix("#/$defs/")?));
    let some = fields.remove("anyOf").and_then(|either| {
        let either = either.as_array().cloned().unwrap_or_default();
        either.into_iter().find(|one| one["type"] != "null")
    });
    for other in target.into_iter().chain(&some) {
        merge(&mut fields, plain(other, defs));
    }
    if let Some(Value::Array(types)) = fields.get("type") {
        let some = types.iter().find(|one| **one != "null").cloned();
        fields.insert("type".into(), some.unwrap_or_default());
    }
    if let Some(Value::Array(names)) = fields.remove("oneOf") {
        // String constants, each with a description.
        let names: Vec<Value> = names.iter().map(|one| one["const"].clone()).collect();
        fields.insert("type".into(), "string".into());
        fields.insert("enum".into(), names.into());
    }
    // `kind` and `v` are not fields of the type.
    fields.remove("additionalProperties");
    if fields.get("type").is_some_and(|kind| kind == "object") {
        // Counts by name, whose names are not known in advance.
        fields.entry("properties").or_insert_with(|| json!({}));
    }
    let fields = fields.iter();
    fields
        .map(|(name, value)| (name.clone(), plain(value, defs)))
        .collect()
}

/// Merges `other` into `fields`; objects and lists that both have are joined.
fn merge(fields: &mut Map<String, Value>, other: Value) {
    let Value::Object(other) = other else { return };
    for (name, value) in other {
        match (fields.get_mut(&name), value) {
            (Some(Value::Object(ours)), Value::Object(theirs)) => ours.extend(theirs),
            (Some(Value::Array(ours)), Value::Array(theirs)) => ours.extend(theirs),
            (Some(_), _) => {}
            (None, value) => {
                fields.insert(name, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protocol::{Incoming, Outgoing, VERSION};

    #[test]
    fn each_kind_by_itself_is_an_object_of_plain_fields() {
        let incoming = schemas_of::<Incoming>();
        let kinds: Vec<&str> = incoming.iter().map(|(kind, _)| kind.as_str()).collect();
        assert_eq!(kinds, Incoming::KINDS);
        let outgoing = schemas_of::<Outgoing>();
        let kinds: Vec<&str> = outgoing.iter().map(|(kind, _)| kind.as_str()).collect();
        assert_eq!(kinds, Outgoing::KINDS);
        for (kind, schema) in incoming.iter().chain(&outgoing) {
            assert_eq!(schema["type"], "object", "{kind}");
            let text = schema.to_string();
            for word in ["$ref", "anyOf", "oneOf", "\"null\""] {
                assert!(!text.contains(word), "{kind} has {word}: {text}");
            }
        }
        let find = |kind: &str, path: &str| {
            let all = incoming.iter().chain(&outgoing);
            let schema = all.clone().find(|(name, _)| name == kind).unwrap();
            schema.1.pointer(path).cloned().unwrap_or_default()
        };
        assert_eq!(find("detection", "/properties/id/type"), "string");
        assert_eq!(find("detection", "/properties/v/const"), VERSION);
        assert_eq!(find("detection", "/properties/v/type"), "integer");
        assert_eq!(find("status", "/properties/rejected/properties"), json!({}));
        assert_eq!(find("task", "/properties/meet/properties/x/type"), "number");
        assert_eq!(find("result", "/properties/result/enum/1"), "GRASP_FAIL");
        assert_eq!(find("robot", "/properties/state/enum/0"), "idle");
        assert_eq!(
            find("status", "/properties/latency/properties/p99_ms/type"),
            "number"
        );
        let required = find("task", "/required");
        let required = required.as_array().unwrap();
        assert!(required.contains(&json!("kind")) && required.contains(&json!("latest_start")));
    }
}
