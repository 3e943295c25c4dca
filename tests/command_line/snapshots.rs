//! Every help page, the main tables and some errors as they are printed, held to the files in
//! `tests/command_line/snapshots/`.
//!
//! Where a change is meant, look at what differs and accept it:
//!
//!     INSTA_UPDATE=always cargo test --test command_line snapshots::
//!
//! or one by one with `cargo insta review` (`cargo install cargo-insta`), and commit the files.
//! `.ci/run` sets `INSTA_UPDATE=no`: what is not accepted fails there, and nothing is written.
//!
//! Pages and tables are those of the default features; others have more or fewer verbs, flags
//! and strategies, and are not held to the files.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Output};

/// Lines are as long as at a terminal of that many columns.
const COLUMNS: &str = "100";

/// What it prints where no stream is a terminal, and what it says in the folder.
fn pickline(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .current_dir(folder)
        .env("COLUMNS", COLUMNS)
        .output()
        .unwrap()
}

fn printed(folder: &Path, arguments: &[&str]) -> String {
    let output = pickline(folder, arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {errors}");
    // A new version is no new page.
    let text = String::from_utf8(output.stdout).unwrap();
    text.replace(env!("CARGO_PKG_VERSION"), "VERSION")
}

/// Holds texts to the files of a folder, one each, and the folder to them.
fn hold(kind: &str, texts: &[(String, String)]) {
    let mut settings = insta::Settings::new();
    settings.set_snapshot_path(format!("snapshots/{kind}"));
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        for (name, text) in texts {
            insta::assert_snapshot!(name.as_str(), text);
        }
    });
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/command_line/snapshots");
    let files = std::fs::read_dir(folder.join(kind)).unwrap();
    let files = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    let expected = texts.iter().map(|(name, _)| format!("{name}.snap"));
    assert_eq!(
        files.collect::<BTreeSet<_>>(),
        expected.collect(),
        "files of what is no longer printed, or not accepted yet"
    );
}

/// The verbs and the verbs below them, as the program lists them; first itself.
fn verbs(folder: &Path) -> Vec<Vec<String>> {
    let mut all = vec![Vec::new()];
    let mut next = 0;
    while next < all.len() {
        let verb: Vec<String> = all[next].clone();
        next += 1;
        let call: Vec<&str> = verb.iter().map(String::as_str).chain(["-h"]).collect();
        let help = printed(folder, &call);
        let Some((_, list)) = help.split_once("\nCommands:\n") else {
            continue;
        };
        let list = list.split("\n\n").next().unwrap().lines();
        // What goes on from the line before is further in.
        let names = list.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
        let names: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
        assert!(names.contains(&"help"), "{names:?}");
        let below = names.iter().filter(|name| **name != "help");
        all.extend(below.map(|name| [&verb[..], &[(*name).to_owned()]].concat()));
    }
    all
}

#[test]
fn every_help_page_is_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let mut pages = Vec::new();
    for verb in verbs(folder.path()) {
        let verb: Vec<&str> = verb.iter().map(String::as_str).collect();
        let page = |call: &[&str]| printed(folder.path(), call);
        let long = page(&[&verb[..], &["--help"]].concat());
        assert_eq!(page(&[&["help"], &verb[..]].concat()), long, "{verb:?}");
        let name = [&["pickline"], &verb[..]].concat().join("-");
        pages.push((format!("{name}.long"), long));
        let short = page(&[&verb[..], &["-h"]].concat());
        pages.push((format!("{name}.short"), short));
    }
    assert!(pages.len() > 40, "{}", pages.len());
    hold("help", &pages);
}

/// Ten items, close together, with all that an item can have.
const PATTERN: &str = "id,x,y,area_cm2,p_grasp,class\n\
    a,0,0.1,80,0.9,PET\nb,-0.03,-0.2,,,PET\nc,-0.05,0.4,120,0.8,glass\nd,-0.08,0.3,,,\n\
    e,-0.09,-0.4,60,0.95,\nf,-0.12,0,,,can\ng,-0.15,-0.1,40,,PET\nh,-0.18,0.45,,,\n\
    i,-0.2,-0.45,200,0.7,\nj,-0.21,0.2,,,\n";
const CASES: &str = "[[case]]\nname = \"sparse\"\ngrid = 0.3\nitems = 8\n\
    [[case]]\nname = \"random\"\npoisson = 0.1\nitems = 20\n";

