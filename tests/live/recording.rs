//! `pickline run --record` and `--replay`: what was recorded gives the same again.

use crate::common::pickline;
use crate::programs::{feed, piped, wait_for};
use pickline::pattern::grid;
use pickline::station::{Station, built_in};
use pickline::strategies::read_alone;
use pickline_live::emulator::{Emulator, InjectedFaults};
use pickline_live::protocol::{Outgoing, decode_outgoing, encode};
use pickline_live::{ClockKind, Config, Controller};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command};

fn start(arguments: &[&str]) -> Child {
    piped(Command::new(env!("CARGO_BIN_EXE_pickline")).args(arguments))
}

/// What a run says of the lines of `input`.
fn run(arguments: &[&str], input: &[u8]) -> Vec<u8> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
    let (output, read) = feed(command.arg("run").args(arguments), input);
    read.unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{errors}");
    output.stdout
}

fn replay(arguments: &[&str]) -> (Vec<u8>, String) {
    let output = pickline(&[&["run", "--replay"], arguments].concat());
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{errors}");
    (output.stdout, errors)
}

/// What the station of a whole run has to say, some of it twice or too late.
fn stream() -> Vec<u8> {
    let station = built_in("paper").unwrap().station(Some(2)).unwrap();
    let pattern = grid(station.belt().width, 0.15, 60).unwrap();
    let trouble = InjectedFaults::default()
        .with_grasp_failures(0.1)
        .with_lost_acks(0.1)
        .with_duplicates(0.1)
        .with_jitter(0.05);
    let emulator = Emulator::new(station.clone(), pattern, trouble).unwrap();
    said_to_a_node(emulator, station, "SPT,FIFO").into_bytes()
}

/// What an emulated station says to a node that plans for `station` with `rules`.
pub fn said_to_a_node(mut emulator: Emulator, station: Station, rules: &str) -> String {
    let config = Config::default().with_clock(ClockKind::Messages);
    let robots = station.robots().len();
    let strategy = read_alone(rules, robots).unwrap().make();
    let mut controller = Controller::new(station, strategy, config).unwrap();
    let (mut stream, mut due) = (String::new(), None);
    loop {
        let round = emulator.round(due);
        if round.is_empty() {
            return stream;
        }
        for message in round {
            stream += &encode(&message);
            controller.handle(message).unwrap();
        }
        for message in controller.take_output() {
            match message {
                Outgoing::Due(message) => due = message.next,
                other => emulator.receive(other),
            }
        }
    }
}

/// The folder that tests/mcap/run.sh reads, with the recordings for it.
fn shared(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mcap");
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join(name);
    let _ = std::fs::remove_file(&file);
    file
}

/// Time for a while, by the machine's clock, with a peer on pipes.
struct Peer {
    node: Child,
    stdin: std::process::ChildStdin,
    stdout: BufReader<std::process::ChildStdout>,
    said: Vec<Outgoing>,
}

fn unix_now() -> f64 {
    let now = std::time::SystemTime::now();
    let since = now.duration_since(std::time::UNIX_EPOCH);
    since.unwrap().as_secs_f64()
}

impl Peer {
    fn start(arguments: &[&str]) -> Self {
        let mut node = start(&[&["run", "--status-every", "0.1"], arguments].concat());
        Self {
            stdin: node.stdin.take().unwrap(),
            stdout: BufReader::new(node.stdout.take().unwrap()),
            node,
            said: Vec::new(),
        }
    }

