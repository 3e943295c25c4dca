//! Bad input ends in exit code 2 and a message that names place, key, value and cure:
//! every field of both files and every flag wrong in turn. Good but unusual input is
//! read like any other.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const BELT: &str = "[belt]\nspeed = 0.05\nlength = 4.2\nwidth = 1.05\n";
const ROBOT: &str = "[[robot]]\nname = \"r1\"\nbase = [1.3, -0.625]\nbin = [1.3, -0.525]\n\
    reach = 0.8\nspeed = 0.5\ngrasp_time = 0.1\nrelease_time = 0.1\n";
const LINE: &str = "[line]\nrobots = 2\nfirst_base_x = 1.3\nspacing = 1.6\nbase_offset = 0.1\n\
    bin_offset = 0.0\ntail = 0.5\nreach = 0.8\nspeed = 0.5\ngrasp_time = 0.1\nrelease_time = 0.1\n";
const PATTERN: &str = "id,x,y,area_cm2,p_detection,p_grasp,weight,class\n\
    a,0,0.1,80,0.9,0.8,,PET\nb,-0.2,-0.1,,,,0.7,\nc,-0.4,0,,,,,glass\n";

fn pickline(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .current_dir(folder)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Everything below `folder`, so that a leftover shows.
fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path.clone());
            }
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Runs what must be refused: exit code 2, nothing on stdout, nothing written, a
/// message with a cure and all of `words`.
fn refused(folder: &Path, arguments: &[&str], words: &[&str]) {
    let before = listing(folder);
    let output = pickline(folder, arguments);
    let message = stderr(&output);
    let about = format!("{arguments:?}\n{message}");
    assert_eq!(output.status.code(), Some(2), "{about}");
    assert!(output.stdout.is_empty(), "{about}");
    assert!(!message.contains("panicked"), "{about}");
    // clap words its own errors: the flag, the value, and where to read on.
    let has_cure = message.contains("\n  cure: ") || message.contains("try '--help'");
    assert!(has_cure, "{about}");
    for word in words {
        assert!(message.contains(word), "no `{word}` from {about}");
    }
    assert_eq!(listing(folder), before, "{about}");
}

