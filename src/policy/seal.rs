//! A hash in the file that detects a changed bit even if the network is still legal.

use super::metadata::PREFIX;
use crate::error::{Error, Result, shown};
use crate::files::fingerprint;
use prost::Message as _;
use tract_onnx::pb::{ModelProto, StringStringEntryProto};

/// The key of the hash's metadata entry, without our prefix.
const KEY: &str = "content_hash";

fn is_seal(entry: &StringStringEntryProto) -> bool {
    entry.key.strip_prefix(PREFIX) == Some(KEY)
}

/// The hash of the rest of `model`: weights, network and metadata.
///
/// Computed from the model encoded again, not from the file's bytes: they can contain the same
/// data in another order, and they include the hash itself.
fn content_hash(model: &ModelProto) -> String {
    let mut rest = model.clone();
    rest.metadata_props.retain(|entry| !is_seal(entry));
    fingerprint(rest.encode_to_vec())
}

/// Adds the hash to `model`, which must be complete.
pub(super) fn seal(model: &mut ModelProto) {
    let value = content_hash(model);
    model.metadata_props.push(StringStringEntryProto {
        key: format!("{PREFIX}{KEY}"),
        value,
    });
}

/// Checks that `model` is unchanged since it was sealed. Files without a seal, from other
/// programs or older releases, pass.
///
/// # Errors
/// The hash differs from the one in the file; `place` is the location.
pub(super) fn check_seal(model: &ModelProto, place: &str) -> Result<()> {
    let Some(entry) = model.metadata_props.iter().find(|entry| is_seal(entry)) else {
        return Ok(());
    };
    let found = content_hash(model);
    if entry.value == found {
        return Ok(());
    }
    Err(Error::input(
        place,
        format!(
            "the file has changed since it was exported: its content has the hash {found}, but its \
             metadata entry {PREFIX}{KEY} says {}",
            shown(&entry.value)
        ),
        "get the file again from its source, or export it again with `pickline train`",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::Policy;
    use std::path::Path;

    /// The built-in policy is older than the hash and got one later; nothing else in it
    /// changed.
    #[test]
    fn a_seal_is_the_last_entry_and_changes_nothing_else() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("policies/pickline.onnx");
        let shipped = std::fs::read(&path).unwrap();
        let mut model = ModelProto::decode(&shipped[..]).unwrap();
        // Reading and writing lose nothing.
        assert_eq!(model.encode_to_vec(), shipped);
        assert!(is_seal(model.metadata_props.last().unwrap()));
        model.metadata_props.pop();
        assert!(!model.metadata_props.iter().any(is_seal));
        let before = model.encode_to_vec();
        assert!(shipped.starts_with(&before));
        let logits = |bytes: &[u8]| -> Vec<u32> {
            let policy = Policy::from_bytes(bytes, "test").unwrap();
            let layout = policy.layout();
            let mut state = policy.state().unwrap();
            let mask = vec![true; layout.actions()];
            let mut all = Vec::new();
            for row in 0..100 {
                let numbers = 0..layout.observation();
                let numbers = numbers.map(|i| ((row * 31 + i * 7) % 64) as f32 / 64.0);
                let mut logits = vec![0.0; layout.actions()];
                let observation: Vec<f32> = numbers.collect();
                state.logits(&observation, &mask, &mut logits).unwrap();
                all.extend(logits.iter().map(|logit| logit.to_bits()));
            }
            all
        };
        let old = logits(&before);
        assert!(old.len() >= 100);
        assert_eq!(logits(&shipped), old);
        seal(&mut model);
        assert_eq!(model.encode_to_vec(), shipped);
    }
}
