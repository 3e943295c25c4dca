//! What the terminal or the shell may do to a call that is right.

use super::stderr;
use std::process::Command;

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
        for word in ["argument 3: ", "\"o\\xFF\"", "not valid UTF-8", "rename"] {
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
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("stdout"), "{}", stderr(&output));
}

/// Help and version are results like any other; a usage error is one wherever it is printed.
#[test]
fn help_that_cannot_be_printed_is_a_failure() {
    let full = || std::fs::File::options().write(true).open("/dev/full");
    for arguments in [&["--version"][..], &["compare", "--help"], &["help", "run"]] {
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(arguments)
            .stdout(full().unwrap())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
        let told = stderr(&output);
        for words in [
            "pickline: cannot write stdout: ",
            "\n  cure: free some disk space",
        ] {
            assert!(told.contains(words), "{words} not in {told}");
        }
    }
    let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .arg("--no-such-flag")
        .stderr(full().unwrap())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(2));
    // A reader that has seen enough is not a failure.
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let status = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["compare", "--help"])
        .stdout(writer)
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(0));
}

/// The threads need 2 GB of addresses for their stacks; the program itself, much less than allowed.
#[cfg(target_os = "linux")]
#[test]
fn threads_that_cannot_be_started_are_not_wrong_usage() {
    let program = env!("CARGO_BIN_EXE_pickline");
    let call = format!("ulimit -v 1000000 && exec {program} optimize -q --threads 1024");
    let output = Command::new("sh").args(["-c", &call]).output().unwrap();
    let told = stderr(&output);
    assert_eq!(output.status.code(), Some(1), "{told}");
    for words in [
        "pickline: worker threads: ",
        "fewer threads, such as --threads 1",
    ] {
        assert!(told.contains(words), "{words} not in {told}");
    }
}

#[cfg(feature = "mcap")]
#[test]
fn a_recording_is_a_regular_file_that_does_not_exist_yet() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("old.mcap"), "x").unwrap();
    for (file, problem) in [
        ("/dev/full", "--record /dev/full: is not a regular file"),
        ("old.mcap", "--record old.mcap: the file already exists"),
    ] {
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(["run", "--record", file])
            .stdin(std::process::Stdio::null())
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(stderr(&output).contains(problem), "{}", stderr(&output));
    }
}
