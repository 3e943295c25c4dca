//! A stdout that cannot be written, or that nobody reads.

use crate::programs::wait_for;
use crate::support::pipe::full_pipe;
use std::io::Write as _;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// A node whose stdout takes nothing.
#[cfg(target_os = "linux")]
fn on_a_full_disk(arguments: &[&str]) -> Child {
    let full = std::fs::File::options().write(true).open("/dev/full");
    Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(full.unwrap())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// A stdout that takes nothing must not go unnoticed: no robot would hear of its tasks.
#[cfg(target_os = "linux")]
#[test]
fn a_stdout_that_cannot_be_written_ends_it() {
    let mut node = on_a_full_disk(&["run", "-q", "--status-every", "0.05"]);
    // It says a status by and by, though it hears nothing; stdin stays open.
    let stdin = node.stdin.take().unwrap();
    let output = node.wait_with_output().unwrap();
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("stdout") && told.contains("cure"), "{told}");
    drop(stdin);
}

/// A stdout that nobody can write to loses no task without a word.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_stdout_is_reported_with_message_time_too() {
    let mut node = on_a_full_disk(&["run", "--clock", "messages"]);
    let mut stdin = node.stdin.take().unwrap();
    stdin
        .write_all(b"{\"kind\":\"tick\",\"stamp\":1}\n")
        .unwrap();
    drop(stdin);
    let output = node.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{stderr}");
    assert!(stderr.contains("stdout"), "{stderr}");
}

/// Whoever reads nothing holds the line up, but not its end.
#[test]
fn a_stalled_reader_does_not_hold_up_the_end_with_message_time() {
    let (unread, stdout) = full_pipe();
    let mut node = Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(["run", "--clock", "messages"])
        .stdin(Stdio::piped())
        .stdout(stdout)
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = node.stdin.take().unwrap();
    let written = Arc::new(AtomicUsize::new(0));
    let count = Arc::clone(&written);
    let feed = thread::spawn(move || {
        for stamp in 0..100_000 {
            let line = format!("{{\"kind\":\"tick\",\"stamp\":{stamp}}}\n");
            if stdin.write_all(line.as_bytes()).is_err() {
                return;
            }
            count.fetch_add(line.len(), Ordering::Relaxed);
        }
    });
    // It reads: this is more than its stdin holds.
    wait_for("messages to be read", || {
        written.load(Ordering::Relaxed) > 70_000
    });
    let pid = node.id().to_string();
    assert!(
        Command::new("kill")
            .args(["-TERM", &pid])
            .status()
            .unwrap()
            .success()
    );
    let mut status = None;
    wait_for("the end", || {
        status = node.try_wait().unwrap();
        status.is_some()
    });
    // Until here its stdout was open and unread.
    drop(unread);
    feed.join().unwrap();
    assert_eq!(status.unwrap().code(), Some(0));
}
