//! `pickline train` as its users see it.
#![cfg(feature = "onnx")]

mod common;

use common::{pickline, text};
use std::path::Path;

/// A line on which a training is short.
const STATION: &str = "--station";

fn train(out: &Path, flags: &[&str]) -> Vec<String> {
    let out = out.to_str().unwrap();
    let small = ["train", "-q", STATION, "paper", "--out", out];
    [&small[..], flags]
        .concat()
        .into_iter()
        .map(str::to_owned)
        .collect()
}

fn refs(arguments: &[String]) -> Vec<&str> {
    arguments.iter().map(String::as_str).collect()
}

#[test]
fn a_training_leaves_its_policy_its_record_and_its_curve() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("p.onnx");
    let flags = [
        "--imitate",
        "SPT,SPT",
        "--imitate-rounds",
        "2",
        "--imitate-patterns",
        "6",
        "--steps",
        "8192",
    ];
    let printed = text(&refs(&train(&out, &flags)));
    assert!(printed.contains("paper: grid 0.15, 150 items"), "{printed}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let record: serde_json::Value = serde_json::from_str(&read("p.json")).unwrap();
    assert_eq!(record["steps"], 8192);
    assert_eq!(record["trials"].as_array().unwrap().len(), 8);
    // Two rounds of imitation and a phase; what each was judged after stands in it.
    let curve = read("p.csv");
    let mut rows = csv::Reader::from_reader(curve.as_bytes());
    let header = rows.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|h| h == name).unwrap();
    let (steps, answers, entropy) = (column("steps"), column("answers"), column("entropy"));
    let rows: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
    let has = |place: usize| -> Vec<bool> { rows.iter().map(|r| !r[place].is_empty()).collect() };
    assert_eq!(has(answers), [true, true, false]);
    assert_eq!(has(entropy), [false, false, true]);
    assert_eq!(&rows[2][steps], "8192");
    let picture = read("p.svg");
    let picture = roxmltree::Document::parse(&picture).unwrap();
    assert!(
        picture
            .descendants()
            .any(|node| node.text() == Some("Learning curve"))
    );
    // It plays, and a checkpoint goes on.
    let strategy = format!("onnx:{}", out.display());
    let run = text(&["simulate", "-q", "--strategy", &strategy]);
    assert!(run.contains("picked"), "{run}");
    let checkpoint = folder.path().join("p.checkpoint.json");
    let checkpoint = checkpoint.to_str().unwrap();
    let further = folder.path().join("q.onnx");
    let resumed = |flags: &[&str]| {
        let out = further.to_str().unwrap();
        text(
            &[
                &["train", "-q", "--resume", checkpoint, "--out", out],
                flags,
            ]
            .concat(),
        )
    };
    // Nothing was left to do: the same policy and the same curve.
    resumed(&[]);
    let again: serde_json::Value = serde_json::from_str(&read("q.json")).unwrap();
    for part in ["trials", "best_steps", "steps", "stations", "wall_time_s"] {
        assert_eq!(again[part], record[part], "{part}");
    }
    assert_eq!(curve, read("q.csv"));
    // Another phase, behind what was there.
    resumed(&["--steps", "16384"]);
    assert!(read("q.csv").starts_with(&curve));
    assert_eq!(read("q.csv").lines().count(), curve.lines().count() + 1);
}

#[test]
fn slips_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("p.onnx");
    let broken = folder.path().join("broken.json");
    std::fs::write(&broken, "{\"plan\": 3}").unwrap();
    let broken = broken.to_str().unwrap();
    for (flags, words) in [
        (
            &["--preset", "papr"][..],
            &["papr", "did you mean `paper`"][..],
        ),
        (&["--learning-rate", "0"], &["--learning-rate"]),
        (&["--learning-rate", "nan"], &["--learning-rate"]),
        (&["--entropy", "-1"], &["--entropy"]),
        (&["--station", "papr:2"], &["papr"]),
        (&["--station", "paper:0"], &["robots"]),
        (
            &["--station", "paper:99999999999999999999"],
            &["99999999999999999999"],
        ),
        (
            &["--imitate", "lookahed"],
            &["--imitate", "did you mean `lookahead`"],
        ),
        (
            &["--imitate", "SPT,SPT", "--imitate-rounds", "0"],
            &["--imitate-rounds"],
        ),
        (
            &["--imitate", "SPT,SPT", "--imitate-patterns", "0"],
            &["--imitate-patterns"],
        ),
        (&["--imitate-rounds", "3"], &["--imitate"]),
        (&["--resume", broken], &["--resume", "--station"]),
        (&["--station", "paper:7"], &["7 robots", "at most 6"]),
        (&["--out", "no-such-folder/p.onnx"], &["no-such-folder"]),
        (&["--threads", "0"], &["--threads"]),
        (&["--steps", "-1"], &["--steps"]),
    ] {
        let arguments = train(&out, flags);
        // The last --out counts where it is given twice, so give it once.
        let arguments = match flags.contains(&"--out") {
            true => [&["train", "-q"], flags].concat(),
            false => refs(&arguments),
        };
        let output = pickline(&arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{flags:?}: {stderr}");
        for word in words {
            assert!(stderr.contains(word), "{flags:?}: {word} not in {stderr}");
        }
        assert!(!stderr.contains("panicked"), "{stderr}");
    }
    for (resumed, words) in [
        (broken, "broken.json"),
        ("nothing-here.json", "nothing-here.json"),
    ] {
        let output = pickline(&[
            "train",
            "-q",
            "--resume",
            resumed,
            "--out",
            out.to_str().unwrap(),
        ]);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{stderr}");
        assert!(stderr.contains(words), "{stderr}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
