//! Actions that the mask forbids are never taken, however much a policy prefers them.

use super::policy_forms::{model, node, value};
use pickline::decision::observation::{Encoder, Layout};
use pickline::decision::{Action, Snapshot, Strategy};
use pickline::nn::{Activation, Architecture, Network, Shape};
use pickline::pattern::grid;
use pickline::policy::{Policy, PolicyStrategy};
use pickline::rl::NetworkPlayer;
use pickline::sim::{Scene, simulate};
use pickline::station::built_in;
use prost::Message as _;
use tract_onnx::pb::{
    AttributeProto, ModelProto, TensorProto, attribute_proto::AttributeType, tensor_proto::DataType,
};

const PAPER: Layout = Layout::PAPER;

fn tensor(name: &str, dims: &[i64], numbers: &[f32]) -> TensorProto {
    TensorProto {
        name: name.into(),
        dims: dims.to_vec(),
        data_type: DataType::Float as i32,
        raw_data: numbers.iter().flat_map(|x| x.to_le_bytes()).collect(),
        ..Default::default()
    }
}

/// A policy whose logits are `preferences` whatever it sees. With `mask` it has an input for
/// the mask, which it adds to them a thousandth of, as a graph may make of it what it likes.
fn preferring(layout: Layout, preferences: &[f32], mask: Option<DataType>) -> Policy {
    let (observation, actions) = (layout.observation(), layout.actions());
    let mut inputs = vec![value("obs", DataType::Float, observation)];
    let mut tensors = vec![
        tensor(
            "w",
            &[observation as i64, actions as i64],
            &vec![0.0; observation * actions],
        ),
        tensor("b", &[actions as i64], preferences),
    ];
    let mut nodes = vec![node("MatMul", &["obs", "w"], "0")];
    match mask {
        // Twice, so that a logit can be beyond all numbers, which no weight may be.
        None => nodes.extend([
            node("Add", &["0", "b"], "1"),
            node("Add", &["1", "b"], "logits"),
        ]),
        Some(kind) => {
            inputs.push(value("action_mask", kind, actions));
            let mut cast = node("Cast", &["action_mask"], "1");
            cast.attribute.push(AttributeProto {
                name: "to".into(),
                i: DataType::Float as i64,
                r#type: AttributeType::Int as i32,
                ..Default::default()
            });
            tensors.push(tensor("small", &[1], &[1e-3]));
            nodes.extend([
                cast,
                node("Mul", &["1", "small"], "2"),
                node("Add", &["0", "2"], "3"),
                node("Add", &["3", "b"], "logits"),
            ]);
        }
    }
    let outputs = vec![value("logits", DataType::Float, actions)];
    let model: ModelProto = model(inputs, nodes, tensors, outputs);
    let policy = Policy::from_bytes(&model.encode_to_vec(), "p.onnx").unwrap();
    assert_eq!(policy.layout(), layout);
    policy
}

/// Plays a strategy and holds each of its answers to `expected`, which knows how many
/// candidates there are.
struct Held<'a> {
    strategy: &'a mut dyn Strategy,
    expected: &'a dyn Fn(&Snapshot) -> Action,
    decisions: usize,
    masked: usize,
}

impl Strategy for Held<'_> {
    fn decide(&mut self, snapshot: &Snapshot) -> Action {
        let action = self.strategy.decide(snapshot);
        let count = snapshot.candidates.len();
        assert_eq!(action, (self.expected)(snapshot), "{count} candidates");
        self.decisions += 1;
        self.masked += usize::from(count < PAPER.slots);
        action
    }

    fn name(&self) -> String {
        self.strategy.name()
    }
}

/// Runs `strategy` on a grid; how many of its decisions had empty slots.
fn play(strategy: &mut dyn Strategy, expected: &dyn Fn(&Snapshot) -> Action) -> usize {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let pattern = grid(station.belt().width, 0.5, 24).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let mut held = Held {
        strategy,
        expected,
        decisions: 0,
        masked: 0,
    };
    let outcome = simulate(&scene, &mut held).unwrap();
    assert!(outcome.figures.picked > 10 && held.decisions >= outcome.figures.picked);
    assert_eq!(held.masked, held.decisions, "a sparse grid fills no slots");
    held.masked
}

