//! Checks a file before tract builds anything from it.

use super::external::{gather, tensors};
use super::seal::check_seal;
use crate::error::{Error, Result, shown};
use prost::Message as _;
use std::collections::HashSet;
use std::path::Path;
use tract_onnx::pb::{
    GraphProto, ModelProto, TensorProto, ValueInfoProto,
    tensor_proto::{DataLocation, DataType},
    tensor_shape_proto::dimension,
    type_proto,
};

/// Larger files are rejected [bytes].
const MOST_BYTES: usize = 256 << 20;

/// The model in `bytes`, checked: it is a complete ONNX file, its weights are finite, every
/// value that it uses is defined, and nothing changed since it was exported. Weights in other
/// files are read from `folder`, if it is known.
///
/// # Errors
/// What is wrong, with `place` as the location.
pub(super) fn read(bytes: &[u8], folder: Option<&Path>, place: &str) -> Result<ModelProto> {
    let wrong = |problem: String| {
        let cure = "give a policy as `pickline train` or torch's ONNX exporter writes it";
        Error::input(place, problem, cure)
    };
    if bytes.len() > MOST_BYTES {
        return Err(wrong(format!(
            "{} bytes are too many for a policy",
            bytes.len()
        )));
    }
    let mut model = ModelProto::decode(bytes).map_err(|error| {
        wrong(format!("not an ONNX file, or truncated ({error})")).caused_by(error)
    })?;
    let Some(graph) = model.graph.as_ref().filter(|graph| !graph.node.is_empty()) else {
        return Err(wrong("not an ONNX file: it contains no graph".into()));
    };
    check_names(graph).map_err(wrong)?;
    if let (Some(folder), Some(graph)) = (folder, &mut model.graph) {
        gather(graph, folder, MOST_BYTES, place)?;
    }
    for tensor in model.graph.iter_mut().flat_map(tensors) {
        check_tensor(tensor).map_err(wrong)?;
    }
    // Last, because it says least about what is wrong.
    check_seal(&model, place)?;
    Ok(model)
}

/// Checks the sizes and values of one tensor of weights.
fn check_tensor(tensor: &TensorProto) -> std::result::Result<(), String> {
    let name = shown(&tensor.name);
    if tensor.data_location == Some(DataLocation::External as i32) {
        return Err(format!("the weights `{name}` are in another file"));
    }
    let count = tensor.dims.iter().try_fold(1i64, |product, dim| {
        product.checked_mul(*dim).filter(|_| *dim >= 0)
    });
    let Some(count) = count else {
        return Err(format!(
            "the weights `{name}` have impossible dimensions {:?}",
            tensor.dims
        ));
    };
    let raw = &tensor.raw_data;
    let (values, size): (Vec<f64>, usize) = match DataType::try_from(tensor.data_type) {
        Ok(DataType::Float) => {
            let raw = raw.chunks_exact(4);
            let raw = raw.map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
            let values = raw.chain(tensor.float_data.iter().copied());
            (values.map(f64::from).collect(), 4)
        }
        Ok(DataType::Double) => {
            let raw = raw.chunks_exact(8);
            let raw =
                raw.map(|b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]));
            (raw.chain(tensor.double_data.iter().copied()).collect(), 8)
        }
        _ => return Ok(()),
    };
    if values.len() as i64 != count || !raw.len().is_multiple_of(size) {
        let found = values.len();
        return Err(format!(
            "the weights `{name}` have {found} of {count} numbers"
        ));
    }
    match values.iter().find(|value| !value.is_finite()) {
        Some(value) => Err(format!("the weights `{name}` contain {value}")),
        None => Ok(()),
    }
}

/// Checks that every output, and every input of a node, is an input, a weight or a node's
/// output.
fn check_names(graph: &GraphProto) -> std::result::Result<(), String> {
    let inputs = graph.input.iter().map(|value| &value.name);
    let weights = graph.initializer.iter().map(|tensor| &tensor.name);
    let outputs = graph.node.iter().flat_map(|node| &node.output);
    let known: HashSet<&String> = inputs.chain(weights).chain(outputs).collect();
    let used = graph.node.iter().flat_map(|node| &node.input);
    let results = graph.output.iter().map(|value| &value.name);
    let missing = |name: &&String| !name.is_empty() && !known.contains(name);
    match used.chain(results).find(missing) {
        Some(name) => Err(format!("the value `{}` is not defined", shown(name))),
        None => Ok(()),
    }
}

/// The inputs that are not weights.
pub(super) fn inputs(graph: &GraphProto) -> impl Iterator<Item = (usize, &ValueInfoProto)> {
    let is_weight = |name: &str| graph.initializer.iter().any(|tensor| tensor.name == name);
    graph
        .input
        .iter()
        .filter(move |value| !is_weight(&value.name))
        .enumerate()
}

/// The sizes of a value (`None` for dynamic ones) and its type.
pub(super) fn shape(value: &ValueInfoProto) -> Option<(Vec<Option<usize>>, i32)> {
    let type_proto::Value::TensorType(tensor) = value.r#type.as_ref()?.value.as_ref()?;
    let size = |dim: &tract_onnx::pb::tensor_shape_proto::Dimension| match dim.value {
        Some(dimension::Value::DimValue(size)) => usize::try_from(size).ok().filter(|s| *s > 0),
        _ => None,
    };
    let dims = tensor.shape.as_ref()?.dim.iter().map(size).collect();
    Some((dims, tensor.elem_type))
}
