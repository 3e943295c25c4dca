//! Who is let in: web pages, tokens, certificates.

use super::{Peer, is_task, node, now, secret};
use crate::authority;
use crate::programs::{Program, wait_for};
use serde_json::{Value, json};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::Command;

/// A page in a browser can send anything but the first line.
#[test]
fn a_web_page_commands_nothing() {
    let (node, address) = node("--status-every 0.1");
    let observer = Peer::new(&address);
    let mut browser = TcpStream::connect(&address).unwrap();
    let body = format!(
        "\n{}\n{}\n",
        json!({"kind": "robot", "stamp": now(), "name": "r1", "state": "idle"}),
        json!({"kind": "detection", "stamp": now(), "id": "a", "x": 1.3, "y": -0.2}),
    );
    let request = format!(
        "POST / HTTP/1.1\r\nHost: {address}\r\nContent-Type: text/plain\r\n\
         Content-Length: {}\r\n\r\n{body}",
        body.len()
    );
    browser.write_all(request.as_bytes()).unwrap();
    let mut answer = String::new();
    browser.read_to_string(&mut answer).unwrap();
    let answer: Value = serde_json::from_str(&answer).unwrap();
    assert_eq!(
        (&answer["kind"], &answer["accepted"]),
        (&json!("hello"), &json!(false))
    );
    let status = observer.status();
    assert_eq!(status["seen"], 0);
    assert_eq!(status["rejected"], json!({"syntax": 1}));
    assert_eq!(status["robots"][0]["state"], "unknown");
    node.remarks.wait_for("it begins with `POST / HTTP/1.1`");
    // JSON of another kind, a version to come, and what only looks like JSON.
    for line in [
        r#"{"jsonrpc":"2.0","method":"x"}"#,
        r#"{"v":2,"kind":"tick","stamp":1}"#,
        "{nonsense",
    ] {
        let stranger = Peer::new(&address);
        let line = format!("{line}\n");
        (&stranger.stream).write_all(line.as_bytes()).unwrap();
        stranger.wait_for_the_end();
        assert_eq!(stranger.heard().last().unwrap()["accepted"], false);
    }
    // One flawed message is no reason, a hundred are.
    let camera = Peer::new(&address);
    for i in 0..99 {
        camera.say(&json!({"kind": "detection", "stamp": now(), "x": i, "y": "nowhere"}));
    }
    camera.see("b", "r1");
    let status = observer.status();
    assert_eq!(status["rejected"]["field"], 99);
    assert_eq!(status["seen"], 1);
    for i in 0..100 {
        camera.say(&json!({"kind": "detection", "stamp": now(), "x": i, "y": "nowhere"}));
    }
    camera.wait_for_the_end();
}

#[test]
fn with_a_token_nobody_is_accepted_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let token = secret(folder.path());
    let (node, address) = node(&format!("--status-every 0.1 --token {token}"));
    let hello = |token: Option<&str>| {
        let peer = Peer::new(&address);
        let mut hello = json!({"kind": "hello", "name": "c", "role": "camera"});
        if let Some(token) = token {
            hello["token"] = json!(token);
        }
        peer.say(&hello);
        peer
    };
    let camera = hello(Some("0123456789abcdef0123456789abcdef"));
    let answer = camera.wait_for("an answer", |message| message["kind"] == "hello");
    assert_eq!(answer["accepted"], true);
    for peer in [
        hello(None),
        hello(Some("0123456789abcdef")),
        hello(Some("")),
    ] {
        peer.wait_for_the_end();
        assert_eq!(peer.heard().len(), 1);
        let reason = peer.heard()[0]["reason"].as_str().unwrap().to_owned();
        assert!(reason.contains("token"), "{reason}");
    }
    // Without a hello, and without a word.
    let rude = Peer::new(&address);
    rude.see("a", "r1");
    let mute = Peer::new(&address);
    for peer in [rude, mute] {
        peer.wait_for_the_end();
        assert_eq!(peer.heard().len(), 1, "{:?}", peer.heard());
        assert_eq!(peer.heard()[0]["accepted"], false);
    }
    assert_eq!(camera.status()["seen"], 0);
    let said = format!("{:?}{:?}", node.remarks.all(), camera.heard());
    assert!(!said.contains("0123456789abcdef"), "{said}");
    // The station shows it.
    let emulate = |more: &str| {
        let line = format!("emulate --connect {address} --belt-speed 0.4 {more}");
        Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(line.split_whitespace())
            .output()
            .unwrap()
    };
    let refused = emulate("");
    let text = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{text}");
    assert!(
        text.contains("its hello has no token") && text.contains("cure: "),
        "{text}"
    );
    let played = emulate(&format!("--token {token}"));
    let text = String::from_utf8_lossy(&played.stderr).into_owned();
    assert_eq!(played.status.code(), Some(0), "{text}");
    assert!(text.contains("of 50 items in the bins"), "{text}");
}