fn accepted(folder: &Path, arguments: &[&str]) -> String {
    let output = pickline(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    String::from_utf8(output.stdout).unwrap()
}

/// `text` with the first line that starts with `key =` after `[table]` replaced by
/// `with`, and the number of that line.
fn replaced(text: &str, table: &str, key: &str, with: Option<&str>) -> (String, usize) {
    let mut lines: Vec<&str> = text.lines().collect();
    let header = lines.iter().position(|line| *line == table).unwrap();
    let start = format!("{key} =");
    let offset = lines[header..].iter().position(|l| l.starts_with(&start));
    let at = header + offset.unwrap();
    match with {
        Some(line) => lines[at] = line,
        None => drop(lines.remove(at)),
    }
    (lines.join("\n") + "\n", at + 1)
}

fn station_refused(folder: &Path, text: impl AsRef<[u8]>, words: &[&str]) {
    std::fs::write(folder.join("s.toml"), text).unwrap();
    refused(folder, &["station", "check", "s.toml"], words);
}

fn pattern_refused(folder: &Path, text: impl AsRef<[u8]>, words: &[&str]) {
    std::fs::write(folder.join("p.csv"), text).unwrap();
    refused(folder, &["simulate", "-q", "--pattern", "p.csv"], words);
}

/// Written values that are wrong wherever a number is due, and how messages say them.
const NO_NUMBERS: [(&str, &str); 6] = [
    ("\"fast\"", "fast"),
    ("true", "true"),
    ("[1, 2, 3]", "[1, 2, 3]"),
    ("1979-05-27", "1979-05-27"),
    ("1e400", "1e400"),
    ("{ a = 1 }", "a table"),
];
const NOT_FINITE: [(&str, &str); 4] = [
    ("nan", "NaN"),
    ("inf", "inf"),
    ("-inf", "-inf"),
    ("1e300", "1e300"),
];
const NEGATIVE: (&str, &str) = ("-0.3", "-0.3");
const ZERO: (&str, &str) = ("0", "0");

#[test]
fn every_number_of_a_station_file() {
    let folder = tempfile::tempdir().unwrap();
    let listed = format!("{BELT}\n{ROBOT}");
    let line = format!("{BELT}\n{LINE}");
    // Whether 0 and negative numbers are forbidden too.
    for (text, table, name, key, zero, negative) in [
        (&listed, "[belt]", "belt", "speed", true, true),
        (&listed, "[belt]", "belt", "length", true, true),
        (&listed, "[belt]", "belt", "width", true, true),
        (&listed, "[[robot]]", "robot[0]", "reach", true, true),
        (&listed, "[[robot]]", "robot[0]", "speed", true, true),
        (&listed, "[[robot]]", "robot[0]", "grasp_time", false, true),
        (
            &listed,
            "[[robot]]",
            "robot[0]",
            "release_time",
            false,
            true,
        ),
        (&line, "[line]", "line", "first_base_x", false, false),
        (&line, "[line]", "line", "spacing", false, true),
        (&line, "[line]", "line", "base_offset", false, false),
        (&line, "[line]", "line", "bin_offset", false, false),
        (&line, "[line]", "line", "tail", false, true),
        (&line, "[line]", "line", "reach", true, true),
        (&line, "[line]", "line", "speed", true, true),
        (&line, "[line]", "line", "grasp_time", false, true),
        (&line, "[line]", "line", "release_time", false, true),
    ] {
        let mut wrong = [&NO_NUMBERS[..], &NOT_FINITE[..]].concat();
        wrong.extend(negative.then_some(NEGATIVE));
        wrong.extend(zero.then_some(ZERO));
        for (written, said) in wrong {
            let with = format!("{key} = {written}");
            let (bad, line) = replaced(text, table, key, Some(&with));
            let place = format!("s.toml:{line}: {name}.{key}: ");
            station_refused(folder.path(), bad, &[&place, said]);
        }
        let (bad, line) = replaced(text, table, key, Some(&format!("{key} = ")));
        let place = format!("s.toml:{line}: ");
        station_refused(folder.path(), bad, &[&place, "not valid TOML"]);
        let (bad, line) = replaced(text, table, key, Some(&format!("{key}x = 1")));
        let place = format!("s.toml:{line}: {name}.{key}x: ");
        let hint = format!("did you mean `{key}`");
        station_refused(folder.path(), bad, &[&place, "unknown key", &hint]);
        let twice = format!("{key} = 1\n{key} = 2");
        let (bad, line) = replaced(text, table, key, Some(&twice));
        let place = format!("s.toml:{}: ", line + 1);
        station_refused(folder.path(), bad, &[&place, "duplicate key"]);
        let (bad, _) = replaced(text, table, key, None);
        let header = 1 + text.lines().position(|line| line == table).unwrap();
        let place = format!("s.toml:{header}: {name}.{key}: ");
        station_refused(folder.path(), bad, &[&place, "missing"]);
    }
}

#[test]
fn names_positions_and_counts_of_a_station_file() {
    let folder = tempfile::tempdir().unwrap();
    let listed = format!("{BELT}\n{ROBOT}");
    for key in ["base", "bin"] {
        for (written, said) in [
            ("1.3", "1.3"),
            ("\"here\"", "here"),
            ("[1.3]", "[1.3]"),
            ("[]", "[]"),
            ("[1, 2, 3]", "[1, 2, 3]"),
            ("[1.3, \"left\"]", "left"),
            ("[1.3, 1e400]", "1e400"),
            ("[nan, 0.1]", "NaN"),
            ("[0.1, inf]", "inf"),
            ("[1, -2e6]", "-2000000"),
        ] {
            let with = format!("{key} = {written}");
            let (bad, line) = replaced(&listed, "[[robot]]", key, Some(&with));
            let place = format!("s.toml:{line}: robot[0].{key}: ");
            station_refused(folder.path(), bad, &[&place, said]);
        }
        let (bad, _) = replaced(&listed, "[[robot]]", key, None);
        let place = format!("s.toml:6: robot[0].{key}: ");
        station_refused(folder.path(), bad, &[&place, "missing"]);
    }
    for (written, said) in [
        ("7", "7 is not a text"),
        ("\" \"", "empty"),
        ("\"\"", "empty"),
    ] {
        let with = format!("name = {written}");
        let (bad, line) = replaced(&listed, "[[robot]]", "name", Some(&with));
        let place = format!("s.toml:{line}: robot[0].name: ");
        station_refused(folder.path(), bad, &[&place, said]);
    }
    let (bad, _) = replaced(&listed, "[[robot]]", "name", None);
    station_refused(
        folder.path(),
        bad,
        &["s.toml:6: robot[0].name: ", "missing"],
    );
    for (written, said) in [
        ("0", "0 robots"),
        ("-1", "-1"),
        ("2.0", "2.0"),
        ("\"two\"", "two"),
        ("101", "101 robots"),
        ("1000000000", "1000000000 robots"),
        ("99999999999999999999", "99999999999999999999"),
        ("nan", "nan"),
    ] {
        let with = format!("robots = {written}");
        let (bad, line) = replaced(&format!("{BELT}{LINE}"), "[line]", "robots", Some(&with));
        let place = format!("s.toml:{line}: line.robots: ");
        station_refused(folder.path(), bad, &[&place, said]);
    }
    let (bad, _) = replaced(&format!("{BELT}{LINE}"), "[line]", "robots", None);
    station_refused(folder.path(), bad, &["s.toml:5: line.robots: ", "missing"]);
}

#[test]
fn stations_that_do_not_hang_together() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let other = ROBOT.replace("r1", "r2");
    for (text, words) in [
        (
            format!("{BELT}{ROBOT}{ROBOT}"),
            &["s.toml:14: robot[1].name: ", "`r1`"][..],
        ),
        (
            format!("{BELT}{ROBOT}{}", other.replace("[1.3, -0.6", "[0.9, -0.6")),
            &["s.toml:15: robot[1].base: ", "0.9", "upstream"],
        ),
        (
            format!("{}{ROBOT}", BELT.replace("0.05", "0.5")),
            &["s.toml:10: robot[0].speed: ", "0.5 m/s, not faster"],
        ),
        (
            format!("{}{ROBOT}", BELT.replace("0.05", "0.6")),
            &["s.toml:10: robot[0].speed: ", "0.6"],
        ),
        (
            format!("{}{LINE}", BELT.replace("0.05", "0.6")),
            &["s.toml:13: line.speed: ", "0.6"],
        ),
        (
            format!("{BELT}{ROBOT}{LINE}"),
            &["s.toml:13: line: ", "both"],
        ),
        (BELT.to_owned(), &["s.toml: ", "no robots"]),
        (ROBOT.to_owned(), &["s.toml: ", "no [belt]"]),
        (
            format!("belt = 3\n{ROBOT}"),
            &["s.toml:1: belt: ", "3 is not a table"],
        ),
        (
            format!("robot = 3\n{BELT}"),
            &["s.toml:1: robot: ", "3 is not a list"],
        ),
        (
            format!("robot = [3]\n{BELT}"),
            &["s.toml:1: robot[0]: ", "3 is not a table"],
        ),
        (
            format!("robot = []\n{BELT}"),
            &["s.toml:1: robot: ", "0 robots"],
        ),
        (
            format!("line = 3\n{BELT}"),
            &["s.toml:1: line: ", "3 is not a table"],
        ),
        (
            format!("{BELT}{}", ROBOT.replace("[[robot]]", "[robot]")),
            &["s.toml:5: robot: ", "a table is not a list", "[[robot]]"],
        ),
        (
            format!("{BELT}{ROBOT}[blet]\n"),
            &["s.toml:13: blet: ", "unknown key", "`belt`"],
        ),
        (
            format!("{BELT}{ROBOT}[belt]\n"),
            &["s.toml:13: ", "not valid TOML"],
        ),
        (
            format!("{BELT}{ROBOT}="),
            &["s.toml:13: ", "not valid TOML"],
        ),
        (
            format!("a = {}", "[".repeat(50_000)),
            &["s.toml:1: ", "not valid TOML"],
        ),
        (String::new(), &["s.toml: ", "empty"]),
        (" \r\n\t\n".to_owned(), &["s.toml: ", "empty"]),
        ("\u{feff}".to_owned(), &["s.toml: ", "empty"]),
        ("# nothing\n".to_owned(), &["s.toml: ", "no [belt]"]),
        ("\0".to_owned(), &["s.toml:1: ", "not valid TOML"]),
        (PATTERN.to_owned(), &["s.toml:1: ", "not valid TOML"]),
    ] {
        station_refused(path, text, words);
    }
    // Line numbers hold under Windows' line ends and behind a byte order mark.
    let windows = format!("\u{feff}{BELT}{ROBOT}").replace('\n', "\r\n");
    let bad = windows.replace("reach = 0.8", "reach = 0");
    station_refused(path, bad, &["s.toml:9: robot[0].reach: ", "0"]);
    station_refused(
        path,
        b"[belt]\nspeed = \xff\n",
        &["s.toml:2: ", "0xff", "UTF-8"],
    );
    let utf16: Vec<u8> = BELT.encode_utf16().flat_map(u16::to_le_bytes).collect();
    station_refused(
        path,
        [&b"\xff\xfe"[..], &utf16].concat(),
        &["s.toml:1: ", "UTF-8"],
    );
    // A million lines; the wrong one is the last.
    let long = format!("{BELT}{ROBOT}{}x = 1\n", "# remark\n".repeat(1_000_000));
    station_refused(path, long, &["s.toml:1000013: robot[0].x: ", "unknown key"]);
    for name in ["no-such.toml", "no-such/s.toml", "."] {
        refused(path, &["station", "check", name], &[name, "cannot read"]);
    }
    refused(
        path,
        &["station", "check", "papre"],
        &["`papre`", "did you mean `paper`"],
    );
}

