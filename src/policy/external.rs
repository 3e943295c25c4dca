//! Weights in separate files beside the ONNX file, as torch's exporter writes them by default
//! (<https://onnx.ai/onnx/repo-docs/ExternalData.html>).

use crate::error::{Error, Result, shown};
use crate::files::folder_of;
use prost::Message as _;
use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use tract_onnx::pb::{GraphProto, ModelProto, TensorProto, tensor_proto::DataLocation};

/// Larger files are not searched for the names of their weight files [bytes].
const MOST_BYTES: u64 = 256 << 20;

/// The files that contain weights of the policy in `file`, or that would by their usual name;
/// empty if the file is not a policy.
pub(crate) fn weight_files(file: &Path) -> Vec<PathBuf> {
    let mut name = file.as_os_str().to_owned();
    name.push(".data");
    let mut found = vec![PathBuf::from(name)];
    let is_read = std::fs::metadata(file).is_ok_and(|about| about.len() <= MOST_BYTES);
    let bytes = std::fs::read(file).ok().filter(|_| is_read);
    let model = bytes.and_then(|bytes| ModelProto::decode(&bytes[..]).ok());
    if let Some(mut graph) = model.and_then(|model| model.graph) {
        let locations = tensors(&mut graph).into_iter().filter_map(|tensor| {
            let location = entry(tensor, "location").filter(|_| is_external(tensor))?;
            Some(folder_of(file).join(location))
        });
        found.extend(locations);
        found.sort();
        found.dedup();
    }
    found
}

fn is_external(tensor: &TensorProto) -> bool {
    tensor.data_location == Some(DataLocation::External as i32)
}

fn entry<'t>(tensor: &'t TensorProto, key: &str) -> Option<&'t str> {
    let entry = tensor.external_data.iter().find(|entry| entry.key == key);
    entry.map(|entry| entry.value.as_str())
}

/// All weights of `graph`, including those in attributes of nodes and in nested graphs.
pub(super) fn tensors(graph: &mut GraphProto) -> Vec<&mut TensorProto> {
    let mut found: Vec<&mut TensorProto> = graph.initializer.iter_mut().collect();
    for node in &mut graph.node {
        for attribute in &mut node.attribute {
            found.extend(attribute.t.iter_mut());
            found.extend(attribute.tensors.iter_mut());
            let graphs = attribute.g.iter_mut().chain(&mut attribute.graphs);
            found.extend(graphs.flat_map(tensors));
        }
    }
    found
}

/// Moves weights from files in `folder` into `graph`. Files of more than `most` bytes are
/// rejected. `place` is the name of the ONNX file in messages.
///
/// # Errors
/// A file that is missing, too large, too short or outside `folder`.
pub(super) fn gather(
    graph: &mut GraphProto,
    folder: &Path,
    most: usize,
    place: &str,
) -> Result<()> {
    let mut files: HashMap<PathBuf, Vec<u8>> = HashMap::new();
    for tensor in tensors(graph) {
        if !is_external(tensor) {
            continue;
        }
        let wrong = |problem: String| {
            let cure = "keep the weights file beside the ONNX file under its original name, or \
                        export with the weights inside (torch: external_data=False)";
            let name = shown(&tensor.name);
            Error::input(place, format!("the weights `{name}` {problem}"), cure)
        };
        let location = entry(tensor, "location").unwrap_or_default();
        let name = Path::new(location);
        let is_beside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
        if location.is_empty() || !name.components().all(is_beside) {
            let location = shown(location);
            return Err(wrong(format!("are in `{location}`, outside its folder")));
        }
        let path = folder.join(name);
        if !files.contains_key(&path) {
            let bytes = read_weights(&path, most, &wrong)?;
            files.insert(path.clone(), bytes);
        }
        let part = part_of(&files[&path], tensor).map(<[u8]>::to_vec);
        let part = part.ok_or_else(|| {
            let file = path.display();
            wrong(format!("are past the end of {file}, which is truncated"))
        })?;
        inline(tensor, part);
    }
    Ok(())
}

/// The content of the weights file at `path`, if it has at most `most` bytes; `wrong` makes an error
/// of what is wrong with it.
fn read_weights(path: &Path, most: usize, wrong: &dyn Fn(String) -> Error) -> Result<Vec<u8>> {
    let file = path.display();
    let about = std::fs::metadata(path).map_err(|error| {
        wrong(format!("are in {file}, which cannot be read ({error})")).caused_by(error)
    })?;
    // Reading a pipe could block forever.
    if !about.is_file() {
        return Err(wrong(format!("are in {file}, which is not a regular file")));
    }
    if about.len() > most as u64 {
        return Err(wrong(format!("are in {file}, which is too large")));
    }
    std::fs::read(path).map_err(|error| Error::read(path, error))
}

/// The part of a weights file that holds `tensor`; `None` if the file ends before it.
fn part_of<'b>(bytes: &'b [u8], tensor: &TensorProto) -> Option<&'b [u8]> {
    let number = |key: &str, otherwise: usize| match entry(tensor, key) {
        Some(text) => text.parse::<usize>().ok(),
        None => Some(otherwise),
    };
    let offset = number("offset", 0)?;
    let length = number("length", bytes.len().saturating_sub(offset))?;
    bytes.get(offset..offset.checked_add(length)?)
}

fn inline(tensor: &mut TensorProto, bytes: Vec<u8>) {
    tensor.raw_data = bytes;
    tensor.data_location = Some(DataLocation::Default as i32);
    tensor.external_data.clear();
}
