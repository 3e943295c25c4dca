//! `pickline run` and `pickline emulate` as programs that talk to each other.
#![cfg(unix)]

use pickline::live::protocol::{Outgoing, Status, decode_outgoing};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Output, Stdio};
use std::thread::{self, JoinHandle};

fn start(arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Hands on what one program says to the other, and keeps it.
fn connect(from: ChildStdout, mut to: ChildStdin) -> JoinHandle<Vec<u8>> {
    thread::spawn(move || {
        let mut from = BufReader::new(from);
        let mut kept = Vec::new();
        loop {
            let part = from.fill_buf().unwrap();
            if part.is_empty() {
                return kept;
            }
            // One that has ended hears no more.
            let _ = to.write_all(part).and_then(|()| to.flush());
            kept.extend_from_slice(part);
            let used = part.len();
            from.consume(used);
        }
    })
}

fn finish(mut child: Child) -> (Option<i32>, String) {
    let mut errors = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut errors)
        .unwrap();
    (child.wait().unwrap().code(), errors)
}

fn messages(lines: &[u8]) -> Vec<Outgoing> {
    let lines = lines
        .split(|byte| *byte == b'\n')
        .filter(|line| !line.is_empty());
    lines.map(|line| decode_outgoing(line).unwrap()).collect()
}

fn last_status(messages: &[Outgoing]) -> Status {
    match messages.last() {
        Some(Outgoing::Status(status)) if status.last => (**status).clone(),
        other => panic!("{other:?}"),
    }
}

/// Feeds `input` to `pickline run` and returns what it makes of it.
fn run_on(arguments: &[&str], input: &[u8]) -> Output {
    let mut child = start(&[&["run"], arguments].concat());
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_vec();
    let feeder = thread::spawn(move || stdin.write_all(&input));
    let output = child.wait_with_output().unwrap();
    feeder.join().unwrap().unwrap();
    output
}

#[test]
fn through_pipes_the_picks_are_those_of_the_simulator() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("p.csv");
    let file = file.to_str().unwrap();
    for robots in ["2", "6"] {
        let made = [
            "pattern", "generate", "poisson", "--radius", "0.12", "--count", "1000",
        ];
        let made = start(&[&made[..], &["--robots", robots, "--output", file]].concat());
        assert_eq!(finish(made).0, Some(0));
        let line = ["--clock", "messages", "--robots", robots];
        let mut node = start(&[&["run"], &line[..]].concat());
        let mut station = start(&[&["emulate", "--pattern", file], &line[..]].concat());
        let down = connect(station.stdout.take().unwrap(), node.stdin.take().unwrap());
        let up = connect(node.stdout.take().unwrap(), station.stdin.take().unwrap());
        let stream = down.join().unwrap();
        let said = up.join().unwrap();
        let (code, errors) = finish(station);
        assert_eq!(code, Some(0), "{errors}");
        let (code, errors) = finish(node);
        assert_eq!(code, Some(0), "{errors}");
        let simulate = ["simulate", "-q", "--format", "json", "--pattern", file];
        let simulated = start(&[&simulate[..], &["--robots", robots]].concat());
        let simulated = simulated.wait_with_output().unwrap().stdout;
        let simulated: serde_json::Value = serde_json::from_slice(&simulated).unwrap();
        let said = messages(&said);
        let tasks = said.iter().filter_map(|message| match message {
            Outgoing::Task(task) => Some(task),
            _ => None,
        });
        let tasks: Vec<_> = tasks.collect();
        let picks = simulated["picks"].as_array().unwrap();
        assert_eq!(tasks.len(), picks.len());
        for (task, pick) in tasks.iter().zip(picks) {
            assert_eq!(pick["item"], task.item);
            assert_eq!(pick["decide_s"], task.decided_at);
            assert_eq!(pick["release_s"], task.free_at);
        }
        let status = last_status(&said);
        assert_eq!((status.seen, status.picked), (1000, picks.len() as u64));
        assert_eq!(status.seen, status.picked + status.missed.total());
        // The stream alone gives the same again, to the bit.
        let again = run_on(&line, &stream);
        assert!(messages(&again.stdout) == said);
    }
}

