//! Station files.

use super::{BELT, Files, LINE, Message, ROBOT, accepted, cases, refused};
use serde::Deserialize;
use std::path::Path;

/// `text` with the first line that starts with `key =` after `[table]` replaced by `with`.
fn replaced(text: &str, table: &str, key: &str, with: Option<&str>) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    let header = lines.iter().position(|line| *line == table).unwrap();
    let start = format!("{key} =");
    let offset = lines[header..].iter().position(|l| l.starts_with(&start));
    let at = header + offset.unwrap();
    match with {
        Some(line) => lines[at] = line,
        None => drop(lines.remove(at)),
    }
    lines.join("\n") + "\n"
}

fn station_refused(folder: &Path, text: impl AsRef<[u8]>, message: &Message) {
    std::fs::write(folder.join("s.toml"), text).unwrap();
    refused(folder, &["station", "check", "s.toml"], message);
}

#[derive(Deserialize)]
struct Values {
    key: Vec<Key>,
}

/// A key and what is wrong with its line.
#[derive(Deserialize)]
struct Key {
    table: String,
    key: String,
    cases: Vec<Line>,
}

#[derive(Deserialize)]
struct Line {
    line: Option<String>,
    #[serde(flatten)]
    message: Message,
}

#[test]
fn every_value_of_a_station_file() {
    let folder = tempfile::tempdir().unwrap();
    let listed = format!("{BELT}\n{ROBOT}");
    let line = format!("{BELT}\n{LINE}");
    let Values { key: keys } = cases("station_values.toml");
    for Key { table, key, cases } in &keys {
        let text = if table == "[line]" { &line } else { &listed };
        assert!(!cases.is_empty(), "{key}");
        for case in cases {
            let bad = replaced(text, table, key, case.line.as_deref());
            station_refused(folder.path(), bad, &case.message);
        }
    }
    // All that a station file can say.
    let text = format!("{BELT}{ROBOT}{LINE}");
    let written = text.lines().filter(|line| line.contains(" = ")).count();
    assert_eq!(keys.len(), written);
}

#[test]
fn inconsistent_stations() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let Files { case: cases } = cases("station_files.toml");
    assert!(cases.len() > 20);
    for case in cases {
        station_refused(path, case.file, &case.message);
    }
    let mend = "fix the line; strings need quotes, and numbers a digit before the decimal point";
    let deep = format!("a = {}", "[".repeat(50_000));
    let message = Message {
        says: None,
        begins: Some("s.toml:1: not valid TOML: ".to_owned()),
        cure: Some(mend.to_owned()),
    };
    station_refused(path, deep, &message);
    let message = Message::new(
        "s.toml:2: byte 0xff is not UTF-8 text",
        "save the file as UTF-8 (plain ASCII is UTF-8)",
    );
    station_refused(path, b"[belt]\nspeed = \xff\n", &message);
    let utf16: Vec<u8> = BELT.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let message = Message::new(
        "s.toml:1: byte 0xff is not UTF-8 text",
        "the file is UTF-16; save it as UTF-8 (in a spreadsheet: CSV UTF-8)",
    );
    station_refused(path, [&b"\xff\xfe"[..], &utf16].concat(), &message);
    // A million lines; the wrong one is the last.
    let long = format!("{BELT}{ROBOT}{}x = 1\n", "# remark\n".repeat(1_000_000));
    let message = Message::new(
        "s.toml:1000013: robot[0].x: unknown key",
        "known: name, base, bin, reach, speed, acceleration, deceleration, lift, travel, grasp_time, release_time, rest",
    );
    station_refused(path, long, &message);
    for (name, problem, cure) in [
        (
            "no-such.toml",
            "cannot read no-such.toml: No such file or directory (os error 2)",
            "the file does not exist; check the path",
        ),
        (
            "no-such/s.toml",
            "cannot read no-such/s.toml: No such file or directory (os error 2)",
            "the folder no-such does not exist; check the path",
        ),
        (
            ".",
            "cannot read .: Is a directory (os error 21)",
            "this is a folder; give the path of a file",
        ),
        (
            "papre",
            "--station: `papre` is neither a file nor a built-in station",
            "did you mean `paper`? known: paper, paper-narrow, delta, sorting",
        ),
    ] {
        let message = Message::new(problem, cure);
        refused(path, &["station", "check", name], &message);
    }
}

#[test]
fn unusual_but_good_stations_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let plain = format!("{BELT}{LINE}");
    let show = |text: &str| {
        std::fs::write(path.join("s.toml"), text).unwrap();
        accepted(path, &["station", "show", "--station", "s.toml"])
    };
    let expected = show(&plain);
    for text in [
        plain.replace('\n', "\r\n"),
        format!("\u{feff}{plain}"),
        format!("# head\n\n{}", plain.replace('\n', "   # remark\n\n")),
        plain.replace(" = ", "="),
        plain
            .replace("0.05", "5e-2")
            .replace("robots = 2", "robots = 0x2"),
        plain
            .replace("robots = 2", "robots = +2")
            .replace("0.0\n", "-0\n"),
        format!("{LINE}{BELT}"),
        plain.trim_end().to_owned(),
        plain
            .replace("[line]\n", "[ line ]\n")
            .replace("tail", "\"tail\""),
        format!("belt = {{ speed = 0.05, length = 4.2, width = 1.05 }}\n{LINE}"),
    ] {
        assert_eq!(show(&text).replace("-0.0,", "0.0,"), expected, "{text}");
    }
    let whole = plain
        .replace("4.2", "5")
        .replace("0.5\n", "1\n")
        .replace("0.1\n", "0\n");
    assert!(show(&whole).contains("length = 5.0"));
}