/// The last slot is nearly always empty, and it is preferred: the last one that holds an item
/// is taken.
#[test]
fn an_empty_slot_is_never_picked() {
    let rising: Vec<f32> = (0..PAPER.slots).map(|slot| slot as f32).collect();
    let last = |snapshot: &Snapshot| Action::Pick(snapshot.candidates.len().min(PAPER.slots) - 1);
    let masks = [
        None,
        Some(DataType::Bool),
        Some(DataType::Float),
        Some(DataType::Int64),
    ];
    for mask in masks {
        let policy = preferring(PAPER, &rising, mask);
        let mut strategy = PolicyStrategy::new("onnx:p".into(), &policy);
        assert!(play(&mut strategy, &last) > 10, "{mask:?}");
        assert_eq!(strategy.trouble(), None);
    }
}

/// What an empty slot's logit is makes no difference, be it no number at all.
#[test]
fn a_logit_of_an_empty_slot_may_be_anything() {
    let mut preferences: Vec<f32> = (0..PAPER.slots).map(|slot| -(slot as f32)).collect();
    preferences[PAPER.slots - 1] = f32::MAX;
    let policy = preferring(PAPER, &preferences, None);
    let mut strategy = PolicyStrategy::new("onnx:p".into(), &policy);
    assert!(play(&mut strategy, &|_| Action::Pick(0)) > 10);
}

/// Of equal logits the first counts.
#[test]
fn equal_logits_mean_the_first_slot() {
    let policy = preferring(PAPER, &[1.0; PAPER.slots], None);
    let mut strategy = PolicyStrategy::new("onnx:p".into(), &policy);
    assert!(play(&mut strategy, &|_| Action::Pick(0)) > 10);
}

/// The network of a training is held to the mask as well: with all weights 0 but the bias of
/// its logits, it prefers the last slot.
#[test]
fn a_player_never_picks_an_empty_slot() {
    let architecture = Architecture::Mlp {
        hidden: vec![2],
        activation: Activation::Tanh,
    };
    let network = Network::new(&architecture, Shape::of(&PAPER));
    let Network::Mlp(net) = &network else {
        panic!("an MLP");
    };
    let before: usize = net.policy()[..1]
        .iter()
        .map(|l| (l.inputs + 1) * l.outputs)
        .sum();
    let biases = before + 2 * PAPER.slots;
    let mut parameters = vec![0.0; net.parameters()];
    for slot in 0..PAPER.slots {
        parameters[biases + slot] = slot as f32;
    }
    let last = |snapshot: &Snapshot| Action::Pick(snapshot.candidates.len().min(PAPER.slots) - 1);
    assert!(play(&mut NetworkPlayer::new(&network, &parameters, PAPER), &last) > 10);
}

/// What a policy is shown is the observation in its order: a logit that copies number j of it
/// is number j.
#[test]
fn a_policy_sees_the_observation_in_its_order() {
    let station = built_in("paper").unwrap().station(None).unwrap();
    let pattern = grid(station.belt().width, 0.2, 40).unwrap();
    let scene = Scene::new(&station, &pattern).unwrap();
    let mut run = pickline::sim::Run::new(&scene);
    let snapshot = run.next_decision().unwrap();
    let mut encoder = Encoder::new(PAPER);
    let mut observation = vec![0.0; PAPER.observation()];
    let mut mask = vec![false; PAPER.actions()];
    encoder.encode(&snapshot, &mut observation, &mut mask);
    let (size, actions) = (PAPER.observation(), PAPER.actions());
    for from in (0..size).step_by(actions) {
        let mut weights = vec![0.0; size * actions];
        for action in 0..actions.min(size - from) {
            weights[(from + action) * actions + action] = 1.0;
        }
        let globals = PAPER.globals();
        let parts = [("globals", globals), ("slots", size - globals)];
        let mut join = node("Concat", &["globals", "slots"], "obs");
        join.attribute.push(AttributeProto {
            name: "axis".into(),
            i: 1,
            r#type: AttributeType::Int as i32,
            ..Default::default()
        });
        let copy = node("MatMul", &["obs", "w"], "logits");
        for (inputs, nodes) in [
            (
                vec![value("obs", DataType::Float, size)],
                vec![copy.clone()],
            ),
            (
                parts
                    .map(|(name, width)| value(name, DataType::Float, width))
                    .to_vec(),
                vec![join, copy],
            ),
        ] {
            let tensors = vec![tensor("w", &[size as i64, actions as i64], &weights)];
            let outputs = vec![value("logits", DataType::Float, actions)];
            let model = model(inputs, nodes, tensors, outputs);
            let policy = Policy::from_bytes(&model.encode_to_vec(), "p.onnx").unwrap();
            let mut logits = vec![0.0; actions];
            let mut state = policy.state().unwrap();
            state.logits(&observation, &mask, &mut logits).unwrap();
            let expected = &observation[from..(from + actions).min(size)];
            assert_eq!(&logits[..expected.len()], expected, "from {from}");
        }
    }
}