#[test]
fn over_tcp_with_everything_going_wrong() {
    let mut node = start(&["run", "--clock", "messages", "--listen", "127.0.0.1:0"]);
    let mut remarks = BufReader::new(node.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("listening at ") {
        line.clear();
        assert!(remarks.read_line(&mut line).unwrap() > 0);
    }
    let address = line.trim().rsplit(' ').next().unwrap();
    let trouble = "--failing-grasps 0.1 --lost-acks 0.02 --duplicates 0.1 --out-of-order 0.05 \
        --jitter-ms 50 --robot-down 1,20,30 --belt-stop 60,20";
    let place = ["emulate", "--clock", "messages", "--connect", address];
    let arguments: Vec<&str> = place
        .into_iter()
        .chain(trouble.split_whitespace())
        .collect();
    let (code, errors) = finish(start(&arguments));
    assert_eq!(code, Some(0), "{errors}");
    assert!(errors.contains("of 50 picked"), "{errors}");
    assert_eq!(node.wait().unwrap().code(), Some(0));
    let mut rest = String::new();
    remarks.read_to_string(&mut rest).unwrap();
    assert!(
        rest.contains("of 50 items picked") && rest.contains("0 on the belt, 0 claimed"),
        "{rest}"
    );
}

#[test]
fn bad_lines_are_refused_and_the_stream_goes_on() {
    let mut input = Vec::new();
    let mut say = |line: &[u8]| {
        input.extend_from_slice(line);
        input.push(b'\n');
    };
    say(br#"{"kind":"robot","stamp":100000,"name":"r1","state":"idle"}"#);
    say(br#"{"kind":"robot","stamp":100000,"name":"r9","state":"idle"}"#);
    say(br#"{"kind":"detection","stamp":100000,"id":"a","x":0.5,"y":-0.2}"#);
    for bad in [
        &br#"{"kind":"detection","stamp":1"#[..],
        br#"{"kind":"detection","stamp":100000,"x":NaN,"y":0}"#,
        br#"{"kind":"detection","stamp":100000,"x":"0","y":0}"#,
        br#"{"kind":"nonsense","stamp":100000}"#,
        br#"{"kind":"detection","stamp":0.5,"x":0,"y":0}"#,
        br#"{"kind":"ack","stamp":100000,"task":77}"#,
        br#"{"kind":"detection","stamp":100000,"x":0,"y":9}"#,
        br#"{"kind":"detection","stamp":100000,"x":99,"y":0}"#,
        b"\xff\x00\x1b[31m",
        &vec![b'x'; 10_000_000],
        format!(
            r#"{{"kind":"detection","stamp":1,"id":"{}","x":0,"y":0}}"#,
            "i".repeat(60_000)
        )
        .as_bytes(),
    ] {
        say(bad);
    }
    say(br#"{"kind":"tick","stamp":100001}"#);
    let output = run_on(&["--clock", "messages"], &input);
    assert_eq!(output.status.code(), Some(0));
    let said = messages(&output.stdout);
    assert!(matches!(&said[0], Outgoing::Task(task) if task.item == "a" && task.robot == "r1"));
    let status = last_status(&said);
    let refused = [
        ("field", 1),
        ("kind", 1),
        ("off_belt", 2),
        ("stamp", 1),
        ("syntax", 3),
        ("too_long", 1),
        ("unknown_robot", 1),
        ("unknown_task", 1),
        ("value", 1),
    ];
    let refused = refused.map(|(reason, count)| (reason.to_owned(), count));
    assert_eq!(status.rejected, refused.into());
    let errors = String::from_utf8(output.stderr).unwrap();
    assert_eq!(errors.matches("refused (").count(), 12, "{errors}");
    assert!(
        errors
            .lines()
            .all(|line| line.len() < 600 && !line.contains('\u{1b}'))
    );
}

#[test]
fn a_signal_ends_it_with_open_tasks_listed() {
    for signal in ["INT", "TERM"] {
        let mut node = start(&["run", "--status-every", "0"]);
        let mut stdin = node.stdin.take().unwrap();
        let now = std::time::SystemTime::now();
        let now = now
            .duration_since(std::time::UNIX_EPOCH)
            .unwrap()
            .as_secs_f64();
        let robot = format!(r#"{{"kind":"robot","stamp":{now},"name":"r1","state":"idle"}}"#);
        let item = format!(r#"{{"kind":"detection","stamp":{now},"id":"a","x":1.3,"y":-0.2}}"#);
        write!(stdin, "{robot}\n{item}\n").unwrap();
        stdin.flush().unwrap();
        let mut stdout = BufReader::new(node.stdout.take().unwrap());
        let mut line = String::new();
        stdout.read_line(&mut line).unwrap();
        let Ok(Outgoing::Task(task)) = decode_outgoing(line.trim().as_bytes()) else {
            panic!("{line}");
        };
        let id = node.id().to_string();
        assert!(
            Command::new("kill")
                .args(["-s", signal, &id])
                .status()
                .unwrap()
                .success()
        );
        let mut rest = Vec::new();
        stdout.read_to_end(&mut rest).unwrap();
        let status = last_status(&messages(&rest));
        assert_eq!(status.open_tasks, [task.id]);
        assert_eq!((status.seen, status.claimed), (1, 1));
        drop(stdin);
        let (code, errors) = finish(node);
        assert_eq!(code, Some(0), "{errors}");
        assert!(errors.contains("open tasks 1"), "{errors}");
    }
}

#[test]
fn wrong_usage_is_refused() {
    for (arguments, word) in [
        (&["run", "--listen", "nowhere"][..], "--listen"),
        (&["run", "--connect", "nowhere"], "--connect"),
        (&["run", "--dashboard", "nowhere"], "--dashboard"),
        (&["run", "--status-every", "1e-9"], "--status-every"),
        (&["run", "--tolerance", "nan"], "--tolerance"),
        (&["run", "--ack-timeout", "0"], "--ack-timeout"),
        (&["run", "--strategy", "SPT"], "strategy"),
        (&["emulate", "--lost-acks", "2"], "--lost-acks"),
        (&["emulate", "--robot-down", "3,1,1"], "--robot-down"),
        (&["emulate", "--robot-down", "0,1,1"], "--robot-down"),
        (&["emulate", "--belt-stop", "1"], "--belt-stop"),
        (&["emulate", "--jitter-ms", "-1"], "--jitter-ms"),
        (&["emulate", "--pattern", "-"], "--pattern"),
    ] {
        let (code, errors) = finish(start(arguments));
        assert_eq!(code, Some(2), "{arguments:?} {errors}");
        assert!(
            errors.contains(word) && errors.contains("cure: "),
            "{errors}"
        );
    }
    let schema = start(&["run", "--schema"])
        .wait_with_output()
        .unwrap()
        .stdout;
    let schema: serde_json::Value = serde_json::from_slice(&schema).unwrap();
    assert!(schema["$defs"]["Incoming"]["oneOf"].is_array());
}
