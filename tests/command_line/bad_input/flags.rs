//! Wrong values of flags.

use super::{BELT, LINE, Message, PATTERN, ROBOT, cases, refused};
use serde::Deserialize;
use std::path::Path;

#[derive(Deserialize)]
struct Tables {
    table: Vec<Table>,
}

/// Flags that are tried with each of some calls.
#[derive(Deserialize)]
struct Table {
    calls: Vec<Vec<String>>,
    cases: Vec<Flags>,
}

#[derive(Deserialize)]
struct Flags {
    flags: Vec<String>,
    #[serde(flatten)]
    message: Message,
}

/// Tries all of a file; returns how many calls that were.
fn try_all(folder: &Path, name: &str) -> usize {
    let Tables { table: tables } = cases(name);
    let mut count = 0;
    for table in &tables {
        for call in &table.calls {
            for case in &table.cases {
                refused(folder, &[&call[..], &case.flags].concat(), &case.message);
                count += 1;
            }
        }
    }
    count
}

/// Flags that several verbs share.
#[test]
fn common_flags() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::write(path.join("file"), "x").unwrap();
    std::fs::write(path.join("s.toml"), format!("{BELT}{ROBOT}")).unwrap();
    std::fs::write(path.join("l.toml"), format!("{BELT}{LINE}")).unwrap();
    assert!(try_all(path, "common_flags.toml") >= 183);
}

#[test]
fn flags_of_each_verb() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let file = |name: &str, text: &str| std::fs::write(path.join(name), text).unwrap();
    file("file", "x");
    file("p.csv", PATTERN);
    file("wide.csv", "id,x,y\na,0,0\nb,-1,3\n");
    file(
        "doubtful.csv",
        "id,x,y,p_detection\na,0,0,0.5\nb,-1,0,0.7\n",
    );
    std::fs::create_dir(path.join("empty")).unwrap();
    std::fs::create_dir(path.join("mixed")).unwrap();
    file("mixed/a.csv", PATTERN);
    file("mixed/b.csv", "id,x,y\na,0,0\nb,-1,3\n");
    assert!(try_all(path, "verb_flags.toml") >= 131);
}

#[derive(Deserialize)]
struct Imports {
    usual: Vec<[String; 2]>,
    cases: Vec<Import>,
}

#[derive(Deserialize)]
struct Import {
    flag: String,
    value: Option<String>,
    #[serde(flatten)]
    message: Message,
}

#[test]
fn flags_of_imports() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let film = "1,1,0,0,10,10,0.9,1,1\n2,1,10,0,10,10,0.9,1,1\n";
    std::fs::write(path.join("t.txt"), film).unwrap();
    std::fs::write(path.join("file"), "x").unwrap();
    std::fs::create_dir(path.join("empty")).unwrap();
    let Imports { usual, cases } = cases("import_flags.toml");
    assert!(cases.len() >= 54);
    for case in cases {
        let mut arguments = vec!["pattern", "import", "mot", "t.txt"];
        for [flag, value] in &usual {
            if *flag != case.flag {
                arguments.extend([flag, value].map(String::as_str));
            } else if let Some(value) = &case.value {
                arguments.extend([flag, value].map(String::as_str));
            }
        }
        refused(path, &arguments, &case.message);
    }
}
