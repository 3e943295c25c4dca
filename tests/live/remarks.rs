//! What the programs of a live line say to their user, on stderr.

#[cfg(feature = "tls")]
use crate::authority::authority;
use crate::programs::{Program, feed};
use std::io::Write as _;
use std::net::{TcpListener, TcpStream};
use std::process::Command;

/// Feeds `input` to `pickline run --clock messages`; returns its lines on stderr.
fn remarks_on(input: &str) -> Vec<String> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pickline"));
    command.args(["run", "--clock", "messages"]);
    let (output, read) = feed(&mut command, input.as_bytes());
    read.unwrap();
    assert_eq!(output.status.code(), Some(0));
    let errors = String::from_utf8(output.stderr).unwrap();
    errors.lines().map(str::to_owned).collect()
}

#[test]
fn what_is_refused_is_named_with_its_line() {
    let long = "x".repeat(70_000);
    let said = remarks_on(&format!(
        "{{\"kind\":\"belt\",\"stamp\":5,\"speed\":0.05}}\n\
         {{\"kind\":\"robot\",\"stamp\":5,\"name\":\"r1\",\"state\":\"idle\"}}\n\
         \n\
         {{\n\
         {long}\n\
         {{\"kind\":\"belt\",\"stamp\":1e9,\"speed\":0.05}}\n\
         {{\"kind\":\"robot\",\"stamp\":6,\"name\":\"r9\",\"state\":\"idle\"}}\n\
         {{\"kind\":\"belt\",\"stamp\":6,\"stamp\":7,\"speed\":0.05}}\n\
         {{\"kind\":\"belt\",\"stamp\":300,\"speed\":0.05}}\n"
    ));
    let refused: Vec<&String> = said
        .iter()
        .filter(|line| line.contains("refused"))
        .collect();
    let expected = [
        "stdin line 4: refused (syntax): ",
        "stdin line 5: refused (too_long): ",
        // It is held back until the next one shows that it is wild.
        "stdin line 6: refused (stamp): stamp = 1000000000, but the time is 5; ",
        "stdin line 7: refused (unknown_robot): ",
        "stdin line 8: refused (field): `stamp` is repeated",
        // Nothing follows it.
        "stdin line 9: refused (stamp): stamp = 300, but the time is 6; ",
    ];
    assert_eq!(refused.len(), expected.len(), "{said:#?}");
    for (line, start) in refused.iter().zip(expected) {
        assert!(line.starts_with(start), "{line}");
    }
}

#[test]
fn what_is_refused_is_named_with_its_sender() {
    let mut node = Program::pickline("run --listen 127.0.0.1:0", &[]);
    node.remarks.wait_for("listening at ");
    let remark = node.remarks.all().pop().unwrap();
    let address = remark.rsplit(' ').next().unwrap();
    for _ in 0..2 {
        let mut peer = TcpStream::connect(address).unwrap();
        let own = peer.local_addr().unwrap();
        peer.write_all(b"{\"kind\":\"tick\",\"stamp\":0}\n\n{]\n")
            .unwrap();
        node.remarks
            .wait_for(&format!("{own} line 1: refused (stamp): "));
        node.remarks
            .wait_for(&format!("{own} line 3: refused (syntax): "));
    }
    node.signal("TERM");
    assert_eq!(node.finish().0, Some(0));
}

/// Once, and again when somebody is there.
#[test]
fn the_awaited_peer_is_reported() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    drop(listener);
    for verb in ["run", "emulate"] {
        let mut program = Program::pickline(&format!("{verb} --connect {address}"), &[]);
        let waits = format!("no connection to {address}: ");
        program.remarks.wait_for(&waits);
        let listener = TcpListener::bind(&address).unwrap();
        let peer = listener.accept().unwrap();
        program.remarks.wait_for(&format!("connected to {address}"));
        program.signal("TERM");
        drop((peer, listener));
        let (_, remarks) = program.finish();
        assert_eq!(
            remarks.matches(&format!("connected to {address}")).count(),
            1
        );
        assert!(remarks.matches(&waits).count() <= 2, "{remarks}");
    }
}

