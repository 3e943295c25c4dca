//! `pickline run` and `pickline emulate` as programs that talk to each other.

use crate::programs::{feed, piped};
use crate::support::three::check_settled;
use crate::trouble::TROUBLE;
use pickline_live::protocol::{Outgoing, Status, decode_outgoing};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Output};
use std::thread::{self, JoinHandle};

fn start(arguments: &[&str]) -> Child {
    piped(Command::new(env!("CARGO_BIN_EXE_pickline")).args(arguments))
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
    let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
    let (output, read) = feed(command.arg("run").args(arguments), input);
    read.unwrap();
    output
}

/// What came of a node and an emulated station that talked to each other.
struct Played {
    /// What the station said, where that was heard.
    stream: Vec<u8>,
    /// What the node said.
    said: Vec<Outgoing>,
    /// Exit code and remarks of the station.
    station: (Option<i32>, String),
}

fn by_pipes(line: &[&str], pattern: &str, trouble: &[&str]) -> Played {
    let mut node = start(&[&["run"], line].concat());
    let mut station = start(&[&["emulate", "--pattern", pattern], line, trouble].concat());
    let down = connect(station.stdout.take().unwrap(), node.stdin.take().unwrap());
    let up = connect(node.stdout.take().unwrap(), station.stdin.take().unwrap());
    let stream = down.join().unwrap();
    let said = up.join().unwrap();
    let (code, errors) = finish(node);
    assert_eq!(code, Some(0), "{errors}");
    Played {
        stream,
        said: messages(&said),
        station: finish(station),
    }
}

/// The node listens; besides the station somebody is there who only hears what is said.
fn by_tcp(line: &[&str], pattern: &str, trouble: &[&str]) -> Played {
    let mut node = start(&[&["run", "--listen", "127.0.0.1:0"], line].concat());
    let mut remarks = BufReader::new(node.stderr.take().unwrap());
    let mut remark = String::new();
    while !remark.contains("listening at ") {
        remark.clear();
        assert!(remarks.read_line(&mut remark).unwrap() > 0);
    }
    let address = remark.trim().rsplit(' ').next().unwrap();
    let hears = TcpStream::connect(address).unwrap();
    let in_turns = line.contains(&"messages");
    let listener = thread::spawn(move || {
        let mut heard = BufReader::new(&hears);
        let mut said = Vec::new();
        heard.read_until(b'\n', &mut said).unwrap();
        if in_turns {
            // The station is there, and the node ends when it has gone.
            hears.shutdown(Shutdown::Write).unwrap();
        }
        heard.read_to_end(&mut said).unwrap();
        said
    });
    let emulate = ["emulate", "--pattern", pattern, "--connect", address];
    let station = finish(start(&[&emulate[..], line, trouble].concat()));
    if !in_turns {
        let id = node.id().to_string();
        let told = Command::new("kill").args(["-s", "TERM", &id]).status();
        assert!(told.unwrap().success());
    }
    let said = listener.join().unwrap();
    let mut rest = String::new();
    remarks.read_to_string(&mut rest).unwrap();
    assert_eq!(node.wait().unwrap().code(), Some(0), "{rest}");
    Played {
        stream: Vec::new(),
        said: messages(&said),
        station,
    }
}

type Transport = fn(&[&str], &str, &[&str]) -> Played;
const TRANSPORTS: [Transport; 2] = [by_pipes, by_tcp];

/// A pattern on a line of so many robots.
fn pattern(folder: &Path, robots: &str, items: &str) -> String {
    let file = folder.join(format!("{robots}.csv"));
    let file = file.to_str().unwrap().to_owned();
    let made = ["pattern", "generate", "poisson", "--radius", "0.12"];
    let more = ["--count", items, "--robots", robots, "--output", &file];
    assert_eq!(finish(start(&[&made[..], &more].concat())).0, Some(0));
    file
}

/// What `simulate` picks.
fn simulated(line: &[&str], pattern: &str) -> Vec<serde_json::Value> {
    let simulate = ["simulate", "-q", "--format", "json", "--pattern", pattern];
    let child = start(&[&simulate[..], line].concat());
    let output = child.wait_with_output().unwrap().stdout;
    let report: serde_json::Value = serde_json::from_slice(&output).unwrap();
    report["picks"].as_array().unwrap().clone()
}

#[test]
fn the_picks_are_those_of_the_simulator() {
    let folder = tempfile::tempdir().unwrap();
    for robots in ["2", "6"] {
        let file = pattern(folder.path(), robots, "1000");
        let picks = simulated(&["--robots", robots], &file);
        let line = ["--clock", "messages", "--robots", robots];
        for play in TRANSPORTS {
            let played = play(&line, &file, &[]);
            let (code, errors) = &played.station;
            assert_eq!(*code, Some(0), "{errors}");
            let tasks = played.said.iter().filter_map(|message| match message {
                Outgoing::Task(task) => Some(task),
                _ => None,
            });
            let tasks: Vec<_> = tasks.collect();
            assert_eq!(tasks.len(), picks.len());
            for (task, pick) in tasks.iter().zip(&picks) {
                assert_eq!(pick["item"], task.item);
                assert_eq!(pick["decide_s"], task.decided_at);
                assert_eq!(pick["release_s"], task.free_at);
            }
            let status = last_status(&played.said);
            assert_eq!((status.seen, status.picked), (1000, picks.len() as u64));
            assert_eq!(status.seen, status.picked + status.missed.total());
            if !played.stream.is_empty() {
                // The stream alone gives the same again, to the bit.
                let again = run_on(&line, &played.stream);
                assert!(messages(&again.stdout) == played.said);
            }
        }
    }
}

