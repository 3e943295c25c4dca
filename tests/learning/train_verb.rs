//! `pickline train` as its users see it.

use crate::common::{pickline, text};
#[cfg(unix)]
use crate::programs::{Program, wait_for};
use pickline::decision::Outcome;
use pickline::dispatch::RuleAssignment;
use pickline::experiment::{Case, load_cases};
use pickline::policy::{Policy, PolicyStrategy};
use pickline::rl::domain::Domain;
use pickline::sim::{Scene, simulate, simulate_rules};
use pickline::station::built_in;
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

/// The figures of a trial are means over patterns that no training and no table sees: those of
/// the case under the seeds from 990,000 on.
fn assert_trial(trial: &serde_json::Value, case: &Case, policy: &Policy) {
    assert_eq!(trial["name"], format!("paper: {}", case.name));
    let station = built_in("paper").unwrap().station(None).unwrap();
    let patterns = case.patterns(station.belt(), 10, 990_000).unwrap();
    let training = Domain::BROAD
        .draw(std::slice::from_ref(&station), 300, 1.0, 1)
        .unwrap();
    let (mut robust, mut best, mut ours) = (0.0, 0.0, 0.0);
    for (_, pattern) in &patterns {
        assert!(!training.iter().any(|course| course.pattern == *pattern));
        let scene = Scene::new(&station, pattern).unwrap();
        // An item of which nothing is known weighs a half.
        let weight = |outcome: &Outcome| 0.5 * outcome.picks.len() as f64;
        let rate = |outcome: Outcome| 60.0 * weight(&outcome) / outcome.figures.end;
        let of = |rules: &RuleAssignment| rate(simulate_rules(&scene, rules).unwrap());
        robust += of(&"SPT,FIFO".parse().unwrap());
        best += RuleAssignment::all(2)
            .map(|rules| of(&rules))
            .fold(0.0, f64::max);
        let mut strategy = PolicyStrategy::new("onnx:p".into(), policy);
        ours += rate(simulate(&scene, &mut strategy).unwrap());
    }
    for (key, sum) in [("robust", robust), ("greedy", best), ("policy", ours)] {
        let (found, expected) = (trial[key].as_f64().unwrap(), sum / patterns.len() as f64);
        assert!(
            (found / expected - 1.0).abs() < 1e-6,
            "{trial}: {key} {expected}"
        );
    }
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
    let policy = Policy::load(&out).unwrap();
    for (trial, case) in record["trials"]
        .as_array()
        .unwrap()
        .iter()
        .zip(load_cases("all").unwrap())
    {
        assert_trial(trial, &case, &policy);
    }
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

/// What is learned from is the plan's, whatever the preset says, and the record repeats it.
#[test]
fn a_plan_changes_the_preset_and_a_record_is_a_plan() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let plan = r#"{"wait": true, "reward": {"pick": 2, "rate": 0.25}, "steps": 4096,
        "imitation": {"strategy": "SPT,SPT", "rounds": 1, "courses": 4}}"#;
    std::fs::write(path("plan.json"), plan).unwrap();
    let train = |plan: &str, out: &str| {
        let (plan, out) = (path(plan), path(out));
        text(&["train", "-q", "--plan", &plan, "--out", &out])
    };
    let printed = train("plan.json", "a.onnx");
    let read = |name: &str| std::fs::read(path(name)).unwrap();
    let record: serde_json::Value = serde_json::from_slice(&read("a.json")).unwrap();
    let made = &record["plan"];
    assert_eq!(made["wait"], true);
    assert_eq!(
        made["reward"],
        serde_json::json!({"pick": 2.0, "rate": 0.25})
    );
    assert_eq!(made["slots"], 16);
    assert_eq!(made["imitation"]["strategy"], "SPT,SPT");
    assert_eq!(String::from_utf8(read("a.csv")).unwrap().lines().count(), 3);
    // The record of a training makes it again.
    assert_eq!(train("a.json", "b.onnx"), printed);
    let rates = |name: &str| {
        let text = String::from_utf8(read(name)).unwrap();
        let rows = text.lines().map(|line| line.split(',').skip(2).collect());
        rows.collect::<Vec<Vec<&str>>>().concat().join(",")
    };
    assert_eq!(rates("a.csv"), rates("b.csv"));
}