#[test]
fn every_column_of_a_pattern_file() {
    let folder = tempfile::tempdir().unwrap();
    let columns: Vec<&str> = PATTERN.lines().next().unwrap().split(',').collect();
    // The third line's item with one field changed.
    let with = |column: &str, value: &str| {
        let mut fields = ["b", "-0.2", "-0.1", "", "", "", "0.7", ""];
        fields[columns.iter().position(|c| *c == column).unwrap()] = value;
        PATTERN.replace("b,-0.2,-0.1,,,,0.7,", &fields.join(","))
    };
    for column in ["x", "y", "area_cm2", "p_detection", "p_grasp", "weight"] {
        let mut wrong = vec![
            ("text", "text"),
            ("1e400", "1e400"),
            ("0x10", "0x10"),
            ("1_000", "1_000"),
            ("0.1 m", "0.1 m"),
            ("nan", "NaN"),
            ("NAN", "NaN"),
            ("inf", "inf"),
            ("-inf", "-inf"),
            ("1e300", "1e300"),
        ];
        match column {
            "x" => wrong.extend([("", "empty"), ("0.01", "0.01"), ("1e-300", "1e-300")]),
            "y" => wrong.push(("", "empty")),
            "p_detection" | "p_grasp" => wrong.extend([("-0.1", "-0.1"), ("1.01", "1.01")]),
            _ => wrong.push(("-1e-9", "-1e-9")),
        }
        for (value, said) in wrong {
            let place = format!("p.csv:3: {column}");
            pattern_refused(folder.path(), with(column, value), &[&place, said]);
        }
    }
    pattern_refused(folder.path(), with("id", ""), &["p.csv:3: id", "empty"]);
    pattern_refused(folder.path(), with("id", "  "), &["p.csv:3: id", "empty"]);
    let twice = &["p.csv:3: id", "`a`", "p.csv:2"];
    pattern_refused(folder.path(), with("id", "a"), twice);
    pattern_refused(folder.path(), with("id", "\" a\""), twice);
    for column in ["id", "x", "y"] {
        let bad = PATTERN.replacen(&format!("{column},"), "", 1);
        let said = format!("`{column}` is missing");
        pattern_refused(folder.path(), bad, &["p.csv:1: ", &said]);
    }
    for (place, column) in columns.iter().enumerate() {
        let said = format!("p.csv:1: column {}: ", place + 1);
        let bad = PATTERN.replacen(column, &format!("{column}z"), 1);
        let value = format!("`{column}z`");
        pattern_refused(folder.path(), bad, &[&said, "unknown column", &value]);
        let mut header = columns.clone();
        header.push(column);
        let bad = PATTERN.replacen(&columns.join(","), &header.join(","), 1);
        pattern_refused(
            folder.path(),
            bad,
            &["p.csv:1: column 9: ", column, "twice"],
        );
    }
    // Beside the belt: it is the station that says so, the file is named all the same.
    let beside = &["p.csv: y of item `b`: ", "0.7 m", "0.525 m"];
    pattern_refused(folder.path(), with("y", "0.7"), beside);
}

