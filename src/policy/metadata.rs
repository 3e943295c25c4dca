//! The metadata of a policy's file.

use crate::decision::observation::{Layout, VERSION};
use crate::error::{Error, Result, shown};
use std::collections::BTreeMap;

/// Prefix of every key of ours in the file.
pub(super) const PREFIX: &str = "pickline.";

/// The file's metadata; keys have no prefix here.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Metadata {
    entries: BTreeMap<String, String>,
}

impl Metadata {
    /// Metadata that describes how to encode the network's observation.
    pub fn new(layout: &Layout) -> Self {
        let mut metadata = Self::default();
        metadata.set("observation_version", VERSION.to_string());
        metadata.set("view", layout.view.name());
        metadata.set("slots", layout.slots.to_string());
        metadata.set("wait", layout.wait.to_string());
        metadata
    }

    /// Adds an entry, or replaces the one with this key.
    pub fn set(&mut self, key: &str, value: impl Into<String>) {
        self.entries.insert(key.to_owned(), value.into());
    }

    /// The value of `key`, which is written without the prefix.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.entries.get(key).map(String::as_str)
    }

    /// Keys as written in the file, and values.
    pub(crate) fn to_file(&self) -> impl Iterator<Item = (String, &str)> {
        let entries = self.entries.iter();
        entries.map(|(key, value)| (format!("{PREFIX}{key}"), value.as_str()))
    }

    /// Our entries among those of a file.
    pub fn from_file<'f>(entries: impl IntoIterator<Item = (&'f str, &'f str)>) -> Self {
        let ours = entries.into_iter().filter_map(|(key, value)| {
            let key = key.strip_prefix(PREFIX)?;
            Some((key.to_owned(), value.to_owned()))
        });
        Self {
            entries: ours.collect(),
        }
    }

    /// The layout; `None` if the file does not describe it.
    ///
    /// # Errors
    /// Another version of the observation, or entries that cannot be parsed; `place` is the
    /// file.
    pub fn layout(&self, place: &str) -> Result<Option<Layout>> {
        let Some(version) = self.get("observation_version") else {
            return Ok(None);
        };
        if version != VERSION.to_string() {
            return Err(Error::input(
                place,
                format!(
                    "the policy was trained on version {} of the observation, but this program \
                     uses version {VERSION}",
                    shown(version)
                ),
                "train it again (`pickline train`), or use the release that it was trained with",
            ));
        }
        let wrong = |key: &str| {
            Error::input(
                place,
                format!(
                    "the metadata entry {PREFIX}{key} has the invalid value `{}`",
                    shown(self.get(key).unwrap_or_default())
                ),
                "export the policy again with `pickline train`",
            )
        };
        let view = self.get("view").unwrap_or_default();
        let slots = self.get("slots").and_then(|text| text.parse().ok());
        let wait = self.get("wait").and_then(|text| text.parse().ok());
        Ok(Some(Layout {
            view: view.parse().map_err(|_| wrong("view"))?,
            slots: slots
                .filter(|slots| (1..=Layout::MOST_SLOTS).contains(slots))
                .ok_or_else(|| wrong("slots"))?,
            wait: wait.ok_or_else(|| wrong("wait"))?,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_survives_the_file_and_another_version_is_refused() {
        let layout = Layout::PAPER;
        let mut metadata = Metadata::new(&layout);
        let read = |metadata: &Metadata| {
            let entries: Vec<_> = metadata.to_file().collect();
            Metadata::from_file(entries.iter().map(|(k, v)| (k.as_str(), *v)))
        };
        assert_eq!(read(&metadata).layout("f").unwrap(), Some(layout));
        assert_eq!(Metadata::default().layout("f").unwrap(), None);
        metadata.set("slots", "0");
        let message = metadata.layout("f.onnx").unwrap_err().to_string();
        assert!(message.contains("f.onnx") && message.contains("pickline.slots"));
        metadata.set("observation_version", "99");
        let message = metadata.layout("f.onnx").unwrap_err().to_string();
        assert!(message.contains("version 99"), "{message}");
    }
}
