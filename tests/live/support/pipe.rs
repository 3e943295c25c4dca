//! Pipes that are not read.

use std::fs::{File, OpenOptions};
use std::io::Write as _;
use std::os::unix::fs::OpenOptionsExt as _;
use std::process::Command;

/// Both ends of a pipe that is full; whoever writes to it waits until it is read.
pub fn full_pipe() -> (File, File) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pipe");
    let made = Command::new("mkfifo").arg(&path).status();
    assert!(made.unwrap().success());
    // With both ends open neither is waited for.
    let both = OpenOptions::new().read(true).write(true).open(&path);
    let both = both.unwrap();
    let reads = File::open(&path).unwrap();
    let writes = OpenOptions::new().write(true).open(&path).unwrap();
    let mut filler = OpenOptions::new()
        .write(true)
        .custom_flags(nix::libc::O_NONBLOCK)
        .open(&path)
        .unwrap();
    while filler.write(b"x").is_ok() {}
    drop(both);
    (reads, writes)
}