#[test]
fn files_that_are_no_patterns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (text, words) in [
        ("", &["p.csv: ", "empty", "id,x,y"][..]),
        ("\u{feff}", &["p.csv: ", "empty"]),
        ("\r\n\n\r\n", &["p.csv: ", "empty"]),
        ("id,x,y\n", &["p.csv: ", "no item"]),
        ("a,0,0\n", &["p.csv:1: column 1", "`a`"]),
        (",,\n", &["p.csv: ", "empty"]),
        (
            "id,x,y\na,0,0\nb,-1\n",
            &["p.csv:3: ", "2 fields", "3", "`b,-1`"],
        ),
        ("id,x,y\na,0,0\nb,-1,0,0\n", &["p.csv:3: ", "4 fields", "3"]),
        ("id,x,y\na,0,0\nb,-1,0,1\n", &["p.csv:3: ", "4 fields"]),
        ("id,x,y\na,0,0\nremark\n", &["p.csv:3: ", "1 fields"]),
        (
            "id,x,y\n\"a,0,0\nb,-1,0\n",
            &["p.csv:2: ", "past the line's end"],
        ),
        (
            "id,x,y,class\na,0,0,\"PET\nb,-1,0,\n",
            &["p.csv:2: ", "past the line's end", "quote"],
        ),
        (
            "id,x,y\r\n\r\na,0,0\r\nb,zero,0\r\n",
            &["p.csv:4: x", "`zero`"],
        ),
        ("\u{feff}id,x,y\n\n\na,0,zero\n", &["p.csv:4: y", "`zero`"]),
        (BELT, &["p.csv:1: column 1", "`[belt]`"]),
    ] {
        pattern_refused(path, text, words);
    }
    pattern_refused(
        path,
        b"id,x,y\na,0,0\n\xe9,-1,0\n",
        &["p.csv:3: ", "0xe9", "UTF-8"],
    );
    pattern_refused(
        path,
        b"\xff\xfei\0d\0,\0x\0,\0y\0\n\0",
        &["p.csv:1: ", "UTF-16", "CSV UTF-8"],
    );
    for name in ["no-such.csv", "no-such/p.csv", "."] {
        for verb in [
            &["simulate", "-q", "--pattern"][..],
            &["pattern", "describe"],
        ] {
            refused(path, &[verb, &[name]].concat(), &[name, "cannot read"]);
        }
    }
    let mut child = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["simulate", "-q", "--pattern", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child
        .stdin
        .take()
        .unwrap()
        .write_all(b"id,x,y\n\xff")
        .unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("stdin:2: byte 0xff"),
        "{}",
        stderr(&output)
    );
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
        &["p.csv:1000001: id", "p.csv:1000000"],
    );
}

