//! One minibatch update against figures recorded from Stable-Baselines3
//! (`tests/sb3/record.py`): advantages, the terms of the loss, every updated weight.

use pickline::nn::{Activation, Mlp, Network, Shape};
use pickline::rl::ppo::{Learner, Minibatch, PpoSettings, Sample, advantages};
use serde::Deserialize;
use std::collections::BTreeMap;

#[derive(Deserialize)]
struct Layer {
    /// As torch has it [outputs, inputs].
    weight: Vec<Vec<f32>>,
    bias: Vec<f32>,
}

type Towers = BTreeMap<String, Vec<Layer>>;

#[derive(Deserialize)]
struct Recorded {
    hidden: Vec<usize>,
    observations: Vec<Vec<f32>>,
    masks: Vec<Vec<bool>>,
    actions: Vec<usize>,
    log_probabilities: Vec<f32>,
    values: Vec<f32>,
    rewards: Vec<f32>,
    episode_starts: Vec<bool>,
    last_value: f32,
    advantages: Vec<f32>,
    returns: Vec<f32>,
    before: Towers,
    after: Towers,
    terms: BTreeMap<String, f64>,
}

fn recorded() -> Recorded {
    serde_json::from_str(include_str!("../sb3/update.json")).unwrap()
}

fn network(recorded: &Recorded) -> Mlp {
    let shape = Shape {
        globals: 2,
        slots: recorded.masks[0].len(),
        slot_features: 1,
        wait: false,
    };
    assert_eq!(shape.observation(), recorded.observations[0].len());
    Mlp::new(shape, &recorded.hidden, Activation::Tanh)
}

/// The towers as one vector of this crate: weights [inputs, outputs], then biases.
fn parameters(net: &Mlp, towers: &Towers) -> Vec<f32> {
    let mut all = Vec::new();
    for (name, layers) in [("policy", net.policy()), ("value", net.value())] {
        for (layer, linear) in towers[name].iter().zip(layers) {
            for i in 0..linear.inputs {
                all.extend(layer.weight.iter().map(|row| row[i]));
            }
            all.extend(&layer.bias);
        }
    }
    assert_eq!(all.len(), net.parameters());
    all
}

fn settings() -> PpoSettings {
    PpoSettings::SB3.with_gamma(0.9995).with_ent_coef(0.01)
}

#[test]
fn advantages_are_those_of_the_rollout_buffer() {
    let r = recorded();
    // An episode ends where the next begins; the recorded buffer's last goes on.
    let mut ended: Vec<bool> = r.episode_starts[1..].to_vec();
    ended.push(false);
    let mut got = vec![0.0; r.rewards.len()];
    let inputs = (&r.rewards[..], &r.values[..], &ended[..]);
    let settings = settings();
    let discount = (settings.gamma, settings.gae_lambda);
    advantages(inputs, r.last_value, discount, &mut got);
    for (got, expected) in got.iter().zip(&r.advantages) {
        assert!((got - expected).abs() < 1e-5, "{got} and {expected}");
    }
}

#[test]
fn a_minibatch_moves_every_weight_as_sb3_does() {
    let r = recorded();
    let net = network(&r);
    let before = parameters(&net, &r.before);
    let after = parameters(&net, &r.after);
    let mut learner = Learner::new(Network::Mlp(Box::new(net)), before.clone());
    let rows: Minibatch = (0..r.actions.len())
        .map(|i| {
            let sample = Sample {
                action: r.actions[i],
                log_probability: r.log_probabilities[i],
                advantage: r.advantages[i],
                target: r.returns[i],
            };
            (&r.observations[i][..], &r.masks[i][..], sample)
        })
        .collect();
    let settings = settings();
    let (terms, _) = learner.minibatch(&rows, &settings, settings.learning_rate);
    for (name, got) in [
        ("policy", terms.policy),
        ("value", terms.value),
        ("entropy", terms.entropy),
        ("divergence", terms.divergence),
        ("clipped", terms.clipped),
        ("loss", terms.loss(&settings)),
    ] {
        let expected = r.terms[name];
        assert!(
            (got - expected).abs() < 2e-6 * (1.0 + expected.abs()),
            "{name}: {got}, {expected}"
        );
    }
    let mut moved = 0;
    for ((was, expected), got) in before.iter().zip(&after).zip(&learner.parameters) {
        // A step of Adam is about the learning rate; a hundredth of it is agreement.
        assert!((got - expected).abs() < 3e-6, "{was}: {got}, {expected}");
        moved += usize::from((expected - was).abs() > 1e-4);
    }
    assert!(moved > after.len() / 2, "only {moved} weights moved");
}
