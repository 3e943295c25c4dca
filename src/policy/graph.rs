//! Writes ONNX: turns nodes, weights and metadata into the bytes of a file.
//!
//! Operator set 17, which torch's exporters of the same years write and every runtime supports
//! (<https://onnx.ai/onnx/operators/>).

use super::metadata::Metadata;
use super::seal::seal;
use prost::Message as _;
use tract_onnx::pb::{
    AttributeProto, GraphProto, ModelProto, NodeProto, OperatorSetIdProto, StringStringEntryProto,
    TensorProto, TensorShapeProto, TypeProto, ValueInfoProto,
    attribute_proto::AttributeType,
    tensor_proto::DataType,
    tensor_shape_proto::{Dimension, dimension},
    type_proto,
};

/// Input: observations [batch, observation], f32.
pub(super) const INPUT: &str = "observation";
/// Input: allowed actions [batch, actions], bool.
pub(super) const MASK: &str = "action_mask";
/// Output: logits [batch, actions], f32; very negative for masked actions.
pub(super) const OUTPUT: &str = "logits";

/// The logit of masked actions, as in Stable-Baselines3's `MaskableCategorical`.
pub(super) const FORBIDDEN: f32 = -1e8;

const OPERATOR_SET: i64 = 17;
/// The version of the format for that operator set.
const IR_VERSION: i64 = 8;

/// A graph under construction. Values are identified by name.
#[derive(Debug, Default)]
pub(super) struct GraphBuilder {
    nodes: Vec<NodeProto>,
    weights: Vec<TensorProto>,
}

impl GraphBuilder {
    fn fresh(&self, what: &str) -> String {
        format!("{what}_{}", self.nodes.len() + self.weights.len())
    }

    /// A constant matrix or vector.
    pub(super) fn weight(&mut self, shape: &[usize], values: &[f32]) -> String {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.tensor(DataType::Float, shape, bytes)
    }

    /// A constant number.
    pub(super) fn number(&mut self, value: f32) -> String {
        self.weight(&[], &[value])
    }

    /// A constant list of integers.
    pub(super) fn integers(&mut self, values: &[i64]) -> String {
        let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.tensor(DataType::Int64, &[values.len()], bytes)
    }

    fn tensor(&mut self, kind: DataType, shape: &[usize], raw_data: Vec<u8>) -> String {
        let name = self.fresh("weight");
        self.weights.push(TensorProto {
            // The weights are in memory, so their sizes fit.
            dims: shape.iter().map(|d| *d as i64).collect(),
            data_type: kind as i32,
            name: name.clone(),
            raw_data,
            ..Default::default()
        });
        name
    }

    /// Adds a node with one output and returns the output's name.
    pub(super) fn node(&mut self, operator: &str, inputs: &[&str]) -> String {
        self.node_with(operator, inputs, &[])
    }

    /// The same with attributes. A single integer becomes an attribute of type int, a list one
    /// of type ints.
    pub(super) fn node_with(
        &mut self,
        operator: &str,
        inputs: &[&str],
        attributes: &[(&str, Attribute)],
    ) -> String {
        let output = self.fresh(&operator.to_lowercase());
        self.push(operator, inputs, &output, attributes);
        output
    }

    fn push(
        &mut self,
        operator: &str,
        inputs: &[&str],
        output: &str,
        attributes: &[(&str, Attribute)],
    ) {
        self.nodes.push(NodeProto {
            input: inputs.iter().map(|name| (*name).to_owned()).collect(),
            output: vec![output.to_owned()],
            name: format!("{output}_node"),
            op_type: operator.to_owned(),
            attribute: attributes
                .iter()
                .map(|(name, value)| value.to_proto(name))
                .collect(),
            ..Default::default()
        });
    }

    /// Columns `from..to` of a matrix.
    pub(super) fn columns(&mut self, matrix: &str, from: usize, to: usize) -> String {
        let [from, to, axis] = [from as i64, to as i64, 1].map(|v| self.integers(&[v]));
        self.node("Slice", &[matrix, &from, &to, &axis])
    }

    /// Number of constants so far.
    pub(super) fn constants(&self) -> usize {
        self.weights.len()
    }

    /// The graph from [`INPUT`] and [`MASK`] to [`OUTPUT`], which equals `logits` for allowed actions.
    pub(super) fn finish(
        mut self,
        logits: &str,
        (observation, actions): (usize, usize),
    ) -> GraphProto {
        let forbidden = self.number(FORBIDDEN);
        self.push("Where", &[MASK, logits, &forbidden], OUTPUT, &[]);
        GraphProto {
            name: "policy".into(),
            node: self.nodes,
            initializer: self.weights,
            input: vec![
                value_info(INPUT, DataType::Float, observation),
                value_info(MASK, DataType::Bool, actions),
            ],
            output: vec![value_info(OUTPUT, DataType::Float, actions)],
            ..Default::default()
        }
    }
}

/// The operator sets that a graph of a [`GraphBuilder`] needs.
pub(super) fn operator_sets() -> Vec<OperatorSetIdProto> {
    vec![OperatorSetIdProto {
        domain: String::new(),
        version: OPERATOR_SET,
    }]
}

/// The bytes of the file with `graph`.
pub(super) fn file_with(graph: GraphProto, metadata: &Metadata) -> Vec<u8> {
    let entry = |(key, value): (String, &str)| StringStringEntryProto {
        key,
        value: value.to_owned(),
    };
    let mut model = ModelProto {
        ir_version: IR_VERSION,
        opset_import: operator_sets(),
        producer_name: env!("CARGO_PKG_NAME").into(),
        producer_version: env!("CARGO_PKG_VERSION").into(),
        graph: Some(graph),
        metadata_props: metadata.to_file().map(entry).collect(),
        ..Default::default()
    };
    seal(&mut model);
    model.encode_to_vec()
}

/// The value of a node's attribute.
#[derive(Debug, Clone, Copy)]
pub(super) enum Attribute<'a> {
    /// One integer.
    Int(i64),
    /// A list of integers.
    Ints(&'a [i64]),
}

impl Attribute<'_> {
    fn to_proto(self, name: &str) -> AttributeProto {
        let mut proto = AttributeProto {
            name: name.to_owned(),
            ..Default::default()
        };
        match self {
            Self::Int(value) => {
                proto.i = value;
                proto.r#type = AttributeType::Int as i32;
            }
            Self::Ints(values) => {
                proto.ints = values.to_vec();
                proto.r#type = AttributeType::Ints as i32;
            }
        }
        proto
    }
}

fn value_info(name: &str, kind: DataType, width: usize) -> ValueInfoProto {
    let dimension = |value| Dimension {
        value: Some(value),
        ..Default::default()
    };
    let dim = vec![
        dimension(dimension::Value::DimParam("batch".into())),
        dimension(dimension::Value::DimValue(width as i64)),
    ];
    ValueInfoProto {
        name: name.to_owned(),
        r#type: Some(TypeProto {
            value: Some(type_proto::Value::TensorType(type_proto::Tensor {
                elem_type: kind as i32,
                shape: Some(TensorShapeProto { dim }),
            })),
            ..Default::default()
        }),
        ..Default::default()
    }
}
