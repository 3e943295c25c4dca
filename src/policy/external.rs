//! Weights that stand in files of their own beside the ONNX file, as torch's exporter writes
//! them by default (<https://onnx.ai/onnx/repo-docs/ExternalData.html>).

use crate::error::{Error, Result, shown};
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use tract_onnx::pb::{GraphProto, TensorProto, tensor_proto::DataLocation};

/// Moves weights that stand in files in `folder` into `graph`. Files of more than `most`
/// bytes are none of a policy. `place` is what messages call the ONNX file.
///
/// # Errors
/// A file that is missing, too large, too short or outside of the folder.
pub fn gather(graph: &mut GraphProto, folder: &Path, most: usize, place: &str) -> Result<()> {
    let mut files: HashMap<PathBuf, Vec<u8>> = HashMap::new();
    let external = DataLocation::External as i32;
    let tensors = graph.initializer.iter_mut();
    for tensor in tensors.filter(|tensor| tensor.data_location == Some(external)) {
        let wrong = |problem: String| {
            let cure = "keep the file of the weights beside the ONNX file under the name that it \
                        was exported with, or export with the weights inside (torch: \
                        external_data=False)";
            let name = shown(&tensor.name);
            Error::input(place, format!("the weights `{name}` {problem}"), cure)
        };
        let entry = |key: &str| {
            let mut entries = tensor.external_data.iter();
            let entry = entries.find(|entry| entry.key == key);
            entry.map(|entry| entry.value.as_str())
        };
        let location = entry("location").unwrap_or_default();
        let name = Path::new(location);
        let is_beside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
        if location.is_empty() || !name.components().all(is_beside) {
            let location = shown(location);
            return Err(wrong(format!(
                "stand in `{location}`, outside of its folder"
            )));
        }
        let path = folder.join(name);
        if !files.contains_key(&path) {
            let size = std::fs::metadata(&path).map_err(|error| {
                wrong(format!(
                    "stand in {}, which cannot be read ({error})",
                    path.display()
                ))
            })?;
            if size.len() > most as u64 {
                return Err(wrong(format!(
                    "stand in {}, which is too large",
                    path.display()
                )));
            }
            let bytes = std::fs::read(&path).map_err(|error| Error::read(&path, error))?;
            files.insert(path.clone(), bytes);
        }
        let bytes = &files[&path];
        let number = |key: &str, otherwise: usize| match entry(key) {
            Some(text) => text.parse::<usize>().ok(),
            None => Some(otherwise),
        };
        let offset = number("offset", 0);
        let rest = bytes.len().saturating_sub(offset.unwrap_or(0));
        let part = offset
            .zip(number("length", rest))
            .and_then(|(offset, length)| bytes.get(offset..offset.checked_add(length)?));
        let Some(part) = part else {
            let file = path.display();
            return Err(wrong(format!(
                "stand past the end of {file}, which is cut short"
            )));
        };
        let part = part.to_vec();
        inline(tensor, part);
    }
    Ok(())
}

fn inline(tensor: &mut TensorProto, bytes: Vec<u8>) {
    tensor.raw_data = bytes;
    tensor.data_location = Some(DataLocation::Default as i32);
    tensor.external_data.clear();
}