#[test]
fn addresses_that_others_reach_ask_for_something() {
    let folder = tempfile::tempdir().unwrap();
    let token = secret(folder.path());
    let run = |line: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_pickline"))
            .args(line.split_whitespace())
            .stdin(std::process::Stdio::null())
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        (output.status.code(), text)
    };
    for (line, word) in [
        ("run --listen 0.0.0.0:0", "--token FILE"),
        ("run --listen [::]:0", "--insecure"),
        ("run --dashboard 0.0.0.0:0", "could watch the line"),
        ("run --connect 192.0.2.1:9", "--tls-ca"),
        ("emulate --listen 0.0.0.0:0", "--insecure"),
        (&format!("run --token {token}"), "it is not used here"),
        (
            &format!("run --connect 127.0.0.1:9 --token {token}"),
            "it is not used here",
        ),
        ("run --listen 127.0.0.1:0 --token /no/such/file", "/no/such"),
    ] {
        let (code, text) = run(line);
        assert_eq!(code, Some(2), "{line}: {text}");
        assert!(
            text.contains(word) && text.contains("cure: "),
            "{line}: {text}"
        );
    }
    // The dashboard alone may be open to others with a token.
    let (code, text) = run(&format!("run --dashboard 0.0.0.0:0 --token {token}"));
    assert_eq!(code, Some(0), "{text}");
    assert!(!text.contains("anyone"), "{text}");
}

/// What the dashboard at `address` answers to a plain request.
fn status_line(address: &str, authorization: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    let request = format!("GET /dashboard.css HTTP/1.1\r\nHost: {address}\r\n{authorization}\r\n");
    stream.write_all(request.as_bytes()).unwrap();
    let mut line = String::new();
    let _ = BufReader::new(stream).read_line(&mut line);
    line.trim().to_owned()
}

/// The address of a node's dashboard.
fn dashboard(node: &Program) -> String {
    node.remarks.wait_for("dashboard at ");
    let remarks = node.remarks.all();
    let remark = remarks.iter().find(|line| line.contains("dashboard at "));
    let url = remark.unwrap().rsplit(' ').next().unwrap();
    let address = url.split("//").nth(1).unwrap();
    address.trim_end_matches('/').to_owned()
}

#[test]
fn the_dashboard_asks_for_the_token_too() {
    let folder = tempfile::tempdir().unwrap();
    let token = secret(folder.path());
    let (node, _) = node(&format!("--dashboard 127.0.0.1:0 --token {token}"));
    let address = dashboard(&node);
    for (authorization, answer) in [
        ("", "HTTP/1.1 401 Unauthorized"),
        (
            "Authorization: Bearer 0123456789abcdef\r\n",
            "HTTP/1.1 401 Unauthorized",
        ),
        (
            "Authorization: Bearer 0123456789abcdef0123456789abcdef\r\n",
            "HTTP/1.1 200 OK",
        ),
        (
            // `me:` and the token.
            "Authorization: Basic bWU6MDEyMzQ1Njc4OWFiY2RlZjAxMjM0NTY3ODlhYmNkZWY=\r\n",
            "HTTP/1.1 200 OK",
        ),
    ] {
        assert_eq!(
            status_line(&address, authorization),
            answer,
            "{authorization}"
        );
    }
}