#[test]
fn unusual_but_good_files_are_read() {
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

/// Wrong values of the flags that several verbs share.
#[test]
fn common_flags() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("file"), "x").unwrap();
    std::fs::write(path.join("s.toml"), format!("{BELT}{ROBOT}")).unwrap();
    std::fs::write(path.join("l.toml"), format!("{BELT}{LINE}")).unwrap();
    let station: &[(&[&str], &[&str])] = &[
        (&["--robots", "0"], &["--robots", "0"]),
        (&["--robots", "-1"], &["--robots", "-1"]),
        (&["--robots", "2.5"], &["--robots", "2.5"]),
        (&["--robots", "two"], &["--robots", "two"]),
        (&["--robots", "1000000000"], &["--robots", "1000000000"]),
        (
            &["--robots", "0", "--station", "l.toml"],
            &["--robots", "0"],
        ),
        (
            &["--robots", "1000000000", "--station", "l.toml"],
            &["--robots", "1000000000"],
        ),
        (&["--robots", "99999999999999999999"], &["--robots"]),
        (
            &["--robots", "2", "--station", "s.toml"],
            &["--robots", "s.toml"],
        ),
        (&["--belt-speed", "nan"], &["--belt-speed", "NaN"]),
        (&["--belt-speed", "inf"], &["--belt-speed", "inf"]),
        (&["--belt-speed", "-0.1"], &["--belt-speed", "-0.1"]),
        (&["--belt-speed", "0"], &["--belt-speed", "0"]),
        (&["--belt-speed", "0.5"], &["--belt-speed", "0.5", "outrun"]),
        (
            &["--belt-speed", "7", "--station", "s.toml"],
            &["--belt-speed", "7", "outrun"],
        ),
        (
            &["--belt-speed", "7", "--station", "l.toml"],
            &["--belt-speed", "7", "outrun"],
        ),
        (&["--belt-speed", "0,1"], &["--belt-speed", "0,1"]),
        (
            &["--station", "papre"],
            &["--station", "`papre`", "`paper`"],
        ),
        (&["--station", ""], &["--station"]),
        (&["--station", "no-such.toml"], &["no-such.toml"]),
        (&["--station", "file"], &["file:1: "]),
    ];
    let common: &[(&[&str], &[&str])] = &[
        (&["--threads", "0"], &["--threads", "0"]),
        (&["--threads", "-1"], &["--threads", "-1"]),
        (&["--threads", "many"], &["--threads", "many"]),
        (&["--threads", "100000"], &["--threads", "100000"]),
        (&["--format", "jsn"], &["--format", "jsn", "'json'"]),
        (&["--out", "file"], &["cannot write file"]),
        (&["--out", "file/below"], &["cannot write file/below"]),
        (&["--update-hz", "-1"], &["--update-hz", "-1"]),
        (
            &["--update-hz", "nan", "--out", "new"],
            &["--update-hz", "NaN"],
        ),
        (
            &["--update-hz", "1e9", "--out", "new"],
            &["--update-hz", "1000000000"],
        ),
        (&["--update-hz", "fast"], &["--update-hz", "fast"]),
        (&["--nonsense"], &["--nonsense"]),
    ];
    let seed: &[(&[&str], &[&str])] = &[
        (&["--seed", "text"], &["--seed", "text"]),
        (&["--seed", "-1"], &["--seed", "-1"]),
        (&["--seed", "1.5"], &["--seed", "1.5"]),
        (&["--seed", "99999999999999999999"], &["--seed"]),
    ];
    let few = ["--patterns", "grid:0.3", "--items", "5", "--validate", "0"];
    for (verb, tables) in [
        (&["simulate"][..], &[station, common, seed][..]),
        (
            &[&["optimize"], &few[..]].concat(),
            &[station, common, seed],
        ),
        (&["pattern", "generate"], &[station, seed]),
        (&["pattern", "generate", "--width", "1"], &[station]),
        (&["pattern", "generate", "poisson"], &[station]),
        (&["station", "show"], &[station]),
        (&["station", "show", "--svg", "new.svg"], &[station]),
    ] {
        for (flags, words) in tables.iter().flat_map(|table| table.iter()) {
            refused(path, &[verb, flags].concat(), words);
        }
    }
}