/// A folder with `p.csv` and `cases.toml`.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("p.csv"), PATTERN).unwrap();
    std::fs::write(folder.path().join("cases.toml"), CASES).unwrap();
    let simulate = [
        "simulate",
        "-q",
        "--pattern",
        "p.csv",
        "--belt-speed",
        "0.25",
    ];
    let picks = printed(
        folder.path(),
        &[&simulate[..], &["--format", "csv"]].concat(),
    );
    std::fs::write(folder.path().join("picks.csv"), picks).unwrap();
    folder
}

#[test]
fn every_table_is_as_it_was() {
    let folder = folder();
    let mut tables = Vec::new();
    for (verb, rest) in [
        ("optimize", "--patterns p.csv --belt-speed 0.25 --top 5"),
        (
            "compare",
            "--cases cases.toml --replicates 3 --no-policy --robust SPT,FIFO \
             --strategy LPT,FIFO",
        ),
        (
            "sweep",
            "--patterns p.csv --from 0.05 --to 0.25 --step 0.1 --strategy SPT,FIFO",
        ),
        ("game", "--patterns p.csv --belt-speed 0.25 --top 5"),
        ("bound", "--pattern p.csv --belt-speed 0.25"),
        ("simulate", "--pattern p.csv --belt-speed 0.25 --check"),
        ("pattern describe", "p.csv"),
        ("check", "picks.csv --pattern p.csv --belt-speed 0.25"),
    ] {
        for format in ["table", "csv", "json"] {
            let quiet = if verb == "pattern describe" { "" } else { "-q" };
            let call = format!("{verb} {quiet} {rest} --format {format}");
            let call: Vec<&str> = call.split_whitespace().collect();
            let name = format!("{}.{format}", verb.replace(' ', "-"));
            tables.push((name, printed(folder.path(), &call)));
        }
    }
    for (verb, rest) in [
        (
            "optimize",
            "-q --race 2 --robots 1 --belt-speed 0.2 --patterns poisson:0.2 --items 30",
        ),
        ("pattern generate", "poisson -q --count 5"),
        ("station show", ""),
        ("station check", "paper"),
        ("station init", ""),
        ("service show", ""),
    ] {
        let call = format!("{verb} {rest}");
        let call: Vec<&str> = call.split_whitespace().collect();
        let name = match verb {
            "optimize" => "optimize-race".to_owned(),
            verb => verb.replace(' ', "-"),
        };
        tables.push((name, printed(folder.path(), &call)));
    }
    hold("tables", &tables);
}

/// Without the rates of the policy, which depend on how the processor multiplies.
#[test]
fn what_a_training_prints_is_as_it_was() {
    let folder = folder();
    let call = ["train", "-q", "--steps", "512", "--out", "q.onnx"];
    let text = printed(folder.path(), &call);
    let without_rate = |line: &str| match line.rsplit_once(' ') {
        Some((rest, rate)) if rate.parse::<f64>().is_ok() => format!("{} RATE\n", rest.trim()),
        _ => format!("{line}\n"),
    };
    let text: String = text.lines().map(without_rate).collect();
    assert_eq!(text.matches(" RATE\n").count(), 8, "{text}");
    hold("training", &[("train".to_owned(), text)]);
}

#[test]
fn the_main_errors_are_as_they_were() {
    let folder = folder();
    let mut text = String::new();
    for call in [
        "optimise",
        "simulate --robot 3",
        "simulate --strategy SPT",
        "simulate --strategy rulse:SPT,FIFO",
        "simulate --pattern no-such.csv",
        "simulate --pattern cases.toml",
        "simulate --station papre",
        "simulate --station p.csv",
        "simulate --belt-speed 7",
        "optimize --patterns blanced:3",
        "optimize --search exhaustive --robots 30",
        "compare --cases p.csv",
        "sweep --from 1 --to 0",
        "pattern import mot p.csv --fps 10 --scale 0.001 --axis x --belt-speed 0.1",
        "run --listen 0.0.0.0:0",
        "run --replay no-such.mcap",
    ] {
        let arguments: Vec<&str> = call.split(' ').collect();
        let output = pickline(folder.path(), &arguments);
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{call}: {said}");
        assert!(output.stdout.is_empty(), "{call}");
        text += &format!("$ pickline {call}\n{said}\n");
    }
    hold("errors", &[("errors".to_owned(), text)]);
}
