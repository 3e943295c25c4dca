//! Policies in files: what is written is what is run, and wrong files are refused with
//! what was expected.

use pickline::decision::observation::{Encoder, Layout, View};
use pickline::nn::{Activation, Architecture, Network, ObservationBatch, Shape, Workspace};
use pickline::pattern::{poisson_disk, random_stream};
use pickline::policy::{Metadata, Policy, export};
use pickline::sim::{Run, Scene};
use pickline::station::built_in;
use prost::Message as _;
use rand::RngExt;
use tract_onnx::pb::ModelProto;

const FULL: Layout = Layout {
    view: View::Full,
    slots: 16,
    wait: false,
};

/// Observations and masks of decisions on real patterns.
fn observed(layout: Layout, count: usize) -> (Vec<f32>, Vec<bool>) {
    let (mut observations, mut masks) = (Vec::new(), Vec::new());
    let mut encoder = Encoder::new(layout);
    let mut rng = random_stream(9, 0);
    for seed in 0.. {
        let station = built_in("paper")
            .unwrap()
            .station(Some(2 + seed % 3))
            .unwrap();
        let mut draw = random_stream(seed as u64, 1);
        let pattern = poisson_disk(station.belt().width, 0.12, 150, &mut draw).unwrap();
        let scene = Scene::new(&station, &pattern).unwrap();
        let mut run = Run::new(&scene);
        while let Some(snapshot) = run.next_decision() {
            if masks.len() == count * layout.actions() {
                return (observations, masks);
            }
            let (at, from) = (observations.len(), masks.len());
            observations.resize(at + layout.observation(), 0.0);
            masks.resize(from + layout.actions(), false);
            encoder.encode(&snapshot, &mut observations[at..], &mut masks[from..]);
            let slots = masks[from..from + layout.slots]
                .iter()
                .filter(|m| **m)
                .count();
            let action = encoder
                .action(&snapshot, rng.random_range(0..slots))
                .unwrap();
            run.act(action).unwrap();
        }
    }
    unreachable!()
}

/// A network of `architecture` with weights that are not small, and its file.
fn exported(architecture: &Architecture, layout: Layout) -> (Network, Vec<f32>, Vec<u8>) {
    let network = Network::new(architecture, Shape::of(&layout));
    let mut parameters = network.initial(&mut random_stream(3, 0));
    let mut rng = random_stream(4, 0);
    parameters
        .iter_mut()
        .for_each(|p| *p += 0.2 * (rng.random::<f32>() - 0.5));
    let bytes = export(&network, &parameters, &layout, &Metadata::new(&layout));
    (network, parameters, bytes)
}

/// The same network in a file of which nobody can tell that it is ours, so that tract runs it.
fn disguised(bytes: &[u8]) -> Vec<u8> {
    let mut model = ModelProto::decode(bytes).unwrap();
    model.graph.as_mut().unwrap().name = "another".into();
    let is_seal = |key: &str| key.ends_with("content_hash");
    model.metadata_props.retain(|entry| !is_seal(&entry.key));
    model.encode_to_vec()
}

/// What the trainer computes is what its file gives: to the bit as it is, and closely in tract.
#[test]
fn files_agree_with_the_trainer_on_a_thousand_observations() {
    let mlp = Architecture::Mlp {
        hidden: vec![64, 64],
        activation: Activation::Tanh,
    };
    let scorer = Architecture::Scorer {
        width: 64,
        activation: Activation::Relu,
    };
    let waiting = Layout { wait: true, ..FULL };
    for (architecture, layout) in [
        (&mlp, Layout::PAPER),
        (&mlp, waiting),
        (&scorer, FULL),
        (&scorer, waiting),
    ] {
        let (network, parameters, bytes) = exported(architecture, layout);
        let policy = Policy::from_bytes(&bytes, "test.onnx").unwrap();
        assert_eq!(policy.layout(), layout);
        let mut state = policy.state().unwrap();
        let in_tract = Policy::from_bytes(&disguised(&bytes), "test.onnx").unwrap();
        let mut tract = in_tract.state().unwrap();
        let rows = 1000;
        let (observations, masks) = observed(layout, rows);
        let mut work = Workspace::default();
        let batch = ObservationBatch {
            observations: &observations,
            masks: &masks,
            rows,
        };
        network.forward(&parameters, batch, &mut work);
        let actions = layout.actions();
        let mut logits = vec![0.0; actions];
        for row in 0..rows {
            let mask = &masks[row * actions..][..actions];
            let observation = &observations[row * layout.observation()..][..layout.observation()];
            let mut native = logits.clone();
            state.logits(observation, mask, &mut native).unwrap();
            tract.logits(observation, mask, &mut logits).unwrap();
            let ours = &work.logits[row * actions..][..actions];
            let allowed = || (0..actions).filter(|action| mask[*action]);
            for action in allowed() {
                assert_eq!(ours[action], native[action]);
                let difference = (ours[action] - logits[action]).abs();
                assert!(difference < 1e-4, "{architecture:?} {row}: {difference}");
            }
            let best = |of: &[f32]| allowed().max_by(|a, b| of[*a].total_cmp(&of[*b]));
            assert_eq!(best(ours), best(&logits));
            assert!(
                (0..actions)
                    .all(|action| mask[action] || logits[action].max(native[action]) < -1e7)
            );
        }
    }
}

