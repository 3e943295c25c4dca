//! The keys of one JSON object, each of which may stand there once.

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::{Map, Value};
use std::fmt;

/// A JSON object as it was written. Which of two values under one key is meant nobody can
/// know: RFC 8259 leaves it to whoever reads.
#[derive(Debug, Default)]
pub struct Fields {
    /// The values by their keys.
    pub values: Map<String, Value>,
    /// The first key that stands there again, if any does.
    pub twice: Option<String>,
}

impl<'de> Deserialize<'de> for Fields {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        struct Reader;

        impl<'de> Visitor<'de> for Reader {
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

        from.deserialize_map(Reader)
    }
}