#[test]
fn certificates_of_both_sides_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let (ours, theirs) = (folder.path().join("ours"), folder.path().join("theirs"));
    for folder in [&ours, &theirs] {
        std::fs::create_dir(folder).unwrap();
        authority::authority(folder, &["node", "station"]);
    }
    let files = |folder: &Path, name: &str| {
        let folder = folder.display();
        format!("--tls-cert {folder}/{name}.pem --tls-key {folder}/{name}.key")
    };
    let (ca, node_files) = (ours.join("ca.pem"), files(&ours, "node"));
    let (node, address) = node(&format!(
        "--dashboard 127.0.0.1:0 --tls-ca {} {node_files}",
        ca.display()
    ));
    let emulate = |more: &str| {
        let line = format!("emulate --connect {address} --belt-speed 0.4 {more}");
        Program::pickline(&line, &[])
    };
    // In the clear, without a certificate, and with one of somebody else.
    let mut in_the_clear = TcpStream::connect(&address).unwrap();
    let tick = format!("{}\n", json!({"kind": "tick", "stamp": now()}));
    in_the_clear.write_all(tick.as_bytes()).unwrap();
    let mut rest = Vec::new();
    let _ = in_the_clear.read_to_end(&mut rest);
    assert!(!rest.starts_with(b"{"));
    node.remarks.wait_for("the TLS handshake failed");
    let ca = ca.display();
    for more in [
        format!("--tls-ca {ca}"),
        format!("--tls-ca {ca} {}", files(&theirs, "station")),
        format!(
            "--tls-ca {}/ca.pem {}",
            theirs.display(),
            files(&ours, "station")
        ),
    ] {
        let stranger = emulate(&more);
        let refused = |line: &String| line.contains("the TLS handshake failed");
        let before = node
            .remarks
            .all()
            .iter()
            .filter(|line| refused(line))
            .count();
        let told = || {
            let remarks = node.remarks.all();
            remarks.iter().filter(|line| refused(line)).count() > before
                || stranger
                    .remarks
                    .all()
                    .iter()
                    .any(|line| line.contains("no connection to"))
        };
        wait_for("a refusal", told);
    }
    let mut station = emulate(&format!("--tls-ca {ca} {}", files(&ours, "station")));
    let (code, remarks) = station.finish();
    assert_eq!(code, Some(0), "{remarks}");
    assert!(
        remarks.contains("of 50 items in the bins; the node reports"),
        "{remarks}"
    );
    // The dashboard has the same certificate, and asks for one too.
    let at = dashboard(&node);
    assert!(!status_line(&at, "").starts_with("HTTP"));
    let shown = Command::new("openssl")
        .args([
            "s_client",
            "-quiet",
            "-verify_return_error",
            "-connect",
            &at,
        ])
        .args(["-CAfile", &ca.to_string()])
        .args(["-cert", ours.join("station.pem").to_str().unwrap()])
        .args(["-key", ours.join("station.key").to_str().unwrap()])
        .stdin(std::process::Stdio::piped())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::null())
        .spawn();
    let mut shown = shown.unwrap();
    let mut stdin = shown.stdin.take().unwrap();
    write!(stdin, "GET /dashboard.css HTTP/1.1\r\nHost: {at}\r\n\r\n").unwrap();
    let mut line = String::new();
    let mut page = BufReader::new(shown.stdout.take().unwrap());
    page.read_line(&mut line).unwrap();
    assert_eq!(line.trim(), "HTTP/1.1 200 OK");
    drop(stdin);
    shown.kill().unwrap();
    shown.wait().unwrap();
}

/// A node that was started again knows who was idle, but who has not shown the token brings
/// nothing to any robot: no task is decided before the robot itself is back.
#[test]
fn with_a_token_unknown_peers_speak_for_no_robot() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = format!(
        "--status-every 0.1 --token {} --journal {}",
        secret(folder.path()),
        folder.path().join("journal").display()
    );
    let hello = |address: &str, role: &str, robots: &[&str]| {
        let peer = Peer::new(address);
        let mut hello = json!({"kind": "hello", "name": role, "role": role,
            "token": "0123456789abcdef0123456789abcdef"});
        if !robots.is_empty() {
            hello["robots"] = json!(robots);
        }
        peer.say(&hello);
        let answer = peer.wait_for("an answer", |message| message["kind"] == "hello");
        assert_eq!(answer["accepted"], true, "{answer}");
        peer
    };
    let (mut before, address) = node(&arguments);
    let camera = hello(&address, "camera", &[]);
    let robot = hello(&address, "robot", &["r1"]);
    camera.stop_belt();
    robot.idle("r1");
    wait_for("an idle robot", || {
        camera.status()["robots"][0]["state"] == "idle"
    });
    before.signal("TERM");
    assert_eq!(before.finish().0, Some(0));
    let (_node, address) = node(&arguments);
    let _stranger = Peer::new(&address);
    let camera = hello(&address, "camera", &[]);
    camera.stop_belt();
    camera.see("a", "r1");
    wait_for("an item", || camera.status()["seen"] == 1);
    let status = camera.status();
    assert_eq!(status["robots"][0]["state"], "idle");
    assert_eq!(
        (&status["claimed"], &status["on_belt"]),
        (&json!(0), &json!(1))
    );
    let robot = hello(&address, "robot", &["r1"]);
    assert_eq!(robot.wait_for("a task", is_task)["item"], "a");
}
