//! `pickline run --journal`: one process at a time, and files that are none of its own.

use crate::common::pickline;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};

fn refused(arguments: &[&str], word: &str) {
    let output = pickline(&[&["run", "--clock", "messages"], arguments].concat());
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {errors}");
    assert!(
        errors.contains(word) && errors.contains("cure: "),
        "{errors}"
    );
    assert!(output.stdout.is_empty());
}

#[test]
fn one_process_at_a_time() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("line.journal");
    let journal = journal.to_str().unwrap();
    let arguments = ["run", "--clock", "messages", "--journal", journal];
    let mut node = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut stdin = node.stdin.take().unwrap();
    writeln!(
        stdin,
        r#"{{"kind":"detection","stamp":1,"id":"a","x":0,"y":0}}"#
    )
    .unwrap();
    writeln!(stdin, r#"{{"kind":"tick","stamp":1}}"#).unwrap();
    let mut stdout = BufReader::new(node.stdout.take().unwrap());
    stdout.read_line(&mut String::new()).unwrap();
    let before = std::fs::read(journal).unwrap();
    refused(
        &["--journal", journal],
        "another process is using this journal",
    );
    // However the file is called.
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(journal, &link).unwrap();
    refused(&["--journal", link.to_str().unwrap()], "another process");
    assert_eq!(std::fs::read(journal).unwrap(), before);
    node.kill().unwrap();
    node.wait().unwrap();
    // With the process its lock is gone. What is torn is told of, and what it was is kept.
    let torn = [&before[..], &before[before.len() - 30..before.len() - 1]].concat();
    std::fs::write(journal, torn).unwrap();
    let output = pickline(&arguments);
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(
        errors.contains("1 items, 0 open tasks; its last record (29 bytes)"),
        "{errors}"
    );
    assert!(errors.contains("of 1 items picked"), "{errors}");
    // What belongs to another line, another clock, or nobody, stays as it is.
    let before = std::fs::read(journal).unwrap();
    refused(
        &["--journal", journal, "--robots", "3"],
        "the journal has station",
    );
    let output = pickline(&["run", "--journal", journal]);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(errors.contains("give --clock messages"), "{errors}");
    assert_eq!(std::fs::read(journal).unwrap(), before);
    // A byte that changed under it.
    let mut changed = before.clone();
    let middle = changed.len() / 2;
    changed[middle] ^= 1;
    std::fs::write(journal, &changed).unwrap();
    refused(&["--journal", journal], "is damaged");
    assert_eq!(std::fs::read(journal).unwrap(), changed);
}

#[test]
fn files_that_are_not_a_journal_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    std::fs::write(path("station.toml"), "[belt]\nspeed = 0.1\n").unwrap();
    refused(
        &["--journal", &path("station.toml")],
        "not the beginning of a journal",
    );
    refused(&["--journal", &path("no-folder/j")], "cannot write");
    refused(&["--journal", &path("station.toml/j")], "cannot write");
    refused(
        &["--journal", folder.path().to_str().unwrap()],
        "cannot write",
    );
    refused(&["--journal", "/dev/null"], "is not a regular file");
    // A folder that nobody may write to, not even the superuser.
    if Path::new("/proc/self").exists() {
        refused(&["--journal", "/proc/self/j"], "cannot write");
    }
    assert_eq!(
        std::fs::read(path("station.toml")).unwrap(),
        b"[belt]\nspeed = 0.1\n"
    );
}

/// A journal that cannot be written ends the run before anything is said that is not in it.
#[test]
fn a_full_disk_ends_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("j");
    // Blocks of 512 bytes that the shell allows a file to have.
    let script = "ulimit -f 8; trap '' XFSZ; exec \"$0\" run --clock messages --journal \"$1\"";
    let mut node = Command::new("sh")
        .args(["-c", script, env!("CARGO_BIN_EXE_pickline")])
        .arg(&journal)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = node.stdin.take().unwrap();
    writeln!(
        stdin,
        r#"{{"kind":"robot","stamp":1,"name":"r1","state":"idle"}}"#
    )
    .unwrap();
    for i in 0..30 {
        let x = f64::from(i) * 0.01;
        // It may have ended by then.
        let _ = writeln!(
            stdin,
            r#"{{"kind":"detection","stamp":1,"id":"{i}","x":{x},"y":0}}"#
        );
        let _ = writeln!(stdin, r#"{{"kind":"tick","stamp":1}}"#);
    }
    drop(stdin);
    let output = node.wait_with_output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{errors}");
    assert!(
        errors.contains("cannot write") && errors.contains("cure: "),
        "{errors}"
    );
    let answers = output.stdout.lines().count();
    let output = pickline(&[
        "run",
        "--clock",
        "messages",
        "--journal",
        journal.to_str().unwrap(),
    ]);
    let errors = String::from_utf8(output.stderr).unwrap();
    let items = errors
        .split("j: ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next());
    let items: usize = items.and_then(|number| number.parse().ok()).expect(&errors);
    assert!(items >= answers && answers > 0, "{items} {answers}");
}