/// Once, however often it is tried.
#[cfg(feature = "tls")]
#[test]
fn an_unreachable_peer_is_reported_once() {
    let folder = tempfile::tempdir().unwrap();
    authority(folder.path(), &["us"]);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let at = folder.path().display();
    let files = format!("--tls-ca {at}/ca.pem --tls-cert {at}/us.pem --tls-key {at}/us.key");
    for verb in ["run", "emulate"] {
        let mut program = Program::pickline(&format!("{verb} --connect {address} {files}"), &[]);
        // Each try ends without TLS.
        for _ in 0..4 {
            drop(listener.accept().unwrap());
        }
        program.remarks.wait_for("retrying");
        program.signal("TERM");
        let (_, remarks) = program.finish();
        let waits = format!("no connection to {address}: ");
        assert_eq!(remarks.matches(&waits).count(), 1, "{remarks}");
        assert!(!remarks.contains("connected to"), "{remarks}");
    }
}

#[cfg(feature = "dashboard")]
#[test]
fn a_dashboard_needs_an_address_of_its_own() {
    let refused = |places: &str, flag: &str| {
        let (code, remarks) = Program::pickline(&format!("run {places}"), &[]).finish();
        assert_eq!(code, Some(2), "{remarks}");
        assert!(
            remarks.contains(&format!("is also the address of {flag}\n  cure: ")),
            "{remarks}"
        );
    };
    for listen in ["127.0.0.1:47400", "localhost:47400", "0.0.0.0:47400"] {
        refused(
            &format!("--listen {listen} --dashboard 127.0.0.1:47400"),
            "--listen",
        );
    }
    refused(
        "--connect 127.0.0.1:47400 --dashboard 0.0.0.0:47400",
        "--connect",
    );
    // Port 0 is another one each time.
    let mut node = Program::pickline("run --listen 127.0.0.1:0 --dashboard 127.0.0.1:0", &[]);
    node.remarks.wait_for("listening at ");
    node.signal("TERM");
    assert_eq!(node.finish().0, Some(0));
}

#[test]
fn an_empty_journal_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("j");
    let run = || {
        let arguments = format!("run --clock messages --journal {}", journal.display());
        let (code, remarks) = Program::pickline(&arguments, &[]).finish();
        assert_eq!(code, Some(0), "{remarks}");
        remarks
    };
    let told = format!(
        "{} is empty, so a new journal is started; ",
        journal.display()
    );
    // One that does not exist yet is nothing to speak of.
    assert!(!run().contains(&told));
    std::fs::write(&journal, "").unwrap();
    assert!(run().contains(&told));
    assert!(run().contains("resuming from "));
}

/// An item in the gripper of a robot that breaks down is in no bin.
#[test]
fn the_station_counts_what_is_in_its_bins() {
    let mut stranded = 0;
    for from in 0..12 {
        let mut node = Program::pickline("run --clock messages --listen 127.0.0.1:0", &[]);
        node.remarks.wait_for("listening at ");
        let remark = node.remarks.all().pop().unwrap();
        let address = remark.rsplit(' ').next().unwrap();
        let emulate = format!(
            "emulate --clock messages --connect {address} --robot-down 1,{},5",
            20.0 + 0.6 * f64::from(from)
        );
        let (code, remarks) = Program::pickline(&emulate, &[]).finish();
        assert_eq!(code, Some(0), "{remarks}");
        let last = remarks.lines().last().unwrap();
        let bins = last.split(' ').next().unwrap();
        assert!(
            last.contains(&format!("the node reports {bins} of 50 picked")),
            "{last}"
        );
        if last.contains("1 in the grippers of robots that broke down") {
            stranded += 1;
            assert!(last.contains("1 of them without a result"), "{last}");
        }
        assert_eq!(node.finish().0, Some(0));
    }
    assert!(stranded > 0);
}
