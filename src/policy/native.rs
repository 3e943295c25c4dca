//! Networks of this program's own architectures, which run without tract.
//!
//! A decision goes through networks so small that tract spends most of it on what it does around its
//! products ([docs/rl.md](../../docs/rl.md#cost)). A file that `pickline train` has written holds
//! one of two architectures, so it is read back and runs as it ran in training.

use super::export::to_graph;
use super::graph::FORBIDDEN;
use crate::decision::observation::Layout;
use crate::nn::{Activation, Architecture, Network, ObservationBatch, Shape, Workspace};
use tract_onnx::pb::{GraphProto, TensorProto};

/// A network of ours with its parameters; those of the value, which no file has, are 0.
#[derive(Debug)]
pub(super) struct NativeNetwork {
    network: Network,
    parameters: Vec<f32>,
}

impl NativeNetwork {
    /// The network that was written as `graph`; `None` for a graph that is anything else, down to the
    /// name of a value: it is written again and compared.
    pub(super) fn read(graph: &GraphProto, layout: &Layout) -> Option<Self> {
        let architecture = architecture(graph)?;
        architecture.check().ok()?;
        let network = Network::new(&architecture, Shape::of(layout));
        // The value has less than twice the parameters of the rest. So no file makes this use more than a few
        // times its own size.
        let constants: usize = graph.initializer.iter().map(|c| c.raw_data.len() / 4).sum();
        if network.parameters() > 3 * constants {
            return None;
        }
        let mut parameters = vec![0.0; network.parameters()];
        for (constant, range) in to_graph(&network, &parameters, layout).layers {
            let from = graph.initializer.get(constant)?.raw_data.chunks_exact(4);
            for (parameter, bytes) in parameters[range].iter_mut().zip(from) {
                *parameter = f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
            }
        }
        let again = to_graph(&network, &parameters, layout).graph;
        (again == *graph).then_some(Self {
            network,
            parameters,
        })
    }

    /// Writes the logits [actions] of one observation.
    pub(super) fn logits(
        &self,
        observation: &[f32],
        mask: &[bool],
        work: &mut Workspace,
        to: &mut [f32],
    ) {
        let batch = ObservationBatch {
            observations: observation,
            masks: mask,
            rows: 1,
        };
        self.network.decide(&self.parameters, batch, work);
        for ((to, logit), allowed) in to.iter_mut().zip(&work.logits).zip(mask) {
            *to = if *allowed { *logit } else { FORBIDDEN };
        }
    }
}

/// The architecture that `graph` can be of, by its operators and the sizes of its constants.
fn architecture(graph: &GraphProto) -> Option<Architecture> {
    let operators = || graph.node.iter().map(|node| node.op_type.as_str());
    let activation = if operators().any(|operator| operator == "Relu") {
        Activation::Relu
    } else {
        Activation::Tanh
    };
    let sizes: Vec<(usize, usize)> = matrices(graph).collect();
    let (_, before) = sizes.split_last()?;
    if operators().any(|operator| operator == "Slice") {
        let (_, width) = sizes[0];
        return Some(Architecture::Scorer { width, activation });
    }
    let joins = |pair: &[(usize, usize)]| pair[0].1 == pair[1].0;
    let hidden = before.iter().map(|(_, outputs)| *outputs).collect();
    let joined = sizes.windows(2).all(joins);
    joined.then_some(Architecture::Mlp { hidden, activation })
}

/// The sizes of the matrices of `graph`, inputs and outputs.
fn matrices(graph: &GraphProto) -> impl Iterator<Item = (usize, usize)> + '_ {
    let size = |tensor: &TensorProto| match tensor.dims[..] {
        [inputs, outputs] => Some((inputs.try_into().ok()?, outputs.try_into().ok()?)),
        _ => None,
    };
    graph.initializer.iter().filter_map(size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decision::observation::View;
    use crate::pattern::random_stream;

    const LAYOUT: Layout = Layout {
        view: View::Full,
        slots: 4,
        wait: true,
    };

    fn written(architecture: &Architecture) -> (Network, Vec<f32>, GraphProto) {
        let network = Network::new(architecture, Shape::of(&LAYOUT));
        let parameters = network.initial(&mut random_stream(5, 0));
        let graph = to_graph(&network, &parameters, &LAYOUT).graph;
        (network, parameters, graph)
    }

    fn architectures() -> [Architecture; 4] {
        let scorer = |width, activation| Architecture::Scorer { width, activation };
        let mlp = |hidden: &[usize], activation| Architecture::Mlp {
            hidden: hidden.to_vec(),
            activation,
        };
        [
            scorer(1, Activation::Relu),
            scorer(7, Activation::Tanh),
            mlp(&[], Activation::Tanh),
            mlp(&[3, 5], Activation::Relu),
        ]
    }

    /// Also where the globals are more than the network is wide, and where there are no hidden layers.
    #[test]
    fn a_written_network_is_read_back() {
        for architecture in architectures() {
            let (network, parameters, graph) = written(&architecture);
            let read = NativeNetwork::read(&graph, &LAYOUT).unwrap();
            assert_eq!(read.network.parameters(), network.parameters());
            let constants = to_graph(&network, &parameters, &LAYOUT).layers;
            assert!(constants.len() >= 2, "{architecture:?}");
            for (_, range) in constants {
                assert_eq!(read.parameters[range.clone()], parameters[range]);
            }
        }
    }

    /// Whatever differs, tract runs it.
    #[test]
    fn any_other_graph_is_left_to_tract() {
        for architecture in architectures() {
            let (_, _, graph) = written(&architecture);
            let changes: [fn(&mut GraphProto); 6] = [
                |graph| graph.name.push('!'),
                |graph| graph.node[0].op_type = "Softmax".into(),
                |graph| drop(graph.node.pop()),
                |graph| graph.initializer[0].dims.push(1),
                |graph| drop(graph.initializer.pop()),
                |graph| {
                    graph
                        .initializer
                        .iter_mut()
                        .for_each(|c| c.dims = vec![4000, 4000])
                },
            ];
            for change in changes {
                let mut graph = graph.clone();
                change(&mut graph);
                assert!(NativeNetwork::read(&graph, &LAYOUT).is_none());
            }
            let narrow = Layout { slots: 3, ..LAYOUT };
            assert!(NativeNetwork::read(&graph, &narrow).is_none());
        }
        assert!(NativeNetwork::read(&GraphProto::default(), &LAYOUT).is_none());
    }
}
