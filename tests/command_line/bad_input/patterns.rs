//! Pattern files.

use super::{Files, Message, PATTERN, accepted, cases, refused, stderr};
use crate::programs::feed;
use serde::Deserialize;
use std::path::Path;
use std::process::Command;

fn pattern_refused(folder: &Path, text: impl AsRef<[u8]>, message: &Message) {
    std::fs::write(folder.join("p.csv"), text).unwrap();
    refused(folder, &["simulate", "-q", "--pattern", "p.csv"], message);
}

#[derive(Deserialize)]
struct Values {
    cases: Vec<Line>,
}

/// A line of the pattern that is written another way.
#[derive(Deserialize)]
struct Line {
    line: usize,
    with: String,
    #[serde(flatten)]
    message: Message,
}

#[test]
fn every_column_of_a_pattern_file() {
    let folder = tempfile::tempdir().unwrap();
    let Values { cases } = cases("pattern_values.toml");
    assert!(cases.len() > 90);
    for case in cases {
        let mut lines: Vec<&str> = PATTERN.lines().collect();
        lines[case.line - 1] = &case.with;
        let text = lines.join("\n") + "\n";
        pattern_refused(folder.path(), text, &case.message);
    }
}

#[test]
fn files_that_are_not_patterns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let Files { case: cases } = cases("pattern_files.toml");
    assert!(cases.len() > 10);
    for case in cases {
        pattern_refused(path, case.file, &case.message);
    }
    let message = Message::new(
        "p.csv:3: byte 0xe9 is not UTF-8 text",
        "save the file as UTF-8 (plain ASCII is UTF-8)",
    );
    pattern_refused(path, b"id,x,y\na,0,0\n\xe9,-1,0\n", &message);
    let message = Message::new(
        "p.csv:1: byte 0xff is not UTF-8 text",
        "the file is UTF-16; save it as UTF-8 (in a spreadsheet: CSV UTF-8)",
    );
    pattern_refused(path, b"\xff\xfei\0d\0,\0x\0,\0y\0\n\0", &message);
    for (name, problem, cure) in [
        (
            "no-such.csv",
            "No such file or directory (os error 2)",
            "the file does not exist; check the path",
        ),
        (
            "no-such/p.csv",
            "No such file or directory (os error 2)",
            "the folder no-such does not exist; check the path",
        ),
        (
            ".",
            "Is a directory (os error 21)",
            "this is a folder; give the path of a file",
        ),
    ] {
        let message = Message::new(&format!("cannot read {name}: {problem}"), cure);
        for verb in [
            &["simulate", "-q", "--pattern"][..],
            &["pattern", "describe"],
        ] {
            refused(path, &[verb, &[name]].concat(), &message);
        }
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
    command.args(["simulate", "-q", "--pattern", "-"]);
    let (output, read) = feed(&mut command, b"id,x,y\n\xff");
    read.unwrap();
    assert_eq!(output.status.code(), Some(2));
    let message = Message::new(
        "stdin:2: byte 0xff is not UTF-8 text",
        "save the file as UTF-8 (plain ASCII is UTF-8)",
    );
    message.check(&stderr(&output), &stderr(&output));
}

#[test]
fn a_million_lines() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let write = |item: &dyn Fn(usize) -> String| {
        let lines: String = (0..1_000_000).map(item).collect();
        std::fs::write(path.join("p.csv"), format!("id,x,y\n{lines}")).unwrap();
    };
    write(&|i| format!("{i},-{}e-2,{}\n", i, (i % 100) as f64 * 0.01 - 0.5));
    let text = accepted(
        path,
        &["simulate", "--pattern", "p.csv", "--format", "csv", "-q"],
    );
    assert!(text.lines().count() > 10_000, "{}", text.lines().count());
    // All in one column, where every item is next to every other along the belt.
    write(&|i| format!("{i},0,{}\n", (i * 7919 % 1_000_000) as f64 * 1e-6 - 0.5));
    let text = accepted(path, &["pattern", "describe", "p.csv"]);
    assert!(text.contains("1000000"), "{text}");
    write(&|i| format!("{},0,0\n", i.min(999_998)));
    refused(
        path,
        &["pattern", "describe", "p.csv"],
        &Message::new(
            "p.csv:1000001: id: `999998` is already the id of p.csv:1000000",
            "give every item a unique id",
        ),
    );
}

#[test]
fn unusual_but_good_patterns_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // Whole numbers and quoted fields as any other, and the figures the same.
    let plain = "id,x,y,weight,class\na,0,0.1,1,PET\nb,-1,0,0.5,\n";
    let run = |text: &str| {
        std::fs::write(path.join("p.csv"), text).unwrap();
        accepted(
            path,
            &["simulate", "-q", "--pattern", "p.csv", "--format", "csv"],
        )
    };
    let expected = run(plain);
    for text in [
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        format!("\u{feff}{plain}"),
        plain.replace('\n', "\n\n\n"),
        plain.replace('\n', "\r\n\r\n"),
        plain.replace(',', " , "),
        plain.trim_end().to_owned(),
        "x,class,id,weight,y\n0,PET,a,1,0.1\n-1,,b,0.5,0\n".to_owned(),
        "\"id\",\"x\",\"y\",\"weight\",\"class\"\n\"a\",\"-0\",\"0.1\",\"1\",\"PET\"\n\
         \"b\",\"-1.0\",\"0\",\"5e-1\",\"\"\n"
            .to_owned(),
        "id,x,y,weight,class,area_cm2\nb,-1,0,.5,,\na,0.,+0.1,1,\"PET\",\n".to_owned(),
    ] {
        assert_eq!(run(&text), expected, "{text}");
    }
}
