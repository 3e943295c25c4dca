//! Policies in the forms in which other programs export them, and policies that answer
//! nonsense.

use crate::common::pickline;
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

pub fn value(name: &str, kind: DataType, width: usize) -> ValueInfoProto {
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

pub fn node(operator: &str, inputs: &[&str], output: &str) -> NodeProto {
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

pub fn model(
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
    for word in ["p.onnx", "`30`, `31`", "`31` is used"] {
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
        error.contains("cannot be matched") && error.contains("cure: "),
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
    refused(&["p.onnx.data", "truncated"]);
    for location in ["../p.onnx.data", "/etc/passwd", ""] {
        stands(&mut outside, location, 0);
        refused(&["outside its folder"]);
    }
    stands(&mut outside, "p.onnx.data", usize::MAX);
    refused(&["truncated"]);
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
    assert_eq!(told.matches("gave no valid answer").count(), 1, "{told}");
}

/// A network that prefers the last slot, or the first, whatever it sees, and has no input for a
/// mask: of the slots that hold an item it gets the last, or the first. Slots hold items in their
/// order on the belt.
#[test]
fn without_its_own_mask_a_policy_takes_only_allowed_actions() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    // With the first item in its bin, the robot has the choice between the other two.
    let station = "[belt]\nspeed = 0.1\nlength = 4\nwidth = 1\n[[robot]]\nname = \"a\"\n\
        base = [1, 0]\nbin = [1, 0]\nreach = 0.5\nspeed = 0.5\ngrasp_time = 0.3\n\
        release_time = 0.2\n";
    std::fs::write(path("s.toml"), station).unwrap();
    std::fs::write(path("p.csv"), "id,x,y\na,0,0\nb,-0.1,0\nc,-0.2,0\n").unwrap();
    let (policy, station, pattern) = (path("p.onnx"), path("s.toml"), path("p.csv"));
    let strategy = format!("onnx:{policy}");
    for (sign, expected) in [(1.0f32, ["a", "c", "b"]), (-1.0, ["a", "b", "c"])] {
        let mut model = plain("logits");
        let graph = model.graph.as_mut().unwrap();
        graph.node[0] = node("MatMul", &["obs", "w"], "product");
        graph
            .node
            .push(node("Add", &["product", "preference"], "logits"));
        let preference = (0..LAYOUT.actions()).map(|slot| sign * 1e6 * slot as f32);
        graph.initializer.push(TensorProto {
            name: "preference".into(),
            dims: vec![LAYOUT.actions() as i64],
            data_type: DataType::Float as i32,
            raw_data: preference.flat_map(f32::to_le_bytes).collect(),
            ..Default::default()
        });
        std::fs::write(&policy, model.encode_to_vec()).unwrap();
        let output = pickline(&[
            "simulate",
            "-q",
            "--no-bound",
            "--format",
            "json",
            "--station",
            &station,
            "--pattern",
            &pattern,
            "--strategy",
            &strategy,
        ]);
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{told}");
        let run: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let picks = run["picks"].as_array().unwrap();
        let items: Vec<&str> = picks
            .iter()
            .map(|pick| pick["item"].as_str().unwrap())
            .collect();
        assert_eq!(items, expected);
    }
}

/// The logits of `plain` beside another output of the same width.
fn beside(operator: &str, other: &str, kind: DataType, name: &str) -> ModelProto {
    let actions = LAYOUT.actions();
    let mut model = plain("l0");
    let graph = model.graph.as_mut().unwrap();
    let inputs: &[&str] = if operator == "Greater" {
        &["l0", "l0"]
    } else {
        &["l0"]
    };
    graph.node.push(node(operator, inputs, other));
    graph.node.push(node("Identity", &["l0"], name));
    graph.output = vec![
        value(other, kind, actions),
        value(name, DataType::Float, actions),
    ];
    model
}

#[test]
fn the_output_of_the_logits_is_found_by_type_and_name_or_asked_for() {
    let expected = logits(&read(&plain("logits")));
    for model in [
        beside("Greater", "mask_out", DataType::Bool, "pi"),
        beside("Neg", "std", DataType::Float, "action_logits"),
        beside("Neg", "action_std", DataType::Float, "action"),
    ] {
        assert_eq!(logits(&read(&model)), expected);
    }
    let unclear = beside("Neg", "a", DataType::Float, "b").encode_to_vec();
    let error = Policy::from_bytes(&unclear, "p.onnx")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("any of the outputs `a`, `b`") && error.contains("`logits`"),
        "{error}"
    );
}

#[test]
fn an_output_of_open_width_shows_what_it_means() {
    let waiting = Layout {
        wait: true,
        ..LAYOUT
    };
    let mut model = plain("logits");
    let graph = model.graph.as_mut().unwrap();
    graph.initializer[0] = weights("w", waiting.actions(), false);
    graph.output[0].r#type = None;
    let policy = read(&model);
    assert_eq!(policy.layout(), waiting);
}

#[test]
fn logits_in_half_and_beyond_single_precision_are_read() {
    let mut half = plain("l0");
    let graph = half.graph.as_mut().unwrap();
    let mut cast = node("Cast", &["l0"], "logits");
    cast.attribute.push(tract_onnx::pb::AttributeProto {
        name: "to".into(),
        i: DataType::Float16 as i64,
        r#type: tract_onnx::pb::attribute_proto::AttributeType::Int as i32,
        ..Default::default()
    });
    graph.node.push(cast);
    graph.output = vec![value("logits", DataType::Float16, LAYOUT.actions())];
    let expected = logits(&read(&plain("logits")));
    for (found, expected) in logits(&read(&half)).iter().zip(&expected) {
        assert!((found - expected).abs() <= 0.01 * expected.abs().max(1.0));
    }
    // The order stays.
    let scaled = |factor: f64| {
        let mut model = plain("logits");
        let graph = model.graph.as_mut().unwrap();
        graph.input[0] = value("obs", DataType::Double, LAYOUT.observation());
        let mut matrix = weights("w", LAYOUT.actions(), true);
        for bytes in matrix.raw_data.chunks_exact_mut(8) {
            let number = f64::from_le_bytes(bytes.try_into().unwrap());
            bytes.copy_from_slice(&(factor * number).to_le_bytes());
        }
        graph.initializer[0] = matrix;
        graph.output[0] = value("logits", DataType::Double, LAYOUT.actions());
        logits(&read(&model))
    };
    let best = |logits: &[f32]| {
        assert!(logits.iter().all(|logit| logit.is_finite()), "{logits:?}");
        (0..logits.len())
            .max_by(|&a, &b| logits[a].total_cmp(&logits[b]))
            .unwrap()
    };
    assert_eq!(best(&scaled(1e60)), best(&scaled(1.0)));
}

/// `plain` with its weights in the file `location`, as weights or as a constant.
fn outside(location: &str, constant: bool) -> (ModelProto, Vec<u8>) {
    let mut model = plain("logits");
    let graph = model.graph.as_mut().unwrap();
    let tensor = &mut graph.initializer[0];
    let bytes = std::mem::take(&mut tensor.raw_data);
    tensor.data_location = Some(DataLocation::External as i32);
    tensor.external_data = vec![StringStringEntryProto {
        key: "location".into(),
        value: location.into(),
    }];
    if constant {
        let mut holder = node("Constant", &[], "w");
        holder.attribute.push(tract_onnx::pb::AttributeProto {
            name: "value".into(),
            t: graph.initializer.pop(),
            r#type: tract_onnx::pb::attribute_proto::AttributeType::Tensor as i32,
            ..Default::default()
        });
        graph.node.insert(0, holder);
    }
    (model, bytes)
}

#[test]
fn weights_elsewhere_are_read_and_never_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("data")).unwrap();
    for constant in [false, true] {
        let (model, bytes) = outside("data/w.bin", constant);
        std::fs::write(at("p.onnx"), model.encode_to_vec()).unwrap();
        std::fs::write(at("data/w.bin"), &bytes).unwrap();
        let expected = logits(&read(&plain("logits")));
        assert_eq!(logits(&Policy::load(&at("p.onnx")).unwrap()), expected);
        let strategy = format!("onnx:{}", at("p.onnx").display());
        let target = at("data/w.bin");
        let output = pickline(&[
            "simulate",
            "-q",
            "--no-bound",
            "--force",
            "--strategy",
            &strategy,
            "--html",
            target.to_str().unwrap(),
        ]);
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(std::fs::read(&target).unwrap(), bytes);
    }
}

#[cfg(unix)]
#[test]
fn weights_in_a_pipe_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("p.onnx");
    std::fs::write(&path, outside("pipe", false).0.encode_to_vec()).unwrap();
    let made = std::process::Command::new("mkfifo")
        .arg(folder.path().join("pipe"))
        .status();
    assert!(made.unwrap().success());
    let error = Policy::load(&path).unwrap_err().to_string();
    assert!(error.contains("not a regular file"), "{error}");
}