#[test]
fn wrong_files_are_refused_with_what_was_expected() {
    let architecture = Architecture::Mlp {
        hidden: vec![8],
        activation: Activation::Tanh,
    };
    let layout = Layout::PAPER;
    let (network, mut parameters, good) = exported(&architecture, layout);
    let message = |bytes: &[u8]| Policy::from_bytes(bytes, "f.onnx").unwrap_err().to_string();
    let check = |bytes: &[u8], words: &[&str]| {
        let message = message(bytes);
        for word in ["f.onnx"].iter().chain(words) {
            assert!(message.contains(word), "`{word}` not in {message}");
        }
    };
    check(b"id,x,y\n1,0,0\n", &["not an ONNX file"]);
    check(b"", &["no graph"]);
    for share in [1, 5, 9] {
        // Cut short, wherever it is.
        check(&good[..good.len() * share / 10], &["\n  cure: "]);
    }
    let mut metadata = Metadata::new(&layout);
    metadata.set("observation_version", "99");
    let other = export(&network, &parameters, &layout, &metadata);
    check(&other, &["version 99", "train it again"]);
    // Metadata of another layout than the network's.
    let wrong = Metadata::new(&FULL);
    check(
        &export(&network, &parameters, &layout, &wrong),
        &["52 numbers", "293"],
    );
    parameters[3] = f32::NAN;
    let nan = export(&network, &parameters, &layout, &Metadata::new(&layout));
    check(&nan, &["NaN"]);
}

/// Whatever bit of a file changes: either it is refused, or it is the same policy.
#[test]
fn a_changed_bit_is_noticed() {
    let architecture = Architecture::Mlp {
        hidden: vec![4],
        activation: Activation::Tanh,
    };
    let layout = Layout::PAPER;
    let (_, parameters, good) = exported(&architecture, layout);
    let observation: Vec<f32> = (0..52).map(|i| i as f32 / 52.0).collect();
    let logits = |policy: &Policy| -> Vec<u32> {
        let mut logits = [0.0; 10];
        let mut state = policy.state().unwrap();
        state
            .logits(&observation, &[true; 10], &mut logits)
            .unwrap();
        logits.map(f32::to_bits).to_vec()
    };
    let expected = logits(&Policy::from_bytes(&good, "f.onnx").unwrap());
    let mut by_hash = 0;
    for place in (0..good.len()).step_by(5) {
        let mut other = good.clone();
        other[place] ^= 1 << (place % 8);
        match Policy::from_bytes(&other, "f.onnx") {
            Ok(policy) => assert_eq!(logits(&policy), expected, "byte {place}"),
            Err(error) => {
                let message = error.to_string();
                assert!(message.contains("f.onnx"), "{message}");
                by_hash += usize::from(message.contains("has changed since it was exported"));
            }
        }
    }
    // Most of the file is weights, of which nearly every change is legal.
    assert!(by_hash > good.len() / 5 / 3, "{by_hash} of {}", good.len());
    let weight = parameters[3].to_le_bytes();
    let place = good.windows(4).position(|bytes| bytes == weight).unwrap();
    let mut other = good.clone();
    other[place] ^= 1;
    let message = Policy::from_bytes(&other, "f.onnx").unwrap_err();
    for word in [
        "f.onnx",
        "pickline.content_hash",
        "cure: get the file again",
    ] {
        assert!(
            message.to_string().contains(word),
            "{word} not in {message}"
        );
    }
}

/// The policy that ships has its hash, so that a bad copy of the repository is noticed.
#[test]
fn the_policy_that_ships_is_sealed() {
    let policy = Policy::shipped().unwrap();
    let hash = policy.metadata().get("content_hash").unwrap();
    assert_eq!(hash.len(), 16);
}

#[test]
fn files_without_metadata_are_known_by_their_sizes() {
    let architecture = Architecture::Mlp {
        hidden: vec![8],
        activation: Activation::Tanh,
    };
    for layout in [Layout::PAPER, FULL, Layout { wait: true, ..FULL }] {
        let (network, parameters, _) = exported(&architecture, layout);
        let bytes = export(&network, &parameters, &layout, &Metadata::default());
        assert_eq!(
            Policy::from_bytes(&bytes, "f.onnx").unwrap().layout(),
            layout
        );
    }
}

/// What both of torch's exporters wrote of a policy of Stable-Baselines3
/// (`tests/sb3/export.py`): the paper's observation, no mask, operator sets 17 to 20, a
/// batch of one and an open one.
#[test]
fn policies_of_stable_baselines_run() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/policies");
    let expected: Vec<f32> =
        serde_json::from_str(include_str!("../data/policies/logits.json")).unwrap();
    let mut read = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "onnx") {
            continue;
        }
        let policy = Policy::load(&path).unwrap();
        assert_eq!(policy.layout(), Layout::PAPER);
        let mut state = policy.state().unwrap();
        let observation: Vec<f32> = (0..52).map(|i| i as f32 / 52.0).collect();
        let mut logits = [0.0; 10];
        state
            .logits(&observation, &[true; 10], &mut logits)
            .unwrap();
        for (got, expected) in logits.iter().zip(&expected) {
            let file = path.display();
            assert!((got - expected).abs() < 1e-4, "{file}: {got}, {expected}");
        }
        read += 1;
    }
    assert_eq!(read, 14);
}