/// No promise was broken, and every one of `items` is accounted for; returns the picks.
fn accounts(played: &Played, items: u64) -> u64 {
    let (code, errors) = &played.station;
    // It ends with another code where two robots were after one item.
    assert_eq!(*code, Some(0), "{errors}");
    let status = last_status(&played.said);
    check_settled(&status, items);
    status.picked
}

#[test]
fn with_everything_going_wrong_every_item_is_accounted_for() {
    let folder = tempfile::tempdir().unwrap();
    let trouble: Vec<&str> = TROUBLE.split_whitespace().collect();
    for robots in ["2", "6"] {
        let file = pattern(folder.path(), robots, "1000");
        let most = simulated(&["--robots", robots], &file).len() as u64;
        for play in TRANSPORTS {
            let line = ["--clock", "messages", "--robots", robots];
            let picked = accounts(&play(&line, &file, &trouble), 1000);
            assert!(picked > most / 2 && picked < most, "{picked} of {most}");
        }
    }
}

/// In real time, which takes as long as the belt does.
#[test]
fn by_the_clock_every_item_is_accounted_for() {
    let folder = tempfile::tempdir().unwrap();
    let trouble = "--failing-grasps 0.1 --lost-acks 0.02 --duplicates 0.1 --out-of-order 0.05 \
        --jitter-ms 50 --robot-down 1,8,3 --belt-stop 12,2";
    thread::scope(|scope| {
        for (play, robots, trouble) in [
            (by_pipes as Transport, "2", ""),
            (by_tcp, "2", trouble),
            (by_pipes, "6", trouble),
            (by_tcp, "6", ""),
        ] {
            let folder = folder.path().join(format!("{robots}{}", trouble.len()));
            scope.spawn(move || {
                std::fs::create_dir(&folder).unwrap();
                let file = pattern(&folder, robots, "100");
                let line = ["--robots", robots, "--belt-speed", "0.4"];
                let most = simulated(&line, &file).len() as u64;
                let trouble: Vec<&str> = trouble.split_whitespace().collect();
                let picked = accounts(&play(&line, &file, &trouble), 100);
                let least = if trouble.is_empty() { most / 2 } else { 1 };
                assert!(picked >= least, "{picked}, simulated {most}");
            });
        }
    });
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
    // Of what is refused twice for one reason the second is a sum of one, of three the rest.
    assert_eq!(errors.matches("refused (").count(), 11, "{errors}");
    assert!(
        errors.contains("and 2 more, the last: stdin line 12: refused (syntax)"),
        "{errors}"
    );
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
        assert!(errors.contains("open tasks: 1"), "{errors}");
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
        (&["emulate", "--failing-grasps", "2"], "--failing-grasps: 2"),
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

/// Node and station are started by hand, each with a file of its own.
#[test]
fn a_node_of_another_station_is_an_error_on_both_sides() {
    let folder = tempfile::tempdir().unwrap();
    let paper = pickline::station::built_in("paper")
        .unwrap()
        .station(None)
        .unwrap();
    let paper = pickline::station::to_toml(&paper);
    let file = |name: &str, text: String| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let names = file(
        "names.toml",
        paper.replace("\"r1\"", "\"a\"").replace("\"r2\"", "\"b\""),
    );
    let reach = file("reach.toml", paper.replace("reach = 0.8", "reach = 0.7"));
    let fast = file("fast.toml", paper.replace("speed = 0.05", "speed = 0.06"));
    let clock = ["--clock", "messages"];
    for (other, words, codes) in [
        (&names, "the node's robots are `a`, `b`", [Some(2), Some(2)]),
        (
            &reach,
            "reaches, speeds or dwell times differ",
            [Some(0), Some(2)],
        ),
        // How fast the belt is, the line itself says.
        (&fast, "picked", [Some(0), Some(0)]),
    ] {
        let mut node = start(&[&["run", "--station", other], &clock[..]].concat());
        let mut station = start(&[&["emulate"], &clock[..]].concat());
        let down = connect(station.stdout.take().unwrap(), node.stdin.take().unwrap());
        let up = connect(node.stdout.take().unwrap(), station.stdin.take().unwrap());
        let (code, errors) = finish(station);
        assert!(errors.contains(words), "{errors}");
        let (of_node, remarks) = finish(node);
        assert_eq!([of_node, code], codes, "{remarks}\n{errors}");
        if of_node == Some(2) {
            assert!(
                remarks.contains("were heard is one of `a`, `b`"),
                "{remarks}"
            );
        }
        down.join().unwrap();
        up.join().unwrap();
    }
}