#[test]
fn flags_of_each_verb() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let file = |name: &str, text: &str| std::fs::write(path.join(name), text).unwrap();
    file("file", "x");
    file("p.csv", PATTERN);
    file("wide.csv", "id,x,y\na,0,0\nb,-1,3\n");
    file("t.txt", "1,1,0,0,10,10,0.9\n2,1,10,0,10,10,0.9\n");
    std::fs::create_dir(path.join("empty")).unwrap();
    std::fs::create_dir(path.join("mixed")).unwrap();
    file("mixed/a.csv", PATTERN);
    file("mixed/b.csv", "id,x,y\na,0,0\nb,-1,3\n");
    let simulate: &[(&[&str], &[&str])] = &[
        (
            &["--strategy", "rulse:SPT,FIFO"],
            &["--strategy", "`rulse`", "`rules`"],
        ),
        (
            &["--strategy", "SPT,FIFOO"],
            &["strategy", "`FIFOO`", "`FIFO`"],
        ),
        (&["--strategy", "SPT"], &["strategy", "1 rule for 2 robots"]),
        (
            &["--budget-ms", "5"],
            &["--budget-ms", "no meaning for rules"],
        ),
        (
            &["--strategy", "lookahead:budget=9", "--budget-ms", "5"],
            &["lookahead:budget", "together with --budget-ms"],
        ),
        (
            &["--strategy", "SPT,FIFO", "--robots", "3"],
            &["strategy", "2 rules for 3 robots"],
        ),
        (&["--strategy", "rules:"], &["strategy", "no rule"]),
        (&["--strategy", ""], &["strategy", "no rule"]),
        (&["--strategy", "SPT,"], &["strategy", "``"]),
        (&["--pattern", "no-such.csv"], &["no-such.csv"]),
        (
            &["--pattern", "wide.csv", "--out", "new"],
            &["wide.csv: y of item `b`", "3 m"],
        ),
        (
            &["--trace", "no-folder/t.csv"],
            &["cannot write no-folder/t.csv"],
        ),
        (
            &["--trace", "no-folder/t.csv", "--out", "new"],
            &["no-folder/t.csv"],
        ),
        (
            &["--trace", "file/t.csv", "--out", "new"],
            &["cannot write file/t.csv"],
        ),
        (&["--trace", "empty"], &["cannot write empty"]),
        (
            &["--html", "no-folder/r.html", "--trace", "new"],
            &["cannot write no-folder/r.html"],
        ),
        (&["--html", "empty"], &["cannot write empty"]),
        (
            &["--trace", "t.csv", "--out", "file/new"],
            &["cannot write file/new"],
        ),
    ];
    let optimize: &[(&[&str], &[&str])] = &[
        (
            &["--objective", "picking-rat"],
            &["--objective", "`picking-rate`"],
        ),
        (&["--objective", ""], &["--objective"]),
        (&["--risk", "wrost"], &["--risk", "`wrost`", "`worst`"]),
        (
            &["--risk", "cvra:0.1"],
            &["--risk", "`cvra:0.1`", "`cvar:A`"],
        ),
        (&["--risk", "cvar:0"], &["--risk", "`0`"]),
        (&["--risk", "cvar:nan"], &["--risk", "`nan`"]),
        (&["--risk", "cvar:1.5"], &["--risk", "`1.5`"]),
        (&["--search", "garsp"], &["--search", "garsp", "'grasp'"]),
        (
            &["--search", "exhaustive", "--robots", "30"],
            &["--search", "30 robots"],
        ),
        (&["--alpha", "2"], &["--alpha", "2"]),
        (&["--alpha", "-0.1"], &["--alpha", "-0.1"]),
        (&["--alpha", "nan"], &["--alpha", "NaN"]),
        (&["--starts", "0"], &["--starts", "0"]),
        (&["--starts", "-3"], &["--starts", "-3"]),
        (&["--starts", "some"], &["--starts", "some"]),
        (&["--items", "0"], &["--items", "0"]),
        (&["--items", "-1"], &["--items", "-1"]),
        (&["--items", "1000000000000"], &["--items", "1000000000000"]),
        (
            &["--items", "18446744073709551615"],
            &["--items", "18446744073709551615"],
        ),
        (&["--validate", "text"], &["--validate", "text"]),
        (&["--validate", "-1"], &["--validate", "-1"]),
        (&["--top", "-1"], &["--top", "-1"]),
        (&["--top", "x"], &["--top", "x"]),
        (&["--speed-step", "0"], &["--speed-step", "0"]),
        (&["--speed-step", "-0.1"], &["--speed-step", "-0.1"]),
        (&["--speed-step", "nan"], &["--speed-step", "NaN"]),
        (&["--speed-step", "1e-12"], &["--speed-step", "1e-12"]),
        (&["--speed-step", "9"], &["--speed-step", "9"]),
        (&["--patterns", "no-such"], &["--patterns no-such"]),
        (
            &["--patterns", "no-such/p.csv"],
            &["--patterns no-such/p.csv"],
        ),
        (&["--patterns", ""], &["--patterns"]),
        (
            &["--patterns", "empty", "--out", "new"],
            &["--patterns empty", ".csv"],
        ),
        (
            &["--patterns", "mixed", "--out", "new"],
            &["b.csv: y of item `b`", "3 m"],
        ),
        (&["--patterns", "wide.csv"], &["wide.csv", "3 m"]),
        (&["--patterns", "file"], &["file:1: "]),
        (&["--patterns", "blanced:3"], &["--patterns", "`balanced`"]),
        (&["--patterns", "balanced:0"], &["--patterns", "`0`"]),
        (&["--patterns", "balanced:-1"], &["--patterns", "`-1`"]),
        (
            &["--patterns", "balanced:1000000"],
            &["--patterns balanced:1000000"],
        ),
        (
            &["--patterns", "balanced:9999999"],
            &["--patterns", "`9999999`"],
        ),
        (&["--patterns", "grid:0"], &["--patterns", "`0`"]),
        (&["--patterns", "grid:-0.1"], &["--patterns", "`-0.1`"]),
        (&["--patterns", "grid:nan"], &["--patterns", "`nan`"]),
        (&["--patterns", "grid:1e-9"], &["--patterns", "1e-9"]),
        (&["--patterns", "poisson:1e-9:2"], &["--patterns", "1e-9"]),
        (&["--patterns", "poisson:x"], &["--patterns", "`x`"]),
        (
            &["--patterns", "p.csv", "--items", "5"],
            &["--items", "recorded"],
        ),
        (
            &["--patterns", "p.csv", "--area", "const:1"],
            &["--area", "recorded"],
        ),
    ];
    let attributes: &[(&[&str], &[&str])] = &[
        (&["--area", "80"], &["--area 80", "no `:`"]),
        (&["--area", "const:-1"], &["--area const:-1", "-1"]),
        (&["--area", "const:1e400"], &["--area", "`1e400`"]),
        (
            &["--area", "unifrom:1,2"],
            &["--area unifrom:1,2", "`uniform`"],
        ),
        (
            &["--area", "uniform:2,1"],
            &["--area uniform:2,1", "2 is above 1"],
        ),
        (
            &["--area", "lognormal:80,1e9"],
            &["--area lognormal:80,1000000000"],
        ),
        (
            &["--p-grasp", "uniform:1.1,3"],
            &["--p-grasp uniform:1.1,3", "probability"],
        ),
        (&["--p-detection", "const:nan"], &["--p-detection", "`nan`"]),
        (&["--p-detection", "beta:0,1"], &["--p-detection beta:0,1"]),
        (
            &["--p-detection", "const:-0.5"],
            &["--p-detection const:-0.5", "-0.5"],
        ),
    ];
    let generate: &[(&[&str], &[&str])] = &[
        (&["gird"], &["gird", "'grid'"]),
        (&["--count", "0"], &["--count", "0"]),
        (&["--count", "-5"], &["--count", "-5"]),
        (&["--count", "1000000000000"], &["--count", "1000000000000"]),
        (
            &["--count", "100000", "--spacing", "1000"],
            &["--count", "m of belt"],
        ),
        (&["--spacing", "0"], &["--spacing", "0"]),
        (&["--spacing", "-1"], &["--spacing", "-1"]),
        (&["--spacing", "nan"], &["--spacing", "NaN"]),
        (&["--radius", "0.2"], &["--radius", "grid"]),
        (&["poisson", "--spacing", "0.2"], &["--spacing", "Poisson"]),
        (&["poisson", "--radius", "0"], &["--radius", "0"]),
        (&["poisson", "--radius", "1e-300"], &["--radius", "1e-300"]),
        (&["poisson", "--radius", "inf"], &["--radius", "inf"]),
        (&["poisson", "--count", "0"], &["--count", "0"]),
        (
            &["poisson", "--count", "99999999999"],
            &["--count", "99999999999"],
        ),
        (
            &["poisson", "--radius", "1e-4", "--width", "1000"],
            &["--radius", "0.0001"],
        ),
        (&["--width", "0"], &["--width", "0"]),
        (&["--width", "-2"], &["--width", "-2"]),
        (&["--width", "nan"], &["--width", "NaN"]),
        (&["--width", "1e300"], &["--width", "1e300"]),
        (
            &["--output", "no-folder/p.csv"],
            &["cannot write no-folder/p.csv"],
        ),
        (&["--output", "file/p.csv"], &["cannot write file/p.csv"]),
        (&["--output", "empty"], &["cannot write empty"]),
    ];
    let describe: &[(&[&str], &[&str])] = &[
        (&["--belt-speed", "0"], &["--belt-speed", "0"]),
        (&["--belt-speed", "-1"], &["--belt-speed", "-1"]),
        (&["--belt-speed", "nan"], &["--belt-speed", "NaN"]),
        (&["--format", "xml"], &["--format", "xml"]),
    ];
    let show: &[(&[&str], &[&str])] = &[
        (
            &["--svg", "no-folder/s.svg"],
            &["cannot write no-folder/s.svg"],
        ),
        (&["--svg", "file/s.svg"], &["cannot write file/s.svg"]),
        (&["--svg", "empty"], &["cannot write empty"]),
        (
            &["--svg", "s.svg", "--pattern", "no-such.csv"],
            &["no-such.csv"],
        ),
        (
            &["--svg", "s.svg", "--pattern", "wide.csv"],
            &["wide.csv: y of item `b`"],
        ),
        (&["--pattern", "p.csv"], &["--svg"]),
    ];
    let init: &[(&[&str], &[&str])] = &[
        (&["file"], &["file", "exists", "--force"]),
        (&["no-folder/s.toml"], &["cannot write no-folder/s.toml"]),
        (&["empty", "--force"], &["cannot write empty"]),
    ];
    for (verb, tables) in [
        (&["simulate", "-q"][..], &[simulate][..]),
        (&["optimize", "-q"], &[optimize, attributes]),
        (&["pattern", "generate"], &[generate, attributes]),
        (&["pattern", "describe", "p.csv"], &[describe]),
        (&["station", "show"], &[show]),
        (&["station", "init"], &[init]),
        (
            &["completions"],
            &[(&[(&["bsh"] as &[&str], &["bsh"] as &[&str])])],
        ),
        (
            &[],
            &[(&[(
                &["optimise"] as &[&str],
                &["optimise", "'optimize'"] as &[&str],
            )])],
        ),
    ] {
        for (flags, words) in tables.iter().flat_map(|table| table.iter()) {
            refused(path, &[verb, flags].concat(), words);
        }
    }
    let good = [
        ("--fps", "10"),
        ("--scale", "0.001"),
        ("--axis", "x"),
        ("--belt-speed", "0.1"),
        ("--centre-px", "5"),
        ("--min-frames", "2"),
        ("--split-distance", "0.1"),
        ("--merge-distance", "0.02"),
        ("--output", "new.csv"),
        ("--report", "new.json"),
    ];
    let import = |changed: &str, value: &str, words: &[&str]| {
        let mut arguments = vec!["pattern", "import", "mot", "t.txt"];
        for (flag, usual) in good {
            arguments.extend([flag, if flag == changed { value } else { usual }]);
        }
        refused(path, &arguments, words);
    };
    for (flag, _) in &good[..8] {
        for value in ["text", "nan", "-1", "0", "1e300"] {
            // Pixels may be anywhere, and an axis is no number.
            if *flag != "--centre-px" || !["-1", "0"].contains(&value) {
                import(flag, value, &[flag]);
            }
        }
    }
    for target in ["no-folder/p", "file/p", "empty"] {
        import("--output", target, &["cannot write", target]);
        import("--report", target, &["cannot write", target]);
    }
    import("--axis", "z", &["--axis", "z"]);
    for (flag, _) in &good[..4] {
        let rest = good[..4].iter().filter(|(other, _)| other != flag);
        let rest = rest.flat_map(|(flag, value)| [*flag, *value]);
        let arguments: Vec<&str> = ["pattern", "import", "mot", "t.txt"]
            .into_iter()
            .chain(rest)
            .collect();
        refused(path, &arguments, &[flag, "required"]);
    }
}

/// What the terminal or the shell may do to a call that is right.
#[cfg(target_os = "linux")]
#[test]
fn odd_surroundings_do_not_panic() {
    use std::os::unix::ffi::OsStrExt as _;
    let folder = tempfile::tempdir().unwrap();
    let not_unicode = std::ffi::OsStr::from_bytes(b"o\xff");
    let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["simulate", "--out"])
        .arg(not_unicode)
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(folder.path().join(not_unicode).join("run.json").exists());
    // Where a path must be text, the argument is named with a cure.
    for verb in [
        &["pattern", "describe"][..],
        &["simulate", "--pattern"],
        &["station", "check"],
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(verb)
            .arg(not_unicode)
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{verb:?}");
        for word in ["argument 3: ", "\"o\\xFF\"", "not UTF-8", "rename"] {
            assert!(
                stderr(&output).contains(word),
                "{word} not in {}",
                stderr(&output)
            );
        }
    }
    let full = || {
        std::fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap()
    };
    let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .arg("simulate")
        .stderr(full())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0));
    let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["simulate", "-q"])
        .stdout(full())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("stdout"), "{}", stderr(&output));
}
