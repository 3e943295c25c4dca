//! The log of a live line: a stderr that nobody reads, remarks that come again and again,
//! lines with levels.

use crate::programs::wait_for;
use crate::support::pipe::full_pipe;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

fn now() -> f64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.unwrap().as_secs_f64()
}

fn start(arguments: &[&str], stderr: impl Into<Stdio>) -> Child {
    Command::new(env!("CARGO_BIN_EXE_pickline"))
        .args(arguments)
        .env_remove("JOURNAL_STREAM")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(stderr)
        .spawn()
        .unwrap()
}

fn signal(child: &Child) {
    let id = child.id().to_string();
    let kill = Command::new("kill").args(["-s", "TERM", &id]).status();
    assert!(kill.unwrap().success());
}

/// It once ended the line: refused lines filled the pipe, and the node waited for whoever
/// had started it.
#[test]
fn a_stderr_that_is_not_read_delays_nothing() {
    let (unread, stderr) = full_pipe();
    let mut node = start(&["run", "--status-every", "0"], stderr);
    let mut stdin = node.stdin.take().unwrap();
    let mut say = |fields: &str| writeln!(stdin, "{{{fields}}}").unwrap();
    let stamp = now();
    say(&format!(r#""kind":"belt","stamp":{stamp},"speed":0.0"#));
    for i in 0..2000 {
        say(&format!(
            r#""kind":"detection","stamp":{},"x":1,"y":0"#,
            stamp - 100.0
        ));
        // Of many kinds too.
        say(&format!(r#""kind":"tick","stamp":{stamp},"other{i}":1"#));
    }
    say(&format!(
        r#""kind":"robot","stamp":{stamp},"name":"r1","state":"idle""#
    ));
    say(&format!(
        r#""kind":"detection","stamp":{stamp},"x":1.3,"y":-0.3,"id":"a""#
    ));
    let said = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&said);
    let stdout = BufReader::new(node.stdout.take().unwrap());
    let reader = thread::spawn(move || {
        for line in stdout.lines() {
            kept.lock().unwrap().push(line.unwrap());
        }
    });
    wait_for("a task", || {
        let said = said.lock().unwrap();
        said.iter()
            .any(|line| line.contains(r#""kind":"task""#) && line.contains(r#""item":"a""#))
    });
    let began = Instant::now();
    signal(&node);
    wait_for("the end", || node.try_wait().unwrap().is_some());
    assert!(began.elapsed() < Duration::from_secs(10));
    assert_eq!(node.wait().unwrap().code(), Some(0));
    reader.join().unwrap();
    let last = said.lock().unwrap().last().cloned().unwrap();
    assert!(
        last.contains(r#""last":true"#) && last.contains(r#""stamp":2000"#),
        "{last}"
    );
    drop(unread);
}

#[test]
fn an_error_ends_the_program_though_nobody_reads_it() {
    let (unread, stderr) = full_pipe();
    let mut node = start(&["run", "--listen", "8.8.8.8:7400"], stderr);
    let began = Instant::now();
    wait_for("the end", || node.try_wait().unwrap().is_some());
    assert!(began.elapsed() < Duration::from_secs(10));
    assert_eq!(node.wait().unwrap().code(), Some(2));
    drop(unread);
}

/// Feeds `input` to `pickline run --clock messages`; returns its stderr.
fn remarks_on(input: &str, arguments: &[&str]) -> String {
    let arguments = [&["run", "--clock", "messages"], arguments].concat();
    let mut node = start(&arguments, Stdio::piped());
    let mut stdin = node.stdin.take().unwrap();
    let mut stderr = node.stderr.take().unwrap();
    let mut stdout = node.stdout.take().unwrap();
    let out = thread::spawn(move || stdout.read_to_end(&mut Vec::new()).unwrap());
    let remarks = thread::spawn(move || {
        let mut text = String::new();
        stderr.read_to_string(&mut text).unwrap();
        text
    });
    stdin.write_all(input.as_bytes()).unwrap();
    drop(stdin);
    assert_eq!(node.wait().unwrap().code(), Some(0));
    out.join().unwrap();
    remarks.join().unwrap()
}

#[test]
fn repeated_refusals_are_summed_up() {
    let belt = "{\"kind\":\"belt\",\"stamp\":500,\"speed\":0}\n";
    // Time begins with the first of two that agree.
    let mut input = belt.repeat(2);
    for _ in 0..2000 {
        input += "{\"kind\":\"detection\",\"stamp\":300,\"x\":1,\"y\":0}\n";
    }
    let remarks = remarks_on(&input, &[]);
    let refused: Vec<&str> = remarks
        .lines()
        .filter(|l| l.contains("refused ("))
        .collect();
    assert_eq!(refused.len(), 2, "{remarks}");
    assert!(
        refused[0].starts_with("stdin line 3: refused (stamp): "),
        "{remarks}"
    );
    let sum = "and 1,999 more, the last: stdin line 2002: refused (stamp): ";
    assert!(refused[1].starts_with(sum), "{remarks}");
    // The figures of the end stay the last word.
    assert!(
        remarks.lines().last().unwrap().contains("decisions, p50"),
        "{remarks}"
    );
    assert_eq!(remarks_on(&input, &["--quiet"]), "");
}

#[test]
fn levels_are_written_as_asked_for() {
    let input = "{\"kind\":\"belt\",\"stamp\":500,\"speed\":0}\n{\n";
    let journald = remarks_on(input, &["--log-format", "journald"]);
    assert!(
        journald.lines().all(|line| line.starts_with('<')),
        "{journald}"
    );
    assert!(journald.contains("<6>running rules:SPT,FIFO"), "{journald}");
    assert!(
        journald.contains("<4>stdin line 2: refused (syntax)"),
        "{journald}"
    );
    let stamped = remarks_on(input, &["--log-format", "stamped"]);
    for line in stamped.lines() {
        let (stamp, rest) = line.split_once(' ').unwrap();
        assert!(
            (stamp.parse::<f64>().unwrap() - now()).abs() < 600.0,
            "{line}"
        );
        assert!(
            rest.starts_with("info ") || rest.starts_with("warning "),
            "{line}"
        );
    }
    assert!(
        stamped.contains(" warning stdin line 2: refused"),
        "{stamped}"
    );
    let plain = remarks_on(input, &["--log-format", "text"]);
    assert_eq!(plain.lines().nth(1), remarks_on(input, &[]).lines().nth(1));
    // Errors too.
    let arguments = ["run", "--log-format", "journald", "--tolerance", "9"];
    let output = start(&arguments, Stdio::piped())
        .wait_with_output()
        .unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.starts_with("<3>pickline: --tolerance") && error.contains("\n<3>  cure: "),
        "{error}"
    );
}