/// The policy is the network at the end, although an earlier one is better on the cases, which are not
/// those that it learns from.
#[test]
fn the_last_network_is_kept_where_the_plan_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let train = |name: &str, keep: &str| {
        let plan = format!(
            r#"{{"preset": "paper", "courses": 12, "updates": 1, "steps": 8192, "keep": "{keep}",
                "domain": {{"patterns": "balanced:6", "items": [40, 40], "curriculum": 0}}}}"#
        );
        let file = folder.path().join("plan.json");
        std::fs::write(&file, plan).unwrap();
        let out = folder.path().join(name);
        text(&refs(&train(&out, &["--plan", file.to_str().unwrap()])));
        let record = std::fs::read_to_string(out.with_extension("json")).unwrap();
        let record: serde_json::Value = serde_json::from_str(&record).unwrap();
        let rates = record["trials"].as_array().unwrap().iter();
        let rates = rates.map(|trial| format!("{:.3}", trial["policy"].as_f64().unwrap()));
        let rates = rates.collect::<Vec<_>>().join(",");
        let curve = learned(folder.path(), &name.replace(".onnx", ".csv"));
        let ends = |row: &String| row.ends_with(&rates);
        (
            record["best_steps"].as_u64(),
            curve.iter().rposition(ends),
            curve.len(),
        )
    };
    let (steps, place, rows) = train("last.onnx", "last");
    assert_eq!((steps, place, rows), (Some(8192), Some(5), 6));
    let (steps, place, _) = train("best.onnx", "best");
    assert_eq!(steps, place.map(|place| 2048 * (place as u64 - 1)));
    assert_ne!(steps, Some(8192));
}

/// The curve without the seconds that it took.
fn learned(folder: &Path, name: &str) -> Vec<String> {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    let row = |line: &str| {
        let parts = line.split(',').enumerate();
        let parts = parts.filter(|(place, _)| *place != 1);
        parts.map(|(_, part)| part).collect::<Vec<_>>().join(",")
    };
    text.lines().map(row).collect()
}

#[cfg(unix)]
#[test]
fn a_training_that_was_interrupted_goes_on_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (whole, cut) = (path("whole.onnx"), path("cut.onnx"));
    text(&["train", "-q", "--steps", "114688", "--out", &whole]);
    let train = format!("train -q --steps 114688 --out {cut}");
    let mut training = Program::pickline(&train, &[]);
    // In the midst of a phase, most likely.
    let curve = folder.path().join("cut.csv");
    wait_for("four lines of the curve", || {
        let lines = std::fs::read_to_string(&curve).map_or(0, |text| text.lines().count());
        lines >= 4
    });
    training.signal("INT");
    let (code, remarks) = training.finish();
    assert_eq!(code, Some(130), "{remarks}");
    assert!(learned(folder.path(), "cut.csv").len() < learned(folder.path(), "whole.csv").len());
    let checkpoint = path("cut.checkpoint.json");
    text(&["train", "-q", "--resume", &checkpoint, "--out", &cut]);
    assert_eq!(
        learned(folder.path(), "whole.csv"),
        learned(folder.path(), "cut.csv")
    );
}

#[test]
fn a_diverging_training_says_so_and_keeps_the_best_policy() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("p.onnx");
    let flags = ["--steps", "20000", "--learning-rate", "1e30"];
    let output = pickline(&refs(&train(&out, &flags)));
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(
        stderr.contains("NaN or infinite") && stderr.contains("--learning-rate"),
        "{stderr}"
    );
    let strategy = format!("onnx:{}", out.display());
    assert!(text(&["simulate", "-q", "--strategy", &strategy]).contains("picked"));
}

#[test]
fn a_plan_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (plan, out) = (path("p.json"), path("p.onnx"));
    std::fs::write(&plan, "{}").unwrap();
    let output = pickline(&["train", "-q", "--plan", &plan, "--out", &out]);
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("--plan"), "{stderr}");
    assert_eq!(std::fs::read_to_string(&plan).unwrap(), "{}");
}

#[test]
fn typing_mistakes_get_a_suggestion() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("p.onnx");
    let broken = folder.path().join("broken.json");
    std::fs::write(&broken, "{\"plan\": 3}").unwrap();
    let broken = broken.to_str().unwrap();
    let unknown = folder.path().join("unknown.json");
    std::fs::write(&unknown, r#"{"ppo": {"gama": 1}}"#).unwrap();
    let unknown = unknown.to_str().unwrap();
    let seen = folder.path().join("seen.json");
    let plan = r#"{"domain": {"patterns": "grid:0.15", "items": [50, 50], "curriculum": 0}}"#;
    std::fs::write(&seen, plan).unwrap();
    let seen = seen.to_str().unwrap();
    for (flags, words) in [
        (
            &["--plan", unknown][..],
            &["unknown.json", "ppo.gama", "did you mean `gamma`"][..],
        ),
        (&["--plan", "nowhere.json"], &["nowhere.json"]),
        (
            &["--plan", seen],
            &["domain.patterns", "scored on all patterns"],
        ),
        (
            &["--out", "policy.json"],
            &["--out", "policy.json", ".onnx"],
        ),
        (&["--plan", unknown, "--resume", broken], &["--resume"]),
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
    // The three files that were given, and nothing half made.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
}