    fn say(&mut self, fields: &str) {
        let stamp = unix_now();
        writeln!(self.stdin, r#"{{"stamp":{stamp},{fields}}}"#).unwrap();
        self.stdin.flush().unwrap();
    }

    fn begin(&mut self) {
        self.say(r#""kind":"belt","speed":0.05,"position":1"#);
        self.say(r#""kind":"robot","name":"r1","state":"idle""#);
        self.say(r#""kind":"robot","name":"r2","state":"idle""#);
        for (id, x, y) in [("a", 0.9, -0.2), ("b", 1.0, -0.3), ("c", 2.6, 0.2)] {
            self.say(&format!(
                r#""kind":"detection","id":"{id}","x":{x},"y":{y}"#
            ));
        }
        self.say(r#""kind":"nonsense""#);
        self.say(r#""kind":"ack","task":99"#);
    }

    /// Hears messages until one is the last of these.
    fn hear(&mut self, is_last: impl Fn(&Outgoing) -> bool) {
        loop {
            let mut line = String::new();
            assert!(self.stdout.read_line(&mut line).unwrap() > 0);
            let message = decode_outgoing(line.trim().as_bytes()).unwrap();
            self.said.push(message.clone());
            if is_last(&message) {
                return;
            }
        }
    }

    fn task(&mut self) -> u64 {
        self.hear(|message| matches!(message, Outgoing::Task(_)));
        match self.said.last() {
            Some(Outgoing::Task(task)) => task.id,
            _ => unreachable!(),
        }
    }

    fn end(mut self) -> Vec<Outgoing> {
        drop(self.stdin);
        for line in self.stdout.lines() {
            self.said
                .push(decode_outgoing(line.unwrap().as_bytes()).unwrap());
        }
        assert!(self.node.wait().unwrap().success());
        self.said
    }

    fn kill(mut self) {
        self.node.kill().unwrap();
        self.node.wait().unwrap();
    }
}

/// Messages but for how long decisions took.
fn without_latency(said: Vec<Outgoing>) -> Vec<Outgoing> {
    let said = said.into_iter().map(|message| match message {
        Outgoing::Status(mut status) => {
            status.latency = None;
            Outgoing::Status(status)
        }
        other => other,
    });
    said.collect()
}

fn messages(lines: &[u8]) -> Vec<Outgoing> {
    let lines = lines.lines().map(|line| line.unwrap());
    let lines = lines.map(|line| decode_outgoing(line.as_bytes()).unwrap());
    without_latency(lines.collect())
}

#[test]
fn with_message_time_the_replay_is_the_run_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = shared("messages.mcap");
    let file = file.to_str().unwrap();
    let mut stream = stream();
    stream.extend_from_slice(b"{\"kind\":\"nonsense\"}\n");
    let line = ["--clock", "messages", "--tolerance", "0.03"];
    let said = run(&[&line[..], &["--record", file]].concat(), &stream);
    assert!(messages(&said).len() > 100);
    for arguments in [&[file][..], &[file, "--clock", "messages"]] {
        let (again, errors) = replay(arguments);
        assert!(again == said, "{errors}");
        assert!(
            errors.contains(&format!("all {} messages", messages(&said).len())),
            "{errors}"
        );
        assert!(errors.contains("--tolerance 0.03"), "{errors}");
    }
    // Another strategy decides otherwise, which is told.
    let (other, errors) = replay(&[file, "--strategy", "LPT,LPT"]);
    assert!(
        other != said && errors.contains("then they differ"),
        "{errors}"
    );
    // A file that is there is not replaced.
    let before = std::fs::read(file).unwrap();
    let output = pickline(&["run", "--record", file]);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2));
    assert!(
        errors.contains("already exists") && errors.contains("cure: "),
        "{errors}"
    );
    assert_eq!(std::fs::read(file).unwrap(), before);
    // Cut off or damaged anywhere, it is replayed as far as it goes, or refused.
    let bad = folder.path().join("bad.mcap");
    let try_out = |bytes: &[u8]| {
        std::fs::write(&bad, bytes).unwrap();
        let output = pickline(&["run", "--replay", bad.to_str().unwrap()]);
        let errors = String::from_utf8(output.stderr).unwrap();
        (output.status.code(), output.stdout, errors)
    };
    let (code, part, errors) = try_out(&before[..before.len() / 2]);
    assert_eq!(code, Some(0), "{errors}");
    assert!(
        said.starts_with(&part) && errors.contains("within a record"),
        "{errors}"
    );
    for (bytes, word) in [
        (&b""[..], "is not a recording"),
        (b"[belt]\nspeed = 0.1\n", "is not an MCAP file"),
        (&before[..300], "is not an MCAP file"),
    ] {
        let (code, _, errors) = try_out(bytes);
        assert_eq!(code, Some(2), "{errors}");
        assert!(
            errors.contains(word) && errors.contains("cure: "),
            "{errors}"
        );
    }
    let find = |text: &[u8]| {
        let found = before.windows(text.len()).position(|part| part == text);
        found.unwrap() + text.len()
    };
    let change = |at: usize, to: u8| {
        let mut bytes = before.clone();
        bytes[at] = to;
        bytes
    };
    let middle = change(before.len() / 2, before[before.len() / 2] ^ 1);
    let other = change(find(b"protocol\x01\0\0\0"), b'9');
    let none = change(find(b"\x08\0\0\0pickline") - 1, b'!');
    for (bytes, word) in [
        (middle, "is damaged"),
        (other, "with protocol 9"),
        (none, "not a recording of pickline"),
    ] {
        let (code, _, errors) = try_out(&bytes);
        assert_eq!(code, Some(2), "{errors}");
        assert!(
            errors.contains(word) && errors.contains("cure: "),
            "{errors}"
        );
    }
    let output = pickline(&["run", "--replay", "nowhere.mcap"]);
    assert_eq!(output.status.code(), Some(2));
    let output = pickline(&["run", "--replay", file, "--robots", "3"]);
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn with_the_system_clock_too_and_over_a_crash() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("journal");
    let journal = journal.to_str().unwrap();
    let (killed, whole) = (shared("killed.mcap"), shared("system.mcap"));
    let (killed, whole) = (killed.to_str().unwrap(), whole.to_str().unwrap());
    let mut peer = Peer::start(&["--journal", journal, "--fsync", "--record", killed]);
    peer.begin();
    let first = peer.task();
    peer.say(&format!(r#""kind":"ack","task":{first}"#));
    let second = peer.task();
    // What was recorded is in the file before long.
    let kind = br#""kind":"task""#;
    wait_for("a task in the file", || {
        let file = std::fs::read(killed).unwrap();
        file.windows(kind.len()).any(|part| part == kind)
    });
    let said = without_latency(peer.said.clone());
    peer.kill();
    let (again, errors) = replay(&[killed]);
    assert!(
        errors.contains("are as recorded; the recording"),
        "{errors}"
    );
    let again = messages(&again);
    let both = said.len().min(again.len());
    assert!(again[..both] == said[..both]);
    assert!(
        again
            .iter()
            .any(|message| matches!(message, Outgoing::Task(_)))
    );
    // The next run goes on, and its recording knows where it began.
    let mut peer = Peer::start(&["--journal", journal, "--record", whole]);
    peer.say(r#""kind":"belt","speed":0.05,"position":1.1"#);
    let mut open = std::collections::BTreeSet::new();
    while open.len() < 2 {
        open.insert(peer.task());
    }
    assert!(open.iter().eq(&[first, second]), "{open:?}");
    for task in &open {
        peer.say(&format!(r#""kind":"ack","task":{task}"#));
        peer.say(&format!(
            r#""kind":"result","task":{task},"result":"PICKED""#
        ));
    }
    peer.hear(|message| matches!(message, Outgoing::Status(s) if s.picked == 2));
    let said = without_latency(peer.end());
    let (again, errors) = replay(&[whole]);
    assert!(messages(&again) == said, "{errors}");
    assert!(
        errors.contains(&format!("all {} messages", said.len())),
        "{errors}"
    );
    // By the stamps alone much is the same; it ends like any replay.
    replay(&[whole, "--clock", "messages"]);
}

#[test]
fn files_that_are_compressed_as_a_whole_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.mcap");
    for (head, word) in [
        (&b"\x1f\x8b\x08\x00\x00"[..], "gzip"),
        (b"\x28\xb5\x2f\xfd\x00", "zstd"),
    ] {
        std::fs::write(&file, head).unwrap();
        let output = pickline(&["run", "--replay", file.to_str().unwrap()]);
        let errors = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2));
        assert!(
            errors.contains(word) && errors.contains("decompress"),
            "{errors}"
        );
    }
}

/// As other programs rewrite recordings: one run, its chunks of 600 bytes compressed.
#[test]
fn recordings_that_were_compressed_are_replayed() {
    let folder = tempfile::tempdir().unwrap();
    let bad = folder.path().join("bad.mcap");
    let mut outputs = Vec::new();
    for name in ["lz4.mcap", "zstd.mcap"] {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/recordings/");
        let file = format!("{file}{name}");
        let (said, errors) = replay(&[&file]);
        // As tests/mcap/compressed.py made them, with this version.
        assert!(errors.contains("messages are as recorded"), "{errors}");
        let lines = said.iter().filter(|byte| **byte == b'\n').count();
        assert!(errors.contains(&format!("all {lines} ")), "{errors}");
        assert!(lines >= 60, "{errors}");
        let whole = std::fs::read(&file).unwrap();
        for length in [whole.len() / 20, whole.len() / 5] {
            std::fs::write(&bad, &whole[..length]).unwrap();
            let output = pickline(&["run", "--replay", bad.to_str().unwrap()]);
            assert!([Some(0), Some(2)].contains(&output.status.code()));
            assert!(said.starts_with(&output.stdout));
        }
        outputs.push(said);
    }
    assert!(outputs[0] == outputs[1]);
}
