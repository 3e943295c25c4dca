//! Every option of `pickline train` reaches the training.

use crate::common::text;

/// Two trainings that differ in each option: what each asks for stands in the record, and where
/// it is more than a figure it is seen in what was written.
#[test]
fn every_option_reaches_the_training() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let train = |out: &str, line: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_pickline"));
        let whole = format!("train --steps 1 --imitate FIFO {line} --out {out}");
        command
            .args(whole.split_whitespace())
            .current_dir(folder.path());
        let output = command.output().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), told)
    };
    let record = |name: &str| -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(path(name)).unwrap()).unwrap()
    };
    // Its own files are written over with --force alone, and not where they lie.
    std::fs::write(path("a.csv"), "mine").unwrap();
    std::fs::hard_link(path("a.csv"), path("kept")).unwrap();
    let line = "-q --preset paper --station paper-narrow:1 --learning-rate 0.0007 --entropy 0.03 \
                --seed 7 --threads 1 --imitate-rounds 1 --imitate-patterns 2";
    let (code, told) = train("a.onnx", line);
    assert!(code == Some(2) && told.contains("a.csv exists"), "{told}");
    assert_eq!(
        train("a.onnx", &format!("{line} --force")),
        (Some(0), String::new())
    );
    assert_eq!(std::fs::read_to_string(path("kept")).unwrap(), "mine");
    let few = "--station paper:1 --imitate-rounds 2 --imitate-patterns 3";
    let (code, told) = train("b.onnx", few);
    assert_eq!(code, Some(0), "{told}");
    assert_eq!(told.matches(" answers, ").count(), 2, "{told}");
    let (a, b) = (record("a.json"), record("b.json"));
    assert_eq!(
        (&a["plan"]["preset"], &b["plan"]["preset"]),
        (&"paper".into(), &"default".into())
    );
    assert_eq!(
        (&a["plan"]["view"], &b["plan"]["view"]),
        (&"paper".into(), &"full".into())
    );
    assert_eq!((&a["seed"], &b["seed"]), (&7.into(), &1.into()));
    assert_eq!(
        (&a["stations"][0], &b["stations"][0]),
        (&"paper-narrow:1".into(), &"paper:1".into())
    );
    // Another line, on which the rules pick other shares.
    assert_eq!(
        a["trials"].as_array().unwrap().len(),
        b["trials"].as_array().unwrap().len()
    );
    assert_ne!(a["trials"][0]["robust"], b["trials"][0]["robust"]);
    let figure =
        |record: &serde_json::Value, name: &str| record["plan"]["ppo"][name].as_f64().unwrap();
    assert!((figure(&a, "learning_rate") - 0.0007).abs() < 1e-9, "{a}");
    assert!((figure(&a, "ent_coef") - 0.03).abs() < 1e-7, "{a}");
    assert!(figure(&b, "learning_rate") != 0.0007 && figure(&b, "ent_coef") != 0.03);
    let rounds = |record: &serde_json::Value| {
        let imitation = &record["plan"]["imitation"];
        (imitation["rounds"].as_u64(), imitation["courses"].as_u64())
    };
    assert_eq!(
        (rounds(&a), rounds(&b)),
        ((Some(1), Some(2)), (Some(2), Some(3)))
    );
    // A station that is not plausible is warned of, before it is found that the strategy to
    // imitate is for another, and refused where that is asked for.
    let station = text(&["station", "show", "--robots", "1"]);
    let odd = station.replace("length = ", "length = 100");
    assert_ne!(odd, station);
    std::fs::write(path("odd.toml"), odd).unwrap();
    let odd = "--station odd.toml --station paper:2";
    let (code, told) = train("d.onnx", odd);
    assert_eq!(code, Some(2));
    assert!(told.starts_with("warning: odd.toml: belt.length"), "{told}");
    assert!(told.contains("pickline: --imitate: "), "{told}");
    let (code, told) = train("d.onnx", &format!("{odd} --strict"));
    assert_eq!(code, Some(2));
    assert!(
        told.starts_with("pickline: odd.toml: belt.length"),
        "{told}"
    );
}

/// More threads than this process has room for: the number reaches those who make them. The
/// stacks are large, so that the one that is refused leaves room for everything else.
#[cfg(target_os = "linux")]
#[test]
fn a_training_is_given_its_threads() {
    let folder = tempfile::tempdir().unwrap();
    let script = "ulimit -v 1048576; exec \"$0\" train --steps 1 --threads 1024";
    let output = std::process::Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_pickline")])
        .current_dir(folder.path())
        .env("RUST_MIN_STACK", "200000000")
        .output()
        .unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{told}");
    let lacks = told.starts_with("pickline: worker threads: ");
    assert!(lacks && told.contains("--threads"), "{told}");
}
