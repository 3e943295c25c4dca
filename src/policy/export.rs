//! A trained network as an ONNX file.

use super::graph::{Attribute, GraphBuilder, INPUT, MASK, file_with};
use super::metadata::Metadata;
use crate::decision::observation::Layout;
use crate::nn::{Activation, Head, Linear, Mlp, Network, Scorer, SetEncoder};
use std::ops::Range;
use tract_onnx::pb::GraphProto;

/// Masked slots are lowered by this much, to exclude them from the pooled maximum.
const BELOW_ALL: f32 = 1e9;

/// The bytes of the file: the policy without its value.
pub fn export(
    network: &Network,
    parameters: &[f32],
    layout: &Layout,
    metadata: &Metadata,
) -> Vec<u8> {
    file_with(to_graph(network, parameters, layout).graph, metadata)
}

/// A network as a graph.
pub(super) struct NetworkGraph {
    pub graph: GraphProto,
    /// Which of the graph's constants are parameters, and which of them.
    pub layers: Vec<(usize, Range<usize>)>,
}

/// The graph of a network, without its value.
pub(super) fn to_graph(network: &Network, parameters: &[f32], layout: &Layout) -> NetworkGraph {
    let mut writer = Writer {
        graph: GraphBuilder::default(),
        parameters,
        layers: Vec::new(),
    };
    let logits = match network {
        Network::Mlp(net) => writer.mlp(net),
        Network::Scorer(net) => writer.scorer(net, layout),
    };
    let sizes = (layout.observation(), layout.actions());
    NetworkGraph {
        layers: writer.layers,
        graph: writer.graph.finish(&logits, sizes),
    }
}

struct Writer<'p> {
    graph: GraphBuilder,
    parameters: &'p [f32],
    layers: Vec<(usize, Range<usize>)>,
}

impl Writer<'_> {
    /// The constant with the parameters of `range`.
    fn constant(&mut self, shape: &[usize], range: Range<usize>) -> String {
        self.layers.push((self.graph.constants(), range.clone()));
        self.graph.weight(shape, &self.parameters[range])
    }

    /// `x W + b` of a matrix.
    fn dense(&mut self, layer: &Linear, x: &str) -> String {
        let weight = self.constant(&[layer.inputs, layer.outputs], layer.weights());
        if layer.biases().is_empty() {
            return self.graph.node("MatMul", &[x, &weight]);
        }
        let bias = self.constant(&[layer.outputs], layer.biases());
        self.graph.node("Gemm", &[x, &weight, &bias])
    }

    fn activate(&mut self, activation: Activation, x: &str) -> String {
        let operator = match activation {
            Activation::Tanh => "Tanh",
            Activation::Relu => "Relu",
        };
        self.graph.node(operator, &[x])
    }

    fn mlp(&mut self, net: &Mlp) -> String {
        let mut x = INPUT.to_owned();
        for (i, layer) in net.policy().iter().enumerate() {
            x = self.dense(layer, &x);
            if i + 1 < net.policy().len() {
                x = self.activate(net.activation(), &x);
            }
        }
        x
    }

    fn scorer(&mut self, net: &Scorer, layout: &Layout) -> String {
        let (k, features) = (layout.slots, layout.slot_features());
        let globals = self.graph.columns(INPUT, 0, layout.globals());
        let flat = self
            .graph
            .columns(INPUT, layout.globals(), layout.observation());
        let shape = self.graph.integers(&[0, k as i64, features as i64]);
        let slots = self.graph.node("Reshape", &[&flat, &shape]);
        let mask = self.graph.columns(MASK, 0, k);
        // 1 is the format's code for f32.
        let present = self
            .graph
            .node_with("Cast", &[&mask], &[("to", Attribute::Int(1))]);
        let present = self.unsqueeze(&present, 2);
        let activation = net.activation();
        let (vectors, pooled) = self.encode(&net.encoder, activation, &slots, &globals, &present);
        let context = self.dense(&net.context, &pooled);
        let context = self.unsqueeze(&context, 1);
        let second = self.dense(&net.slot, &vectors);
        let second = self.graph.node("Add", &[&second, &context]);
        let second = self.activate(activation, &second);
        let scores = self.dense(&net.logit, &second);
        let shape = self.graph.integers(&[0, k as i64]);
        let scores = self.graph.node("Reshape", &[&scores, &shape]);
        match &net.wait {
            None => scores,
            Some(head) => {
                let wait = self.head(head, activation, &pooled, &globals);
                self.concat(&scores, &wait)
            }
        }
    }

    /// The slots' vectors [batch, K, width], and the mean and maximum of occupied slots.
    fn encode(
        &mut self,
        encoder: &SetEncoder,
        activation: Activation,
        slots: &str,
        globals: &str,
        present: &str,
    ) -> (String, String) {
        let context = self.dense(&encoder.global, globals);
        let context = self.unsqueeze(&context, 1);
        let slots = self.dense(&encoder.slot, slots);
        let sum = self.graph.node("Add", &[&slots, &context]);
        let vectors = self.activate(activation, &sum);
        let axis = self.graph.integers(&[1]);
        let flat = [("keepdims", Attribute::Int(0))];
        let count = self.graph.node_with("ReduceSum", &[present, &axis], &flat);
        let one = self.graph.number(1.0);
        let count = self.graph.node("Max", &[&count, &one]);
        let kept = self.graph.node("Mul", &[&vectors, present]);
        let total = self.graph.node_with("ReduceSum", &[&kept, &axis], &flat);
        let mean = self.graph.node("Div", &[&total, &count]);
        let absent = self.graph.node("Sub", &[present, &one]);
        let far = self.graph.number(BELOW_ALL);
        let lowered = self.graph.node("Mul", &[&absent, &far]);
        let lowered = self.graph.node("Add", &[&vectors, &lowered]);
        let axes = [("axes", Attribute::Ints(&[1])), flat[0]];
        let most = self.graph.node_with("ReduceMax", &[&lowered], &axes);
        let pooled = self.concat(&mean, &most);
        (vectors, pooled)
    }

    fn head(&mut self, head: &Head, activation: Activation, pooled: &str, globals: &str) -> String {
        let context = self.dense(&head.context, pooled);
        let global = self.dense(&head.global, globals);
        let sum = self.graph.node("Add", &[&context, &global]);
        let hidden = self.activate(activation, &sum);
        self.dense(&head.out, &hidden)
    }

    fn concat(&mut self, a: &str, b: &str) -> String {
        self.graph
            .node_with("Concat", &[a, b], &[("axis", Attribute::Int(1))])
    }

    fn unsqueeze(&mut self, x: &str, axis: i64) -> String {
        let axis = self.graph.integers(&[axis]);
        self.graph.node("Unsqueeze", &[x, &axis])
    }
}
