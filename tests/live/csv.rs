//! Robots and cameras that speak the csv dialect, over pipes and TCP. The checksum, the fields
//! and the times are computed here from docs/dialect-csv.md, not by the library.

use crate::programs::{Program, feed};
use serde_json::Value;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt as _;
use std::process::Command;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

fn checksum(text: &str) -> u32 {
    let (mut low, mut high) = (0u32, 0u32);
    for byte in text.bytes() {
        low = (low + u32::from(byte)) % 255;
        high = (high + low) % 255;
    }
    high * 256 + low
}

fn line(text: &str) -> String {
    format!("{text}*{:05}\r\n", checksum(text))
}

/// The fields of a line from the node, whose length and checksum are checked, and its number.
fn fields(line: &str, number: &mut u32) -> Vec<String> {
    assert!(
        line.len() <= 80 && line.ends_with("\r\n") && line.is_ascii(),
        "{line:?}"
    );
    let (text, sum) = line.trim_end().rsplit_once('*').unwrap();
    assert_eq!(sum, format!("{:05}", checksum(text)), "{line}");
    let fields: Vec<String> = text.split(',').map(str::to_owned).collect();
    assert_eq!(fields[1].parse(), Ok(*number), "{line}");
    *number = (*number + 1) % 1000;
    fields
}

/// Now, as a field `t` has it [ms].
fn now() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    (since.as_millis() % 1_000_000_000) as i64
}

