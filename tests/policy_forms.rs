//! Policies in the forms in which other programs export them, and policies that answer
//! nonsense.
#![cfg(feature = "onnx")]

mod common;

use common::pickline;
use pickline::decision::observation::Layout;
use pickline::policy::Policy;
use prost::Message as _;
use std::path::Path;
use tract_onnx::pb::{
    GraphProto, ModelProto, NodeProto, OperatorSetIdProto, StringStringEntryProto, TensorProto,
    TensorShapeProto, TypeProto, ValueInfoProto,
    tensor_proto::{DataLocation, DataType},
    tensor_shape_proto::{Dimension, dimension},
    type_proto,
};

const LAYOUT: Layout = Layout::PAPER;

fn value(name: &str, kind: DataType, width: usize) -> ValueInfoProto {
    let dimension = |value| Dimension {
        value: Some(value),
        ..Default::default()
    };
    let dim = vec![
        dimension(dimension::Value::DimParam("batch".into())),
        dimension(dimension::Value::DimValue(width as i64)),
    ];
    ValueInfoProto {
        name: name.into(),
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

fn node(operator: &str, inputs: &[&str], output: &str) -> NodeProto {
    NodeProto {
        op_type: operator.into(),
        name: output.into(),
        input: inputs.iter().map(|name| (*name).to_owned()).collect(),
        output: vec![output.into()],
        ..Default::default()
    }
}

/// A matrix of numbers that are no regular pattern.
fn weights(name: &str, columns: usize, double: bool) -> TensorProto {
    let rows = LAYOUT.observation();
    let numbers = (0..rows * columns).map(|i| ((i * 37 % 101) as f32 - 50.0) / 64.0);
    let (kind, raw_data) = if double {
        let bytes = numbers.flat_map(|x| f64::from(x).to_le_bytes()).collect();
        (DataType::Double, bytes)
    } else {
        (
            DataType::Float,
            numbers.flat_map(f32::to_le_bytes).collect(),
        )
    };
    TensorProto {
        name: name.into(),
        dims: vec![rows as i64, columns as i64],
        data_type: kind as i32,
        raw_data,
        ..Default::default()
    }
}

fn model(
    inputs: Vec<ValueInfoProto>,
    nodes: Vec<NodeProto>,
    weights: Vec<TensorProto>,
    outputs: Vec<ValueInfoProto>,
) -> ModelProto {
    ModelProto {
        ir_version: 8,
        opset_import: vec![OperatorSetIdProto {
            domain: String::new(),
            version: 17,
        }],
        graph: Some(GraphProto {
            name: "policy".into(),
            node: nodes,
            initializer: weights,
            input: inputs,
            output: outputs,
            ..Default::default()
        }),
        ..Default::default()
    }
}

/// From one observation to logits called `output`.
fn plain(output: &str) -> ModelProto {
    let (observation, actions) = (LAYOUT.observation(), LAYOUT.actions());
    model(
        vec![value("obs", DataType::Float, observation)],
        vec![node("MatMul", &["obs", "w"], output)],
        vec![weights("w", actions, false)],
        vec![value(output, DataType::Float, actions)],
    )
}

fn logits(policy: &Policy) -> Vec<f32> {
    assert_eq!(policy.layout(), LAYOUT);
    let observation: Vec<f32> = (0..LAYOUT.observation())
        .map(|i| (i * i % 7) as f32)
        .collect();
    let mut logits = vec![0.0; LAYOUT.actions()];
    let mask = vec![true; LAYOUT.actions()];
    let mut state = policy.state().unwrap();
    state.logits(&observation, &mask, &mut logits).unwrap();
    logits
}

fn read(model: &ModelProto) -> Policy {
    Policy::from_bytes(&model.encode_to_vec(), "p.onnx").unwrap()
}

#[test]
fn of_several_outputs_the_logits_are_taken_and_named() {
    let expected = logits(&read(&plain("logits")));
    assert_eq!(read(&plain("31")).remark(), None);
    let (observation, actions) = (LAYOUT.observation(), LAYOUT.actions());
    let nodes = vec![
        node("MatMul", &["obs", "v"], "30"),
        node("MatMul", &["obs", "w"], "31"),
    ];
    let tensors = vec![weights("v", 1, false), weights("w", actions, false)];
    let outputs = [("30", 1), ("31", actions)];
    let outputs = outputs.map(|(name, width)| value(name, DataType::Float, width));
    let inputs = vec![value("obs", DataType::Float, observation)];
    let both = read(&model(inputs, nodes, tensors, outputs.to_vec()));
    assert_eq!(logits(&both), expected);
    let remark = both.remark().unwrap();
    for word in ["p.onnx", "`30`, `31`", "takes `31`"] {
        assert!(remark.contains(word), "{remark}");
    }
}

#[test]
fn doubles_and_two_inputs_mean_the_same() {
    let expected = logits(&read(&plain("logits")));
    let (observation, actions) = (LAYOUT.observation(), LAYOUT.actions());
    let double = model(
        vec![value("obs", DataType::Double, observation)],
        vec![node("MatMul", &["obs", "w"], "logits")],
        vec![weights("w", actions, true)],
        vec![value("logits", DataType::Double, actions)],
    );
    for (double, single) in logits(&read(&double)).iter().zip(&expected) {
        assert!((double - single).abs() < 1e-4, "{double} {single}");
    }
    let globals = LAYOUT.globals();
    let parts = [("a", globals), ("b", observation - globals)];
    // The widths tell the parts, not their order or names.
    for order in [[0, 1], [1, 0]] {
        let mut joined = node("Concat", &["a", "b"], "obs");
        joined.attribute.push(tract_onnx::pb::AttributeProto {
            name: "axis".into(),
            i: 1,
            r#type: tract_onnx::pb::attribute_proto::AttributeType::Int as i32,
            ..Default::default()
        });
        let inputs = order.map(|place| value(parts[place].0, DataType::Float, parts[place].1));
        let two = model(
            inputs.to_vec(),
            vec![joined, node("MatMul", &["obs", "w"], "logits")],
            vec![weights("w", actions, false)],
            vec![value("logits", DataType::Float, actions)],
        );
        assert_eq!(logits(&read(&two)), expected);
    }
    let mut odd = plain("logits");
    let graph = odd.graph.as_mut().unwrap();
    graph.input = vec![
        value("a", DataType::Float, globals + 1),
        value("b", DataType::Float, observation - globals - 1),
    ];
    graph.node[0].input[0] = "a".into();
    let error = Policy::from_bytes(&odd.encode_to_vec(), "p.onnx").unwrap_err();
    let error = error.to_string();
    assert!(
        error.contains("cannot be told") && error.contains("cure: "),
        "{error}"
    );
}

#[test]
fn weights_may_stand_in_a_file_beside() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let mut outside = plain("logits");
    let graph = outside.graph.as_mut().unwrap();
    let bytes = std::mem::take(&mut graph.initializer[0].raw_data);
    let length = bytes.len();
    let stands = |model: &mut ModelProto, location: &str, offset: usize| {
        let tensor = &mut model.graph.as_mut().unwrap().initializer[0];
        tensor.data_location = Some(DataLocation::External as i32);
        tensor.external_data = [
            ("location", location.to_owned()),
            ("offset", offset.to_string()),
            ("length", length.to_string()),
        ]
        .map(|(key, value)| StringStringEntryProto {
            key: key.into(),
            value,
        })
        .to_vec();
        std::fs::write(at("p.onnx"), model.encode_to_vec()).unwrap();
    };
    stands(&mut outside, "p.onnx.data", 8);
    let refused = |words: &[&str]| {
        let error = Policy::load(&at("p.onnx")).unwrap_err().to_string();
        for word in words {
            assert!(error.contains(word), "{word} not in {error}");
        }
    };
    refused(&["p.onnx.data", "cannot be read", "external_data=False"]);
    std::fs::write(at("p.onnx.data"), [&[0; 8], &bytes[..]].concat()).unwrap();
    let policy = Policy::load(&at("p.onnx")).unwrap();
    assert_eq!(logits(&policy), logits(&read(&plain("logits"))));
    std::fs::write(at("p.onnx.data"), &bytes[..length - 1]).unwrap();
    refused(&["p.onnx.data", "cut short"]);
    for location in ["../p.onnx.data", "/etc/passwd", ""] {
        stands(&mut outside, location, 0);
        refused(&["outside of its folder"]);
    }
    stands(&mut outside, "p.onnx.data", usize::MAX);
    refused(&["cut short"]);
}

/// `plain` with its logits put through `operators`.
fn nonsense(operators: &[&str], file: &Path) {
    let mut model = plain("logits");
    let graph = model.graph.as_mut().unwrap();
    (graph.node[0].output[0], graph.node[0].name) = ("0".into(), "0".into());
    for (place, operator) in operators.iter().enumerate() {
        let last = place + 1 == operators.len();
        let to = if last {
            "logits".into()
        } else {
            (place + 1).to_string()
        };
        let from = place.to_string();
        graph.node.push(node(operator, &[&from], &to));
    }
    std::fs::write(file, model.encode_to_vec()).unwrap();
}

#[test]
fn a_policy_that_answers_nonsense_ends_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("n.onnx");
    let strategy = format!("onnx:{}", file.display());
    for (operators, logit) in [
        (&["Abs", "Neg", "Sqrt"][..], "NaN"),
        (&["Exp", "Exp", "Exp", "Exp"], "inf"),
    ] {
        nonsense(operators, &file);
        for verb in [
            &["simulate", "-q", "--no-bound"][..],
            &[
                "compare",
                "-q",
                "--no-bound",
                "--replicates",
                "1",
                "--robust",
                "SPT,FIFO",
            ],
        ] {
            let output = pickline(&[verb, &["--strategy", &strategy]].concat());
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            assert_eq!(output.status.code(), Some(1), "{verb:?}: {told}");
            assert!(output.stdout.is_empty());
            for word in [
                "n.onnx",
                "decision number ",
                "observation: [",
                logit,
                "robot `r",
                "cure: ",
            ] {
                assert!(told.contains(word), "{word} not in {told}");
            }
        }
    }
    // A live line goes on without a task, says so once and counts.
    nonsense(&["Abs", "Neg", "Sqrt"], &file);
    let stream = "{\"kind\":\"robot\",\"stamp\":0,\"name\":\"r1\",\"state\":\"idle\"}\n\
        {\"kind\":\"detection\",\"stamp\":1,\"id\":\"a\",\"x\":0.5,\"y\":-0.3}\n\
        {\"kind\":\"tick\",\"stamp\":40}\n";
    let mut node = std::process::Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["run", "--clock", "messages", "--strategy", &strategy])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    use std::io::Write as _;
    node.stdin
        .take()
        .unwrap()
        .write_all(stream.as_bytes())
        .unwrap();
    let output = node.wait_with_output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(!said.contains("\"kind\":\"task\""), "{said}");
    assert!(said.contains("illegal_action"), "{said}");
    assert_eq!(told.matches("has no usable answer").count(), 1, "{told}");
}
