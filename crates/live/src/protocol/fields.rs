//! A JSON object in which each key may occur once.

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::{Map, Value};
use std::fmt;

/// A JSON object as it was written. RFC 8259 does not define which of two values under the same key
/// counts, so repetitions are noted.
#[derive(Debug, Default)]
pub(super) struct Fields {
    /// The values by key.
    pub values: Map<String, Value>,
    /// The first repeated key, if there is one.
    pub twice: Option<String>,
}

impl<'de> Deserialize<'de> for Fields {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct FieldsVisitor;

        impl<'de> Visitor<'de> for FieldsVisitor {
            type Value = Fields;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a JSON object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Fields, A::Error> {
                let mut fields = Fields::default();
                while let Some((key, value)) = map.next_entry::<String, Value>()? {
                    if fields.twice.is_none() && fields.values.contains_key(&key) {
                        fields.twice = Some(key.clone());
                    }
                    fields.values.insert(key, value);
                }
                Ok(fields)
            }
        }

        from.deserialize_map(FieldsVisitor)
    }
}
