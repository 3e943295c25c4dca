//! Logits that single precision cannot hold.

use crate::policy_forms::{model, node, value};
use pickline::decision::observation::Layout;
use pickline::policy::Policy;
use prost::Message as _;
use tract_onnx::pb::{TensorProto, tensor_proto::DataType};

const LAYOUT: Layout = Layout::PAPER;

fn tensor(name: &str, dims: &[usize], numbers: &[f64]) -> TensorProto {
    TensorProto {
        name: name.into(),
        dims: dims.iter().map(|size| *size as i64).collect(),
        data_type: DataType::Double as i32,
        raw_data: numbers.iter().flat_map(|x| x.to_le_bytes()).collect(),
        ..Default::default()
    }
}

/// What is read of a network whose first logits are `first`, in double precision, and whose
/// others are 0, where only the actions in `allowed` are.
fn read(first: &[f64], allowed: &[usize]) -> Vec<f32> {
    let (observation, actions) = (LAYOUT.observation(), LAYOUT.actions());
    let mut preference = vec![0.0; actions];
    preference[..first.len()].copy_from_slice(first);
    let nothing = vec![0.0; observation * actions];
    let model = model(
        vec![value("obs", DataType::Double, observation)],
        vec![
            node("MatMul", &["obs", "w"], "product"),
            node("Add", &["product", "preference"], "logits"),
        ],
        vec![
            tensor("w", &[observation, actions], &nothing),
            tensor("preference", &[actions], &preference),
        ],
        vec![value("logits", DataType::Double, actions)],
    );
    let policy = Policy::from_bytes(&model.encode_to_vec(), "p.onnx").unwrap();
    let mut mask = vec![false; actions];
    allowed.iter().for_each(|action| mask[*action] = true);
    let mut logits = vec![0.0; actions];
    let mut state = policy.state().unwrap();
    let observation = vec![1.0; observation];
    state.logits(&observation, &mask, &mut logits).unwrap();
    logits
}

#[test]
fn allowed_logits_keep_their_differences_whatever_the_others_are() {
    assert_eq!(read(&[3.0, 5.0, 7.0], &[0, 1])[..3], [3.0, 5.0, 7.0]);
    for huge in [1e300, -1e300] {
        let logits = read(&[3.0, 5.0, huge], &[0, 1]);
        assert_eq!(logits[1] - logits[0], 2.0, "{huge}: {logits:?}");
        assert!(logits.iter().all(|logit| logit.is_finite()), "{logits:?}");
    }
    // Where an allowed one is huge itself, nothing else has a chance.
    let logits = read(&[3.0, 2e300, 1e300], &[0, 1, 2]);
    assert_eq!(logits[..3], [f32::MIN, 0.0, f32::MIN]);
}
