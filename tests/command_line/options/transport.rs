//! Where `run` and `emulate` talk, to whom, and how they remark.

use super::{Row, hold, row};
use crate::programs::{Program, wait_for};
use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{TcpListener, TcpStream};

const LINES: [&str; 2] = ["run", "emulate"];

pub const ROWS: &[Row] = &[
    row(&LINES, "--listen", |rig, verb| {
        let mut program = rig.program(&format!("{verb} --clock messages --listen 127.0.0.1:0"));
        let address = told(&mut program, "listening at ");
        assert!(is_served(TcpStream::connect(address).unwrap(), verb));
    }),
    row(&LINES, "--connect", |rig, verb| {
        let server = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = server.local_addr().unwrap();
        let call = format!("{verb} --clock messages --connect {address}");
        let mut program = rig.program(&call);
        assert!(is_served(accepted(&server, &mut program), verb));
    }),
    row(&LINES, "--insecure", |rig, verb| {
        let call = format!("{verb} --clock messages --listen 0.0.0.0:0");
        let words = ["other machines can reach 0.0.0.0:0", "--insecure"];
        rig.refused(&call, &words);
        let mut program = rig.program(&format!("{call} --insecure"));
        told(&mut program, "listening at ");
    }),
    row(&LINES, "--max-peers", |rig, verb| {
        let call = format!("{verb} --clock messages --listen 127.0.0.1:0");
        for (most, words) in [
            ("1", "--max-peers allows no more"),
            ("2", "is not the live protocol"),
        ] {
            let mut program = rig.program(&format!("{call} --max-peers {most}"));
            let address = told(&mut program, "listening at ");
            let first = TcpStream::connect(&address).unwrap();
            assert!(is_served(first.try_clone().unwrap(), verb));
            // The second has to go in either case: for want of room, or for what it says.
            let mut second = TcpStream::connect(&address).unwrap();
            let _ = second.write_all(b"GET / HTTP/1.1\r\n\r\n");
            let is_out = |line: &String| {
                ["turned away", "disconnected"]
                    .iter()
                    .any(|word| line.contains(word))
            };
            let mut why = String::new();
            wait_for("the second's end", || {
                why = program
                    .remarks
                    .all()
                    .into_iter()
                    .find(is_out)
                    .unwrap_or_default();
                !why.is_empty()
            });
            assert!(why.contains(words), "{why}");
        }
    }),
    row(&LINES, "--quiet", |rig, verb| {
        let call = format!("{verb} --clock messages");
        assert_ne!(rig.done(&call).stderr, "");
        for flag in ["-q", "--quiet"] {
            assert_eq!(rig.done(&format!("{call} {flag}")).stderr, "");
        }
    }),
    row(&LINES, "--log-format", |rig, verb| {
        let begins = match verb {
            "run" => "running ",
            _ => "playing ",
        };
        let line = |format: &str| {
            let called = rig.done(&format!("{verb} --clock messages {format}"));
            called.stderr.lines().next().unwrap().to_owned()
        };
        for format in ["", "--log-format auto", "--log-format text"] {
            assert!(line(format).starts_with(begins), "{}", line(format));
        }
        assert!(line("--log-format journald").starts_with(&format!("<6>{begins}")));
        let stamped = line("--log-format stamped");
        let (time, rest) = stamped.split_once(' ').unwrap();
        assert!(time.parse::<f64>().unwrap() > 1e9 && rest.starts_with(&format!("info {begins}")));
    }),
    #[cfg(feature = "dashboard")]
    row(&["run"], "--dashboard", |rig, verb| {
        let call = format!("{verb} --listen 127.0.0.1:0 --dashboard 127.0.0.1:0");
        let mut program = rig.program(&call);
        // The dashboard is opened first.
        told(&mut program, "listening at ");
        let lines = program.remarks.all();
        let found = lines
            .iter()
            .find_map(|line| line.split_once("dashboard at http://"));
        let (_, address) = found.expect("a dashboard");
        let address = address.trim_end_matches('/');
        let mut page = TcpStream::connect(address).unwrap();
        write!(
            page,
            "GET / HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"
        )
        .unwrap();
        let answer = std::io::read_to_string(page).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200 ") && answer.contains("<!doctype html>"));
    }),
];

#[test]
fn transport_options_have_their_effect() {
    hold(ROWS);
}

/// What a program tells behind `words`, which it has to before it ends.
fn told(program: &mut Program, words: &str) -> String {
    let mut found = None;
    wait_for(words, || {
        let is_running = program.is_running();
        let lines = program.remarks.all();
        let line = lines.iter().find_map(|line| line.split_once(words));
        found = line.map(|(_, rest)| rest.to_owned());
        found.is_some() || !is_running
    });
    found.unwrap_or_else(|| panic!("{words} not in {:?}", program.remarks.all()))
}

/// The program that connects to `server`.
fn accepted(server: &TcpListener, program: &mut Program) -> TcpStream {
    server.set_nonblocking(true).unwrap();
    let mut peer = None;
    wait_for("a connection", || {
        let is_running = program.is_running();
        peer = server.accept().ok();
        peer.is_some() || !is_running
    });
    let (peer, _) = peer.expect("a connection");
    peer.set_nonblocking(false).unwrap();
    peer
}

/// Whether the other side talks: the station by itself, the node in answer to a tick.
fn is_served(mut peer: TcpStream, verb: &str) -> bool {
    let expected = match verb {
        "run" => {
            // Whoever is refused may have gone by now.
            let _ = writeln!(peer, r#"{{"kind":"tick","stamp":1}}"#);
            "\"kind\":\"due\""
        }
        _ => "\"kind\":\"robot\"",
    };
    let lines = BufReader::new(peer).lines();
    lines
        .map_while(Result::ok)
        .any(|line| line.contains(expected))
}