/// Feeds lines to a node with message time; returns what it says and remarks.
fn run_on(lines: &[String], arguments: &[&str]) -> (Vec<String>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
    command.args(["run", "--clock", "messages", "--dialect", "csv"]);
    let (output, _) = feed(command.args(arguments), lines.concat().as_bytes());
    let said = String::from_utf8(output.stdout).unwrap();
    let said = said.split_inclusive('\n').map(str::to_owned).collect();
    (said, String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_stream_of_lines_is_answered_in_lines() {
    let lines = [
        "B,0,100000,50",
        "R,1,100000,r1,I",
        "D,2,100000,500,-200,a,PET,80,,30,33.5",
        "K,3,101000",
        "A,4,101100,1",
        "F,5,103000,1,P",
        "K,6,104000",
    ];
    let lines = lines.map(line);
    let (said, remarks) = run_on(&lines, &[]);
    assert!(!remarks.contains("refused"), "{remarks}");
    let mut number = 0;
    let said: Vec<Vec<String>> = said.iter().map(|line| fields(line, &mut number)).collect();
    let of = |letter: &str| said.iter().find(|fields| fields[0] == letter).unwrap();
    let (item, task) = (of("I"), of("T"));
    assert_eq!(item[2..5], ["1", "a", "PET"]);
    assert_eq!(item[8..], ["30", "33.5"]);
    assert_eq!(task[3..5], ["r1", "1"]);
    // The same through JSON: the same task, to the digits that the dialect has.
    let input = r#"{"kind":"belt","stamp":100,"speed":0.05}
{"kind":"robot","stamp":100,"name":"r1","state":"idle"}
{"kind":"detection","stamp":100,"x":0.5,"y":-0.2,"id":"a","class":"PET","area_cm2":80}
{"kind":"tick","stamp":101}
"#;
    let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
    command.args(["run", "--clock", "messages"]);
    let (output, read) = feed(&mut command, input.as_bytes());
    read.unwrap();
    let messages = String::from_utf8(output.stdout).unwrap();
    let messages = messages
        .lines()
        .map(|line| serde_json::from_str(line).unwrap());
    let mut tasks = messages.filter(|message: &Value| message["kind"] == "task");
    let json = tasks.next().unwrap();
    let number = |path: &str| json.pointer(path).and_then(Value::as_f64).unwrap();
    let at = number("/decided_at");
    let near = |field: usize, value: f64, off: f64| {
        let found: f64 = task[field].parse().unwrap();
        assert!((found - value).abs() <= off, "{task:?}: {found}, {value}");
    };
    near(2, 1e3 * at, 0.5);
    near(6, 1e3 * (number("/start") - at), 1.0);
    near(7, 1e3 * (number("/latest_start") - at), 1.0);
    near(8, 1e3 * (number("/meet_at") - at), 1.0);
    near(9, 1e3 * number("/meet/x"), 0.051);
    near(10, 1e3 * number("/meet/y"), 0.051);
    // Seen, picked, missed, on the belt, claimed, last.
    let last = said.last().unwrap();
    assert_eq!(last[0], "S");
    assert_eq!(last[3..], ["1", "1", "0", "0", "0", "1"]);
}

#[test]
fn what_is_wrong_is_refused_and_counted_by_reason() {
    let wrong_sum = line("D,2,100000,500,-200,a").replace('5', "6");
    let lines = [
        line("B,0,100000,50"),
        line("B,1,100000,50"),
        wrong_sum,
        line("D,3,100000,500,-200,b"),
        line("D,6,100000,600,-200,c"),
        line("D,7,100000,-350000,0,d"),
        line("Q,8,100000"),
        line("K,9,100000,1"),
        line("K,,100500"),
        line(&format!("D,10,100000,1,1,{}", "x".repeat(80))),
        "K,11,101000\r\n".to_owned(),
        line("K,12,101000"),
    ];
    let (said, remarks) = run_on(&lines, &[]);
    for (number, words) in [
        (3, "refused (checksum): the checksum is `"),
        (
            4,
            "refused (sequence): the sequence number is 3, 1 too high",
        ),
        (6, "refused (value): x = -350; "),
        (7, "refused (kind): there is no line `Q`"),
        (8, "refused (field): tick: 4 fields; expected at most 3"),
        (10, "refused (too_long): "),
        (11, "refused (syntax): "),
    ] {
        let place = format!("stdin line {number}: ");
        let line = remarks.lines().find(|line| line.contains(&place));
        assert!(
            line.is_some_and(|line| line.contains(words)),
            "{words} not in {remarks}"
        );
    }
    // Lines 5 and 12 come after gaps too.
    let sum = "and 2 more, the last: stdin line 12: refused (sequence)";
    assert!(remarks.contains(sum), "{remarks}");
    // Those after a gap count: b and c were seen.
    let last = said.last().unwrap();
    assert_eq!(
        fields(last, &mut last.split(',').nth(1).unwrap().parse().unwrap())[3],
        "2"
    );
}

/// Without a clock, times are left out; beside a camera that speaks JSON.
#[test]
fn a_robot_without_a_clock_works_beside_a_camera_in_json() {
    let mut node = Program::pickline(
        "run --listen 127.0.0.1:0 --dialect csv --status-every 0.2 --ack-timeout 10",
        &[],
    );
    node.remarks.wait_for("listening at ");
    let remark = node.remarks.all().pop().unwrap();
    let address = remark.rsplit(' ').next().unwrap();
    let mut robot = TcpStream::connect(address).unwrap();
    robot
        .set_read_timeout(Some(Duration::from_secs(60)))
        .unwrap();
    robot.write_all(line("R,0,,r1,I").as_bytes()).unwrap();
    let mut camera = TcpStream::connect(address).unwrap();
    let stamp = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap()
        .as_secs_f64();
    let json = format!(
        "{{\"kind\":\"belt\",\"stamp\":{stamp},\"speed\":0}}\n{{\"kind\":\"detection\",\"stamp\":{stamp},\
         \"x\":1.3,\"y\":-0.3,\"id\":\"a\"}}\n"
    );
    camera.write_all(json.as_bytes()).unwrap();
    let mut lines = BufReader::new(robot.try_clone().unwrap());
    let mut number = 0;
    let mut next = |letter: &str| loop {
        let mut text = String::new();
        assert!(lines.read_line(&mut text).unwrap() > 0);
        let fields = fields(&text, &mut number);
        if fields[0] == letter {
            return fields;
        }
    };
    let task = next("T");
    assert_eq!(task[3], "r1");
    let sent: i64 = task[2].parse().unwrap();
    // The node rounds to whole [ms] where `now` cuts off: up to 1 ms ahead of it.
    let ago = (now() + 1 - sent).rem_euclid(1_000_000_000);
    assert!(ago < 60_000, "{task:?}");
    robot
        .write_all(line(&format!("A,1,,{}", task[4])).as_bytes())
        .unwrap();
    robot
        .write_all(line(&format!("F,2,,{},P", task[4])).as_bytes())
        .unwrap();
    loop {
        let status = next("S");
        if status[4] == "1" {
            assert_eq!(status[3..8], ["1", "1", "0", "0", "0"]);
            break;
        }
    }
    // Whoever begins in JSON is answered in it.
    let mut text = String::new();
    let mut heard = BufReader::new(camera);
    while !text.contains("\"picked\":1") {
        text.clear();
        assert!(heard.read_line(&mut text).unwrap() > 0);
    }
    serde_json::from_str::<Value>(&text).unwrap();
    // A browser is nobody's peer.
    let mut browser = TcpStream::connect(address).unwrap();
    browser
        .write_all(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
        .unwrap();
    browser
        .set_read_timeout(Some(Duration::from_millis(500)))
        .unwrap();
    let _ = browser.read(&mut [0; 64]);
    node.signal("TERM");
    let (code, remarks) = node.finish();
    assert_eq!(code, Some(0), "{remarks}");
}

#[test]
fn a_robot_says_who_it_is_and_shows_its_token() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("token");
    let token = "0123456789abcdef0123456789abcdef";
    std::fs::write(&file, token).unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
    let arguments = format!(
        "run --listen 127.0.0.1:0 --dialect csv --status-every 0.2 --token {}",
        file.display()
    );
    let mut node = Program::pickline(&arguments, &[]);
    node.remarks.wait_for("listening at ");
    let remarks = node.remarks.all();
    let remark = remarks.iter().find(|line| line.contains("listening at "));
    let address = remark.unwrap().rsplit(' ').next().unwrap();
    for (shown, accepted) in [("wrong", "0"), (token, "1")] {
        let mut robot = TcpStream::connect(address).unwrap();
        robot
            .set_read_timeout(Some(Duration::from_secs(60)))
            .unwrap();
        let hello = line(&format!("H,0,cell-1,R,r1;r2,{shown}"));
        robot.write_all(hello.as_bytes()).unwrap();
        let mut text = String::new();
        BufReader::new(robot).read_line(&mut text).unwrap();
        assert_eq!(fields(&text, &mut 0)[..3], ["H", "0", accepted], "{text}");
    }
    node.signal("TERM");
    assert_eq!(node.finish().0, Some(0));
}

#[test]
fn lines_that_names_do_not_fit_on_are_refused_at_the_start() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("line.toml");
    let station = "[belt]\nspeed = 0.05\nlength = 4.0\nwidth = 1.0\n\n[[robot]]\nname = \"delta-left\"\n\
                   base = [1.3, -0.6]\nbin = [1.3, -0.5]\nreach = 0.8\nspeed = 0.5\n\
                   grasp_time = 0.1\nrelease_time = 0.1\n";
    std::fs::write(&file, station).unwrap();
    let (said, remarks) = run_on(&[], &["--station", file.to_str().unwrap()]);
    assert!(said.is_empty());
    assert!(
        remarks.contains("--dialect: `delta-left`") && remarks.contains("cure: rename the robot"),
        "{remarks}"
    );
}
